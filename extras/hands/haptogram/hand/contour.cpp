// SPDX-License-Identifier: Apache-2.0
#include "haptogram/hand/contour.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

namespace haptogram {
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
