// SPDX-License-Identifier: Apache-2.0
#include "haptogram/robot/controller.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/robot/geometry.hpp"

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

/// The motors yield from now on: the handle is pulled back to where it was wanted, by tensions within their limits.
void Controller::overload(const Wrench& user) {
    if (yielding_) return;
    Wrench force = Wrench::Zero();
    force.head<3>() = user.head<3>();
    const double part = largest_wrench(geometry_, wanted_.pose(), force).value_or(0.0);
    report(Event::Kind::overload, -1,
           fmt::format("no tensions from {:g} to {:g} N balance a force of ({:.1f}, {:.1f}, {:.1f}) N there, {:.1f} N "
                       "that way are the most; the motors yield, and the handle gives way",
                       geometry_.least_n, geometry_.most_n, user[0], user[1], user[2], part * force.norm()));
    yielding_ = true;
    led_ = wanted_.place.head<3>();
    refuge_ = Pose{led_, Matrix3::Identity()};
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
        return distribute(structure, load, least, most);
    };
    if (const auto found = with_reserve(options_.reserve_n)) return found->tensions;
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

bool Controller::whole() const { return std::count(cable_good_.begin(), cable_good_.end(), true) == cable_count; }

/// Without one of the cables no servo of lengths is safe: seven cables leave the handle ways that stretch none of them,
/// and it would turn over. What they can do is to make the wrench that leads it to a refuge, as nearly as their limits
/// allow. There it rests. A user who is stronger than they are moves it against their damping. Eight cables that yield
/// are led in the same way, back to where the handle was wanted.
void Controller::lead_by_tensions() {
    const Pose here = pose_;
    if (!braking_ && !whole() && vector_of(here.rotation).norm() > options_.turned_rad) {
        braking_ = true;
        braked_ = lengths_;
        report(
            Event::Kind::cannot_hold, -1,
            "the cables that are left have lost the handle, which turns over; the motors wind in and let out no more");
    }
    if (braking_) return brake();
    if (tumbles()) {
        led_ = here.position;
        led_m_s_ = 0.0;
        pulls_ = PerCable::Constant((geometry_.least_n + geometry_.most_n) / 2.0);
        keeping_up_ = options_.loose_n_s_m * speeds_;
        return;
    }
    if (!refuge_) {
        led_ = here.position;
        alone_ = time_ - felt_s_ > options_.alone_s;
        refuge_ = refuge(geometry_, here, cable_good_, options_.refuge_n);
        if (!refuge_) {
            refuge_ = Pose{here.position, Matrix3::Identity()};
            report(Event::Kind::cannot_hold, -1,
                   "the cables that are left can hold the handle nowhere near; they slow it down");
        }
    }
    const Vector3 way = refuge_->position - led_;
    const double dt = options_.servo_period_s;
    led_m_s_ = std::min({options_.refuge_m_s, led_m_s_ + options_.refuge_m_s2 * dt,
                         std::sqrt(2.0 * options_.refuge_m_s2 * way.norm())});
    const Vector3 stride = way.norm() > led_m_s_ * dt ? Vector3(led_m_s_ * dt * way.normalized()) : way;
    led_ += stride;
    // To pull harder than the cables can would only turn the handle: what it is led by is never far ahead of it.
    const Vector3 ahead = led_ - here.position;
    if (yielding_ && ahead.norm() > options_.leash_m) led_ = here.position + options_.leash_m * ahead.normalized();

    const Structure structure = structure_of(geometry_, here);
    Eigen::Matrix<double, cable_count, 6> lengthening = -structure.transpose();
    PerCable speeds = speeds_;
    for (int i = 0; i < cable_count; ++i)
        if (!length_good_[static_cast<std::size_t>(i)]) {
            lengthening.row(i).setZero();
            speeds[i] = 0.0;
        }
    const Wrench velocity = lengthening.colPivHouseholderQr().solve(speeds);
    // Where it is not at rest anyway it is damped more, because it may have to be stopped.
    const double damping = yielding_ && way.norm() > 0.0 ? 2.0 : 1.0;
    Wrench wanted;
    wanted << options_.rest_n_m * (led_ - here.position) +
                  damping * options_.rest_n_s_m * (stride / dt - Vector3(velocity.head<3>())),
        -options_.rest_n_m_rad * vector_of(here.rotation) -
            damping * options_.rest_n_m_s_rad * Vector3(velocity.tail<3>());
    Wrench weight = geometry_.weight();
    Structure effect = structure;
    if (alone_) {
        const Eigen::Matrix<double, 6, 6> moved = moved_by(structure);
        weight = moved * weight;
        effect = moved * effect;
        // A handle that turns over cannot be brought back, one that moves can.
        constexpr double turns_count = 10.0 / 3.0;  // more than they do anyway
        for (Wrench* one : {&wanted, &weight}) one->tail<3>() *= turns_count;
        effect.bottomRows<3>() *= turns_count;
    }
    pulls_ = nearest_tensions(effect, wanted - weight, geometry_.least_n, geometry_.most_n, cable_good_, pulls_);
    // The motors go along with the handle, so that no cable hangs and then is jerked.
    if (yielding_) keeping_up_ = options_.damping_n_s_m * (speeds - lengthening * velocity);

    const bool carried = way.norm() == 0.0 && (led_ - here.position).norm() > options_.carried_m;
    carried_ticks_ = carried ? carried_ticks_ + 1 : 0;
    if (static_cast<double>(carried_ticks_) * dt >= options_.carried_s)
        report(
            Event::Kind::cannot_hold, -1,
            fmt::format("the user is stronger than the cables that are left, which hold {:.1f} N in every direction; "
                        "they slow the handle down",
                        force_held(geometry_, *refuge_, cable_good_).value_or(0.0)));
}

