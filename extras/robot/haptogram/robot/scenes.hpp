// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "haptogram/format/path.hpp"
#include "haptogram/perception/magnitude.hpp"
#include "haptogram/robot/modes.hpp"
#include "haptogram/robot/simulate.hpp"

namespace haptogram::fusion {

/// A focus of a frame, and what makes it feel as it shall.
struct FramePoint {
    Vec3 position;  ///< array frame, metres
    perception::Setting setting;
};

/// What the ultrasound plays in one period of the robot.
struct Frame {
    Path path;  ///< exactly as long as the period; the modulation is in its steps
    double magnitude = 0.0, frequency_hz = 0.0;
    std::vector<FramePoint> points;  ///< that are played
    std::size_t silent = 0;          ///< points that the array cannot make at that magnitude; they stay silent
    std::string why;                 ///< of the first of these
};

/// How many points a period of the robot has time for at a frequency: whole periods of the square wave, at least one.
[[nodiscard]] std::size_t places_of(const SharedClock& clock, double frequency_hz);

/// Turns stimuli into frames. The square wave of 50 % duty goes on from frame to frame without a jump of its phase, at
/// whatever frequency each asks for; its edges lie on the nearest carrier period. A focus rests for a whole period of
/// the square wave, then the next point has its turn, because the magnitudes were measured with a focus that rests.
class FramePen {
public:
    /// @param grip_n  force that the hand holds, for the threshold
    FramePen(const Array& array, const perception::Tables& tables, const SharedClock& clock, double grip_n = 1.0)
        : array_(array), tables_(tables), clock_(clock), grip_n_(grip_n) {}

    /// How many points a frame has time for at a frequency.
    [[nodiscard]] std::size_t places(double frequency_hz) const { return places_of(clock_, frequency_hz); }

    /// @throws Error{bad_argument} naming "magnitude" or "frequency" when the tables do not know them, or "points" when
    /// there are more than places()
    [[nodiscard]] Frame play(const Stimulus& stimulus);

private:
    const Array& array_;
    const perception::Tables& tables_;
    SharedClock clock_;
    double grip_n_;
    double phase_ = 0.0;  ///< of the square wave when the next frame begins, in its periods, 0…1
};

/// How strong a point is felt when the carrier at the pins has another amplitude than was asked for.
/// @param command  that was measured, as a fraction of full drive
/// @throws Error{bad_argument} naming "output" when the tables do not know so strong a focus
[[nodiscard]] double magnitude_of(const perception::Tables& tables, double frequency_hz, const FramePoint& point,
                                  double command);

}  // namespace haptogram::fusion

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

// Scenes for both modes of the paper Multimodal, section III: what `haptogram robot explore` and `robot tell` play.

namespace haptogram::fusion {

/// Mode W1: the ultrasound shows where an object's edges and corners meet the hand; the cables give the weight of what
/// is carried, and the friction and texture of a surface on which it can be put.
struct ExploreScene {
    TouchObject object;                            ///< array frame
    double weight_n = 1.0;                         ///< of what is carried
    Surface surface;                               ///< its height is above the array
    double tilt_deg = 0.0;                         ///< of the hand, fingers down
    double magnitude = 2.0, frequency_hz = 200.0;  ///< of each focus
    SliceOptions slice;
};
/// Where there are more points than a frame has time for, they take turns from frame to frame.
/// @param clock    of the frames
/// @param body_kg  of the virtual body that the surface carries (robot::AdmittanceOptions)
/// @throws Error{bad_argument} naming what makes no sense, such as a stiffness of the surface that would make the body
/// swing: stiffness · period² / body must be below 4
[[nodiscard]] Scene scene_of(const ExploreScene& explored, const SharedClock& clock, double body_kg = 1.0);

/// What a pattern on the palm tells.
enum class PalmValue { distance, texture, hardness };
/// "distance", "texture" or "hardness". @throws Error{bad_argument} naming "value"
[[nodiscard]] PalmValue palm_value(const std::string& name);

/// Mode W2: the cables give the weight; a pattern on the palm tells how near the hand is to a height, how rough a cloth
/// at that height is, or how hard it is. Of texture and hardness something is told only below the height, where the
/// hand has reached them. Ranges are ours.
struct TellScene {
    PalmPattern pattern;
    PalmValue value = PalmValue::distance;
    std::size_t points = 6;  ///< of a line or a ring; a focus is one
    double weight_n = 1.0;
    double height_m = 0.25;                           ///< above the array
    double range_m = 0.1;                             ///< of the distance
    double cell_m = 20e-3;                            ///< of the cloth's threads
    double stiffness_n_m = 500.0;                     ///< that is told
    double softest_n_m = 50.0, hardest_n_m = 5000.0;  ///< and the ends of its range
};
/// @throws Error{bad_argument} naming what makes no sense
[[nodiscard]] Scene scene_of(const TellScene& told);

}  // namespace haptogram::fusion
