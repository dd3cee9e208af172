// SPDX-License-Identifier: Apache-2.0
#include "haptogram/shape/tour.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <limits>
#include <nanoflann.hpp>
#include <numeric>
#include <random>
#include <span>
#include <utility>

#include "haptogram/base/error.hpp"

namespace haptogram {
namespace {

struct Candidate {
    Vec3 at;
    double gap2 = std::numeric_limits<double>::infinity();  ///< square of the distance to the nearest chosen point
    std::size_t index = 0;
};

bool is_farther(const Candidate& a, const Candidate& b) {
    return a.gap2 > b.gap2 || (a.gap2 == b.gap2 && a.index < b.index);
}

/// Neighbouring candidates, with the box around them. When a newly chosen point is far from the box, no candidate in
/// it changes, and one comparison with the box replaces one with each candidate.
struct Group {
    std::span<Candidate> members;
    Vec3 low, high;
    Candidate farthest;
};

double square(double a) { return a * a; }

/// Square of the distance from `p` to the box. It never exceeds that to any member, even after rounding, because every
/// step of both calculations is monotonic.
double box_gap2(const Group& group, Vec3 p) {
    const auto outside = [](double low, double high, double v) { return std::max({low - v, v - high, 0.0}); };
    return square(outside(group.low.x, group.high.x, p.x)) + square(outside(group.low.y, group.high.y, p.y)) +
           square(outside(group.low.z, group.high.z, p.z));
}

void choose(Vec3 p, Group& group) {
    for (Candidate& candidate : group.members)
        candidate.gap2 = std::min(
            candidate.gap2, square(candidate.at.x - p.x) + square(candidate.at.y - p.y) + square(candidate.at.z - p.z));
    group.farthest = *std::min_element(group.members.begin(), group.members.end(), is_farther);
}

/// Halves the widest axis at the median until groups are small.
void divide(std::span<Candidate> members, std::vector<Group>& groups) {
    constexpr std::size_t largest_group = 128;
    Group group{members, members.front().at, members.front().at, members.front()};
    double widest = -1.0;
    double Vec3::*across = &Vec3::x;
    for (double Vec3::*const axis : {&Vec3::x, &Vec3::y, &Vec3::z}) {
        for (const Candidate& candidate : members) {
            group.low.*axis = std::min(group.low.*axis, candidate.at.*axis);
            group.high.*axis = std::max(group.high.*axis, candidate.at.*axis);
        }
        if (group.high.*axis - group.low.*axis > widest) {
            widest = group.high.*axis - group.low.*axis;
            across = axis;
        }
    }
    if (members.size() <= largest_group) {
        groups.push_back(group);
        return;
    }
    const std::size_t half = members.size() / 2;
    std::nth_element(members.begin(), members.begin() + static_cast<std::ptrdiff_t>(half), members.end(),
                     [across](const Candidate& a, const Candidate& b) { return a.at.*across < b.at.*across; });
    divide(members.first(half), groups);
    divide(members.subspan(half), groups);
}

}  // namespace

std::vector<std::size_t> farthest_points(const std::vector<Vec3>& candidates, std::size_t count, std::size_t first) {
    std::vector<std::size_t> chosen;
    if (candidates.empty() || count == 0) return chosen;
    std::vector<Candidate> all(candidates.size());
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = {candidates[i], std::numeric_limits<double>::infinity(), i};
    Candidate next = all.at(first);
    std::vector<Group> groups;
    divide(all, groups);
    while (chosen.size() < count && next.gap2 > 0.0) {
        chosen.push_back(next.index);
        const Vec3 p = next.at;
        next.gap2 = 0.0;
        for (Group& group : groups) {
            if (box_gap2(group, p) < group.farthest.gap2) choose(p, group);
            if (is_farther(group.farthest, next)) next = group.farthest;
        }
    }
    return chosen;
}

namespace {

/// In [0, 1), equal on every platform, which std::uniform_real_distribution does not promise.
double uniform(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1p-53; }

template <class Kind>
std::vector<const Kind*> pieces_of(const Shape& shape) {
    std::vector<const Kind*> found;
    for (const Piece& piece : shape.pieces)
        if (const Kind* const one = std::get_if<Kind>(&piece)) found.push_back(one);
    return found;
}

void along(const Curve& curve, std::size_t count, std::vector<Vec3>& out) {
    if (count == 1 && !curve.closed) {
        out.push_back(curve.at(0.5 * curve.length));
        return;
    }
    const auto steps = static_cast<double>(curve.closed ? count : count - 1);
    for (std::size_t i = 0; i < count; ++i)
        out.push_back(curve.at(std::min(curve.length, curve.length * (static_cast<double>(i) / steps))));
}

void along(const std::vector<const Curve*>& curves, std::size_t count, std::vector<Vec3>& out) {
    if (curves.empty()) return;
    std::vector<double> lengths;
    lengths.reserve(curves.size());
    for (const Curve* curve : curves) lengths.push_back(curve->length);
    const std::vector<std::size_t> shares = share(count, lengths);
    for (std::size_t i = 0; i < curves.size(); ++i)
        if (shares[i] > 0) along(*curves[i], shares[i], out);
}

/// Random points, equally dense everywhere on the surface. The triangles are laid out in a row by their areas; even
/// steps along the row, from a random start, choose the triangle of each point.
void over(const std::vector<const Mesh*>& meshes, std::size_t count, std::mt19937_64& random, std::vector<Vec3>& out) {
    struct Triangle {
        Vec3 corner, side, other_side;
        double area_until;
    };
    std::vector<Triangle> strip;
    double area = 0.0;
    for (const Mesh* mesh : meshes) {
        for (const auto& [a, b, c] : mesh->triangles) {
            const Vec3 corner = mesh->vertices[a];
            const Vec3 side = mesh->vertices[b] - corner;
            const Vec3 other_side = mesh->vertices[c] - corner;
            area += 0.5 * norm(cross(side, other_side));
            strip.push_back({corner, side, other_side, area});
        }
    }
    if (area == 0.0) return;
    const double start = uniform(random);
    auto triangle = strip.begin();
    for (std::size_t i = 0; i < count; ++i) {
        const double at = area * (static_cast<double>(i) + start) / static_cast<double>(count);
        while (triangle->area_until < at && triangle + 1 != strip.end()) ++triangle;
        const double root = std::sqrt(uniform(random));  // evenly over a triangle: Osada et al. 2002, eq. 1
        const double part = uniform(random);
        out.push_back(triangle->corner + root * (1.0 - part) * triangle->side + root * part * triangle->other_side);
    }
}

}  // namespace

std::vector<std::size_t> share(std::size_t count, const std::vector<double>& weights) {
    const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
    std::vector<std::size_t> shares(weights.size());
    std::vector<double> remainders(weights.size());
    std::size_t given = 0;
    for (std::size_t i = 0; i < weights.size(); ++i) {
        const double exact = total > 0.0 ? static_cast<double>(count) * weights[i] / total : 0.0;
        shares[i] = std::min(static_cast<std::size_t>(exact), count - given);
        remainders[i] = exact - std::floor(exact);
        given += shares[i];
    }
    std::vector<std::size_t> order(weights.size());
    std::iota(order.begin(), order.end(), 0U);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return remainders[a] > remainders[b]; });
    for (std::size_t k = 0; given < count; ++k, ++given) ++shares[order[k % order.size()]];
    return shares;
}

