// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "haptogram/robot/geometry.hpp"

namespace haptogram::robot {

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

}  // namespace haptogram::robot
