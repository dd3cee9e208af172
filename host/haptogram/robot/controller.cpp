// SPDX-License-Identifier: Apache-2.0
#include "haptogram/robot/controller.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/robot/kinematics.hpp"

namespace haptogram::robot {

std::string name_of(Event::Kind kind) {
    switch (kind) {
        case Event::Kind::slack: return "slack";
        case Event::Kind::broken: return "broken";
        case Event::Kind::encoder_slip: return "encoder slip";
        case Event::Kind::sensor_lost: return "sensor lost";
        case Event::Kind::out_of_reach: return "out of reach";
        case Event::Kind::overload: return "overload";
        case Event::Kind::cannot_hold: return "cannot hold";
    }
    return "fault";
}

Controller::Controller(const Geometry& geometry, const ControllerOptions& options, const Pose& start)
    : geometry_(geometry), options_(options), pose_(start) {
    require_sound(options.admittance);
    if (!(options.servo_period_s > 0.0 && options.servo_period_s <= options.admittance.period_s))
        throw bad_argument(
            "servo_period",
            fmt::format("must be above 0 and not longer than the admittance's, found {:g} s", options.servo_period_s));
    if (!(options.stiffness_n_m > 0.0 && options.damping_n_s_m >= 0.0 && options.reserve_n >= 0.0))
        throw bad_argument("stiffness", "stiffness must be positive, damping and reserve not negative");
    if (const std::string why = infeasible(geometry, start, geometry.weight()); !why.empty())
        throw bad_argument("start", fmt::format("the handle cannot rest there: {}", why));
    ticks_a_period_ = std::max(1, static_cast<int>(std::lround(options.admittance.period_s / options.servo_period_s)));
    options_.admittance.period_s = ticks_a_period_ * options.servo_period_s;
    length_good_.fill(true);
    tension_good_.fill(true);
    cable_good_.fill(true);
    wanted_.place << start.position, vector_of(start.rotation);
    home_ = cable_lengths(geometry, start);
    lengths_ = last_lengths_ = from_ = target_ = next_target_ = home_;
    const auto pulls = balance(start, geometry.weight());
    if (!pulls) throw bad_argument("start", "no tensions hold the handle there");
    pulls_ = *pulls;
    believe_lengths();
}

void Controller::report(Event::Kind kind, int cable, std::string text) {
    for (const Event& event : events_)
        if (event.kind == kind && event.cable == cable) return;
    events_.push_back({time_, kind, cable, std::move(text)});
    resting_ = true;
}

void Controller::report_overload(const Wrench& user) {
    report(Event::Kind::overload, -1,
           fmt::format("no tensions from {:g} to {:g} N balance a force of ({:.1f}, {:.1f}, {:.1f}) N there",
                       geometry_.least_n, geometry_.most_n, user[0], user[1], user[2]));
}

/// What follows from pose_: the lengths that it has, and the directions in which lengths cannot change.
void Controller::believe_lengths() {
    reference_ = cable_lengths(geometry_, pose_);
    if (const auto space = tension_space(structure_of(geometry_, pose_), Wrench::Zero()))
        impossible_ = space->null_space;
}

/// Tensions that balance a load in a pose, with as much of the reserve as there can be, so that they do not jump where
/// it ends. A cable that is gone has none. None when there are no such tensions.
std::optional<PerCable> Controller::balance(const Pose& pose, const Wrench& load) const {
    const Structure structure = structure_of(geometry_, pose);
    const auto with_reserve = [&](double reserve) {
        PerCable least = PerCable::Constant(geometry_.least_n + reserve);
        PerCable most = PerCable::Constant(geometry_.most_n);
        for (int i = 0; i < cable_count; ++i)
            if (!cable_good_[static_cast<std::size_t>(i)]) least[i] = most[i] = 0.0;
        return distribute(structure, load, least, most);
    };
    const bool whole = std::count(cable_good_.begin(), cable_good_.end(), true) == cable_count;
    if (const auto found = with_reserve(whole ? options_.reserve_n : 0.0)) return found->tensions;
    if (!whole) return std::nullopt;
    auto found = with_reserve(0.0);
    if (!found) return std::nullopt;
    double low = 0.0, high = options_.reserve_n;
    for (int i = 0; i < 12; ++i) {
        const double middle = (low + high) / 2.0;
        if (const auto better = with_reserve(middle)) {
            found = better;
            low = middle;
        } else {
            high = middle;
        }
    }
    return found->tensions;
}

/// The nearest place at which the cables that are left hold the handle: seven cables can do so in a part of the
/// workspace only, and elsewhere leave it a way that stretches none of them.
void Controller::seek_refuge() {
    constexpr double step_m = 0.005, farthest_m = 0.080;
    const Pose here = wanted_.pose();
    for (double radius = 0.0; radius <= farthest_m; radius += step_m)
        for (int x = -1; x <= 1; ++x)
            for (int y = -1; y <= 1; ++y)
                for (int z = -1; z <= 1; ++z) {
                    const Vector3 direction(x, y, z);
                    if ((direction.norm() > 0.0) != (radius > 0.0)) continue;
                    Pose place = here;
                    if (radius > 0.0) place.position += radius * direction.normalized();
                    if (!out_of_length(geometry_, cable_lengths(geometry_, place)).empty()) continue;
                    PerCable least = PerCable::Constant(options_.refuge_least_n),
                             most = PerCable::Constant(options_.refuge_most_n);
                    for (int i = 0; i < cable_count; ++i)
                        if (!cable_good_[static_cast<std::size_t>(i)]) least[i] = most[i] = 0.0;
                    if (!distribute(structure_of(geometry_, place), geometry_.weight(), least, most)) continue;
                    refuge_ = place;
                    return;
                }
    held_ = false;
    report(Event::Kind::cannot_hold, -1, "the cables that are left cannot hold the handle; they let it settle");
}

void Controller::check(const std::array<DriveReading, cable_count>& readings) {
    const auto ticks = [&](double seconds) { return std::lround(seconds / options_.servo_period_s); };
    for (int i = 0; i < cable_count; ++i) {
        const auto at = static_cast<std::size_t>(i);
        const DriveReading& reading = readings[at];
        silent_ticks_[at] = reading.tension_valid ? 0 : silent_ticks_[at] + 1;
        same_ticks_[at] = reading.tension_valid && reading.tension_n == last_tension_[i] ? same_ticks_[at] + 1 : 0;
        if (reading.tension_valid) last_tension_[i] = reading.tension_n;
        if (tension_good_[at] && silent_ticks_[at] >= ticks(options_.silent_s)) {
            tension_good_[at] = false;
            report(Event::Kind::sensor_lost, i, fmt::format("the tension sensor of cable {} does not answer", i + 1));
        }
        if (tension_good_[at] && same_ticks_[at] >= ticks(options_.frozen_s)) {
            tension_good_[at] = false;
            report(Event::Kind::sensor_lost, i,
                   fmt::format("the tension sensor of cable {} has told {:.3f} N for {:g} ms", i + 1, reading.tension_n,
                               options_.frozen_s * 1e3));
        }
        const bool slack = tension_good_[at] && reading.tension_valid && reading.tension_n < options_.slack_n;
        slack_ticks_[at] = slack ? slack_ticks_[at] + 1 : 0;
        // Only the cable that is slack first is taken out: while the handle comes to rest, others may be for a moment.
        if (!resting_ && slack_ticks_[at] >= ticks(options_.slack_s)) {
            const Wrench load = -structure_of(geometry_, pose_) * last_tension_;
            if (!distribute(structure_of(geometry_, pose_), load, geometry_.least_n, geometry_.most_n)) {
                report_overload(load - geometry_.weight());
            } else {
                cable_good_[at] = length_good_[at] = false;
                report(Event::Kind::slack, i, fmt::format("cable {} is slack: {:.3f} N", i + 1, reading.tension_n));
            }
        }
        if (!cable_good_[at] && !broken_[at] && slack && lengths_[i] < reference_[i] - options_.broken_m) {
            broken_[at] = true;
            report(Event::Kind::broken, i,
                   fmt::format("cable {} is broken: its motor has wound in {:.1f} mm", i + 1,
                               (reference_[i] - lengths_[i]) * 1e3));
        }
        const double jump = std::abs(lengths_[i] - last_lengths_[i]);
        if (length_good_[at] && jump > options_.fastest_m_s * options_.servo_period_s) {
            length_good_[at] = false;
            report(Event::Kind::encoder_slip, i,
                   fmt::format("the encoder of cable {} jumped by {:.2f} mm", i + 1, jump * 1e3));
        }
    }
}

/// Eight lengths have six freedoms; what is left shows an encoder that slips slowly.
void Controller::check_lengths() {
    if (std::count(length_good_.begin(), length_good_.end(), true) < cable_count) return;
    const Eigen::Vector2d off = impossible_.transpose() * (lengths_ - reference_);
    if (off.norm() < options_.mismatch_m) return;
    // A slip δ of cable i shows as δ times row i.
    int likely = 0;
    double best = 0.0;
    for (int i = 0; i < cable_count; ++i) {
        const Eigen::Vector2d row = impossible_.row(i).transpose();
        const double likeness = std::abs(row.dot(off)) / row.norm();
        if (likeness <= best) continue;
        best = likeness;
        likely = i;
    }
    report(Event::Kind::encoder_slip, -1,
           fmt::format(
               "the eight lengths fit no pose by {:.2f} mm; the encoder of cable {} is the likeliest to have slipped",
               off.norm() * 1e3, likely + 1));
}

/// The tensions that hold the handle's weight where it is, while it comes to rest.
void Controller::rest() {
    if (const auto pulls = balance(pose_, geometry_.weight())) {
        pulls_ = *pulls;
        return;
    }
    // Not possible here. As little tension as the whole robot would need, without the share of what is gone, leaves the
    // least of a wrench that could push the handle away, until the servos have led it to where it can be held.
    pulls_ = PerCable::Constant(geometry_.least_n);
    if (const auto whole =
            distribute(structure_of(geometry_, pose_), geometry_.weight(), geometry_.least_n, geometry_.most_n))
        pulls_ = whole->tensions;
    for (int i = 0; i < cable_count; ++i)
        if (!cable_good_[static_cast<std::size_t>(i)]) pulls_[i] = 0.0;
}

/// Once in the period of the admittance.
void Controller::period() {
    const bool all_tensions = std::count(tension_good_.begin(), tension_good_.end(), true) == cable_count;
    const PerCable tensions = tension_sum_ / ticks_a_period_;
    tension_sum_.setZero();
    const Wrench cables = cable_sum_ / ticks_a_period_;
    cable_sum_.setZero();
    Wrench inertia = Wrench::Zero();
    inertia.head<3>() = geometry_.mass_kg * wanted_.acceleration.head<3>();
    user_ = all_tensions ? Wrench(inertia - cables - geometry_.weight()) : Wrench::Zero();

    AdmittanceState next = wanted_;
    if (!resting_) {
        next = admit(wanted_, user_ + scene_, options_.admittance);
        if (const std::string why = infeasible(geometry_, next.pose(), geometry_.weight()); !why.empty()) {
            report(Event::Kind::out_of_reach, -1,
                   fmt::format("({:.1f}, {:.1f}, {:.1f}) mm is out of reach: {}", next.place[0] * 1e3,
                               next.place[1] * 1e3, next.place[2] * 1e3, why));
            next = wanted_;
            next.velocity.setZero();
            next.acceleration.setZero();
        }
    } else {
        // The virtual body runs out, or goes to where it can be held, within a few periods.
        const double period = options_.admittance.period_s;
        next.velocity *= 0.5;
        if (refuge_) next.velocity.head<3>() = (refuge_->position - wanted_.place.head<3>()) * 0.9 / period;
        next.acceleration.setZero();
        next.place += period * next.velocity;
        if (!refuge_ && !infeasible(geometry_, next.pose(), geometry_.weight()).empty()) {
            next = wanted_;
            next.velocity.setZero();
        }
    }
    wanted_ = next;
    const Pose pose = wanted_.pose();
    if (!resting_) {
        if (const auto pulls = balance(pose, geometry_.weight() + user_))
            pulls_ = *pulls;
        else
            report_overload(user_);
    }
    if (all_tensions && !resting_) {
        // Only what no wrench needs: errors of the tensions in their null space.
        const PerCable wrong = impossible_ * (impossible_.transpose() * (pulls_ - tensions));
        correction_ += options_.tension_gain / options_.stiffness_n_m * wrong;
    }
    from_ = target_;
    target_ = next_target_;
    next_target_ = cable_lengths(geometry_, pose) - correction_;
}

/// Between two periods the wanted lengths follow a quadratic B-spline through the last three targets: their speed
/// changes evenly from that of the last period to that of this one, because a step of speed would jerk the handle.
void Controller::servo_targets(PerCable& length, PerCable& speed, PerCable& acceleration) const {
    const double period = options_.admittance.period_s;
    const double part = static_cast<double>(ticks_ % ticks_a_period_) / ticks_a_period_;
    const PerCable before = (target_ - from_) / period, after = (next_target_ - target_) / period;
    acceleration = (after - before) / period;
    speed = before + part * (after - before);
    length = (from_ + target_) / 2.0 + period * part * (before + part / 2.0 * (after - before));
}

std::array<std::int16_t, cable_count> Controller::step(const std::array<DriveReading, cable_count>& readings) {
    last_lengths_ = lengths_;
    for (int i = 0; i < cable_count; ++i)
        lengths_[i] = home_[i] + readings[static_cast<std::size_t>(i)].counts * options_.drives.metres_per_count();
    if (ticks_ == 0) last_lengths_ = lengths_;
    const std::size_t known = events_.size();
    check(readings);
    check_lengths();
    if (events_.size() > known) {  // not only at the end of the period
        if (std::count(cable_good_.begin(), cable_good_.end(), true) < cable_count && !refuge_) seek_refuge();
        rest();
    }
    const double blend = options_.servo_period_s / (options_.servo_period_s + options_.velocity_filter_s);
    speeds_ += blend * ((lengths_ - last_lengths_) / options_.servo_period_s - speeds_);
    for (int i = 0; i < cable_count; ++i) {
        const auto at = static_cast<std::size_t>(i);
        if (tension_good_[at] && readings[at].tension_valid) tension_sum_[i] += readings[at].tension_n;
        if (!length_good_[at] && cable_good_[at]) speeds_[i] = 0.0;
    }
    if (std::count(length_good_.begin(), length_good_.end(), true) >= 6) {
        try {
            pose_ = forward(geometry_, lengths_, pose_, length_good_).pose;
            believe_lengths();
        } catch (const Error&) {
            // Slack cables can have lengths that no pose has. The last pose is the best that is known.
            if (!resting_) report(Event::Kind::encoder_slip, -1, "the lengths of the cables fit no pose at all");
        }
    }
    // The directions of the cables change within a period, so their wrench is summed, and not their tensions alone.
    cable_sum_ += structure_of(geometry_, pose_) * last_tension_;
    if (resting_) rest();
    ++ticks_;
    time_ += options_.servo_period_s;
    if (ticks_ % ticks_a_period_ == 0) period();

    PerCable wanted, wanted_speed, wanted_acceleration;
    servo_targets(wanted, wanted_speed, wanted_acceleration);
    std::array<std::int16_t, cable_count> codes{};
    for (int i = 0; i < cable_count; ++i) {
        const auto at = static_cast<std::size_t>(i);
        double pull = pulls_[i] - options_.drive_kg * wanted_acceleration[i];
        if (length_good_[at])
            pull += options_.stiffness_n_m * (lengths_[i] - wanted[i]) +
                    options_.damping_n_s_m * (speeds_[i] - wanted_speed[i]);
        if (!cable_good_[at])  // wound in gently until it is known to be broken
            pull = (broken_[at] ? 0.0 : geometry_.least_n) + options_.damping_n_s_m * speeds_[i];
        else if (held_)
            pull = std::max(pull, geometry_.least_n);  // a cable cannot push
        const auto largest = static_cast<double>(options_.drives.largest_code());
        const double code = std::round(pull / options_.drives.newtons_per_code());
        if (std::abs(code) > largest) ++saturated_;
        codes[at] = static_cast<std::int16_t>(std::clamp(code, -largest, largest));
    }
    return codes;
}

}  // namespace haptogram::robot