Sampled sample(const Shape& shape, std::size_t count, std::uint64_t seed) {
    if (count == 0)
        throw bad_argument("points", "found 0, expected at least 1; ask for as many points as the hand shall feel",
                           {"points"});
    const auto curves = pieces_of<Curve>(shape);
    const auto meshes = pieces_of<Mesh>(shape);
    const auto clouds = pieces_of<Cloud>(shape);
    constexpr std::size_t least_candidates = 10'000;
    constexpr std::size_t candidates_per_point = 20;
    const std::size_t dense = std::max(candidates_per_point * count, least_candidates);
    const bool only_curves = meshes.empty() && clouds.empty();

    std::mt19937_64 random(seed);
    std::vector<Vec3> candidates;
    along(curves, only_curves ? count : dense, candidates);
    over(meshes, dense, random, candidates);
    for (const Cloud* cloud : clouds) candidates.insert(candidates.end(), cloud->points.begin(), cloud->points.end());
    if (candidates.empty())
        throw bad_argument("shape", "found nothing, expected a curve, a surface or points; name a shape", {"shape"});

    const auto first = static_cast<std::size_t>(uniform(random) * static_cast<double>(candidates.size()));
    std::vector<std::size_t> chosen = farthest_points(candidates, count, first);
    std::sort(chosen.begin(), chosen.end());
    Sampled sampled;
    for (const std::size_t index : chosen) sampled.points.push_back(candidates[index]);
    if (chosen.size() < count) sampled.duplicates_removed = candidates.size() - chosen.size();
    return sampled;
}

namespace {

/// The points as nanoflann wants to see them.
struct PointsView {
    const std::vector<Vec3>& points;

