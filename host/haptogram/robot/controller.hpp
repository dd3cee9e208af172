// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "haptogram/robot/admittance.hpp"
#include "haptogram/robot/drives.hpp"
#include "haptogram/robot/tension.hpp"

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
    // Faults.
    double slack_n = 0.1, slack_s = 0.003;  ///< a sensor below the one for the other: the cable is slack
    double broken_m = 0.005;                ///< a slack cable that its motor winds in by this: it is broken
    double fastest_m_s = 2.0;               ///< cable speed that only an encoder that slips can show
    double mismatch_m = 0.001;              ///< of lengths that no pose has: an encoder has slipped
    double refuge_least_n = 1.0,
           refuge_most_n = 5.0;                 ///< tensions of the place where seven cables shall hold the handle
    double silent_s = 0.005, frozen_s = 0.050;  ///< a sensor that does not answer, or always the same
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
    void report_overload(const Wrench& user);
    void seek_refuge();
    void rest();
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
    std::optional<Pose> refuge_;  ///< where cables that are left hold the handle
    bool resting_ = false, held_ = true;
    long saturated_ = 0;
};

}  // namespace haptogram::robot
