// SPDX-License-Identifier: Apache-2.0
#include "haptogram/robot/admittance.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "haptogram/base/error.hpp"

namespace haptogram::robot {

Vector3 Zones::force(const Vector3& position) const {
    const double radius = position.norm();
    if (radius <= inner_m) return -inner_n_m * position;
    if (radius <= middle_m) return Vector3::Zero();
    return -outer_n_m * (radius - middle_m) / radius * position;
}

int Zones::zone(const Vector3& position) const {
    const double radius = position.norm();
    return radius <= inner_m ? 1 : radius <= middle_m ? 2 : radius <= outer_m ? 3 : 4;
}

Pose AdmittanceState::pose() const { return {place.head<3>(), rotation_of(place.tail<3>())}; }

AdmittanceState admit(const AdmittanceState& state, const Wrench& wrench, const AdmittanceOptions& options) {
    const double period = options.period_s;
    Wrench spring;
    spring << options.zones.force(state.place.head<3>()), -options.turn_stiffness_n_m * state.place.tail<3>();
    Wrench inertia, damping;
    inertia << Vector3::Constant(options.inertia_kg), Vector3::Constant(options.turn_inertia_kg_m2);
    damping << Vector3::Constant(options.damping_n_s_m), Vector3::Constant(options.turn_damping_n_m_s);
    AdmittanceState next;
    next.velocity = (state.velocity + period * (wrench + spring).cwiseQuotient(inertia))
                        .cwiseQuotient(Wrench::Ones() + period * damping.cwiseQuotient(inertia));
    next.acceleration = (next.velocity - state.velocity) / period;
    next.place = state.place + period * next.velocity;
    return next;
}

void require_sound(const AdmittanceOptions& options) {
    const auto positive = [](double value, const char* name) {
        if (!(value > 0.0 && std::isfinite(value)))
            throw bad_argument(name, fmt::format("must be a positive number, found {:g}", value));
    };
    positive(options.period_s, "period");
    positive(options.inertia_kg, "inertia");
    positive(options.turn_inertia_kg_m2, "turn_inertia");
    const Zones& zones = options.zones;
    if (!(zones.inner_m > 0.0 && zones.inner_m < zones.middle_m && zones.middle_m < zones.outer_m))
        throw bad_argument("zones", fmt::format("the radii must grow, found {:g}, {:g} and {:g} mm",
                                                zones.inner_m * 1e3, zones.middle_m * 1e3, zones.outer_m * 1e3));
    if (!(options.damping_n_s_m >= 0.0 && options.turn_damping_n_m_s >= 0.0 && options.turn_stiffness_n_m >= 0.0 &&
          zones.inner_n_m >= 0.0 && zones.outer_n_m >= 0.0))
        throw bad_argument("stiffness", "dampings and stiffnesses must not be negative");
    const double square = options.period_s * options.period_s;
    const double stiffest = std::max(zones.inner_n_m, zones.outer_n_m);
    if (stiffest * square / options.inertia_kg >= 4.0 ||
        options.turn_stiffness_n_m * square / options.turn_inertia_kg_m2 >= 4.0)
        throw bad_argument("stiffness", fmt::format("a spring over its inertia must stay below 4/T² = {:g} s⁻² to be "
                                                    "stable; take less stiffness or more inertia",
                                                    4.0 / square));
}

}  // namespace haptogram::robot
