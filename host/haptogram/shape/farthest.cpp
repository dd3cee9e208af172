// SPDX-License-Identifier: Apache-2.0
#include "haptogram/shape/farthest.hpp"

#include <algorithm>
#include <limits>
#include <span>

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

}  // namespace haptogram
