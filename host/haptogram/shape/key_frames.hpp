// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <map>
#include <vector>

#include "haptogram/array/vec3.hpp"
#include "haptogram/format/path.hpp"

namespace haptogram {

/// How what changes goes from a key frame to the next one.
enum class Ease {
    linear,  ///< evenly
    smooth,  ///< slowly at both ends: 3 u² − 2 u³ of the part u of the time
    step,    ///< not at all, until the next is reached
};

/// Where a shape is, and how strong, at a time. What it says is of the placed shape: nothing of it moves the shape.
struct KeyFrame {
    double time_s = 0.0;
    Vec3 move{};         ///< metres
    Vec3 turn_deg{};     ///< about x, then y, then z, through the shape's centre
    double scale = 1.0;  ///< about its centre
    double amplitude = 1.0;
    double am_hz = 0.0;  ///< the amplitude rises and falls so often a second, as a cosine from 0 to 1; 0: it stays
    Ease ease = Ease::linear;
    bool mark = false;      ///< a board's trigger output tells when it is reached
    std::size_t shape = 0;  ///< number of the form that the shape has become there; 0: its own
    friend constexpr bool operator==(const KeyFrame&, const KeyFrame&) = default;
};

/// The points of a form that the points of a pass become: those of a closed tour, run through at an even pace, from
/// that point on and in that sense which make the sum of the squared ways least. As neighbours stay neighbours, the
/// tour on the way is at most as long as the two tours, mixed as it is.
/// @param pass  in their order; of more than 1024, as many of them, evenly, are compared
/// @param tour  at least one
[[nodiscard]] std::vector<Vec3> matched(const std::vector<Vec3>& pass, const std::vector<Vec3>& tour);

/// What the foci of a pass become, in their order, by the numbers of forms.
using Forms = std::map<std::size_t, std::vector<Vec3>>;

/// Plays passes over a shape one after the other while the shape moves from key frame to key frame; the path ends at
/// the last one. A step that a key frame falls into is cut there. Where a focus is and how strong is what holds in the
/// middle of its step.
/// @param pass        over the shape as it was placed
/// @param centre      of the shape, metres
/// @param most_steps  that can be played
/// @param forms       that key frames name, each with as many points as the pass has foci
/// @throws Error{bad_argument} naming "keyframe", for fewer than two, for a first one that is not at 0 s, for times
/// that do not rise by at least a carrier period, for an amplitude outside 0…1, a scale that is not above 0, a number
/// that is not finite, a negative am_hz or a form that is not there; Error{bad_input} for a path of more steps
[[nodiscard]] Path moved_by(const std::vector<KeyFrame>& frames, const Path& pass, Vec3 centre, double carrier_hz,
                            std::size_t most_steps, const Forms& forms = {});

}  // namespace haptogram
