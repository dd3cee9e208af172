// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <string>

#include "haptogram/hand/hand.hpp"
#include "haptogram/robot/stimulus.hpp"

// Mode W2 of the paper Multimodal (section III): the cables give the weight; a pattern on the palm says by its
// intensity, its frequency or a transformation how far, how hard or how rough something is.

namespace haptogram::fusion {

/// What of the pattern tells the value.
enum class PalmSign { intensity, frequency, translation, rotation, scaling };
/// "intensity", "frequency", "translation", "rotation" or "scaling". @throws Error{bad_argument} naming "sign"
[[nodiscard]] PalmSign palm_sign(const std::string& name);

/// What a sign is for the values 0 and 1 unless the user says otherwise, in the units of PalmPattern. Ours.
struct SignRange {
    double low, high;
};
[[nodiscard]] SignRange usual_range(PalmSign sign);

enum class PalmShape { focus, line, ring };
/// "focus", "line" or "ring". @throws Error{bad_argument} naming "pattern"
[[nodiscard]] PalmShape palm_shape(const std::string& name);

/// A pattern on the palm. The paper names the signs; the measures and ranges are ours. `low` and `high` are what the
/// sign is for the values 0 and 1, linear between them.
struct PalmPattern {
    PalmSign sign = PalmSign::frequency;
    PalmShape shape = PalmShape::focus;
    double low = 80.0, high = 300.0;  ///< magnitude, Hz, metres along the hand, degrees to the left, or a factor
    double magnitude = 2.0;           ///< perceived, unless it is the sign
    double frequency_hz = 200.0;      ///< unless it is the sign
    double size_m = 20e-3;            ///< length of the line, diameter of the ring
};

/// The pattern that tells a value.
/// @param value   0…1
/// @param points  of a line or a ring, at least 2; a focus is one
/// @throws Error{bad_argument} naming "value" outside of 0…1, and what of the pattern makes no sense: a sign that its
/// shape does not show (a focus does not turn or grow, a ring does not turn)
[[nodiscard]] Stimulus tell(const PalmPattern& pattern, double value, const Hand& palm, std::size_t points = 1);

/// Values for tell(). Nearness is 1 at the target and falls linearly to 0 at `range_m` and beyond.
[[nodiscard]] double nearness(double distance_m, double range_m);
/// Roughness of a cloth whose threads cross every `cell_m`: ½ + ½·sin(2πx/cell)·sin(2πy/cell).
[[nodiscard]] double cloth(double x_m, double y_m, double cell_m);
/// Hardness of a spring between the softest and the hardest that are told, by the logarithm of its stiffness.
/// @throws Error{bad_argument} naming "stiffness" outside of them
[[nodiscard]] double hardness(double stiffness_n_m, double softest_n_m, double hardest_n_m);

}  // namespace haptogram::fusion
