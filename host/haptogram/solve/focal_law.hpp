// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "haptogram/model/array.hpp"
#include "haptogram/solve/timer.hpp"

namespace haptogram {

/// Emission ticks that bring every element's wave to each focus in phase (Haptogram eq. 2, 3 and 5):
/// t = |F − E| / c, τ = max(t) − t, tick = τ mod T in timer ticks, rounded to the nearest.
/// Computed in single precision with correctly rounded operations only, so that every processor gives the same ticks;
/// they differ from double precision only where τ lies within 0.01 tick of a rounding edge.
/// @param foci  metres, array frame, z > 0
/// @return foci.size() rows of elements.size() ticks, each in [0, timer.cycle_ticks)
/// @throws Error{bad_input} when a focus or an element is not finite
[[nodiscard]] std::vector<std::uint16_t> focal_law(const Array& array, const Timer& timer, std::span<const Vec3> foci);

/// Name of the instruction set that focal_law was dispatched to, for reports.
[[nodiscard]] const char* focal_law_target();

}  // namespace haptogram
