// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "haptogram/robot/frame.hpp"
#include "haptogram/robot/simulate.hpp"

// Both stages under one hand: the simulated robot that it holds, and what the ultrasound plays meanwhile, on one clock.

namespace haptogram::fusion {

/// What a scene is asked about at the beginning of a period.
struct Moment {
    double time_s = 0.0;
    Vec3 palm;  ///< of the hand that holds the handle, array frame, metres
    Vec3 body;  ///< where the robot wants the palm: the virtual body's place. Forces of a scene follow it, because the
                ///< handle is some 50 ms behind, and a stiff surface that is felt so late would make it bounce
    robot::Vector3 velocity = robot::Vector3::Zero();  ///< of the virtual body, m/s
};

/// What a scene gives the hand for one period.
using Scene = std::function<Stimulus(const Moment&)>;

/// The robot beside the array. All values but the clock's are ours.
struct TogetherOptions {
    Vec3 robot_centre{0.0, 0.0, 0.25};  ///< of the robot's frame, in the array's
    robot::Geometry geometry;
    robot::PlantOptions plant;
    robot::ControllerOptions controller;            ///< its zones are left out: the scene's wrench is all that acts
    robot::Vector3 start = robot::Vector3::Zero();  ///< of the handle, in the robot's frame, metres
    robot::User user;                               ///< in the robot's frame
};

/// What was in one period of the robot.
struct Period {
    Moment before;           ///< what the scene was asked about
    Stimulus stimulus;       ///< what it gave
    Frame frame;             ///< what the ultrasound plays of it
    double time_s = 0.0;     ///< at the period's end, as all that follows
    Vec3 palm;               ///< array frame, metres
    robot::Vector3 user;     ///< force of the user on the handle, N
    robot::Wrench measured;  ///< what the controller takes it for
    double rendered = 0.0;   ///< part of the scene's wrench that the cables have tensions for; 0 when they rest
};

/// Leads the simulated robot period by period, and makes the frames of the ultrasound.
class Together {
public:
    /// Keeps references to the array and the tables.
    /// @param clock  its period must be that of the controller's admittance
    /// @throws Error{bad_argument} naming "period" when it is not, and where the handle cannot start
    Together(const TogetherOptions& options, const Array& array, const perception::Tables& tables,
             const SharedClock& clock);

    [[nodiscard]] Moment now() const;
    /// How many points a frame has time for at a frequency.
    [[nodiscard]] std::size_t places(double frequency_hz) const { return pen_.places(frequency_hz); }

    /// One period. @throws Error as FramePen::play()
    [[nodiscard]] Period play(const Stimulus& stimulus);

    [[nodiscard]] const std::vector<robot::Event>& events() const { return controller_.events(); }
    [[nodiscard]] double least_tension_n() { return plant_.least_tensions().minCoeff(); }

private:
    [[nodiscard]] double rendered(const robot::Wrench& wrench) const;

    Vec3 centre_;
    SharedClock clock_;
    robot::Geometry geometry_;
    robot::Plant plant_;
    robot::Controller controller_;
    FramePen pen_;
    double servo_s_;
};

/// A whole run of a scene.
struct SceneRun {
    std::vector<Period> periods;
    std::vector<robot::Event> events;
    double least_tension_n = 0.0;
    std::size_t points = 0, silent = 0;  ///< foci that were asked for, and that the array cannot make
    std::string why;                     ///< of the first of these

    /// What the ultrasound plays, all frames in one path.
    [[nodiscard]] Path path() const;
};

/// Plays a scene for a time. The same options give the same result.
/// @throws Error as Together, and as the scene
[[nodiscard]] SceneRun play_scene(const Scene& scene, const TogetherOptions& options, const Array& array,
                                  const perception::Tables& tables, const SharedClock& clock, double duration_s,
                                  const Progress& progress = {});

/// How a hand goes through a scene: along straight lines from place to place with one speed, then it stays at the last.
struct HandWay {
    std::vector<Vec3> places;  ///< of the palm, array frame, metres; at least one
    double speed_m_s = 0.05;
    double wait_s = 1.0;    ///< at the last place
    robot::Impedance hand;  ///< between the hand and where it wants to be
    double load_n = 0.0;  ///< that it carries: it wants to be higher than its way by as much as the load pulls it down
};

/// Plays a scene for a hand on its way; `start` and `user` of the options follow from it.
/// @throws Error{bad_argument} naming "way" or "speed"; and as play_scene() above
[[nodiscard]] SceneRun play_scene(const Scene& scene, const HandWay& way, TogetherOptions options, const Array& array,
                                  const perception::Tables& tables, const SharedClock& clock,
                                  const Progress& progress = {});

/// The forces of a run, N.
struct SceneForces {
    double most_n = 0.0;      ///< largest force that the scene asked of the cables
    double rendered_n = 0.0;  ///< largest that they rendered
    double missing_n = 0.0;   ///< most that was missing
    double most_off_n = 0.0;  ///< largest difference of the user's force and what the controller took it for
};
[[nodiscard]] SceneForces forces_of(const SceneRun& run);

/// A row a period: time_s, x_mm, y_mm, z_mm of the palm, the scene's wrench (fx_n, fy_n, fz_n, tx_nm, ty_nm, tz_nm),
/// the user's force (user_x_n …) and what the controller takes it for (measured_x_n …), frequency_hz and magnitude of
/// the ultrasound (0 when it is silent), points that are played, and silent ones.
[[nodiscard]] std::string to_csv(const SceneRun& run);

/// Where a hand wants to be that goes along straight lines from place to place with one speed, and stays at the last.
/// @param places  at least one, metres
/// @throws Error{bad_argument} naming "way" or "speed"
[[nodiscard]] std::function<robot::Vector3(double time_s)> along(const std::vector<robot::Vector3>& places,
                                                                 double speed_m_s);
/// How long that takes, s.
[[nodiscard]] double seconds_along(const std::vector<robot::Vector3>& places, double speed_m_s);

}  // namespace haptogram::fusion
