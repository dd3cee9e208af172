// SPDX-License-Identifier: Apache-2.0
#include "haptogram/scene/touch_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "haptogram/base/error.hpp"

namespace haptogram {
namespace {

constexpr double longest_gap_s = 0.5;  ///< after a longer one the object has stood still: nobody held it

Solid solid_of(const SceneOptions& options) {
    return built_in_object(options.kind, {options.size_m, options.height_m, {}, {}}).solid;
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

Vec3 TouchScene::inward_at(Vec3 place) const {
    constexpr double step = 1e-6;
    const Pose pose = object();
    const Vec3 at = pose.inwards(place);
    const auto slope = [&](Vec3 way) { return solid_.distance(at + step * way) - solid_.distance(at - step * way); };
    const Vec3 out{slope({1, 0, 0}), slope({0, 1, 0}), slope({0, 0, 1})};
    // In the middle of an object no direction is the nearest; then a finger has come from above.
    return norm(out) > 0.0 ? pose.turned(out * (-1.0 / norm(out))) : Vec3{0, 0, -1};
}

std::vector<Vec3> TouchScene::section_of(std::span<const Vec3> cloud, const Cluster& cluster, Vec3 surface,
                                         Vec3 inward) const {
    const auto beside_plane = [&](Vec3 p) { return std::abs(dot(p - surface, inward)) < options_.slab_m; };
    std::vector<Vec3> points;
    Vec3 low = cluster.points.front(), high = low;
    for (const Vec3& p : cluster.points) {
        low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
        if (beside_plane(p)) points.push_back(p);
    }
    // Outside, what is joined to the points inside is the same finger. It starts within the slab's thickness of them.
    const double margin = 2.0 * options_.slab_m + options_.cluster_m;
    for (const Vec3& p : cloud)
        if (p.x > low.x - margin && p.y > low.y - margin && p.z > low.z - margin && p.x < high.x + margin &&
            p.y < high.y + margin && p.z < high.z + margin && beside_plane(p) && distance_to(p) >= 0.0)
            points.push_back(p);
    std::vector<Cluster> parts = clusters_of(points, options_.cluster_m, 1);
    return parts.empty() ? std::vector<Vec3>{} : std::move(parts.front().points);
}

void TouchScene::meet(std::span<const Vec3> cloud, const std::vector<Cluster>& clusters,
                      const std::vector<TrackedFinger>& tracked) {
    const Pose pose = object();
    std::erase_if(held_, [&](const auto& held) {
        return std::none_of(tracked.begin(), tracked.end(), [&](const auto& t) { return t.id == held.first; });
    });
    fingers_.clear();
    for (const TrackedFinger& t : tracked) {
        const auto found = held_.find(t.id);
        // A finger that has come out, and is in again at another place, begins anew.
        if (found != held_.end() && t.seen && found->second.contact.ended(t.place, pose)) held_.erase(found);
        auto [held, fresh] = held_.try_emplace(
            t.id, Held{FingerContact(options_.contact, t.place, inward_at(t.place), pose), t.place, t.place});
        held->second.from = fresh ? t.place : held->second.to;
        held->second.to = t.place;
        SceneFinger finger;
        finger.id = t.id;
        finger.seen = t.seen;
        finger.place = t.place;
        if (shot_s_ > 0.0) finger.velocity = (t.place - held->second.from) * (1.0 / shot_s_);
        finger.inward = held->second.contact.inward(pose);
        const Vec3 god = held->second.contact.place(pose);
        finger.surface = god + solid_.distance(pose.inwards(god)) * finger.inward;
        if (t.seen) {
            for (const Vec3& p : clusters[t.cluster].points)
                finger.deepest_m = std::max(finger.deepest_m, dot(p - finger.surface, finger.inward));
            finger.section = section_of(cloud, clusters[t.cluster], finger.surface, finger.inward);
        }
        fingers_.push_back(std::move(finger));
    }
}

void TouchScene::simulate(double seconds) {
    if (world_.bodies() == 0) return;
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
            finger.force = {};
            for (const Push& push : held.contact.pushes(held.from + part * (held.to - held.from), velocity, pose,
                                                        [&](Vec3 p) { return world_.velocity_at(0, p); })) {
                world_.push(0, push.force, push.place);
                finger.force = finger.force + push.force;
            }
        }
        world_.step();
    }
}

const std::vector<SceneFinger>& TouchScene::update(std::span<const Vec3> cloud, double time_s) {
    if (time_s_ && !(time_s > *time_s_))
        throw bad_argument("time", fmt::format("{} s after one of {} s; expected a later one", time_s, *time_s_));
    shot_s_ = time_s_ ? time_s - *time_s_ : 0.0;
    time_s_ = time_s;
    const Pose pose = object();
    std::vector<Vec3> inside;
    for (const Vec3& p : cloud)
        if (solid_.contains(pose.inwards(p))) inside.push_back(p);
    const std::vector<Cluster> clusters = clusters_of(inside, options_.cluster_m, options_.least_points);
    meet(cloud, clusters, tracker_.update(clusters));
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
