// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <optional>
#include <string>

#include "haptogram/array/array.hpp"
#include "haptogram/format/waveform.hpp"
#include "haptogram/hand/movement.hpp"

namespace haptogram {

/// A movement as a user names it.
struct MovementRequest {
    std::string movement;     ///< line, circle, spiral or random
    MovementOptions options;  ///< but for its grid and modulation
    bool grid = false;        ///< only the positions of the device's table, at the height of the centre
    std::string am = "square:200";
    AmplitudeLaw am_law = AmplitudeLaw::pressure;
    std::optional<std::string> array, board;  ///< as a project has them
};

/// The path, and for what it was made.
struct MovementOnArray {
    MadeMovement made;
    Array array;
    double carrier_hz = 0.0;
    std::size_t places = 0;  ///< different ones
    [[nodiscard]] double seconds() const { return static_cast<double>(made.path.periods()) / carrier_hz; }
};

/// A modulated focus that moves as in Hoshi et al. 2010.
/// @throws Error{bad_argument} for names and measures that make no sense, Error{bad_input} when the array cannot reach
/// a place
[[nodiscard]] MovementOnArray movement(const MovementRequest& request);

}  // namespace haptogram
