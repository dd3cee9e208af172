// SPDX-License-Identifier: Apache-2.0
#include "haptogram/hand/contour.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include "haptogram/shape/draw.hpp"

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

namespace {

/// Fills a depth map block by block.
class Prober {
public:
    Prober(const SkinRegion& region, const Solid& solid, DepthFor use) : region_(region), solid_(solid), use_(use) {
        map_.depth.resize(region.points.size());
    }

    DepthMap run() {
        for (std::size_t row = 0; row < region_.rows; row += sizes.front())
            for (std::size_t column = 0; column < region_.columns; column += sizes.front()) block(row, column, 0);
        for (std::size_t i = 0; i < map_.depth.size(); ++i)
            if (map_.depth[i] > map_.depth[map_.deepest]) map_.deepest = i;
        map_.touched = !map_.depth.empty() && map_.depth[map_.deepest] > 0.0;
        return std::move(map_);
    }

private:
    /// Points a side of a block, and of those that it is divided into.
    static constexpr std::array<std::size_t, 3> sizes{64, 16, 4};

    struct Known {
        Vec3 point;
        double depth = 0.0;
    };

    void block(std::size_t row, std::size_t column, std::size_t level) {
        const std::size_t end_row = std::min(row + sizes.at(level), region_.rows);
        const std::size_t end_column = std::min(column + sizes.at(level), region_.columns);
        const Vec3 middle = region_.point((row + end_row) / 2, (column + end_column) / 2);
        // With the neighbours of the block's points, so that no cell with a point in it is crossed either.
        double square = 0.0;
        for (std::size_t r = row == 0 ? 0 : row - 1; r < std::min(end_row + 1, region_.rows); ++r)
            for (std::size_t c = column == 0 ? 0 : column - 1; c < std::min(end_column + 1, region_.columns); ++c) {
                const Vec3 way = region_.point(r, c) - middle;
                square = std::max(square, dot(way, way));
            }
        const double radius = std::sqrt(square);
        Known known = last_;  // often the last point that was asked for tells enough
        if (!tells(known, middle, radius)) known = {middle, roughly(middle)};
        if (!tells(known, middle, radius)) known = last_ = {middle, -solid_.distance(middle)};
        if (tells(known, middle, radius)) {
            for (std::size_t r = row; r < end_row; ++r)
                for (std::size_t c = column; c < end_column; ++c) map_.depth[r * region_.columns + c] = known.depth;
        } else if (level + 1 == sizes.size()) {
            points(row, end_row, column, end_column);
        } else {
            for (std::size_t r = row; r < end_row; r += sizes.at(level + 1))
                for (std::size_t c = column; c < end_column; c += sizes.at(level + 1)) block(r, c, level + 1);
        }
    }

    /// Whether all points this near to another are on the same side of the surface as one that is known, and their sign
    /// is enough.
    [[nodiscard]] bool tells(const Known& known, Vec3 point, double radius) const {
        if (known.depth > 0.0 && use_ == DepthFor::inside) return false;
        return std::abs(known.depth) - distance(point, known.point) > radius;
    }

    /// A depth with the right sign that is not farther from 0 than the right one; 0 when nothing but the distance
    /// tells.
    [[nodiscard]] double roughly(Vec3 point) const { return solid_.bound ? -solid_.bound(point) : 0.0; }

    /// Each point, unless one that is known tells that the surface is farther than its neighbours.
    void points(std::size_t row, std::size_t end_row, std::size_t column, std::size_t end_column) {
        std::array<Known, sizes.back() * sizes.back() + 1> known;
        std::size_t count = 0;
        known[count++] = last_;
        for (std::size_t r = row; r < end_row; ++r) {
            for (std::size_t c = column; c < end_column; ++c) {
                const Vec3 p = region_.point(r, c);
                const double edge = farthest_neighbour(r, c);
                const auto tells_enough = [&](const Known& one) { return tells(one, p, edge); };
                const auto end = known.begin() + static_cast<std::ptrdiff_t>(count);
                const auto found = std::find_if(known.begin(), end, tells_enough);
                Known here = found != end ? *found : Known{p, roughly(p)};
                if (!tells_enough(here)) here = known[count++] = last_ = {p, -solid_.distance(p)};
                map_.depth[r * region_.columns + c] = here.depth;
            }
        }
    }