/// The accelerations that a wrench causes, as the wrenches that would cause each of them alone. The motors go along
/// with a handle, and their inertia makes a force turn it. (A hand, whose mass is not known, keeps it from that.)
Eigen::Matrix<double, 6, 6> Controller::moved_by(const Structure& structure) const {
    Eigen::Matrix<double, 6, 6> inertia = Eigen::Matrix<double, 6, 6>::Zero();
    inertia.diagonal().head<3>().setConstant(geometry_.mass_kg);
    inertia.bottomRightCorner<3, 3>() =
        pose_.rotation * geometry_.inertia_kg_m2.asDiagonal() * pose_.rotation.transpose();
    for (int i = 0; i < cable_count; ++i)
        if (cable_good_[static_cast<std::size_t>(i)])
            inertia += options_.drive_kg * structure.col(i) * structure.col(i).transpose();
    return inertia.diagonal().asDiagonal() * inertia.inverse();
}

/// Far outside no tensions keep a handle upright, and a wrench that is wanted in vain makes cables hang, which are
/// jerked when they are taut again. Each cable for itself keeps the middle of the limits then, and is damped.
bool Controller::tumbles() {
    const double fastest = speeds_.cwiseAbs().maxCoeff();
    if (yielding_ && fastest > options_.tumbling_m_s && vector_of(pose_.rotation).norm() > options_.turned_rad)
        tumbling_ = true;
    calm_ticks_ = fastest < options_.calm_m_s ? calm_ticks_ + 1 : 0;
    if (static_cast<double>(calm_ticks_) * options_.servo_period_s > options_.calm_s) tumbling_ = false;
    return tumbling_;
}

