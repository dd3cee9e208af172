// SPDX-License-Identifier: Apache-2.0
#include "haptogram/hand/mesh_solid.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <numeric>
#include <tuple>
#include <vector>

#include "haptogram/base/error.hpp"
#include "haptogram/hand/distance_grid.hpp"

namespace haptogram {
namespace {

struct Bounds {
    Vec3 low{INFINITY, INFINITY, INFINITY}, high{-INFINITY, -INFINITY, -INFINITY};
    void add(Vec3 p) {
        low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
};

/// Bounds in half the memory, which is what a search waits for. They are rounded outwards, so nothing is missed.
struct FloatBox {
    std::array<float, 3> low{}, high{};
    FloatBox() = default;
    explicit FloatBox(const Bounds& b)
        : low{down(b.low.x), down(b.low.y), down(b.low.z)},
          high{-down(-b.high.x), -down(-b.high.y), -down(-b.high.z)} {}
    [[nodiscard]] double square_distance(Vec3 p) const {
        const double x = std::max({low[0] - p.x, 0.0, p.x - high[0]});
        const double y = std::max({low[1] - p.y, 0.0, p.y - high[1]});
        const double z = std::max({low[2] - p.z, 0.0, p.z - high[2]});
        return x * x + y * y + z * z;
    }

private:
    static float down(double value) { return std::nextafter(static_cast<float>(value), -INFINITY); }
};

/// Which part of a triangle is nearest: a corner, the edge behind a corner, or the face.
struct Nearest {
    double square = INFINITY;
    Vec3 point;
    int part = 6;  ///< 0 to 2: a corner; 3 to 5: the edge from corner part − 3 to the next; 6: the face
};

struct Corners {
    Vec3 a, b, c;

    /// The nearest point by the regions of the triangle's plane in which p may lie.
    [[nodiscard]] Nearest to(Vec3 p) const {
        const Vec3 ab = b - a, ac = c - a, ap = p - a;
        const auto found = [p](Vec3 point, int part) { return Nearest{dot(p - point, p - point), point, part}; };
        const double d1 = dot(ab, ap), d2 = dot(ac, ap);
        if (d1 <= 0.0 && d2 <= 0.0) return found(a, 0);
        const Vec3 bp = p - b;
        const double d3 = dot(ab, bp), d4 = dot(ac, bp);
        if (d3 >= 0.0 && d4 <= d3) return found(b, 1);
        const double vc = d1 * d4 - d3 * d2;
        if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return found(a + d1 / (d1 - d3) * ab, 3);
        const Vec3 cp = p - c;
        const double d5 = dot(ab, cp), d6 = dot(ac, cp);
        if (d6 >= 0.0 && d5 <= d6) return found(c, 2);
        const double vb = d5 * d2 - d1 * d6;
        if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return found(a + d2 / (d2 - d6) * ac, 5);
        const double va = d3 * d6 - d5 * d4;
        if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0)
            return found(b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b), 4);
        const double scale = 1.0 / (va + vb + vc);
        return found(a + vb * scale * ab + vc * scale * ac, 6);
    }
};

/// A triangle with what tells its sides.
struct Triangle : Corners {
    std::array<std::uint32_t, 3> corner;
    Vec3 face;                 ///< normal
    std::array<Vec3, 3> edge;  ///< normals of the edges, from corner i to the next
};

/// Triangles in a tree of boxes. A node's children are the next node and `second`; a leaf has `count` triangles.
class Tree {
public:
    Tree(std::vector<Triangle> triangles, std::vector<Vec3> corner_normals)
        : triangles_(std::move(triangles)), corner_normals_(std::move(corner_normals)) {
        nodes_.reserve(2 * triangles_.size() / leaf + 1);
        build(0, triangles_.size());
        corners_.assign(triangles_.begin(), triangles_.end());
    }

