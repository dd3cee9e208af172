// SPDX-License-Identifier: Apache-2.0
#include "haptogram/hand/feature.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/hand/random.hpp"

namespace haptogram {
namespace {

constexpr double full_turn = 2.0 * std::numbers::pi;

/// The plane that touches the skin at a point, with two directions in it.
struct Tangent {
    explicit Tangent(const SkinPoint& point) : at(point) {
        // Of the axes, one that is not along the normal; always the same one, so that figures do not jump.
        const Vec3 axis = std::abs(point.normal.x) < 0.9 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
        const Vec3 way = axis - dot(axis, point.normal) * point.normal;
        u = way * (1.0 / norm(way));
        v = cross(point.normal, u);
    }
    [[nodiscard]] SkinPoint place(double radius, double angle) const {
        return {at.position + radius * (std::cos(angle) * u + std::sin(angle) * v), at.normal};
    }
    SkinPoint at;
    Vec3 u, v;
};

SkinLine figure(const SkinPoint& corner, std::size_t region, std::size_t number, double time_s,
                const FeatureOptions& options) {
    const Tangent plane(corner);
    SkinLine line{{}, false, LineKind::feature, region};
    switch (options.corner) {
        case CornerFigure::circle: return skin_circle(corner, options.radius_m, LineKind::feature, region);
        case CornerFigure::pulsing: {
            const double swing = 1.0 + options.pulse_share * std::sin(full_turn * options.pulse_hz * time_s);
            return skin_circle(corner, options.radius_m * swing, LineKind::feature, region);
        }
        case CornerFigure::line: {
            const double angle = full_turn * std::fmod(options.turns_hz * time_s, 1.0);
            line.points = {plane.place(0.5 * options.line_m, angle + std::numbers::pi),
                           plane.place(0.5 * options.line_m, angle)};
            return line;
        }
        case CornerFigure::triangle:
            line.closed = true;
            for (int i = 0; i < 3; ++i)
                line.points.push_back(plane.place(options.triangle_m / std::numbers::sqrt3, full_turn * i / 3.0));
            return line;
        case CornerFigure::points: {
            line.closed = true;
            KeyedRandom random{std::bit_cast<std::int64_t>(options.seed), static_cast<std::int64_t>(number),
                               std::bit_cast<std::int64_t>(time_s)};
            for (std::size_t i = 0; i < options.points; ++i) {
                const double radius = options.radius_m * std::sqrt(random.uniform(0.0, 1.0));  // evenly over the disc
                line.points.push_back(plane.place(radius, random.uniform(0.0, full_turn)));
            }
            return line;
        }
    }
    return line;
}

using Share = std::array<double, 2>;

/// Takes from a part of the way what was taken before, and marks the rest as taken.
std::vector<Share> take(std::vector<Share>& taken, Share part) {
    std::vector<Share> rest{part};
    for (const Share& one : taken) {
        std::vector<Share> left;
        for (const Share& piece : rest) {
            if (piece[0] < std::min(piece[1], one[0])) left.push_back({piece[0], std::min(piece[1], one[0])});
            if (std::max(piece[0], one[1]) < piece[1]) left.push_back({std::max(piece[0], one[1]), piece[1]});
        }
        rest = std::move(left);
    }
    taken.push_back(part);
    return rest;
}

}  // namespace

CornerFigure corner_figure(const std::string& name) {
    constexpr std::array names{"circle", "pulsing-circle", "rotating-line", "triangle", "random-points"};
    for (std::size_t i = 0; i < names.size(); ++i)
        if (name == names.at(i)) return static_cast<CornerFigure>(i);
    throw bad_argument("corner", fmt::format("found \"{}\", expected {}", name, fmt::join(names, ", ")));
}

SkinLine skin_circle(const SkinPoint& centre, double radius, LineKind kind, std::size_t region) {
    constexpr int corners = 64;
    const Tangent plane(centre);
    SkinLine line{{}, true, kind, region};
    for (int i = 0; i < corners; ++i) line.points.push_back(plane.place(radius, full_turn * i / corners));
    return line;
}

std::vector<SkinLine> feature_lines(const TouchObject& object, const std::vector<SkinRegion>& skin, double time_s,
                                    const FeatureOptions& options) {
    std::vector<SkinLine> lines;
    for (const Edge& edge : object.edges) {
        // An edge of many short pieces, such as a circle, becomes one line as long as it stays in one region.
        std::vector<std::pair<Share, SkinLine>> parts;  // by their places along the edge
        for (std::size_t k = 1; k < edge.size(); ++k) {
            const Vec3 from = edge[k - 1], to = edge[k];
            std::vector<Share> taken;
            for (std::size_t region = 0; region < skin.size(); ++region) {
                for (const SkinPatch& patch : skin[region].patches) {
                    const auto inside = patch.clip(from, to);
                    if (!inside) continue;
                    for (const Share& part : take(taken, *inside)) {
                        SkinLine line{{}, false, LineKind::feature, region};
                        const double length = (part[1] - part[0]) * distance(from, to);
                        const double steps = options.project ? std::max(1.0, std::ceil(length / options.step_m)) : 1.0;
                        for (double i = 0.0; i <= steps; ++i) {
                            const Vec3 p = from + (part[0] + (part[1] - part[0]) * i / steps) * (to - from);
                            const SkinPoint near = patch.nearest(p);
                            line.points.push_back(options.project ? near : SkinPoint{p, near.normal});
                        }
                        const auto place = static_cast<double>(k);
                        parts.push_back({{place + part[0], place + part[1]}, std::move(line)});
                    }
                }
            }
        }
        std::stable_sort(parts.begin(), parts.end(),
                         [](const auto& a, const auto& b) { return a.first[0] < b.first[0]; });
        for (std::size_t i = 0; i < parts.size(); ++i) {
            constexpr double touching = 1e-9;
            const bool goes_on = i > 0 && parts[i].first[0] - parts[i - 1].first[1] < touching &&
                                 parts[i].second.region == parts[i - 1].second.region;
            if (!goes_on)
                lines.push_back(parts[i].second);
            else
                lines.back().points.insert(lines.back().points.end(), parts[i].second.points.begin(),
                                           parts[i].second.points.end());
        }
    }
    for (std::size_t number = 0; number < object.corners.size(); ++number) {
        const Vec3 corner = object.corners[number];
        std::size_t nearest = skin.size();
        SkinPoint at;
        for (std::size_t region = 0; region < skin.size(); ++region)
            for (const SkinPatch& patch : skin[region].patches) {
                if (!patch.clip(corner, corner)) continue;
                const SkinPoint found = patch.nearest(corner);
                if (nearest < skin.size() && distance(found.position, corner) >= distance(at.position, corner))
                    continue;
                nearest = region;
                at = found;
            }
        if (nearest == skin.size()) continue;
        lines.push_back(figure(options.project ? at : SkinPoint{corner, at.normal}, nearest, number, time_s, options));
    }
    return lines;
}

}  // namespace haptogram
