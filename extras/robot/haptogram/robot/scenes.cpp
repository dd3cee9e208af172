// SPDX-License-Identifier: Apache-2.0
#include "haptogram/robot/scenes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <optional>
#include <utility>

#include "haptogram/array/millimetres.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/perception/magnitude.hpp"
#include "haptogram/robot/place.hpp"
#include "haptogram/robot/tension.hpp"

namespace haptogram::fusion {

std::size_t places_of(const SharedClock& clock, double frequency_hz) {
    return std::max<std::size_t>(1, static_cast<std::size_t>(frequency_hz * clock.period_s() + 1e-9));
}

Frame FramePen::play(const Stimulus& stimulus) {
    Frame frame;
    frame.magnitude = stimulus.magnitude;
    frame.frequency_hz = stimulus.frequency_hz;
    if (stimulus.points.empty()) {
        frame.path.steps.push_back({{}, clock_.carrier_periods});
        phase_ = 0.0;
        return frame;
    }
    if (stimulus.points.size() > places(stimulus.frequency_hz))
        throw bad_argument("points", fmt::format("a frame of {:g} ms has time for {} points at {:g} Hz, found {}",
                                                 clock_.period_s() * 1e3, places(stimulus.frequency_hz),
                                                 stimulus.frequency_hz, stimulus.points.size()));
    perception::Wanted wanted;
    wanted.magnitude = stimulus.magnitude;
    wanted.frequency_hz = stimulus.frequency_hz;
    wanted.grip_n = grip_n_;
    // What the tables do not know is an error. What this array cannot do at one place is silence there, and counted.
    static_cast<void>(perception::setting_for(tables_, wanted));
    std::vector<std::optional<Focus>> foci;
    for (const Vec3& place : stimulus.points) {
        std::optional<Focus> focus;
        try {
            const perception::Setting setting = perception::setting_for(tables_, wanted, array_, place);
            frame.points.push_back({place, setting});
            focus = Focus{place, setting.command};
        } catch (const Error& error) {
            if (error.where() != "focus" && error.where() != "magnitude") throw;
            if (frame.silent++ == 0) frame.why = error.message();
        }
        foci.push_back(focus);
    }
    constexpr double duty = 0.5, rounding = 1e-9;
    for (std::uint32_t period = 0; period < clock_.carrier_periods; ++period) {
        const double at = phase_ + stimulus.frequency_hz * period / clock_.carrier_hz + rounding;
        const double begun = std::floor(at);
        const auto& turn = foci[static_cast<std::size_t>(begun) % foci.size()];
        PathStep step;
        if (at - begun < duty && turn) step.foci.push_back(*turn);
        if (!frame.path.steps.empty() && frame.path.steps.back().foci == step.foci)
            ++frame.path.steps.back().periods;
        else
            frame.path.steps.push_back(std::move(step));
    }
    phase_ = std::fmod(phase_ + stimulus.frequency_hz * clock_.period_s() + rounding, 1.0) - rounding;
    return frame;
}

double magnitude_of(const perception::Tables& tables, double frequency_hz, const FramePoint& point, double command) {
    return perception::magnitude_of_output(perception::fit_at(tables, frequency_hz),
                                           command * command * point.setting.full_gf / point.setting.factor);
}

namespace {

robot::ControllerOptions without_zones(robot::ControllerOptions options) {
    options.admittance.zones.inner_n_m = options.admittance.zones.outer_n_m = 0.0;
    return options;
}

robot::PlantOptions with_drives(robot::PlantOptions plant, const robot::DriveOptions& drives) {
    plant.drives = drives;
    return plant;
}

robot::Pose at(const robot::Vector3& place) { return {place, robot::Matrix3::Identity()}; }

}  // namespace

Together::Together(const TogetherOptions& options, const Array& array, const perception::Tables& tables,
                   const SharedClock& clock)
    : centre_(options.robot_centre),
      clock_(clock),
      geometry_(options.geometry),
      plant_(options.geometry, with_drives(options.plant, options.controller.drives), at(options.start), options.user),
      controller_(options.geometry, without_zones(options.controller), at(options.start)),
      pen_(array, tables, clock),
      servo_s_(options.controller.servo_period_s) {
    const double period = options.controller.admittance.period_s;
    if (std::abs(period - clock.period_s()) > 1e-9)
        throw bad_argument("period",
                           fmt::format("the robot's is {:g} s, and the clock's {:g} s", period, clock.period_s()));
}

Moment Together::now() const {
    const robot::Vector3& place = plant_.pose().position;
    const robot::AdmittanceState& body = controller_.wanted();
    return {plant_.time_s(), centre_ + Vec3{place.x(), place.y(), place.z()},
            centre_ + Vec3{body.place[0], body.place[1], body.place[2]}, body.velocity.head<3>()};
}

Period Together::play(const Stimulus& stimulus) {
    Period period;
    period.before = now();
    period.stimulus = stimulus;
    controller_.render(stimulus.wrench);
    period.frame = pen_.play(stimulus);
    robot::CableDrives& drives = plant_;
    const long ticks = std::lround(clock_.period_s() / servo_s_);
    for (long tick = 0; tick < ticks; ++tick) {
        drives.command(controller_.step(drives.read()));
        plant_.advance(servo_s_);
    }
    period.time_s = plant_.time_s();
    period.palm = now().palm;
    period.user = plant_.user_force();
    period.measured = controller_.user();
    period.rendered = rendered(stimulus.wrench);
    return period;
}

/// The hand bears what the scene asks for, so the cables must balance the opposite.
double Together::rendered(const robot::Wrench& wrench) const {
    if (controller_.resting()) return 0.0;
    if (wrench.isZero()) return 1.0;
    return std::min(1.0, robot::largest_wrench(geometry_, plant_.pose(), -wrench).value_or(0.0));
}

Path SceneRun::path() const {
    Path path;
    for (const Period& period : periods)
        for (const PathStep& step : period.frame.path.steps)
            if (!path.steps.empty() && path.steps.back().foci == step.foci)
                path.steps.back().periods += step.periods;
            else
                path.steps.push_back(step);
    return path;
}

SceneRun play_scene(const Scene& scene, const TogetherOptions& options, const Array& array,
                    const perception::Tables& tables, const SharedClock& clock, double duration_s,
                    const Progress& progress) {
    if (!(duration_s > 0.0 && duration_s <= 3600.0))
        throw bad_argument("duration", fmt::format("must be above 0 s and up to an hour, found {:g} s", duration_s));
    Together together(options, array, tables, clock);
    const auto periods = static_cast<long>(std::ceil(duration_s / clock.period_s() - 1e-9));
    SceneRun run;
    for (long n = 0; n < periods; ++n) {
        run.periods.push_back(together.play(scene(together.now())));
        const Frame& frame = run.periods.back().frame;
        run.points += frame.points.size() + frame.silent;
        run.silent += frame.silent;
        if (run.why.empty()) run.why = frame.why;
        progress(static_cast<double>(n + 1) / static_cast<double>(periods), "playing");
    }
    run.events = together.events();
    run.least_tension_n = together.least_tension_n();
    return run;
}

SceneRun play_scene(const Scene& scene, const HandWay& way, TogetherOptions options, const Array& array,
                    const perception::Tables& tables, const SharedClock& clock, const Progress& progress) {
    std::vector<robot::Vector3> places;
    for (const Vec3 place : way.places) {
        const Vec3 there = place - options.robot_centre;
        places.emplace_back(there.x, there.y, there.z);
    }
    const double duration_s = seconds_along(places, way.speed_m_s) + way.wait_s;
    const robot::Vector3 lift = way.load_n / way.hand.stiffness_n_m * robot::Vector3::UnitZ();
    options.start = places.front();
    options.user = robot::impedance_user(way.hand, [there = along(places, way.speed_m_s), lift](double time_s) {
        return robot::Vector3(there(time_s) + lift);
    });
    return play_scene(scene, options, array, tables, clock, duration_s, progress);
}

SceneForces forces_of(const SceneRun& run) {
    SceneForces forces;
    for (const Period& period : run.periods) {
        const robot::Vector3 asked = period.stimulus.wrench.head<3>(), measured = period.measured.head<3>();
        forces.most_n = std::max(forces.most_n, asked.norm());
        forces.rendered_n = std::max(forces.rendered_n, period.rendered * asked.norm());
        forces.missing_n = std::max(forces.missing_n, (1.0 - period.rendered) * asked.norm());
        forces.most_off_n = std::max(forces.most_off_n, (measured - period.user).norm());
    }
    return forces;
}

std::string to_csv(const SceneRun& run) {
    fmt::memory_buffer text;
    auto out = std::back_inserter(text);
    fmt::format_to(out,
                   "time_s,x_mm,y_mm,z_mm,fx_n,fy_n,fz_n,tx_nm,ty_nm,tz_nm,user_x_n,user_y_n,user_z_n,measured_x_n,"
                   "measured_y_n,measured_z_n,frequency_hz,magnitude,points,silent\n");
    for (const Period& period : run.periods) {
        const robot::Wrench& w = period.stimulus.wrench;
        const bool felt = !period.frame.points.empty();
        fmt::format_to(out, "{:.4f},{:.4f},{:.4f},{:.4f},{:.5f},{:.5f},{:.5f},{:.6f},{:.6f},{:.6f},", period.time_s,
                       period.palm.x / millimetre, period.palm.y / millimetre, period.palm.z / millimetre, w[0], w[1],
                       w[2], w[3], w[4], w[5]);
        fmt::format_to(out, "{:.5f},{:.5f},{:.5f},{:.5f},{:.5f},{:.5f},{:.4f},{:.5f},{},{}\n", period.user.x(),
                       period.user.y(), period.user.z(), period.measured[0], period.measured[1], period.measured[2],
                       felt ? period.frame.frequency_hz : 0.0, felt ? period.frame.magnitude : 0.0,
                       period.frame.points.size(), period.frame.silent);
    }
    return fmt::to_string(text);
}

double seconds_along(const std::vector<robot::Vector3>& places, double speed_m_s) {
    if (places.empty()) throw bad_argument("way", "has no place to go to");
    for (const robot::Vector3& place : places)
        if (!place.allFinite()) throw bad_argument("way", "has a place that is not finite");
    if (!(speed_m_s > 0.0 && std::isfinite(speed_m_s)))
        throw bad_argument("speed", fmt::format("must be positive, found {:g} m/s", speed_m_s));
    double length = 0.0;
    for (std::size_t i = 1; i < places.size(); ++i) length += (places[i] - places[i - 1]).norm();
    return length / speed_m_s;
}

std::function<robot::Vector3(double)> along(const std::vector<robot::Vector3>& places, double speed_m_s) {
    static_cast<void>(seconds_along(places, speed_m_s));  // which checks them
    return [places, speed_m_s](double time_s) {
        double left = std::max(0.0, time_s) * speed_m_s;
        for (std::size_t i = 1; i < places.size(); ++i) {
            const robot::Vector3 way = places[i] - places[i - 1];
            const double length = way.norm();
            if (left < length) return robot::Vector3(places[i - 1] + left / length * way);
            left -= length;
        }
        return places.back();
    };
}

namespace {

/// A weight of nothing is a hand without a load.
void require_weight(double weight_n) {
    if (!(weight_n >= 0.0 && std::isfinite(weight_n)))
        throw bad_argument("weight", fmt::format("must not be negative, found {:g} N", weight_n));
}

/// So many of the points, beginning with number `first`, which then is the next one's turn.
std::vector<Vec3> turn(const std::vector<Vec3>& points, std::size_t most, std::size_t& first) {
    if (points.size() <= most) return points;
    std::vector<Vec3> taken;
    for (std::size_t i = 0; i < most; ++i) taken.push_back(points[(first + i) % points.size()]);
    first = (first + most) % points.size();
    return taken;
}

}  // namespace

Scene scene_of(const ExploreScene& explored, const SharedClock& clock, double body_kg) {
    require_weight(explored.weight_n);
    if (!(explored.frequency_hz > 0.0 && std::isfinite(explored.frequency_hz)))
        throw bad_argument("frequency", fmt::format("must be positive, found {:g} Hz", explored.frequency_hz));
    const double stiffest = 4.0 * body_kg / (clock.period_s() * clock.period_s());
    if (!(explored.surface.stiffness_n_m < stiffest))
        throw bad_argument("stiffness",
                           fmt::format("found {:g} N/m; a body of {:g} kg that moves every {:g} ms swings "
                                       "on a surface of {:.0f} N/m or more",
                                       explored.surface.stiffness_n_m, body_kg, clock.period_s() * 1e3, stiffest));
    const std::size_t places = places_of(clock, explored.frequency_hz);
    return [explored, places, first = std::make_shared<std::size_t>(0)](const Moment& moment) {
        const Hand hand = open_hand(moment.palm, explored.tilt_deg);
        const robot::Vector3 position(moment.body.x, moment.body.y, moment.body.z);
        Stimulus stimulus = explore(explored.object, hand, palmar_surface(hand), explored.weight_n, explored.surface,
                                    position, moment.velocity, explored.slice);
        stimulus.points = turn(stimulus.points, places, *first);
        stimulus.magnitude = explored.magnitude;
        stimulus.frequency_hz = explored.frequency_hz;
        return stimulus;
    };
}

PalmValue palm_value(const std::string& name) {
    for (const auto& [known, value] :
         {std::pair("distance", PalmValue::distance), std::pair("texture", PalmValue::texture),
          std::pair("hardness", PalmValue::hardness)})
        if (name == known) return value;
    throw bad_argument("value", fmt::format("found \"{}\", expected distance, texture or hardness", name));
}

Scene scene_of(const TellScene& told) {
    require_weight(told.weight_n);
    const auto value_at = [told](Vec3 palm) {
        switch (told.value) {
            case PalmValue::distance: return nearness(palm.z - told.height_m, told.range_m);
            case PalmValue::texture: return cloth(palm.x, palm.y, told.cell_m);
            case PalmValue::hardness: return hardness(told.stiffness_n_m, told.softest_n_m, told.hardest_n_m);
        }
        throw bad_argument("value", "is none that a pattern tells");
    };
    // What makes no sense is said before the run.
    static_cast<void>(tell(told.pattern, value_at({0.0, 0.0, told.height_m}), open_hand({0.0, 0.0, told.height_m}, 0.0),
                           told.points));
    return [told, value_at](const Moment& moment) {
        Stimulus stimulus;
        const bool reached = told.value == PalmValue::distance || moment.palm.z <= told.height_m;
        if (reached)
            stimulus = tell(told.pattern, value_at(moment.palm), open_hand(moment.palm, 0.0),
                            told.pattern.shape == PalmShape::focus ? 1 : told.points);
        stimulus.wrench[2] = -told.weight_n;
        return stimulus;
    };
}

}  // namespace haptogram::fusion