    [[nodiscard]] double distance(Vec3 p) const {
        // Queries come from neighbours, so the triangle of the last one is a good bound for this one. Whatever another
        // thread left there, the result is the same.
        std::uint32_t best = last_.load(std::memory_order_relaxed);
        Nearest nearest = corners_[best].to(p);
        std::array<std::pair<std::uint32_t, double>, 64> waiting;
        std::size_t depth = 0;
        waiting[depth++] = {0, nodes_[0].box.square_distance(p)};
        while (depth > 0) {
            const auto [at, square] = waiting[--depth];
            if (square >= nearest.square) continue;
            const Node& node = nodes_[at];
            for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
                if (const Nearest one = corners_[i].to(p); one.square < nearest.square) {
                    nearest = one;
                    best = i;
                }
            if (node.count > 0) continue;
            std::pair one{at + 1, nodes_[at + 1].box.square_distance(p)};
            std::pair other{node.second, nodes_[node.second].box.square_distance(p)};
            if (one.second < other.second) std::swap(one, other);  // the nearer one is looked at first
            if (one.second < nearest.square) waiting[depth++] = one;
            if (other.second < nearest.square) waiting[depth++] = other;
        }
        last_.store(best, std::memory_order_relaxed);
        const Triangle& triangle = triangles_[best];
        const Vec3 normal = nearest.part < 3
                                ? corner_normals_[triangle.corner.at(static_cast<std::size_t>(nearest.part))]
                            : nearest.part < 6 ? triangle.edge.at(static_cast<std::size_t>(nearest.part - 3))
                                               : triangle.face;
        const double away = std::sqrt(nearest.square);
        return dot(p - nearest.point, normal) < 0.0 ? -away : away;
    }

private:
    static constexpr std::size_t leaf = 8;
    struct Node {
        FloatBox box;
        std::uint32_t first = 0, count = 0, second = 0;
    };

    void build(std::size_t begin, std::size_t end) {
        const std::size_t at = nodes_.size();
        nodes_.emplace_back();
        Bounds all, centres;
        for (std::size_t i = begin; i < end; ++i) {
            const Triangle& t = triangles_[i];
            for (const Vec3 p : {t.a, t.b, t.c}) all.add(p);
            centres.add(t.a + t.b + t.c);
        }
        nodes_[at].box = FloatBox(all);
        if (end - begin <= leaf) {
            nodes_[at].first = static_cast<std::uint32_t>(begin);
            nodes_[at].count = static_cast<std::uint32_t>(end - begin);
            return;
        }
        const Vec3 size = centres.high - centres.low;
        double Vec3::*const axis = size.x >= size.y && size.x >= size.z ? &Vec3::x
                                   : size.y >= size.z                   ? &Vec3::y
                                                                        : &Vec3::z;
        const std::size_t middle = begin + (end - begin) / 2;
        const auto place = [this](std::size_t i) { return triangles_.begin() + static_cast<std::ptrdiff_t>(i); };
        std::nth_element(place(begin), place(middle), place(end), [axis](const Triangle& one, const Triangle& other) {
            return one.a.*axis + one.b.*axis + one.c.*axis < other.a.*axis + other.b.*axis + other.c.*axis;
        });
        build(begin, middle);
        nodes_[at].second = static_cast<std::uint32_t>(nodes_.size());
        build(middle, end);
    }

    std::vector<Triangle> triangles_;
    std::vector<Corners> corners_;  ///< of the same, close together for the search
    std::vector<Vec3> corner_normals_;
    std::vector<Node> nodes_;
    mutable std::atomic<std::uint32_t> last_{0};
};

double angle_between(Vec3 a, Vec3 b) { return std::atan2(norm(cross(a, b)), dot(a, b)); }

std::string in_mm(Vec3 p) {
    return fmt::format("({:.4g}, {:.4g}, {:.4g}) mm", p.x / millimetre, p.y / millimetre, p.z / millimetre);
}

}  // namespace

std::vector<std::uint32_t> welded(std::span<const Vec3> vertices) {
    std::vector<std::uint32_t> order(vertices.size()), same(vertices.size());
    std::iota(order.begin(), order.end(), 0U);
    const auto key = [&](std::uint32_t i) { return std::tie(vertices[i].x, vertices[i].y, vertices[i].z); };
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        return std::tuple_cat(key(a), std::tie(a)) < std::tuple_cat(key(b), std::tie(b));
    });
    for (std::size_t i = 0; i < order.size(); ++i)
        same[order[i]] = i > 0 && key(order[i]) == key(order[i - 1]) ? same[order[i - 1]] : order[i];
    return same;
}

