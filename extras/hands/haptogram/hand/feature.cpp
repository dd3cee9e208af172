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

namespace haptogram {
namespace {

/// A place of the raster between its points.
SkinPoint at(const SkinRegion& region, double row, double column) {
    const auto r = std::min(static_cast<std::size_t>(row), region.rows - 2);
    const auto c = std::min(static_cast<std::size_t>(column), region.columns - 2);
    const auto point = [&](std::size_t i, std::size_t j) {
        return SkinPoint{region.point(i, j), region.normals[i * region.columns + j]};
    };
    const double down = row - static_cast<double>(r), right = column - static_cast<double>(c);
    return between(between(point(r, c), point(r, c + 1), right), between(point(r + 1, c), point(r + 1, c + 1), right),
                   down);
}

/// What std::floor gives, without a call.
std::int64_t whole_below(double value) {
    const auto cut = static_cast<std::int64_t>(value);
    return static_cast<double>(cut) > value ? cut - 1 : cut;
}

/// Directions that turn by at most a right angle from step to step.
double turned(KeyedRandom& random, double angle) {
    return angle + random.uniform(-0.5 * std::numbers::pi, 0.5 * std::numbers::pi);
}

}  // namespace

std::vector<SkinLine> random_grain(const SkinRegion& region, const DepthMap& map, double time_s, std::size_t number,
                                   const GrainOptions& options) {
    std::vector<SkinLine> lines;
    if (!map.touched) return lines;
    // How far neighbours are apart, so that squares and steps have their size on the skin.
    const double row_m = distance(region.point(0, 0), region.point(1, 0));
    const double column_m = distance(region.point(0, 0), region.point(0, 1));
    const double rows = options.spacing_m / row_m, columns = options.spacing_m / column_m;
    const double last_row = static_cast<double>(region.rows - 1), last_column = static_cast<double>(region.columns - 1);
    bool back = false;  // every other row of squares the other way, which keeps the jumps short
    for (double row = 0.0; row + 0.5 * rows <= last_row; row += rows, back = !back) {
        std::vector<SkinLine> along;
        for (double column = 0.0; column + 0.5 * columns <= last_column; column += columns) {
            const auto middle = static_cast<std::size_t>(std::lround(row + 0.5 * rows)) * region.columns +
                                static_cast<std::size_t>(std::lround(column + 0.5 * columns));
            if (!(map.depth[middle] > 0.0)) continue;
            KeyedRandom random{std::bit_cast<std::int64_t>(options.seed), std::bit_cast<std::int64_t>(time_s),
                               static_cast<std::int64_t>(number), static_cast<std::int64_t>(middle)};
            double r = std::min(last_row, row + random.uniform(0.0, rows));
            double c = std::min(last_column, column + random.uniform(0.0, columns));
            double angle = random.uniform(0.0, 2.0 * std::numbers::pi);
            const double step = options.length_m / static_cast<double>(options.points - 1);
            SkinLine line{{at(region, r, c)}, false, LineKind::grain, number};
            while (line.points.size() < options.points) {
                angle = turned(random, angle);
                const double to_r = r + step / row_m * std::cos(angle), to_c = c + step / column_m * std::sin(angle);
                if (to_r < 0.0 || to_r > last_row || to_c < 0.0 || to_c > last_column) {
                    angle += std::numbers::pi;  // back from the raster's border
                    continue;
                }
                r = to_r;
                c = to_c;
                line.points.push_back(at(region, r, c));
            }
            along.push_back(std::move(line));
        }
        if (back) std::reverse(along.begin(), along.end());
        lines.insert(lines.end(), along.begin(), along.end());
    }
    return lines;
}

std::vector<SkinLine> fixed_grain(const SkinRegion& region, const DepthMap& map, std::size_t number,
                                  const GrainOptions& options) {
    using Cube = std::array<std::int64_t, 3>;
    std::vector<SkinLine> lines;
    if (!map.touched) return lines;
    std::vector<Cube> cubes;  // in which the skin is inside
    for (std::size_t i = 0; i < region.points.size(); ++i) {
        if (!(map.depth[i] > 0.0)) continue;
        const Vec3 p = region.points[i] * (1.0 / options.spacing_m);
        const Cube cube{whole_below(p.x), whole_below(p.y), whole_below(p.z)};
        if (cubes.empty() || cubes.back() != cube) cubes.push_back(cube);
    }
    std::sort(cubes.begin(), cubes.end());
    cubes.erase(std::unique(cubes.begin(), cubes.end()), cubes.end());
    for (const Cube& cube : cubes) {
        KeyedRandom random{std::bit_cast<std::int64_t>(options.seed), cube[0], cube[1], cube[2]};
        const Vec3 low =
            Vec3{static_cast<double>(cube[0]), static_cast<double>(cube[1]), static_cast<double>(cube[2])} *
            options.spacing_m;
        const double step = options.length_m / static_cast<double>(options.points - 1);
        const auto somewhere = [&] { return random.uniform(0.0, options.spacing_m); };
        Vec3 p = low + Vec3{somewhere(), somewhere(), somewhere()};
        double angle = random.uniform(0.0, 2.0 * std::numbers::pi);
        SkinLine line{{}, false, LineKind::grain, number};
        // Steps in the plane that the skin faces most; there the line keeps its length when it is laid onto the skin.
        const Vec3 normal = region.nearest(low + 0.5 * options.spacing_m * Vec3{1, 1, 1}).normal;
        const bool along_x = std::abs(normal.x) >= std::max(std::abs(normal.y), std::abs(normal.z));
        const bool along_y = !along_x && std::abs(normal.y) >= std::abs(normal.z);
        while (true) {
            line.points.push_back(region.nearest(p));
            if (line.points.size() == options.points) break;
            angle = turned(random, angle);
            const double u = step * std::cos(angle), v = step * std::sin(angle);
            p = p + (along_x ? Vec3{0, u, v} : along_y ? Vec3{u, 0, v} : Vec3{u, v, 0});
        }
        lines.push_back(std::move(line));
    }
    return lines;
}

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