    [[nodiscard]] std::size_t kdtree_get_point_count() const { return points.size(); }
    [[nodiscard]] double kdtree_get_pt(std::size_t i, std::size_t axis) const {
        return axis == 0 ? points[i].x : axis == 1 ? points[i].y : points[i].z;
    }
    template <class Box>
    bool kdtree_get_bbox(Box& /*box*/) const {
        return false;
    }
};

using Tree =
    nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, PointsView>, PointsView, 3, std::size_t>;

/// Nanoflann result set: the nearest point not yet visited, the lowest index among equals.
class NearestUnvisited {
public:
    explicit NearestUnvisited(const std::vector<bool>& visited) : visited_(visited) {}

    [[nodiscard]] static bool full() { return true; }
    [[nodiscard]] double worstDist() const { return distance2_; }
    bool addPoint(double distance2, std::size_t index) {
        if (!visited_[index] && (distance2 < distance2_ || (distance2 == distance2_ && index < index_))) {
            distance2_ = distance2;
            index_ = index;
        }
        return true;
    }
    [[nodiscard]] std::size_t index() const { return index_; }

private:
    const std::vector<bool>& visited_;
    double distance2_ = std::numeric_limits<double>::infinity();
    std::size_t index_ = std::numeric_limits<std::size_t>::max();
};

std::vector<std::size_t> nearest_neighbour_tour(const std::vector<Vec3>& points, const Tree& tree) {
    std::vector<bool> visited(points.size());
    std::vector<std::size_t> tour{0};
    visited[0] = true;
    while (tour.size() < points.size()) {
        NearestUnvisited nearest(visited);
        const Vec3& here = points[tour.back()];
        const std::array<double, 3> query{here.x, here.y, here.z};
        tree.findNeighbors(nearest, query.data(), nanoflann::SearchParams());
        tour.push_back(nearest.index());
        visited[nearest.index()] = true;
    }
    return tour;
}

constexpr std::size_t neighbour_count = 10;

std::vector<std::vector<std::size_t>> neighbour_lists(const std::vector<Vec3>& points, const Tree& tree) {
    std::vector<std::vector<std::size_t>> lists(points.size());
    std::array<std::size_t, neighbour_count + 1> indices{};
    std::array<double, neighbour_count + 1> distances2{};
    for (std::size_t i = 0; i < points.size(); ++i) {
        const std::array<double, 3> query{points[i].x, points[i].y, points[i].z};
        const std::size_t found = tree.knnSearch(query.data(), indices.size(), indices.data(), distances2.data());
        for (std::size_t k = 0; k < found; ++k)
            if (indices.at(k) != i) lists[i].push_back(indices.at(k));
    }
    return lists;
}

/// A closed tour that can be shortened.
class Tour {
public:
    Tour(const std::vector<Vec3>& points, std::vector<std::size_t> order)
        : points_(points), order_(std::move(order)), position_(order_.size()) {
        for (std::size_t i = 0; i < order_.size(); ++i) position_[order_[i]] = i;
    }

    [[nodiscard]] const std::vector<std::size_t>& order() const { return order_; }

    /// Makes the first move found that replaces one of the two edges at `a` and shortens the tour.
    /// @return the points whose edges changed; none when there was no such move
    std::vector<std::size_t> improve(std::size_t a, const std::vector<std::size_t>& neighbours) {
        for (const bool forward : {true, false}) {
            if (auto touched = two_opt(a, neighbours, forward); !touched.empty()) return touched;
            if (auto touched = or_opt(a, neighbours, forward); !touched.empty()) return touched;
        }
        return {};
    }

private:
    [[nodiscard]] double length(std::size_t a, std::size_t b) const { return distance(points_[a], points_[b]); }
    [[nodiscard]] std::size_t next(std::size_t a, bool forward = true) const {
        const std::size_t i = position_[a];
        const std::size_t last = order_.size() - 1;
        return forward ? order_[i == last ? 0 : i + 1] : order_[i == 0 ? last : i - 1];
    }
    /// A difference that may be rounding is no gain; otherwise moves could undo each other for ever.
    static bool is_gain(double removed, double added) { return removed - added > 1e-9 * removed; }

    /// The edge from `a` to b, and one from a neighbour c of `a` to d in the same direction, become a–c and b–d.
    std::vector<std::size_t> two_opt(std::size_t a, const std::vector<std::size_t>& neighbours, bool forward) {
        const std::size_t b = next(a, forward);
        for (const std::size_t c : neighbours) {
            if (length(a, c) >= length(a, b)) break;
            const std::size_t d = next(c, forward);
            if (c == b || d == a || !is_gain(length(a, b) + length(c, d), length(a, c) + length(b, d))) continue;
            exchange(a, b, c);
            return {a, b, c, d};
        }
        return {};
    }