    [[nodiscard]] double farthest_neighbour(std::size_t r, std::size_t c) const {
        const Vec3 p = region_.point(r, c);
        double square = 0.0;
        const auto look = [&](std::size_t row, std::size_t column) {
            const Vec3 way = region_.point(row, column) - p;
            square = std::max(square, dot(way, way));
        };
        if (r > 0) look(r - 1, c);
        if (r + 1 < region_.rows) look(r + 1, c);
        if (c > 0) look(r, c - 1);
        if (c + 1 < region_.columns) look(r, c + 1);
        return std::sqrt(square);
    }

    const SkinRegion& region_;
    const Solid& solid_;
    DepthFor use_;
    DepthMap map_;
    Known last_;  ///< the last point whose depth was asked for; none tells nothing
};

}  // namespace

DepthMap depth_map(const SkinRegion& region, const Solid& solid, DepthFor use) {
    return Prober(region, solid, use).run();
}

std::vector<SkinLine> contours(const SkinRegion& region, const DepthMap& map, double level, std::size_t number,
                               LineKind kind) {
    if (!map.touched) return {};
    constexpr std::int32_t none = -1;
    const std::size_t columns = region.columns;
    // A node is where the contour crosses a side of a cell: 2i between point i and the next in its row, 2i + 1 between
    // point i and the one in the next row. Each has at most one node after it and one before it.
    std::vector<std::int32_t> after(2 * region.points.size(), none);
    std::vector<bool> led(after.size(), false);
    std::vector<std::size_t> nodes;
    const auto link = [&](std::size_t from, std::size_t to) {
        after[from] = static_cast<std::int32_t>(to);
        led[to] = true;
        nodes.push_back(from);
    };
    const auto inside = [&](std::size_t i) { return map.depth[i] > level; };
    for (std::size_t row = 0; row + 1 < region.rows; ++row) {
        for (std::size_t column = 0; column + 1 < columns; ++column) {
            const std::size_t a = row * columns + column, b = a + 1, d = a + columns, c = d + 1;  // anticlockwise
            const unsigned corners =
                (inside(a) ? 1U : 0U) | (inside(b) ? 2U : 0U) | (inside(c) ? 4U : 0U) | (inside(d) ? 8U : 0U);
            if (corners == 0 || corners == 15) continue;
            const std::size_t bottom = 2 * a, right = 2 * b + 1, top = 2 * d, left = 2 * a + 1;
            const bool joined = map.depth[a] + map.depth[b] + map.depth[c] + map.depth[d] > 4.0 * level;
            switch (corners) {
                case 1: link(bottom, left); break;
                case 2: link(right, bottom); break;
                case 3: link(right, left); break;
                case 4: link(top, right); break;
                case 5:
                    link(bottom, joined ? right : left);
                    link(top, joined ? left : right);
                    break;
                case 6: link(top, bottom); break;
                case 7: link(top, left); break;
                case 8: link(left, top); break;
                case 9: link(bottom, top); break;
                case 10:
                    link(left, joined ? bottom : top);
                    link(right, joined ? top : bottom);
                    break;
                case 11: link(right, top); break;
                case 12: link(left, right); break;
                case 13: link(bottom, right); break;
                default: link(left, bottom); break;
            }
        }
    }
    const auto point = [&](std::size_t node) {
        const std::size_t i = node / 2, k = node % 2 == 0 ? i + 1 : i + columns;
        const double share = (level - map.depth[i]) / (map.depth[k] - map.depth[i]);
        return between({region.points[i], region.normals[i]}, {region.points[k], region.normals[k]}, share);
    };
    std::vector<SkinLine> lines;
    const auto follow = [&](std::size_t first) {
        SkinLine line{{}, false, kind, number};
        for (std::size_t node = first;;) {
            line.points.push_back(point(node));
            const std::int32_t next = std::exchange(after[node], none);
            if (next == none) break;
            node = static_cast<std::size_t>(next);
            if (node == first) {
                line.closed = true;
                break;
            }
        }
        lines.push_back(std::move(line));
    };
    for (const std::size_t node : nodes)
        if (!led[node]) follow(node);
    for (const std::size_t node : nodes)
        if (after[node] != none) follow(node);
    return lines;
}

std::optional<Deepest> deepest_of(const std::vector<SkinRegion>& skin, const std::vector<DepthMap>& maps) {
    std::optional<Deepest> found;
    for (std::size_t i = 0; i < skin.size(); ++i) {
        if (!maps[i].touched) continue;
        const std::size_t at = maps[i].deepest;
        if (found && found->depth >= maps[i].depth[at]) continue;
        found = Deepest{{skin[i].points[at], skin[i].normals[at]}, maps[i].depth[at], i};
    }
    return found;
}

}  // namespace haptogram
