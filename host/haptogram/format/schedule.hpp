// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "haptogram/format/path.hpp"

namespace haptogram {

/// Carrier periods for each of `count` points, as even as whole numbers allow, so that a pass over all of them takes
/// 1 / rate_hz.
/// @param most_periods  the most that a point may last; an entry of the core's sequence can hold 65,535
/// @throws Error{bad_input} when a point would last less than one period or more than `most_periods`, saying which
/// rates and numbers of points can be had
[[nodiscard]] std::vector<std::uint32_t> even_dwells(double carrier_hz, double rate_hz, std::size_t count,
                                                     std::uint32_t most_periods);

/// The points in their order, one focus each at full amplitude.
/// @param dwells  carrier periods, one a point
[[nodiscard]] Path path_through(const std::vector<Vec3>& points, const std::vector<std::uint32_t>& dwells);

}  // namespace haptogram
