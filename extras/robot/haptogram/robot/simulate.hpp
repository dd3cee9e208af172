// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "haptogram/base/progress.hpp"
#include "haptogram/robot/controller.hpp"
#include "haptogram/robot/geometry.hpp"
#include "haptogram/robot/plant.hpp"

namespace haptogram::robot {

/// A force of the user from one time to another.
struct Push {
    double from_s = 0.0, to_s = 0.0;
    Vector3 force = Vector3::Zero();  ///< N
};
/// "FROM:TO:X,Y,Z", seconds and newtons. @throws Error{bad_argument} naming "push"
[[nodiscard]] Push parse_push(const std::string& text);
/// A user whose force is the sum of these pushes.
[[nodiscard]] User pushing_user(std::vector<Push> pushes);

/// A user whose hand goes from one random place of a ball to the next, smoothly, each after half a second to three,
/// with this impedance.
[[nodiscard]] User wandering_user(const Impedance& impedance, double ball_m, std::uint64_t seed);

/// What shall break, and when.
struct Fault {
    enum class Kind { broken, slip, lost, frozen };
    Kind kind = Kind::broken;
    int cable = 0;  ///< 0…7
    double time_s = 0.0;
    double metres = 0.005;  ///< of a slip
};
/// "KIND:CABLE:TIME": broken, slip, lost or frozen; cables from 1; seconds. @throws Error{bad_argument} naming "fault"
[[nodiscard]] Fault parse_fault(const std::string& text);

struct SimulationOptions {
    Geometry geometry;
    PlantOptions plant;
    ControllerOptions controller;
    User user;
    std::vector<Fault> faults;
    Pose start;
    double duration_s = 10.0;
    double record_s = 0.030;  ///< time between two rows
};

/// What was at a time.
struct TraceRow {
    double time_s = 0.0;
    Vector3 position, velocity, turn;  ///< of the handle itself, m, m/s, and its rotation vector
    Vector3 wanted;                    ///< of the virtual body, m
    Vector3 user, measured;            ///< the user's force, and what the controller takes it for, N
    PerCable tensions;                 ///< N
};

struct Simulation {
    std::vector<TraceRow> rows;
    std::vector<Event> events;
    PerCable least_n = PerCable::Zero(),
             most_n = PerCable::Zero();  ///< true tensions of each cable; most at the servo's times
    double fastest_end_m_s = 0.0;        ///< the handle's largest speed in the last second
    double steadiness_m = 0.0;           ///< largest distance between two of the handle's places in the last second
    long saturated = 0;                  ///< codes beyond the converter
    double most_off_m = 0.0;             ///< largest distance of the handle from the virtual body
    double most_turn_rad = 0.0;          ///< by which the handle was turned
    Nearness nearest;                    ///< where cables had the least room among themselves or beside the grip,
    double nearest_s = 0.0;              ///< when that was,
    double touched_s = 0.0;              ///< and for how long in all there was interference
};

/// Plays the controller on the plant. The same options give the same bytes.
/// @throws Error{bad_argument} naming what makes no sense
[[nodiscard]] Simulation simulate(const SimulationOptions& options, const Progress& progress = {});

}  // namespace haptogram::robot
