// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <random>
#include <vector>

#include "haptogram/live/shot_rings.hpp"
#include "haptogram/live/skin_sense.hpp"
#include "haptogram/live/source.hpp"

namespace haptogram::live {

/// The first task of Fingers: the angle and the height of a surface are to be found by touch alone. The surface is felt
/// on a disc only. The numbers that the paper does not print are ours.
struct SurfaceOptions {
    FingerOptions fingers;   ///< scene: overwritten from what is below
    CameraOptions cameras;   ///< one, below the surface, as in the paper's experiment
    double angle_deg = 0.0;  ///< about y, which is the direction in which the person looks
    double height_m = 0.0;   ///< over the middle of its range
    Vec3 middle{0, 0, 0.2};
    double disc_m = 10e-3;   ///< radius
    std::size_t places = 5;  ///< where the finger comes down, evenly over the disc
    double lowering_m_s = 40e-3;
    double press_m = 3e-3;                 ///< how far it goes on when it feels
    std::size_t stay = 3;                  ///< shots for which it stays there
    double at_most_s = 30.0;               ///< then the trial has failed
    double key_deg = 0.5, key_m = 0.5e-3;  ///< what a key of the answer changes
    bool nothing = false;                  ///< no ring is played
    /// A person who feels by the skin; without, the finger knows exactly where the rings are, which tells the errors of
    /// cameras and sections.
    std::optional<SenseOptions> sense{};
    double hand_sd_m = 5e-3;        ///< of a person: how far off the own hand's height is thought to be, a trial
    std::uint64_t person_seed = 1;  ///< of all that a person does by chance
};

/// Draws angle and height as the paper does, in steps of the keys: -45° to 45°, and -10 to 10 mm.
void draw_surface(SurfaceOptions& options, std::mt19937_64& random);

struct SurfaceReport {
    bool done = false;     ///< the finger felt the surface at two places at least
    bool guessed = false;  ///< a person who felt less answered by chance
    std::size_t felt_places = 0;
    std::uint64_t shots = 0;
    double time_s = 0.0;                                 ///< from the first touch to the answer
    double angle_deg = 0.0, height_m = 0.0;              ///< the answer, in steps of the keys
    double angle_error_deg = 0.0, height_error_m = 0.0;  ///< the answer less the truth
    ShotCounts counts;
};

/// A finger that comes down at several places, stays where it feels its ring, and goes on to the next. The answer is
/// the line of least squares through what it felt. A person (`sense`) who felt it at less than two places guesses
/// within the range of draw_surface().
/// @throws Error{bad_argument} for measures that make no sense, and as ShotRings
[[nodiscard]] SurfaceReport find_surface(const Array& array, const SurfaceOptions& options,
                                         const std::function<void(const ShotReport&)>& told = {});

}  // namespace haptogram::live
