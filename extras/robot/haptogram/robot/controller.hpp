// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "haptogram/robot/plant.hpp"
#include "haptogram/robot/tension.hpp"
#include "haptogram/robot/workspace.hpp"

namespace haptogram::robot {

/// How the drives are led. All values are ours.
struct ControllerOptions {
    AdmittanceOptions admittance;
    DriveOptions drives;
    double servo_period_s = 0.001;
    double stiffness_n_m = 4000.0, damping_n_s_m = 60.0;  ///< of a drive about its wanted length
    double velocity_filter_s = 0.002;                     ///< time constant for the velocity that encoder counts give
    double reserve_n = 3.0;      ///< asked on top of the least tension, so that none falls below it in motion
    double drive_kg = 0.21;      ///< a motor's inertia, seen at the cable
    double tension_gain = 0.05;  ///< of the tension controller: part of an error that it takes back in one period
    double unfelt_n = 0.03;  ///< a smaller force counts as none. The mean of a period has 6 mN of the sensors' noise,
                             ///< and the stretch of the cables looks like 1 mN: in Z2 these would add up to a way
    // Faults.
    double turned_rad = 0.35;  ///< a handle that is turned by so much is lost to seven cables: the motors brake
    double tumbling_m_s = 0.5, calm_m_s = 0.1, calm_s = 0.1;  ///< and to eight at such a speed of a cable: until they
                                                              ///< are calm for so long, each motor damps its own cable
    double loose_n_s_m = 20.0;                                ///< by this
    double slack_n = 0.1, slack_s = 0.003;  ///< a sensor below the one for the other: the cable is slack
    double kicked_s = 0.050;                ///< and so long when the user pushes hard
    double leash_m = 0.004;                 ///< that far ahead of a handle that is pushed away goes what leads it back
    double broken_m = 0.005;                ///< a slack cable that its motor winds in by this: it is broken
    double fastest_m_s = 2.0;               ///< cable speed that only an encoder that slips can show
    double mismatch_m = 0.001;              ///< of lengths that no pose has: an encoder has slipped
    double refuge_n = 2.5;  ///< force that the place where seven cables hold the handle shall bear in every direction.
                            ///< More is found farther away, where a hand that stays behind pulls more
    double refuge_m_s = 0.3, refuge_m_s2 = 3.0;   ///< speed and acceleration with which they lead it there
    double rest_n_m = 3000.0, rest_n_s_m = 50.0;  ///< of the handle about that place. Twice these dampings, and
    double rest_n_m_rad = 12.0,
           rest_n_m_s_rad = 0.05;                ///< servo and cables shake at 141 Hz; the second is of its turns
    double hand_n = 0.1, alone_s = 1.0;          ///< no force above the one for the other: no hand is at the handle
    double carried_m = 0.010, carried_s = 0.25;  ///< that far from it for so long: the user is stronger
    double silent_s = 0.005, frozen_s = 0.050;   ///< a sensor that does not answer, or always the same
};

/// Something that the controller noticed. After a fault the handle is brought to rest.
struct Event {
    enum class Kind { slack, broken, encoder_slip, sensor_lost, out_of_reach, overload, cannot_hold };
    double time_s = 0.0;
    Kind kind = Kind::slack;
    int cable = -1;    ///< 0…7, or −1 when it is no single cable
    std::string text;  ///< what was found, for a person; cables are counted from 1
};
[[nodiscard]] std::string name_of(Event::Kind kind);

/// Leads eight drives so that the handle behaves like the virtual body of the admittance (Multimodal Fig. 5): once a
/// period it finds the pose from the lengths and the user's wrench from the tensions, W_e = W_c − W_ini (eq. 18: cables
/// less weight and inertia, each with its own sign), moves the virtual body, and asks each drive for the length
/// l_R = l_e − l_Δ (eq. 19) and a tension. In between, the drives are servos.
class Controller {
public:
    /// @param start  the handle's pose at the counts of 0
    /// @throws Error{bad_argument} naming options that make no sense
    Controller(const Geometry& geometry, const ControllerOptions& options, const Pose& start);

