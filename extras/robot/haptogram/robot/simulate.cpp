// SPDX-License-Identifier: Apache-2.0
#include "haptogram/robot/simulate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <memory>
#include <string_view>
#include <utility>

#include "haptogram/base/error.hpp"

namespace haptogram::robot {
namespace {

std::vector<std::string> split(const std::string& text, char at) {
    std::vector<std::string> parts{""};
    for (const char c : text)
        if (c == at)
            parts.emplace_back();
        else
            parts.back() += c;
    return parts;
}

/// A finite number that is the whole text; NaN when it is none.
double number_of(const std::string& text) {
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc() && end == text.data() + text.size() && std::isfinite(value) ? value : NAN;
}

/// A way from one place to another without jerks: 0 to 1 with zero speed at both ends.
double smooth(double part) {
    const double t = std::clamp(part, 0.0, 1.0);
    return t * t * t * (10.0 + t * (-15.0 + 6.0 * t));
}

/// Random places and the times at which the hand sets out for them.
class Wander {
public:
    Wander(double ball_m, std::uint64_t seed) : ball_(ball_m), random_(seed) {}
    Vector3 at(double time) {
        while (time >= arrives_) {
            from_ = to_;
            leaves_ = arrives_;
            arrives_ = leaves_ + std::uniform_real_distribution<double>(0.5, 3.0)(random_);
            std::uniform_real_distribution<double> edge(-ball_, ball_);
            do to_ = {edge(random_), edge(random_), edge(random_)};
            while (to_.norm() > ball_);
        }
        return from_ + smooth((time - leaves_) / (arrives_ - leaves_)) * (to_ - from_);
    }

private:
    double ball_;
    std::mt19937_64 random_;
    Vector3 from_ = Vector3::Zero(), to_ = Vector3::Zero();
    double leaves_ = 0.0, arrives_ = 0.0;
};

void watch_room(Simulation& result, const Nearness& near, double time_s, double tick_s) {
    if (result.nearest_s == 0.0 || near.room_m < result.nearest.room_m) {
        result.nearest = near;
        result.nearest_s = time_s;
    }
    if (near.room_m < 0.0) result.touched_s += tick_s;
}

}  // namespace

Push parse_push(const std::string& text) {
    const auto parts = split(text, ':');
    const auto forces = parts.size() == 3 ? split(parts[2], ',') : std::vector<std::string>{};
    Push push;
    if (forces.size() == 3) {
        push.from_s = number_of(parts[0]);
        push.to_s = number_of(parts[1]);
        for (int k = 0; k < 3; ++k) push.force[k] = number_of(forces[static_cast<std::size_t>(k)]);
    }
    if (forces.size() != 3 || !(push.from_s >= 0.0 && push.from_s < push.to_s) || !push.force.allFinite())
        throw bad_argument(
            "push", fmt::format("expected FROM:TO:X,Y,Z in seconds and newtons, such as 1:4:0,0,8, found '{}'", text));
    return push;
}

User pushing_user(std::vector<Push> pushes) {
    return {0.0, [pushes = std::move(pushes)](double time, const Vector3&, const Vector3&) {
                Vector3 force = Vector3::Zero();
                for (const Push& push : pushes)
                    if (time >= push.from_s && time < push.to_s) force += push.force;
                return force;
            }};
}

User wandering_user(const Impedance& impedance, double ball_m, std::uint64_t seed) {
    return impedance_user(impedance,
                          [wander = std::make_shared<Wander>(ball_m, seed)](double time) { return wander->at(time); });
}

Fault parse_fault(const std::string& text) {
    const auto parts = split(text, ':');
    constexpr std::pair<std::string_view, Fault::Kind> kinds[] = {{"broken", Fault::Kind::broken},
                                                                  {"slip", Fault::Kind::slip},
                                                                  {"lost", Fault::Kind::lost},
                                                                  {"frozen", Fault::Kind::frozen}};
    const auto kind =
        std::find_if(std::begin(kinds), std::end(kinds), [&](const auto& one) { return one.first == parts[0]; });
    Fault fault;
    double cable = NAN;
    if (parts.size() == 3) {
        cable = number_of(parts[1]);
        fault.time_s = number_of(parts[2]);
    }
    if (kind == std::end(kinds) || !(cable >= 1.0 && cable <= cable_count && cable == std::floor(cable)) ||
        !(fault.time_s >= 0.0))
        throw bad_argument(
            "fault", fmt::format("expected KIND:CABLE:TIME, KIND one of broken, slip, lost, frozen, CABLE 1 to 8, "
                                 "TIME in seconds, such as broken:3:2.5, found '{}'",
                                 text));
    fault.kind = kind->second;
    fault.cable = static_cast<int>(cable) - 1;
    return fault;
}

Simulation simulate(const SimulationOptions& options, const Progress& progress) {
    if (!(options.duration_s > 0.0 && options.duration_s <= 86400.0))
        throw bad_argument("duration",
                           fmt::format("must be above 0 s and up to a day, found {:g} s", options.duration_s));
    PlantOptions made_of = options.plant;
    made_of.drives = options.controller.drives;
    Plant plant(options.geometry, made_of, options.start, options.user);
    Controller controller(options.geometry, options.controller, options.start);
    const double tick_s = options.controller.servo_period_s;
    const long ticks = std::lround(options.duration_s / tick_s);
    const long ticks_a_row = std::max(1L, std::lround(options.record_s / tick_s));
    const long last_second = std::max(0L, ticks - std::lround(1.0 / tick_s));
    std::vector<Fault> waiting = options.faults;
    Simulation result;
    Vector3 low = Vector3::Constant(1e9), high = -low;
    CableDrives& drives = plant;
    for (long tick = 0; tick < ticks; ++tick) {
        for (auto fault = waiting.begin(); fault != waiting.end();) {
            if (plant.time_s() < fault->time_s) {
                ++fault;
                continue;
            }
            switch (fault->kind) {
                case Fault::Kind::broken: plant.break_cable(fault->cable); break;
                case Fault::Kind::slip: plant.slip_encoder(fault->cable, fault->metres); break;
                case Fault::Kind::lost: plant.lose_sensor(fault->cable); break;
                case Fault::Kind::frozen: plant.freeze_sensor(fault->cable); break;
            }
            fault = waiting.erase(fault);
        }
        drives.command(controller.step(drives.read()));
        plant.advance(tick_s);
        result.most_n = result.most_n.cwiseMax(plant.tensions());
        result.most_off_m =
            std::max(result.most_off_m, (plant.pose().position - Vector3(controller.wanted().place.head<3>())).norm());
        result.most_turn_rad = std::max(result.most_turn_rad, vector_of(plant.pose().rotation).norm());
        watch_room(result, clearance(options.geometry, plant.pose()).least(), plant.time_s(), tick_s);
        if (tick >= last_second) {
            result.fastest_end_m_s = std::max(result.fastest_end_m_s, plant.velocity().norm());
            low = low.cwiseMin(plant.pose().position);
            high = high.cwiseMax(plant.pose().position);
        }
        if ((tick + 1) % ticks_a_row == 0) {
            result.rows.push_back({plant.time_s(), plant.pose().position, plant.velocity(),
                                   vector_of(plant.pose().rotation), controller.wanted().place.head<3>(),
                                   plant.user_force(), controller.user().head<3>(), plant.tensions()});
            progress(static_cast<double>(tick) / static_cast<double>(ticks));
        }
    }
    result.least_n = plant.least_tensions();
    result.events = controller.events();
    result.steadiness_m = (high - low).norm();
    result.saturated = controller.saturated();
    return result;
}

}  // namespace haptogram::robot
