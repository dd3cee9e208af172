// SPDX-License-Identifier: Apache-2.0
#include "haptogram/hand/skin_line.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "haptogram/shape/curve.hpp"

namespace haptogram {
namespace {

/// A closed line, begun at an arc length.
SkinLine begun_at(const SkinLine& line, double start) {
    if (start == 0.0) return line;
    const std::vector<SkinPoint> round = opened(line);
    std::size_t i = 1;
    double passed = 0.0;
    for (; i + 1 < round.size(); ++i) {
        const double part = distance(round[i - 1].position, round[i].position);
        if (passed + part > start) break;
        passed += part;
    }
    const double part = distance(round[i - 1].position, round[i].position);
    SkinLine begun{{}, true, line.kind, line.region};
    begun.points.push_back(between(round[i - 1], round[i], part > 0.0 ? std::min(1.0, (start - passed) / part) : 0.0));
    for (std::size_t k = i; k + 1 < round.size(); ++k) begun.points.push_back(round[k]);
    for (std::size_t k = 0; k < i; ++k) begun.points.push_back(round[k]);
    return begun;
}

}  // namespace

const char* name_of(LineKind kind) {
    switch (kind) {
        case LineKind::contour: return "contour";
        case LineKind::feature: return "feature";
        case LineKind::solid: return "solid";
        case LineKind::grain: return "grain";
        case LineKind::blob: return "blob";
        case LineKind::pointer: return "pointer";
        case LineKind::press: return "press";
    }
    return "";
}

std::vector<SkinPoint> opened(const SkinLine& line) {
    std::vector<SkinPoint> points = line.points;
    if (line.closed && !points.empty()) points.push_back(points.front());
    return points;
}

double length_of(const SkinLine& line) {
    double sum = 0.0;
    for (std::size_t i = 1; i < line.points.size(); ++i)
        sum += distance(line.points[i - 1].position, line.points[i].position);
    if (line.closed && !line.points.empty()) sum += distance(line.points.back().position, line.points.front().position);
    return sum;
}

double length_of(const std::vector<SkinLine>& lines) {
    double sum = 0.0;
    for (const SkinLine& line : lines) sum += length_of(line);
    return sum;
}

SkinPoint between(const SkinPoint& a, const SkinPoint& b, double share) {
    const Vec3 normal = (1.0 - share) * a.normal + share * b.normal;
    const double length = norm(normal);
    return {(1.0 - share) * a.position + share * b.position, length > 0.0 ? normal * (1.0 / length) : a.normal};
}

std::vector<SkinLine> toured(std::vector<SkinLine> lines) {
    std::erase_if(lines, [](const SkinLine& line) { return length_of(line) == 0.0; });
    if (lines.size() > most_toured) return lines;
    std::vector<Curve> curves;
    for (const SkinLine& line : lines) {
        std::vector<Vec3> corners;
        for (const SkinPoint& point : line.points) corners.push_back(point.position);
        curves.push_back(polyline(corners, line.closed));
    }
    std::vector<SkinLine> ordered;
    for (const CurveVisit& visit : curve_tour(curves).visits) {
        SkinLine line = begun_at(lines[visit.curve], visit.start);
        if (visit.backwards) std::reverse(line.points.begin(), line.points.end());
        ordered.push_back(std::move(line));
    }
    return ordered;
}

std::vector<SkinLine> away_from(const std::vector<SkinLine>& lines, const std::vector<Vec3>& points, double gap) {
    if (points.empty()) return lines;
    const auto room = [&](Vec3 p) {  // beyond the gap
        double nearest = INFINITY;
        for (const Vec3 point : points) nearest = std::min(nearest, dot(p - point, p - point));
        return std::sqrt(nearest) - gap;
    };
    std::vector<SkinLine> left;
    for (const SkinLine& line : lines) {
        const std::vector<SkinPoint> path = opened(line);
        std::vector<double> rooms;
        for (const SkinPoint& point : path) rooms.push_back(room(point.position));
        if (std::all_of(rooms.begin(), rooms.end(), [](double r) { return r >= 0.0; })) {
            left.push_back(line);
            continue;
        }
        const std::size_t before = left.size();
        SkinLine run{{}, false, line.kind, line.region};
        for (std::size_t i = 0; i < path.size(); ++i) {
            const bool kept = rooms[i] >= 0.0;
            if (i > 0 && kept != (rooms[i - 1] >= 0.0))
                run.points.push_back(between(path[i - 1], path[i], rooms[i - 1] / (rooms[i - 1] - rooms[i])));
            if (kept) run.points.push_back(path[i]);
            if ((!kept || i + 1 == path.size()) && run.points.size() > 1) left.push_back(run);
            if (!kept) run.points.clear();
        }
        // The run across a closed line's first point is one run.
        if (line.closed && rooms.front() >= 0.0 && left.size() > before + 1) {
            SkinLine& first = left[before];
            SkinLine last = std::move(left.back());
            left.pop_back();
            last.points.insert(last.points.end(), first.points.begin() + 1, first.points.end());
            first = std::move(last);
        }
    }
    return left;
}

std::vector<Vec3> points_along(const std::vector<SkinLine>& lines, double step) {
    std::vector<Vec3> along;
    for (const SkinLine& line : lines) {
        const std::vector<SkinPoint> path = opened(line);
        for (std::size_t i = 0; i < path.size(); ++i) {
            const Vec3 to = path[i].position, from = i > 0 ? path[i - 1].position : to;
            const double parts = std::max(1.0, std::ceil(distance(from, to) / step));
            for (double k = 1.0; k <= parts; ++k) along.push_back(from + (k / parts) * (to - from));
        }
    }
    return along;
}

}  // namespace haptogram
