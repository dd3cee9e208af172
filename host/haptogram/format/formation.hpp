// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <span>

#include "haptogram/array/array.hpp"
#include "haptogram/format/core.hpp"

namespace haptogram {

/// How long a focal point takes to form (Haptogram III-G), with the part of the geometry and the part of the
/// transducers apart. The paper's formula has only the first; the 640 µs that it measured are mostly the second.
struct Formation {
    double flight_spread_s = 0.0;  ///< ΔT, Haptogram eq. 4
    std::uint32_t periods = 0;     ///< β = ⌈f_U·ΔT⌉, Haptogram eq. 11
    double formation_s = 0.0;      ///< T_f = β/f_U + C/f_P, Haptogram eq. 12
    double ring_up_s = 0.0;        ///< to 90 % of the amplitude: 2.3·τ with τ = 1/(π·bandwidth)
    [[nodiscard]] double with_ring_up_s() const { return formation_s + ring_up_s; }
};

/// @param focus  metres, array frame
/// @param foci   as in load_clocks()
[[nodiscard]] Formation formation(const Array& array, const Core& core, Vec3 focus, std::uint32_t foci = 0);

/// The largest of each member over several foci.
[[nodiscard]] Formation slowest_formation(const Array& array, const Core& core, std::span<const Vec3> points,
                                          std::uint32_t foci = 0);

/// The largest number of focal points that each get their full pressure at a rendering rate (Haptogram eq. 13):
/// ⌊1/(f_R·T_f)⌋.
[[nodiscard]] std::uint32_t most_points(double rate_hz, double formation_s);

}  // namespace haptogram