Solid mesh_solid(std::span<const Vec3> vertices, std::span<const std::array<std::uint32_t, 3>> triangles) {
    for (const Vec3& vertex : vertices)
        if (!is_finite(vertex)) throw bad_input("mesh", "a coordinate is not finite; correct the file");
    const std::vector<std::uint32_t> same = welded(vertices);
    std::vector<Triangle> made;
    double volume = 0.0;
    for (const auto& [i, j, k] : triangles) {
        if (std::max({i, j, k}) >= vertices.size())
            throw bad_input("mesh", fmt::format("a corner is vertex {} of {}", std::max({i, j, k}), vertices.size()));
        Triangle t{{vertices[i], vertices[j], vertices[k]}, {same[i], same[j], same[k]}, {}, {}};
        const Vec3 across = cross(t.b - t.a, t.c - t.a);
        if (t.corner[0] == t.corner[1] || t.corner[1] == t.corner[2] || t.corner[2] == t.corner[0]) continue;
        if (norm(across) == 0.0)
            throw bad_input(
                "mesh",
                fmt::format("the triangle at {} has no area, which leaves its side open; repair the mesh", in_mm(t.a)));
        t.face = unit(across);
        volume += dot(t.a - vertices[triangles.front()[0]], across) / 6.0;
        made.push_back(t);
    }

    // Each edge must lead from one corner to another in one triangle, and back in another one.
    std::vector<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>> ways;  // from, to, triangle
    for (std::uint32_t t = 0; t < made.size(); ++t)
        for (std::size_t i = 0; i < 3; ++i) ways.emplace_back(made[t].corner.at(i), made[t].corner.at((i + 1) % 3), t);
    std::sort(ways.begin(), ways.end());
    const auto from_to = [&](std::uint32_t from, std::uint32_t to) {
        const auto begin = std::lower_bound(ways.begin(), ways.end(), std::tuple(from, to, 0U));
        auto end = begin;
        while (end != ways.end() && std::get<0>(*end) == from && std::get<1>(*end) == to) ++end;
        return std::pair(begin, end);
    };
    std::size_t open = 0;
    Vec3 where;
    std::vector<Vec3> corner_normals(vertices.size());
    for (Triangle& t : made) {
        const std::array<Vec3, 3> at{t.a, t.b, t.c};
        for (std::size_t i = 0; i < 3; ++i) {
            const std::size_t next = (i + 1) % 3, last = (i + 2) % 3;
            const auto [here, here_end] = from_to(t.corner.at(i), t.corner.at(next));
            const auto [back, back_end] = from_to(t.corner.at(next), t.corner.at(i));
            if (here_end - here != 1 || back_end - back != 1) {
                ++open;
                where = 0.5 * (at.at(i) + at.at(next));
                continue;
            }
            t.edge.at(i) = t.face + made[std::get<2>(*back)].face;
            Vec3& corner = corner_normals[t.corner.at(i)];
            corner = corner + angle_between(at.at(next) - at.at(i), at.at(last) - at.at(i)) * t.face;
        }
    }
    if (open > 0)
        throw bad_input("mesh",
                        fmt::format("it is not closed: {} sides of triangles, one at {}, do not meet just one other "
                                    "that runs the other way; close the mesh, or correct the order of corners",
                                    open, in_mm(where)));
    if (made.empty() || volume == 0.0) throw bad_input("mesh", "it has no volume; give a closed surface");
    if (volume < 0.0) throw bad_input("mesh", "its faces look inwards; turn the order of their corners round");
    Bounds box;
    for (const Triangle& t : made)
        for (const Vec3 p : {t.a, t.b, t.c}) box.add(p);
    const auto tree = std::make_shared<const Tree>(std::move(made), std::move(corner_normals));
    const auto distance = [tree](Vec3 p) { return tree->distance(p); };
    const auto grid = std::make_shared<const DistanceGrid>(box.low, box.high, distance);
    return {distance, [grid](Vec3 p) { return grid->bound(p); }};
}

}  // namespace haptogram
