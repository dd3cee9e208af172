// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "haptogram/array/array.hpp"
#include "haptogram/format/schedule.hpp"

namespace haptogram {

/// Emission ticks that bring every element's wave to each focus in phase (Haptogram eq. 2, 3 and 5). With the range
/// R = |F − E|, √((dx² + dy²) + dz²), and the greatest range R_max of a focus, the tick is
/// (R_max − R)·ticks_per_m, rounded to the nearest whole number, halves up, modulo timer.cycle_ticks;
/// ticks_per_m = 1/(c·tick). Every tick is exactly what this formula gives in double precision, on every processor.
/// Where an element's response is not 1, its wave's phase delays its tick; a dead one's tick is silent_timing.
/// @param foci   metres, array frame, within 1 km of the origin, as the elements are
/// @param ticks  foci.size() rows of elements.size() ticks, each in [0, timer.cycle_ticks)
/// @throws Error{bad_input} naming the focus or the element that is not finite or too far away, or Error{bad_argument}
/// when `ticks` has another size
void focal_law(const Array& array, const Timer& timer, std::span<const Vec3> foci, std::span<std::uint16_t> ticks);
[[nodiscard]] std::vector<std::uint16_t> focal_law(const Array& array, const Timer& timer, std::span<const Vec3> foci);

/// Name of the instruction set that focal_law was dispatched to, for reports.
[[nodiscard]] const char* focal_law_target();

}  // namespace haptogram
