// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "haptogram/render/path.hpp"
#include "haptogram/render/section.hpp"

namespace haptogram {

/// What plays on a finger (Fingers, section 3, "Haptic feedback").
enum class FocusMotion {
    revolving,  ///< around the section's outline
    still,      ///< the paper's control: in the section's middle. A focus that does not move is only felt when it is
                ///< modulated, so it is, by a sine; the paper does not say by what
};

struct RingOptions {
    FocusMotion motion = FocusMotion::revolving;
    std::size_t points = 10;     ///< of a turn
    double turns_hz = 100.0;     ///< 10 points at 100 Hz are the paper's 1 ms each. A few turns a second are felt as
                                 ///< steady pressure instead of vibration; they need more points
    double still_am_hz = 200.0;  ///< of the still focus, a multiple of turns_hz below half the rate of points
};
/// @throws Error{bad_argument} naming what makes no sense
void require_sound(const RingOptions& options);

/// Points on an ellipse at equal distances along it, in the right-hand direction about its normal, the first one as
/// near as possible to `start`.
[[nodiscard]] std::vector<Vec3> ring_points(const Ellipse& ellipse, std::size_t count,
                                            const std::optional<Vec3>& start = {});

/// One turn on several fingers at once: in step j the j-th point of each. All steps last equally long, in whole carrier
/// periods.
/// @param starts   of each section, where its focus is now; a place for each
/// @throws Error{bad_argument} when a step would last less than a carrier period
[[nodiscard]] Path ring_path(std::span<const Ellipse> sections, std::span<const std::optional<Vec3>> starts,
                             double carrier_hz, const RingOptions& options = {});

}  // namespace haptogram
