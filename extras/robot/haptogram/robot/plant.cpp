// SPDX-License-Identifier: Apache-2.0
#include "haptogram/robot/plant.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/robot/geometry.hpp"
#include "haptogram/robot/tension.hpp"

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

namespace {

int checked(int cable) {
    if (cable < 0 || cable >= cable_count)
        throw bad_argument("cable", fmt::format("cables are numbered 1 to {}, found {}", cable_count, cable + 1));
    return cable;
}

}  // namespace

User impedance_user(const Impedance& impedance, std::function<Vector3(double)> wanted) {
    return {
        impedance.mass_kg,
        [impedance, wanted = std::move(wanted)](double time, const Vector3& position, const Vector3& velocity) {
            return Vector3(impedance.stiffness_n_m * (wanted(time) - position) - impedance.damping_n_s_m * velocity);
        }};
}

Plant::Plant(const Geometry& geometry, const PlantOptions& options, const Pose& start, User user)
    : geometry_(geometry), options_(options), user_(std::move(user)), pose_(start), random_(options.seed) {
    if (const std::string why = infeasible(geometry, start, geometry.weight()); !why.empty())
        throw bad_argument("start", fmt::format("the handle cannot rest there: {}", why));
    if (!(options.step_s > 0.0 && options.step_s <= 1e-4))
        throw bad_argument("step", fmt::format("an integration step is above 0 and up to 100 us, found {:g} us",
                                               options.step_s * 1e6));
    const double radius = options.drives.pulley_m / 2.0, gear = options.drives.gear;
    drive_kg_ = options.rotor_kg_m2 * gear * gear / (radius * radius);
    const auto tensions = distribute(structure_of(geometry, start), geometry.weight(),
                                     geometry.least_n + options.pretension_n, geometry.most_n);
    if (!tensions)
        throw bad_argument("start", fmt::format("no tensions from {:g} N hold the handle there; take less pretension",
                                                geometry.least_n + options.pretension_n));
    tensions_ = tensions->tensions;
    // A spring of EA/length, stretched by tension·length/EA, so that length + stretch is the distance.
    spooled_ = cable_lengths(geometry, start).cwiseQuotient(PerCable::Ones() + tensions_ / options.cable_n);
    zero_ = spooled_;
    pulls_ = tensions_;
    least_ = tensions_;
    last_told_ = tensions_;
}

void Plant::command(const std::array<std::int16_t, cable_count>& codes) {
    for (std::size_t i = 0; i < codes.size(); ++i) {
        if (std::abs(codes[i]) > options_.drives.largest_code())
            throw bad_argument("codes", fmt::format("code {} of drive {} has more than {} bits", codes[i], i + 1,
                                                    options_.drives.converter_bits));
        pulls_[static_cast<int>(i)] = codes[i] * options_.drives.newtons_per_code();
    }
}

std::array<DriveReading, cable_count> Plant::read() {
    std::array<DriveReading, cable_count> readings;
    for (int i = 0; i < cable_count; ++i) {
        const auto at = static_cast<std::size_t>(i);
        const double told = tensions_[i] + options_.sensor_noise_n * noise_(random_);
        if (!frozen_[at]) last_told_[i] = told;
        readings[at].counts = static_cast<std::int32_t>(
            std::lround((spooled_[i] + slipped_[i] - zero_[i]) / options_.drives.metres_per_count()));
        readings[at].tension_valid = !lost_[at];
        readings[at].tension_n = lost_[at] ? 0.0 : last_told_[i];
    }
    return readings;
}

void Plant::advance(double seconds) {
    const auto steps = std::lround(seconds / options_.step_s);
    for (long i = 0; i < steps; ++i) step();
    // Rounding makes a product of many rotations drift away from one.
    pose_.rotation = Eigen::Quaterniond(pose_.rotation).normalized().toRotationMatrix();
}

void Plant::step() {
    const double dt = options_.step_s;
    const double damping = 2.0 * options_.cable_damping_ratio * std::sqrt(geometry_.mass_kg);
    force_ = user_.force ? user_.force(time_, pose_.position, velocity_) : Vector3::Zero();
    Vector3 force = force_, torque = Vector3::Zero();
    force.z() -= geometry_.mass_kg * gravity_m_s2;
    for (int i = 0; i < cable_count; ++i) {
        const auto at = static_cast<std::size_t>(i);
        const Vector3 arm = pose_.rotation * geometry_.attachments[at];
        const Vector3 cable = geometry_.anchors[at] - pose_.position - arm;
        const double length = cable.norm(), stretch = length - spooled_[i];
        double tension = 0.0;
        if (stretch > 0.0 && !broken_[at]) {
            const Vector3 direction = cable / length;
            const double stiffness = options_.cable_n / spooled_[i];
            const double lengthening = -direction.dot(velocity_ + turning_.cross(arm)) - spool_velocity_[i];
            tension = std::max(0.0, stiffness * stretch + damping * std::sqrt(stiffness) * lengthening);
            force += tension * direction;
            torque += tension * arm.cross(direction);
        }
        tensions_[i] = tension;
        const double net = tension - pulls_[i] - options_.friction_n_s_m * spool_velocity_[i];
        spool_velocity_[i] += dt * net / drive_kg_;
    }
    least_ = least_.cwiseMin(tensions_);
    velocity_ += dt * force / (geometry_.mass_kg + user_.mass_kg);
    const Matrix3 inertia = pose_.rotation * geometry_.inertia_kg_m2.asDiagonal() * pose_.rotation.transpose();
    const Matrix3 mobility =
        pose_.rotation * geometry_.inertia_kg_m2.cwiseInverse().asDiagonal() * pose_.rotation.transpose();
    turning_ += dt * (mobility * (torque - turning_.cross(inertia * turning_)));
    pose_.position += dt * velocity_;
    pose_.rotation = rotation_of(dt * turning_) * pose_.rotation;
    spooled_ += dt * spool_velocity_;
    for (int i = 0; i < cable_count; ++i) {
        if (spooled_[i] >= geometry_.shortest_m / 2.0) continue;
        spooled_[i] = geometry_.shortest_m / 2.0;  // all of a broken cable is wound up
        spool_velocity_[i] = 0.0;
    }
    time_ += dt;
}

PerCable Plant::least_tensions() { return std::exchange(least_, tensions_); }

void Plant::break_cable(int cable) { broken_[static_cast<std::size_t>(checked(cable))] = true; }
void Plant::slip_encoder(int cable, double metres) { slipped_[checked(cable)] += metres; }
void Plant::lose_sensor(int cable) { lost_[static_cast<std::size_t>(checked(cable))] = true; }
void Plant::freeze_sensor(int cable) { frozen_[static_cast<std::size_t>(checked(cable))] = true; }

}  // namespace haptogram::robot
