// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "haptogram/format/path.hpp"
#include "haptogram/hand/press.hpp"
#include "haptogram/hand/section.hpp"

namespace haptogram {

/// What plays on a finger (Fingers, section 3, "Haptic feedback").
enum class FocusMotion {
    revolving,  ///< around the section's outline
    still,      ///< the paper's control: in the section's middle. A focus that does not move is only felt when it is
                ///< modulated, so it is, by a sine; the paper does not say by what
    pressing,   ///< several at once that turn slowly around the section's middle, as algorithm L has them
};

struct RingOptions {
    FocusMotion motion = FocusMotion::revolving;
    std::size_t points = 10;  ///< of a turn; of pressing foci, of each one's way to the place of the next, after which
                              ///< all is as before and can be repeated
    double turns_hz = 100.0;  ///< 10 points at 100 Hz are the paper's 1 ms each
    double still_am_hz = 200.0;  ///< of the still focus, a multiple of turns_hz below half the rate of points
    PressOptions press;
    /// Foci of each section in a step.
    [[nodiscard]] std::size_t foci() const { return motion == FocusMotion::pressing ? press.foci : 1; }
    /// How often a second the path begins anew.
    [[nodiscard]] double passes_hz() const {
        return motion == FocusMotion::pressing ? press.turns_hz * press.foci : turns_hz;
    }
};
/// The longest step of a pressing focus that is still felt as steady pressure, metres (Morisaki et al. 2022: below 1
/// mm).
inline constexpr double longest_press_step_m = 1e-3;
/// @throws Error{bad_argument} naming what makes no sense
void require_sound(const RingOptions& options);

/// What is left of the fundamental of a still focus' radiation pressure, because each step holds it: sin(π/m)/(π/m)
/// with m steps in a wave of still_am_hz.
[[nodiscard]] double held_fundamental(const RingOptions& options);

/// Points on an ellipse at equal distances along it, in the right-hand direction about its normal, the first one as
/// near as possible to `start`.
[[nodiscard]] std::vector<Vec3> ring_points(const Ellipse& ellipse, std::size_t count,
                                            const std::optional<Vec3>& start = {});

/// One pass on several fingers at once: in step j the j-th point of each, and of pressing foci all those of a finger
/// before those of the next one. All steps last equally long, in whole carrier
/// periods.
/// @param starts   of each section, where its focus is now; a place for each
/// @throws Error{bad_argument} when a step would last less than a carrier period
[[nodiscard]] Path ring_path(std::span<const Ellipse> sections, std::span<const std::optional<Vec3>> starts,
                             double carrier_hz, const RingOptions& options = {});

}  // namespace haptogram
