// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string_view>

#include "haptogram/hand/hand.hpp"

namespace haptogram {

/// What a synthetic hand does. It repeats after its time.
enum class HandScript {
    press,  ///< an open hand goes down by 30 mm and up again, in 2 s
    slide,  ///< an open hand goes 60 mm to the side and back, in 3 s
    grasp,  ///< the fingers bend by 70° at each of their two outer joints and open again, in 2 s
    wave,   ///< an open hand turns 30° to either side about its wrist, in 1 s
};

/// The script of a name: press, slide, grasp or wave.
/// @throws Error{bad_argument} for another name
[[nodiscard]] HandScript hand_script(std::string_view name);

/// After which it repeats.
[[nodiscard]] double seconds_of(HandScript script);

/// A right hand of a usual size at a time of its script: palm down, fingers along y. All moves are smooth, and the
/// velocity is their exact derivative.
/// @param height_m  of the palm above the array when the script begins
[[nodiscard]] Hand synthetic_hand(HandScript script, double time_s, double height_m = 0.2);

}  // namespace haptogram
