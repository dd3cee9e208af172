// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <random>

#include "haptogram/live/shot_rings.hpp"
#include "haptogram/live/skin_sense.hpp"
#include "haptogram/live/source.hpp"

namespace haptogram::live {

/// What the fingers get to feel.
enum class Felt {
    dynamic,  ///< rings
    still,    ///< the still focus
    nothing,
};

/// The second task of Fingers: a cube is to be lifted by at least 50 mm for 1.5 s, with two fingers, seen (procedure 1)
/// or hidden behind a wall (procedure 2). The numbers that the paper does not print are ours.
struct LiftOptions {
    FingerOptions fingers;  ///< scene: overwritten from what is below
    CameraOptions cameras;  ///< around the middle of the room
    Felt felt = Felt::dynamic;
    bool seen = true;
    double edge_m = 40e-3;
    double x_m = 0.0, y_m = 0.0, turn_deg = 0.0;  ///< where the cube stands on the floor, which is 100 mm high
    double lift_m = 50e-3, hold_s = 1.5;
    double at_most_s = 12.0;     ///< then the trial has failed
    double squeeze_m = 10e-3;    ///< how far the fingers go in beyond the first touch
    double guess_m = 60e-3;      ///< between the fingertips and the middle, when they begin to close
    double closing_m_s = 60e-3;  ///< speed of each finger
    double lifting_m_s = 80e-3;
    std::size_t looks = 3;  ///< shots in which a finger feels where on it the face is, before the hand turns
    SenseOptions sense{};
    std::uint64_t person_seed = 1;  ///< of what is felt by chance
};

/// Draws a cube as the paper does, at random: 30 to 50 mm, in any place of the floor and at any angle. A hidden one
/// stands before the hand, within 15 mm along the fingers' way, 5 mm across it and 20°, because the scripted hand does
/// not search for it.
void draw_cube(LiftOptions& options, std::mt19937_64& random);

struct LiftReport {
    bool done = false;
    std::uint64_t shots = 0;
    std::uint64_t touched_shots = 0;  ///< of these, in which a finger touched the cube
    std::uint64_t felt_shots = 0;     ///< of those, in which the skin of one felt something
    std::size_t tries = 1;            ///< how often the fingers closed
    double first_touch_s = 0.0;       ///< of the cube by any finger
    double time_s = 0.0;              ///< from then to the end of the task
    double lifted_m = 0.0;            ///< at most
    double most_force_n = 0.0;        ///< of both fingers together
    double mean_force_n = 0.0;        ///< while it was held up
    double energy_made_j = 0.0;  ///< by how much the energy less the fingers' work ever grew; see TouchScene::work()
    ShotCounts counts;
};

/// A hand of two opposite fingers that carries out the task by a script. It feels by the skin (skin_sense.hpp) and, of
/// a seen cube, sees through the simulated cameras and the scene:
/// - A seen cube: it closes the fingers on the cube's middle, across two opposite faces, until it feels or sees each of
///   them in, and then by `squeeze_m` more. It lifts and holds.
/// - A hidden cube: it closes along x about the room's middle. The first finger that feels stays for `looks` shots: how
///   far off its middle, sideways, it feels says how the face is turned, and the hand turns about that round fingertip
///   so that it meets the face squarely. Then the other one closes. With nothing to feel, both close to half of the
///   smallest cube's width.
/// Fingers that meet each other, or that rise without the cube, open and try again.
/// @throws Error{bad_argument} for measures that are not positive, and as ShotRings
[[nodiscard]] LiftReport lift(const Array& array, const LiftOptions& options,
                              const std::function<void(const ShotReport&)>& told = {});

}  // namespace haptogram::live
