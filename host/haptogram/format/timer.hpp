// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>

#include "haptogram/array/array.hpp"
#include "haptogram/format/core.hpp"

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

}  // namespace haptogram
