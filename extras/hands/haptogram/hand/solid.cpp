// SPDX-License-Identifier: Apache-2.0
#include "haptogram/hand/solid.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <numeric>
#include <tuple>
#include <vector>

#include "haptogram/array/rig.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/text.hpp"

namespace haptogram {
namespace {

/// A point of the half-plane in which a solid of revolution has its profile.
struct Profile {
    double r, z;
};

/// A line of the profile.
struct ProfileLine {
    Profile from;
    double er, ez;          ///< to its end
    double inverse_square;  ///< of its length
};

/// Distance to the surface of a convex solid of revolution: the nearest of its profile's lines, negative when the point
/// is on the inner side of all.
double revolved_distance(const std::vector<ProfileLine>& lines, double r, double z) {
    double nearest = std::numeric_limits<double>::infinity();  // squared
    bool inside = true;
    for (const ProfileLine& line : lines) {
        const double pr = r - line.from.r, pz = z - line.from.z;
        const double part = std::clamp((pr * line.er + pz * line.ez) * line.inverse_square, 0.0, 1.0);
        const double dr = pr - part * line.er, dz = pz - part * line.ez;
        nearest = std::min(nearest, dr * dr + dz * dz);
        inside = inside && line.er * pz - line.ez * pr > 0.0;
    }
    return inside ? -std::sqrt(nearest) : std::sqrt(nearest);
}

/// @param corners  of the profile, in the order in which the solid is on the left of the way. Lines that lie on the
/// axis
///                 are no surface, so they are not given
Solid revolved(Vec3 at, const std::vector<Profile>& corners) {
    std::vector<ProfileLine> lines;
    for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
        const double er = corners[i + 1].r - corners[i].r, ez = corners[i + 1].z - corners[i].z;
        lines.push_back({corners[i], er, ez, 1.0 / (er * er + ez * ez)});
    }
    return {[at, lines = std::move(lines)](Vec3 p) {
        const double x = p.x - at.x, y = p.y - at.y;
        return revolved_distance(lines, std::sqrt(x * x + y * y), p.z - at.z);
    }};
}

double segment_distance(Vec3 p, Vec3 a, Vec3 b) {
    const double part = std::clamp(dot(p - a, b - a) / dot(b - a, b - a), 0.0, 1.0);
    return distance(p, a + part * (b - a));
}

/// Distance to a flat convex face. @param corners  anticlockwise, seen from outside
double face_distance(Vec3 p, const std::vector<Vec3>& corners, Vec3 normal) {
    bool above = true;
    double edges = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const Vec3 a = corners[i], b = corners[(i + 1) % corners.size()];
        above = above && dot(cross(normal, b - a), p - a) >= 0.0;
        edges = std::min(edges, segment_distance(p, a, b));
    }
    return above ? std::abs(dot(p - corners.front(), normal)) : edges;
}

}  // namespace

Solid solid_sphere(Vec3 centre, double radius) {
    require_positive("radius", radius);
    return {[=](Vec3 p) { return distance(p, centre) - radius; }};
}

Solid solid_box(Vec3 centre, Vec3 edges) {
    for (const double edge : {edges.x, edges.y, edges.z}) require_positive("edges", edge);
    return {[=](Vec3 p) {
        const Vec3 beyond{std::abs(p.x - centre.x) - 0.5 * edges.x, std::abs(p.y - centre.y) - 0.5 * edges.y,
                          std::abs(p.z - centre.z) - 0.5 * edges.z};
        const Vec3 outside{std::max(beyond.x, 0.0), std::max(beyond.y, 0.0), std::max(beyond.z, 0.0)};
        return norm(outside) + std::min(0.0, std::max({beyond.x, beyond.y, beyond.z}));
    }};
}

Solid half_space(Vec3 point, Vec3 normal) {
    const double length = norm(normal);
    require_positive("normal", length);
    return {[point, n = normal * (1.0 / length)](Vec3 p) { return dot(p - point, n); }};
}

Solid solid_cylinder(Vec3 centre, double radius, double height) {
    require_positive("radius", radius);
    require_positive("height", height);
    return revolved(centre, {{0, -0.5 * height}, {radius, -0.5 * height}, {radius, 0.5 * height}, {0, 0.5 * height}});
}

Solid solid_cone(Vec3 base, double radius, double height) {
    require_positive("radius", radius);
    require_positive("height", height);
    return revolved(base, {{0, 0}, {radius, 0}, {0, height}});
}