    /// The one to three points from `a` to `last`, going away from `before`, move in between a neighbour c of `a` and a
    /// point d beside it; `a` comes to lie beside c and `last` beside d.
    std::vector<std::size_t> or_opt(std::size_t a, const std::vector<std::size_t>& neighbours, bool forward) {
        constexpr std::size_t longest = 3;
        const std::size_t n = order_.size();
        const std::size_t before = next(a, !forward);
        std::size_t last = a;
        for (std::size_t size = 1; size <= longest && size + 3 <= n; ++size, last = next(last, forward)) {
            const std::size_t after = next(last, forward);
            const double freed = length(before, a) + length(last, after) - length(before, after);
            for (const std::size_t c : neighbours) {
                if (length(a, c) >= freed) break;
                const std::size_t steps_to_c =
                    (forward ? position_[c] + n - position_[a] : position_[a] + n - position_[c]) % n;
                if (steps_to_c < size) continue;  // c is one of those that would move
                for (const bool beyond : {true, false}) {
                    const std::size_t d = next(c, beyond == forward);
                    if ((c == before && d == a) || (c == after && d == last)) continue;
                    if (!is_gain(freed + length(c, d), length(a, c) + length(last, d))) continue;
                    if (beyond) {                    // before [a…last] [after…c] d
                        exchange(before, a, c);      // before [c…after] [last…a] d
                        exchange(before, c, after);  // before [after…c] [last…a] d
                        exchange(c, last, a);        // before [after…c] [a…last] d
                    } else {                         // before [a…last] [after…d] c
                        exchange(before, a, d);      // before [d…after] [last…a] c
                        exchange(before, d, after);  // before [after…d] [last…a] c
                    }
                    return {before, after, a, last, c, d};
                }
            }
        }
        return {};
    }

    /// Replaces the edge a–b, and the edge from c to its neighbour d in the same direction, by a–c and b–d. The path
    /// from b to c is reversed by this.
    void exchange(std::size_t a, std::size_t b, std::size_t c) {
        if (next(a) == b)
            reverse(b, c);
        else
            reverse(c, b);
    }

    /// Reverses the path from `from` on to `to`, or the rest of the tour, which gives the same closed tour; whichever
    /// is shorter.
    void reverse(std::size_t from, std::size_t to) {
        const std::size_t n = order_.size();
        std::size_t i = position_[from];
        std::size_t j = position_[to];
        std::size_t inside = (j + n - i) % n + 1;
        if (2 * inside > n) {
            std::swap(i, j);
            i = (i + 1) % n;
            j = (j + n - 1) % n;
            inside = n - inside;
        }
        for (std::size_t swaps = inside / 2; swaps > 0; --swaps) {
            std::swap(order_[i], order_[j]);
            position_[order_[i]] = i;
            position_[order_[j]] = j;
            i = i + 1 == n ? 0 : i + 1;
            j = j == 0 ? n - 1 : j - 1;
        }
    }

    const std::vector<Vec3>& points_;
    std::vector<std::size_t> order_;
    std::vector<std::size_t> position_;
};

}  // namespace

std::vector<std::size_t> closed_tour(const std::vector<Vec3>& points) {
    std::vector<std::size_t> order(points.size());
    std::iota(order.begin(), order.end(), 0U);
    if (points.size() <= 3) return order;
    const PointsView view{points};
    const Tree tree(3, view);
    const auto neighbours = neighbour_lists(points, tree);
    Tour tour(points, nearest_neighbour_tour(points, tree));
    std::deque<std::size_t> to_try(tour.order().begin(), tour.order().end());
    std::vector<bool> waiting(points.size(), true);
    while (!to_try.empty()) {
        const std::size_t point = to_try.front();
        to_try.pop_front();
        waiting[point] = false;
        for (const std::size_t touched : tour.improve(point, neighbours[point])) {
            if (!waiting[touched]) to_try.push_back(touched);
            waiting[touched] = true;
        }
    }
    order = tour.order();
    std::rotate(order.begin(), std::find(order.begin(), order.end(), 0U), order.end());
    return order;
}

double tour_length(const std::vector<Vec3>& points, const std::vector<std::size_t>& order) {
    double length = 0.0;
    for (std::size_t i = 0; i < order.size(); ++i)
        length += distance(points.at(order[i]), points.at(order[(i + 1) % order.size()]));
    return length;
}

}  // namespace haptogram
