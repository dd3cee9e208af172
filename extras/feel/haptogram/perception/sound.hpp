// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>
#include <vector>

#include "haptogram/acoustics/drive_sequence.hpp"
#include "haptogram/array/array.hpp"
#include "haptogram/perception/spectrum.hpp"

namespace haptogram::perception {

/// How much a sequence is likely to be heard, beside a reference.
///
/// Air makes sound of the envelope E of strong ultrasound in proportion to d²(E²)/dt² (Berktay 1965). E² is taken as
/// the sum of |drive|² over the elements after the transducers' bandwidth, so that steps of the phase, at which a
/// carrier dips, make noise as changes of the amplitude do. Directions and the room are left out: differences between
/// sequences of one array mean something, and the level at an ear does not follow.
struct Noise {
    double relative_db = 0.0;  ///< A-weighted, 20 Hz to 16 kHz, over that of every element at full drive under a sine
                               ///< from 0 to 1 at 200 Hz; −∞ for a steady drive
    double loudest_hz = 0.0;   ///< the strongest line; 0 for a steady drive
    double largest_step_deg = 0.0;  ///< of any element's phase from one carrier period to the next
    std::vector<Line> lines;        ///< A-weighted second derivatives of E², in the unit of the reference's sum
};
/// @throws Error{bad_input} for a sequence of nothing
[[nodiscard]] Noise noise_of(const Array& array, const DriveSequence& sequence);

/// What reaches a listener.
struct Exposure {
    Vec3 ear;              ///< metres, array frame
    double mean_db = 0.0;  ///< of the mean square over the sequence, dB SPL
    double most_db = 0.0;  ///< of the loudest set of drives, if it stayed
};
/// Ultrasound at an ear, in a free field: without head, hand and walls.
/// @throws Error{bad_input} when the ear coincides with an element
[[nodiscard]] std::vector<Exposure> exposure(const Array& array, const DriveSequence& sequence,
                                             std::span<const Vec3> ears);

/// The largest mean level on a hemisphere in front of the array, around its centre, looked at every 2 degrees.
[[nodiscard]] Exposure loudest_around(const Array& array, const DriveSequence& sequence, double radius_m = 0.5);

}  // namespace haptogram::perception
