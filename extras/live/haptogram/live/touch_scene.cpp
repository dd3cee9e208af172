// SPDX-License-Identifier: Apache-2.0
#include "haptogram/live/touch_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>
#include <utility>

#include "haptogram/base/error.hpp"

namespace haptogram {
namespace {

constexpr double longest_gap_s = 0.5;  ///< after a longer one the object has stood still: nobody held it

Solid solid_of(const SceneOptions& options) {
    if (options.solid) return *options.solid;
    return built_in_object(options.kind, {options.size_m, options.height_m, {}, {}}).solid;
}

/// Calls `take` with the points of a cloud that are not farther than a margin from a cluster's box.
template <class Take>
void around(std::span<const Vec3> cloud, const Cluster& cluster, double margin, Take take) {
    Vec3 low = cluster.points.front(), high = low;
    for (const Vec3& p : cluster.points) {
        low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
    for (const Vec3& p : cloud)
        if (p.x > low.x - margin && p.y > low.y - margin && p.z > low.z - margin && p.x < high.x + margin &&
            p.y < high.y + margin && p.z < high.z + margin)
            take(p);
}

}  // namespace

TouchScene::TouchScene(const SceneOptions& options)
    : options_(options), solid_(solid_of(options)), world_(options.world), tracker_(options.gate_m) {
    require_sound(options.contact);
    if (!(options.slab_m > 0.0))
        throw bad_argument("slab", fmt::format("found {} m, expected more than 0", options.slab_m));
    if (options.mass_kg > 0.0) {
        const double height = options.kind == "cylinder" ? options.height_m : options.size_m;
        world_.add(options.kind, options.size_m, height, {options.mass_kg, options.pose});
    }
}

Pose TouchScene::object() const { return world_.bodies() > 0 ? world_.pose(0) : options_.pose; }

double TouchScene::distance_to(Vec3 point) const { return solid_.distance(object().inwards(point)); }

TouchScene::Entry TouchScene::entry_of(std::span<const Vec3> cloud, Cluster cluster) const {
    const Pose pose = object();
    std::vector<Vec3> outside;
    around(cloud, cluster, options_.slab_m + options_.cluster_m, [&](Vec3 p) {
        const Vec3 at = pose.inwards(p);
        if (const double out = solid_.distance(at); out >= 0.0 && out < options_.slab_m) outside.push_back(at);
    });
    Crossing crossing(solid_, outside);
    // What is in the object altogether came in by the nearest face, and in the middle of it from above.
    const std::optional<Vec3> voted = crossing.inward();
    const std::optional<Vec3> nearest = voted ? voted : inward_at(solid_, pose.inwards(cluster.centroid));
    const Vec3 inward = nearest ? pose.turned(*nearest) : Vec3{0, 0, -1};
    return {std::move(cluster), std::move(crossing), inward};
}

std::vector<TouchScene::Entry> TouchScene::entries_of(std::span<const Vec3> cloud) const {
    const Pose pose = object();
    std::vector<Vec3> inside;
    for (const Vec3& p : cloud)
        if (solid_.contains(pose.inwards(p))) inside.push_back(p);
    std::vector<Entry> entries;
    for (Cluster& cluster : clusters_of(inside, options_.cluster_m, options_.least_points))
        entries.push_back(entry_of(cloud, std::move(cluster)));
    join_parts(cloud, entries);
    return entries;
}

/// Whether two parts of skin go through the surface the same way, within 45°, and are together no wider than a finger.
/// Beside an edge a finger goes through two faces, and each part of it may have more of the other one; so it is enough
/// that both go through the face that they go through most together.
bool TouchScene::one_finger(const Entry& a, const Entry& b) const {
    constexpr double same_way = 0.5 * std::numbers::sqrt2;
    const std::optional<Vec3> through = Crossing(a.crossing, b.crossing).inward();
    const bool both = through && a.crossing.area(*through) > 0.0 && b.crossing.area(*through) > 0.0;
    if (!both && dot(a.inward, b.inward) < same_way) return false;
    const Vec3 inward = through ? object().turned(*through) : a.inward;
    return width_across(together(a.cluster, b.cluster).points, inward) <= options_.finger_m;
}

/// Cameras that look along a finger, or at its sides alone, see parts of its skin with gaps between them. Those that
/// are one finger are joined, the nearest pairs first. Ours: the paper has cameras on all sides.
void TouchScene::join_parts(std::span<const Vec3> cloud, std::vector<Entry>& entries) const {
    for (bool joined = options_.finger_m > 0.0; joined;) {
        joined = false;
        std::vector<std::tuple<double, std::size_t, std::size_t>> pairs;
        for (std::size_t a = 0; a < entries.size(); ++a)
            for (std::size_t b = a + 1; b < entries.size(); ++b)
                pairs.emplace_back(distance(entries[a].cluster.centroid, entries[b].cluster.centroid), a, b);
        std::sort(pairs.begin(), pairs.end());
        for (const auto& [way, a, b] : pairs) {
            if (!one_finger(entries[a], entries[b])) continue;
            entries[a] = entry_of(cloud, together(entries[a].cluster, entries[b].cluster));
            entries.erase(entries.begin() + static_cast<std::ptrdiff_t>(b));
            joined = true;
            break;
        }
    }
    std::stable_sort(entries.begin(), entries.end(),
                     [](const Entry& a, const Entry& b) { return a.cluster.points.size() > b.cluster.points.size(); });
}

std::vector<Vec3> TouchScene::section_of(std::span<const Vec3> cloud, const Cluster& cluster, Vec3 surface,
                                         Vec3 inward) const {
    const auto beside_plane = [&](Vec3 p) { return std::abs(dot(p - surface, inward)) < options_.slab_m; };
    std::vector<Vec3> points;
    for (const Vec3& p : cluster.points)
        if (beside_plane(p)) points.push_back(p);
    // Outside, what is joined to the points inside is the same finger. It starts within the slab's thickness of them.
    around(cloud, cluster, 2.0 * options_.slab_m + options_.cluster_m, [&](Vec3 p) {
        if (beside_plane(p) && distance_to(p) >= 0.0) points.push_back(p);
    });
    const std::vector<Cluster> parts = clusters_of(points, options_.cluster_m, 1);
    if (parts.empty()) return {};
    // A part that has points inside is of this finger, too, unless it makes it wider than one.
    std::vector<Vec3> section = parts.front().points;
    for (std::size_t i = 1; i < parts.size(); ++i) {
        if (std::none_of(parts[i].points.begin(), parts[i].points.end(), [&](Vec3 p) { return distance_to(p) < 0.0; }))
            continue;
        std::vector<Vec3> both = section;
        both.insert(both.end(), parts[i].points.begin(), parts[i].points.end());
        if (width_across(both, inward) <= options_.finger_m) section = std::move(both);
    }
    return section;
}

/// The contact of a finger: a new one, or the one that it has, turned to where it goes through the surface now.
/// @param entry  nothing for a finger that is not seen in this shot
TouchScene::Held& TouchScene::hold(const TrackedFinger& finger, const Entry* entry) {
    const Pose pose = object();
    const auto found = held_.find(finger.id);
    // A finger that has come out, and is in again at another place, begins anew.
    if (found != held_.end() && entry != nullptr && found->second.contact.ended(finger.place, pose)) held_.erase(found);
    const Vec3 inward = entry != nullptr ? entry->inward : Vec3{0, 0, -1};
    const auto [at, fresh] = held_.try_emplace(
        finger.id, Held{FingerContact(options_.contact, finger.place, inward, pose), finger.place, finger.place});
    Held& held = at->second;
    if (!fresh && entry != nullptr) {
        constexpr double same = 0.985, bend = 0.5 * std::numbers::sqrt2;  // 10° and 45°
        const double alike = dot(held.contact.inward(pose), entry->inward);
        const auto area = [&](Vec3 way) {
            return entry->crossing.area({dot(way, pose.x), dot(way, pose.y), dot(way, pose.z)});
        };
        // Round a bend the normal follows; over an edge only when most of the finger is on the other face.
        const bool follows = alike > bend || area(entry->inward) >= 2.0 * area(held.contact.inward(pose));
        if (alike < same && follows && area(entry->inward) > 0.0) held.contact.turn(held.to, entry->inward, pose);
    }
    held.from = fresh ? finger.place : held.to;
    held.to = finger.place;
    return held;
}

/// The point of the surface that a god-object belongs to: outwards from one inside, the nearest from one outside.
Vec3 TouchScene::surface_at(Vec3 god, Vec3 inward_of_body) const {
    const Pose pose = object();
    const Vec3 at = pose.inwards(god);
    const double out = solid_.distance(at);
    if (out < 0.0) return god - depth_along(solid_, at, inward_of_body) * pose.turned(inward_of_body);
    const Vec3 way = inward_at(solid_, at).value_or(inward_of_body);
    return god + out * pose.turned(way);
}

void TouchScene::meet(std::span<const Vec3> cloud, const std::vector<Entry>& entries,
                      const std::vector<TrackedFinger>& tracked) {
    const Pose pose = object();
    std::erase_if(held_, [&](const auto& held) {
        return std::none_of(tracked.begin(), tracked.end(), [&](const auto& t) { return t.id == held.first; });
    });
    fingers_.clear();
    for (const TrackedFinger& t : tracked) {
        const Entry* entry = t.seen ? &entries[t.cluster] : nullptr;
        const Held& held = hold(t, entry);
        SceneFinger finger;
        finger.id = t.id;
        finger.seen = t.seen;
        finger.place = t.place;
        if (shot_s_ > 0.0) finger.velocity = (t.place - held.from) * (1.0 / shot_s_);
        finger.inward = held.contact.inward(pose);
        finger.surface = surface_at(held.contact.place(pose), held.contact.inward_of_body());
        if (entry != nullptr) {
            for (const Vec3& p : entry->cluster.points)
                finger.deepest_m = std::max(finger.deepest_m, dot(p - finger.surface, finger.inward));
            finger.section = section_of(cloud, entry->cluster, finger.surface, finger.inward);
        }
        fingers_.push_back(std::move(finger));
    }
}

void TouchScene::simulate(double seconds) {
    const bool moves = world_.bodies() > 0;  // what is fixed is pushed, too, and god-objects slide on it
    if (seconds > longest_gap_s) seconds = longest_gap_s;
    owed_s_ += seconds;
    const double step_s = options_.world.step_s;
    const auto steps = static_cast<std::size_t>(std::floor(owed_s_ / step_s + 1e-9));
    owed_s_ -= static_cast<double>(steps) * step_s;
    for (std::size_t i = 1; i <= steps; ++i) {
        const Pose pose = object();
        const double part = static_cast<double>(i) / static_cast<double>(steps);
        for (SceneFinger& finger : fingers_) {
            Held& held = held_.at(finger.id);
            const Vec3 velocity = (held.to - held.from) * (1.0 / seconds);
            const Vec3 moved = (held.to - held.from) * (1.0 / static_cast<double>(steps));
            const Vec3 place = held.from + part * (held.to - held.from);
            finger.force = {};
            for (const Push& push : held.contact.pushes(
                     place, velocity, pose, [&](Vec3 p) { return moves ? world_.velocity_at(0, p) : Vec3{}; })) {
                if (moves) world_.push(0, push.force, push.place);
                finger.force = finger.force + push.force;
            }
            // A spring's force grows with the way, so its mean over the step is what counts.
            work_j_ += 0.5 * dot(held.force + finger.force, moved);
            held.force = finger.force;
        }
        if (moves) world_.step();
    }
}

const std::vector<SceneFinger>& TouchScene::update(std::span<const Vec3> cloud, double time_s) {
    if (time_s_ && !(time_s > *time_s_))
        throw bad_argument("time", fmt::format("{} s after one of {} s; expected a later one", time_s, *time_s_));
    shot_s_ = time_s_ ? time_s - *time_s_ : 0.0;
    time_s_ = time_s;
    const std::vector<Entry> entries = entries_of(cloud);
    std::vector<Cluster> clusters;
    for (const Entry& entry : entries) clusters.push_back(entry.cluster);
    meet(cloud, entries, tracker_.update(clusters));
    if (shot_s_ > 0.0) simulate(shot_s_);
    return fingers_;
}

double TouchScene::energy() const {
    const Pose pose = object();
    double energy = world_.bodies() > 0 ? world_.energy(0) : 0.0;
    for (const auto& [id, held] : held_) energy += held.contact.spring_energy(held.to, pose);
    return energy;
}

}  // namespace haptogram
