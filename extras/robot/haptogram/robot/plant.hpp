// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <random>

#include "haptogram/robot/drives.hpp"

namespace haptogram::robot {

/// A hand at the handle.
struct User {
    double mass_kg = 0.0;  ///< of the hand, which moves with the handle
    /// The force of the hand, N: over time, and over the handle's position and velocity.
    std::function<Vector3(double time_s, const Vector3& position, const Vector3& velocity)> force;
};

/// A hand as a spring and a damper between the handle and where the hand wants to be.
struct Impedance {
    double mass_kg = 0.5, damping_n_s_m = 5.0, stiffness_n_m = 100.0;
};
[[nodiscard]] User impedance_user(const Impedance& impedance, std::function<Vector3(double time_s)> wanted);

/// What the plant is made of. All of it is ours; the paper names a motor RE 25 and no masses or stiffnesses.
struct PlantOptions {
    DriveOptions drives;
    double rotor_kg_m2 = 1.08e-6;       ///< inertia of one motor
    double friction_n_s_m = 1.0;        ///< viscous, of one drive, seen at the cable
    double cable_n = 20e3;              ///< EA: stiffness times length of a cable
    double cable_damping_ratio = 0.05;  ///< of a cable with the handle's mass
    double sensor_noise_n = 0.02;       ///< standard deviation
    double step_s = 50e-6;              ///< of the integration
    double pretension_n = 3.0;          ///< above the geometry's least tension, with which it starts
    std::uint64_t seed = 1;             ///< of the noise
};

/// A simulated robot: eight motors with gear and encoder wind cables, which are springs that only pull; the handle is a
/// rigid body with six freedoms, under gravity, the cables and the user. Integrated by the semi-implicit Euler method.
class Plant : public CableDrives {
public:
    /// Starts at rest in a pose, with the tensions of least norm above the pretension.
    /// @throws Error{bad_argument} naming "start" when the handle cannot rest there
    Plant(const Geometry& geometry, const PlantOptions& options, const Pose& start, User user);

    void command(const std::array<std::int16_t, cable_count>& codes) override;
    [[nodiscard]] std::array<DriveReading, cable_count> read() override;

    /// Lets time pass, at the commanded torques.
    void advance(double seconds);

    [[nodiscard]] double time_s() const { return time_; }
    [[nodiscard]] const Pose& pose() const { return pose_; }
    [[nodiscard]] const Vector3& velocity() const { return velocity_; }
    [[nodiscard]] const Vector3& turning() const { return turning_; }  ///< rad/s
    /// The cables' true tensions, and the least that each has had since the plant was made or this was last called.
    [[nodiscard]] const PerCable& tensions() const { return tensions_; }
    [[nodiscard]] PerCable least_tensions();
    [[nodiscard]] Vector3 user_force() const { return force_; }

    /// Faults. @param cable  0…7
    void break_cable(int cable);
    void slip_encoder(int cable, double metres);
    void lose_sensor(int cable);    ///< it does not answer any more
    void freeze_sensor(int cable);  ///< it answers with its last value for ever

private:
    void step();

    Geometry geometry_;
    PlantOptions options_;
    User user_;
    double time_ = 0.0;
    Pose pose_;
    Vector3 velocity_ = Vector3::Zero(), turning_ = Vector3::Zero(), force_ = Vector3::Zero();
    PerCable spooled_, spool_velocity_ = PerCable::Zero();  ///< unstretched length outside of the pulley, m
    PerCable zero_;                                         ///< spooled_ where the counts are 0
    PerCable tensions_ = PerCable::Zero(), least_, pulls_ = PerCable::Zero();
    std::array<bool, cable_count> broken_{}, lost_{}, frozen_{};
    PerCable slipped_ = PerCable::Zero(), last_told_ = PerCable::Zero();
    double drive_kg_;  ///< a motor's inertia, seen at the cable
    std::mt19937_64 random_;
    std::normal_distribution<double> noise_;
};

}  // namespace haptogram::robot
