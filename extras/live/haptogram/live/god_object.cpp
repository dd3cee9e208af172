// SPDX-License-Identifier: Apache-2.0
#include "haptogram/live/god_object.hpp"

#include <fmt/format.h>

#include <cmath>

#include "haptogram/base/error.hpp"

namespace haptogram {

void require_sound(const ContactOptions& options) {
    const auto not_negative = [](const char* name, double value) {
        if (!(value >= 0.0 && std::isfinite(value)))
            throw bad_argument(name, fmt::format("found {}, expected 0 or more", value));
    };
    not_negative("stiffness", options.stiffness_n_m);
    not_negative("damping", options.damping_n_s_m);
    not_negative("static friction", options.static_friction);
    not_negative("dynamic friction", options.dynamic_friction);
    not_negative("spread", options.spread_m);
    if (options.dynamic_friction > options.static_friction)
        throw bad_argument("dynamic friction", fmt::format("found {}, expected no more than the static one, {}",
                                                           options.dynamic_friction, options.static_friction));
}

Vec3 slid(Vec3 god_object, Vec3 finger, Vec3 inward, double static_friction, double dynamic_friction) {
    const Vec3 way = finger - god_object;
    const double deep = dot(way, inward);
    const Vec3 along = way - deep * inward;
    const double sideways = norm(along);
    if (!(deep > 0.0) || sideways <= static_friction * deep) return god_object;
    return god_object + ((sideways - dynamic_friction * deep) / sideways) * along;
}

FingerContact::FingerContact(const ContactOptions& options, Vec3 finger, Vec3 inward, const Pose& body)
    : options_(options), inward_{dot(inward, body.x), dot(inward, body.y), dot(inward, body.z)} {
    require_sound(options);
    const Vec3 level = std::abs(inward.z) < 0.9 ? Vec3{0, 0, 1} : Vec3{1, 0, 0};
    const Vec3 side = cross(inward, level) * (1.0 / norm(cross(inward, level)));
    const Vec3 up = cross(side, inward);
    offsets_ = {Vec3{}, options.spread_m * side, -1.0 * options.spread_m * side, options.spread_m * up,
                -1.0 * options.spread_m * up};
    for (std::size_t i = 0; i < god_objects; ++i) gods_.at(i) = body.inwards(finger + offsets_.at(i));
}

std::array<Push, FingerContact::god_objects> FingerContact::pushes(Vec3 finger, Vec3 finger_velocity, const Pose& body,
                                                                   const std::function<Vec3(Vec3 place)>& velocity_of) {
    constexpr double share = 1.0 / god_objects;
    const Vec3 normal = inward(body);
    std::array<Push, god_objects> pushes;
    for (std::size_t i = 0; i < god_objects; ++i) {
        const Vec3 point = finger + offsets_.at(i);
        const Vec3 god =
            slid(body.outwards(gods_.at(i)), point, normal, options_.static_friction, options_.dynamic_friction);
        gods_.at(i) = body.inwards(god);
        const Vec3 force = share * (options_.stiffness_n_m * (point - god) +
                                    options_.damping_n_s_m * (finger_velocity - velocity_of(god)));
        const bool inside = dot(point - god, normal) > 0.0 && dot(force, normal) > 0.0;
        pushes.at(i) = {inside ? force : Vec3{}, god};
    }
    return pushes;
}

void FingerContact::turn(Vec3 finger, Vec3 inward, const Pose& body) {
    const Vec3 from = this->inward(body), axis = cross(from, inward);
    const double cosine = dot(from, inward);
    // By Rodrigues' formula; half a turn has no axis of its own, and any across the normal does.
    const Vec3 across = std::abs(from.x) < 0.9 ? cross(from, {1, 0, 0}) : cross(from, {0, 1, 0});
    const auto turned = [&](Vec3 v) {
        if (cosine < -1.0 + 1e-9) return 2.0 / dot(across, across) * dot(across, v) * across - v;
        return cosine * v + cross(axis, v) + dot(axis, v) / (1.0 + cosine) * axis;
    };
    for (std::size_t i = 0; i < god_objects; ++i) {
        const Vec3 spring = finger + offsets_.at(i) - body.outwards(gods_.at(i));
        offsets_.at(i) = turned(offsets_.at(i));
        gods_.at(i) = body.inwards(finger + offsets_.at(i) - turned(spring));
    }
    inward_ = {dot(inward, body.x), dot(inward, body.y), dot(inward, body.z)};
}

bool FingerContact::ended(Vec3 finger, const Pose& body) const { return dot(finger - place(body), inward(body)) < 0.0; }

double FingerContact::spring_energy(Vec3 finger, const Pose& body) const {
    double energy = 0.0;
    for (std::size_t i = 0; i < god_objects; ++i) {
        const Vec3 way = finger + offsets_.at(i) - body.outwards(gods_.at(i));
        if (dot(way, inward(body)) > 0.0) energy += 0.5 * options_.stiffness_n_m / god_objects * dot(way, way);
    }
    return energy;
}

}  // namespace haptogram