/// The last resort, which needs no pose: the motors take in what a cable gives, and let out nothing, up to the limit of
/// the tension. Lengths that only fall come to an end.
void Controller::brake() {
    const double most = geometry_.most_n - geometry_.least_n;
    for (int i = 0; i < cable_count; ++i) {
        if (!cable_good_[static_cast<std::size_t>(i)]) continue;
        braked_[i] = std::clamp(braked_[i], lengths_[i] - most / options_.stiffness_n_m, lengths_[i]);
        const double held =
            options_.stiffness_n_m * (lengths_[i] - braked_[i]) + options_.damping_n_s_m * std::max(0.0, speeds_[i]);
        pulls_[i] = geometry_.least_n + std::min(held, most);
    }
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
        if (whole() && !yielding_ && slack_ticks_[at] >= ticks(resting_ ? options_.kicked_s : options_.slack_s)) {
            const Structure structure = structure_of(geometry_, pose_);
            const Wrench load = -structure * last_tension_;
            // A kick slackens the cable in front, too, until its motor has wound in. It shows as a force that the loss
            // of this cable's pull cannot be.
            const double change = (load - geometry_.weight() - user_).head<3>().norm();
            const bool kicked = change > 1.5 * pulls_[i] && slack_ticks_[at] < ticks(options_.kicked_s);
            if (!distribute(structure, load, geometry_.least_n, geometry_.most_n)) {
                overload(load - geometry_.weight());
            } else if (!resting_ && !kicked) {
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
        // While the motors yield, cables that hang and are jerked would look like encoders that slip.
        const double jump = std::abs(lengths_[i] - last_lengths_[i]);
        if (!yielding_ && length_good_[at] && jump > options_.fastest_m_s * options_.servo_period_s) {
            length_good_[at] = false;
            report(Event::Kind::encoder_slip, i,
                   fmt::format("the encoder of cable {} jumped by {:.2f} mm", i + 1, jump * 1e3));
        }
    }
}

/// Eight lengths have six freedoms; what is left shows an encoder that slips slowly.
void Controller::check_lengths() {
    if (std::count(length_good_.begin(), length_good_.end(), true) < cable_count || yielding_) return;
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
    pulls_ = PerCable::Constant(geometry_.least_n);  // the servos hold the lengths
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
    if (user_.head<3>().norm() > options_.hand_n) felt_s_ = time_;  // a period late: a cable that breaks is no hand
    user_ = all_tensions ? Wrench(inertia - cables - geometry_.weight()) : Wrench::Zero();

    AdmittanceState next = wanted_;
    if (!resting_) {
        Wrench felt = user_;
        if (felt.head<3>().norm() < options_.unfelt_n) felt.head<3>().setZero();
        next = admit(wanted_, felt + scene_, options_.admittance);
        if (const std::string why = infeasible(geometry_, next.pose(), geometry_.weight()); !why.empty()) {
            report(Event::Kind::out_of_reach, -1,
                   fmt::format("({:.1f}, {:.1f}, {:.1f}) mm is out of reach: {}", next.place[0] * 1e3,
                               next.place[1] * 1e3, next.place[2] * 1e3, why));
            next = wanted_;
            next.velocity.setZero();
            next.acceleration.setZero();
        }
    } else {
        // The virtual body runs out within a few periods.
        next.velocity *= 0.5;
        next.acceleration.setZero();
        next.place += options_.admittance.period_s * next.velocity;
        if (!infeasible(geometry_, next.pose(), geometry_.weight()).empty()) {
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
            overload(user_);
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

/// The pose of the lengths that can be believed. While the handle is flung, a slack cable is longer than its way.
void Controller::find_pose() {
    const auto six = [](const CablesLeft& cables) { return std::count(cables.begin(), cables.end(), true) >= 6; };
    CablesLeft used = length_good_;
    for (int i = 0; yielding_ && i < cable_count; ++i)
        if (last_tension_[i] < options_.slack_n) used[static_cast<std::size_t>(i)] = false;
    if (!six(used)) used = length_good_;
    if (!six(used)) return;
    try {
        pose_ = forward(geometry_, lengths_, pose_, used).pose;
        believe_lengths();
    } catch (const Error&) {
        // Slack cables can have lengths that no pose has. The last pose is the best that is known.
        if (!resting_) report(Event::Kind::encoder_slip, -1, "the lengths of the cables fit no pose at all");
    }
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
        rest();
    }
    const double blend = options_.servo_period_s / (options_.servo_period_s + options_.velocity_filter_s);
    speeds_ += blend * ((lengths_ - last_lengths_) / options_.servo_period_s - speeds_);
    for (int i = 0; i < cable_count; ++i) {
        const auto at = static_cast<std::size_t>(i);
        if (tension_good_[at] && readings[at].tension_valid) tension_sum_[i] += readings[at].tension_n;
        if (!length_good_[at] && cable_good_[at]) speeds_[i] = 0.0;
    }
    find_pose();
    // The directions of the cables change within a period, so their wrench is summed, and not their tensions alone.
    cable_sum_ += structure_of(geometry_, pose_) * last_tension_;
    if (by_tensions())
        lead_by_tensions();
    else if (resting_)
        rest();
    ++ticks_;
    time_ += options_.servo_period_s;
    if (ticks_ % ticks_a_period_ == 0) period();
    return codes_of(by_tensions() ? PerCable(pulls_ + keeping_up_) : servo_pulls());
}

/// What the servos of the lengths ask of the motors.
PerCable Controller::servo_pulls() {
    PerCable wanted, wanted_speed, wanted_acceleration;
    servo_targets(wanted, wanted_speed, wanted_acceleration);
    PerCable pulls = pulls_ - options_.drive_kg * wanted_acceleration;
    for (int i = 0; i < cable_count; ++i)
        if (length_good_[static_cast<std::size_t>(i)])
            pulls[i] += options_.stiffness_n_m * (lengths_[i] - wanted[i]) +
                        options_.damping_n_s_m * (speeds_[i] - wanted_speed[i]);
    return pulls;
}

/// A motor yields at the largest tension, and a cable cannot push.
std::array<std::int16_t, cable_count> Controller::codes_of(const PerCable& pulls) {
    std::array<std::int16_t, cable_count> codes{};
    for (int i = 0; i < cable_count; ++i) {
        const auto at = static_cast<std::size_t>(i);
        double pull = std::clamp(pulls[i], geometry_.least_n, geometry_.most_n);
        if (!cable_good_[at])  // wound in gently until it is known to be broken
            pull = (broken_[at] ? 0.0 : geometry_.least_n) + options_.damping_n_s_m * speeds_[i];
        const auto largest = static_cast<double>(options_.drives.largest_code());
        const double code = std::round(pull / options_.drives.newtons_per_code());
        if (std::abs(code) > largest) ++saturated_;
        codes[at] = static_cast<std::int16_t>(std::clamp(code, -largest, largest));
    }
    return codes;
}

}  // namespace haptogram::robot