    /// One servo period. @return the torque codes for the drives
    [[nodiscard]] std::array<std::int16_t, cable_count> step(const std::array<DriveReading, cable_count>& readings);

    /// A wrench of the virtual scene, which the virtual body feels beside the user's from the next period on: a weight
    /// that is carried, a surface, friction. The user then feels it through the handle.
    void render(const Wrench& scene) { scene_ = scene; }

    [[nodiscard]] double time_s() const { return time_; }
    [[nodiscard]] const AdmittanceState& wanted() const { return wanted_; }
    [[nodiscard]] const Pose& pose() const { return pose_; }    ///< from the encoders
    [[nodiscard]] const Wrench& user() const { return user_; }  ///< from the tensions of the last period
    [[nodiscard]] const std::vector<Event>& events() const { return events_; }
    [[nodiscard]] bool resting() const { return resting_; }      ///< after a fault
    [[nodiscard]] long saturated() const { return saturated_; }  ///< codes that were beyond the converter

private:
    void check(const std::array<DriveReading, cable_count>& readings);
    void check_lengths();
    void period();
    void report(Event::Kind kind, int cable, std::string text);
    void servo_targets(PerCable& length, PerCable& speed, PerCable& acceleration) const;
    [[nodiscard]] std::optional<PerCable> balance(const Pose& pose, const Wrench& load) const;
    void overload(const Wrench& user);
    void rest();
    [[nodiscard]] bool whole() const;
    [[nodiscard]] bool by_tensions() const { return resting_ && (yielding_ || !whole()); }
    void lead_by_tensions();
    [[nodiscard]] bool tumbles();
    void find_pose();
    [[nodiscard]] PerCable servo_pulls();
    [[nodiscard]] std::array<std::int16_t, cable_count> codes_of(const PerCable& pulls);
    [[nodiscard]] Eigen::Matrix<double, 6, 6> moved_by(const Structure& structure) const;
    void brake();
    void believe_lengths();

    Geometry geometry_;
    ControllerOptions options_;
    double time_ = 0.0;
    long ticks_ = 0;
    int ticks_a_period_;
    AdmittanceState wanted_;
    Pose pose_;
    Wrench user_ = Wrench::Zero(), scene_ = Wrench::Zero();
    PerCable home_, lengths_, last_lengths_, speeds_ = PerCable::Zero();
    PerCable from_, target_, next_target_, correction_ = PerCable::Zero(), pulls_;
    Wrench cable_sum_ = Wrench::Zero();  ///< of the cables on the handle, over the ticks of a period
    PerCable tension_sum_ = PerCable::Zero(), last_tension_ = PerCable::Zero();
    PerCable reference_;                                ///< lengths of pose_
    Eigen::Matrix<double, cable_count, 2> impossible_;  ///< directions in which no motion changes the lengths
    std::array<bool, cable_count> length_good_{}, tension_good_{}, cable_good_{}, broken_{};
    std::array<long, cable_count> slack_ticks_{}, silent_ticks_{}, same_ticks_{};
    std::vector<Event> events_;
    std::optional<Pose> refuge_;     ///< where the cables that are left shall hold the handle
    Vector3 led_ = Vector3::Zero();  ///< where they are to hold it now, on the way there
    double led_m_s_ = 0.0;
    long carried_ticks_ = 0, calm_ticks_ = 0;
    PerCable braked_ = PerCable::Zero();      ///< lengths that the brakes hold
    PerCable keeping_up_ = PerCable::Zero();  ///< pull with which the motors follow a handle that is pushed away
    bool braking_ = false, tumbling_ = false;
    bool alone_ = false;     ///< without a hand, when a cable was lost
    double felt_s_ = -1e9;   ///< when a hand was felt last
    bool yielding_ = false;  ///< to a user who is stronger than eight cables
    bool resting_ = false;
    long saturated_ = 0;
};

}  // namespace haptogram::robot