Solid solid_pyramid(Vec3 base, double edge, double height) {
    require_positive("edge", edge);
    require_positive("height", height);
    const double h = 0.5 * edge;
    const Vec3 tip = base + Vec3{0, 0, height};
    const std::vector<Vec3> corners{base + Vec3{-h, -h, 0}, base + Vec3{h, -h, 0}, base + Vec3{h, h, 0},
                                    base + Vec3{-h, h, 0}};
    std::vector<std::vector<Vec3>> faces{{corners[3], corners[2], corners[1], corners[0]}};
    for (std::size_t i = 0; i < 4; ++i) faces.push_back({corners[i], corners[(i + 1) % 4], tip});
    std::array<Vec3, 5> normals;
    for (std::size_t i = 0; i < faces.size(); ++i) {
        const Vec3 across = cross(faces[i][1] - faces[i][0], faces[i][2] - faces[i][0]);
        normals[i] = across * (1.0 / norm(across));
    }
    // Above the highest plane of a face. Inside a convex solid that is the nearest face, outside the surface is
    // farther.
    const auto above = [points = std::array{faces[0][0], faces[1][0], faces[2][0], faces[3][0], faces[4][0]},
                        normals](Vec3 p) {
        double highest = -std::numeric_limits<double>::infinity();
        for (std::size_t i = 0; i < points.size(); ++i) highest = std::max(highest, dot(p - points[i], normals[i]));
        return highest;
    };
    return {[above, faces, normals](Vec3 p) {
                if (const double highest = above(p); highest < 0.0) return highest;
                double nearest = std::numeric_limits<double>::infinity();
                for (std::size_t i = 0; i < faces.size(); ++i)
                    if (dot(p - faces[i][0], normals[i]) >= 0.0)  // the nearest face is one that the point sees
                        nearest = std::min(nearest, face_distance(p, faces[i], normals[i]));
                return nearest;
            },
            above};
}

Solid moved(const Solid& solid, Vec3 shift, Vec3 angles_deg) {
    const Pose pose = pose_of(shift, angles_deg);
    Solid result{[distance = solid.distance, pose](Vec3 p) { return distance(pose.inwards(p)); }};
    if (solid.bound) result.bound = [bound = solid.bound, pose](Vec3 p) { return bound(pose.inwards(p)); };
    return result;
}

namespace {

/// Along the longest edge of the box. More take longer to make, and tell more of the skin near the surface.
constexpr double steps = 32.0;

}  // namespace

DistanceGrid::DistanceGrid(Vec3 low, Vec3 high, const std::function<double(Vec3)>& distance) : low_(low), high_(high) {
    const Vec3 size = high - low;
    step_ = std::max({size.x, size.y, size.z}) / steps;
    count_ = {static_cast<std::size_t>(std::ceil(size.x / step_)) + 1,
              static_cast<std::size_t>(std::ceil(size.y / step_)) + 1,
              static_cast<std::size_t>(std::ceil(size.z / step_)) + 1};
    distances_.reserve(count_[0] * count_[1] * count_[2]);
    for (std::size_t k = 0; k < count_[2]; ++k)
        for (std::size_t j = 0; j < count_[1]; ++j)
            for (std::size_t i = 0; i < count_[0]; ++i)
                distances_.push_back(static_cast<float>(distance(place(i, j, k))));
}

Vec3 DistanceGrid::place(std::size_t i, std::size_t j, std::size_t k) const {
    return low_ + step_ * Vec3{static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)};
}

double DistanceGrid::bound(Vec3 p) const {
    const Vec3 outside{std::max({low_.x - p.x, 0.0, p.x - high_.x}), std::max({low_.y - p.y, 0.0, p.y - high_.y}),
                       std::max({low_.z - p.z, 0.0, p.z - high_.z})};
    const double to_box = norm(outside);
    const auto nearest = [this](double from_low, std::size_t count) {
        return static_cast<std::size_t>(std::clamp(std::round(from_low / step_), 0.0, static_cast<double>(count - 1)));
    };
    const Vec3 from_low = p - low_;
    const std::size_t i = nearest(from_low.x, count_[0]), j = nearest(from_low.y, count_[1]),
                      k = nearest(from_low.z, count_[2]);
    const double there = distances_[(k * count_[1] + j) * count_[0] + i];
    constexpr double rounding = 1.0 - 1e-6;  // of the distances that are kept in single precision
    const double least = rounding * std::abs(there) - norm(p - place(i, j, k));
    // Farther out than the box's wall, the solid is at least as far as the wall.
    return least > to_box ? std::copysign(least, there) : to_box;
}

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
