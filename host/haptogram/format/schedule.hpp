// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "haptogram/array/array.hpp"
#include "haptogram/format/core.hpp"
#include "haptogram/format/path.hpp"

namespace haptogram {

/// How the FPGA counts one carrier period: `cycle_ticks` ticks of `prescaler` clocks, high for `pulse_ticks` of them.
struct Timer {
    double clock_hz = 50e6;
    std::uint32_t prescaler = 5;
    std::uint32_t cycle_ticks = 250;
    std::uint32_t pulse_ticks = 125;
    std::uint32_t shortest_pulse_ticks = 1;  ///< the shortest pulse that the board plays

    [[nodiscard]] double tick_s() const { return prescaler / clock_hz; }
    [[nodiscard]] double period_s() const { return cycle_ticks * tick_s(); }
    [[nodiscard]] double carrier_hz() const { return 1.0 / period_s(); }
    [[nodiscard]] double duty() const { return static_cast<double>(pulse_ticks) / cycle_ticks; }
    [[nodiscard]] std::uint32_t cycle_clocks() const { return cycle_ticks * prescaler; }
    friend bool operator==(const Timer&, const Timer&) = default;
};

/// The finest timer, that is, the smallest prescaler, whose carrier is within 100 ppm of the array's, whose pulse
/// counter can hold the wanted duty to half a tick, and whose every tick is a timing that the board's timing bits can
/// hold. Its pulse is one that the board plays: a duty of one half of an odd number of ticks is rounded down.
/// @throws Error{bad_input} when no prescaler does
[[nodiscard]] Timer choose_timer(const Array& array, const Core& core);

/// The timer of records with amplitudes (rtl/README.md, "The second instrument"): ticks of one clock, and the array's
/// duty as the longest pulse. Its carrier is within 100 ppm of the array's.
/// @throws Error{bad_input} when the core has no amplitudes, or cannot play such a cycle
[[nodiscard]] Timer choose_amplitude_timer(const Array& array, const Core& core);

/// Length in ticks of the pulse whose carrier has `amplitude` times that of the timer's own pulse:
/// (cycle/π)·asin(amplitude·sin(π·duty)), rounded (Hoshi et al. 2010, eq. 7, solved for the pulse). It is 0 for 0, and
/// the timer's own pulse for 1. Below the shortest pulse that the board plays, it is that one or 0, whichever is
/// nearer.
[[nodiscard]] std::uint32_t pulse_ticks(const Timer& timer, double amplitude);

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
