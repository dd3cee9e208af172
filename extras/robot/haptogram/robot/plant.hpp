// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <numbers>
#include <random>

#include "haptogram/robot/geometry.hpp"

namespace haptogram::robot {

/// What the drives are made of (Multimodal section II-C). Where the paper gives no value the default is ours.
struct DriveOptions {
    double gear = 4.4;           ///< motor turns a pulley turn
    double pulley_m = 0.020;     ///< diameter
    int encoder_pulses = 500;    ///< a motor turn; each pulse gives four counts
    int converter_bits = 12;     ///< of the torque command, one of them the sign
    double full_scale_n = 20.0;  ///< pull at the largest code; ours, twice the largest tension

    /// Cable length of one encoder count, m.
    [[nodiscard]] double metres_per_count() const {
        return std::numbers::pi * pulley_m / (gear * 4.0 * encoder_pulses);
    }
    [[nodiscard]] int largest_code() const { return (1 << (converter_bits - 1)) - 1; }
    /// Pull of one code, N.
    [[nodiscard]] double newtons_per_code() const { return full_scale_n / largest_code(); }
};

/// What one drive tells.
struct DriveReading {
    std::int32_t counts = 0;    ///< encoder, growing while cable is let out, 0 where the robot was switched on
    double tension_n = 0.0;     ///< force sensor at the handle
    bool tension_valid = true;  ///< false when the sensor does not answer
};

/// The eight drives, as a driver for their bus has them. The simulated plant is one.
class CableDrives {
public:
    virtual ~CableDrives() = default;
    /// Torque commands: positive codes pull. @throws Error{bad_argument} for codes beyond largest_code(), Error{device}
    /// when the bus fails
    virtual void command(const std::array<std::int16_t, cable_count>& codes) = 0;
    /// The latest readings. @throws Error{device} when the bus fails
    [[nodiscard]] virtual std::array<DriveReading, cable_count> read() = 0;
};

/// The three zones of Multimodal task T1: balls around the origin, in which other springs act.
struct Zones {
    double inner_m = 0.040;   ///< Z1 up to here: a spring to the origin
    double middle_m = 0.120;  ///< Z2 up to here: inertia and damping alone
    double outer_m = 0.160;   ///< Z3 up to here: a spring back to Z2. Beyond, the same spring pulls on
    double inner_n_m = 150.0, outer_n_m = 400.0;  ///< stiffnesses; the paper does not print them

    /// The spring's force at a place, N.
    [[nodiscard]] Vector3 force(const Vector3& position) const;
    /// 1, 2 or 3; 4 beyond the outer ball.
    [[nodiscard]] int zone(const Vector3& position) const;
};

/// The virtual body that the user moves. The paper prints none of these values; translation has those with which its
/// Fig. 8 can be told again, and turns are held by a spring, because the zones say nothing of them.
struct AdmittanceOptions {
    double period_s = 0.030;  ///< the paper's handle update of 33.3 Hz
    double inertia_kg = 1.0, damping_n_s_m = 10.0;
    double turn_inertia_kg_m2 = 0.01, turn_damping_n_m_s = 0.2, turn_stiffness_n_m = 2.0;
    Zones zones;
};

/// Where the virtual body is: position and rotation vector, m and rad, and their rates.
struct AdmittanceState {
    Wrench place = Wrench::Zero(), velocity = Wrench::Zero(), acceleration = Wrench::Zero();
    [[nodiscard]] Pose pose() const;
};

/// I·ẍ + D·ẋ + E·x = W (Multimodal eq. 17), a spring, mass and damper for each of six freedoms, where the spring E·x of
/// the translations is that of the zones. The step is semi-implicit: v⁺ = (v + T·(W − E·x)/I)/(1 + T·D/I),
/// x⁺ = x + T·v⁺, which is stable for E·T²/I < 4.
/// @param wrench  of the user on the handle
/// @return the state one period later
[[nodiscard]] AdmittanceState admit(const AdmittanceState& state, const Wrench& wrench,
                                    const AdmittanceOptions& options);

/// @throws Error{bad_argument} naming what makes no sense: an inertia or a period that is not positive, balls that do
/// not grow, a spring too stiff for the period
void require_sound(const AdmittanceOptions& options);

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
