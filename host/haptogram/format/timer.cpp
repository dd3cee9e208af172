// SPDX-License-Identifier: Apache-2.0
#include "haptogram/format/timer.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "haptogram/base/error.hpp"

namespace haptogram {
namespace {

constexpr double carrier_tolerance = 100e-6;

std::string name_of(const Array& array) { return array.file.empty() ? array.name : array.file; }

}  // namespace

Timer choose_timer(const Array& array, const Core& core) {
    const interface::CoreParameters& board = core.parameters;
    const double clocks = board.clock_hz / array.carrier_hz;
    if (256.0 * array.duty > board.max_duty_256 + 1e-9)
        throw bad_input(
            name_of(array),
            fmt::format("pulses of {:.1f} % duty, but the board plays at most {:.1f} %; choose a smaller duty",
                        100.0 * array.duty, board.max_duty_256 / 2.56),
            {"array", "board"});
    const std::uint32_t longest_pulse = (1U << board.pulse_bits) - 1U;
    // The last tick of the longest cycle is one less than this. So no tick has all bits set, which would mean silence.
    const std::uint32_t longest_cycle = (1U << board.timing_bits) - 1U;
    for (std::uint32_t prescaler = 1; prescaler * 8.0 <= clocks; ++prescaler) {
        const double ticks = clocks / prescaler;
        const double cycle = std::round(ticks);
        const double pulse = std::min(std::round(array.duty * cycle), std::floor(board.max_duty_256 * cycle / 256.0));
        const std::uint32_t shortest_pulse = (board.min_pulse_clocks + prescaler - 1) / prescaler;
        if (std::abs(cycle / ticks - 1.0) > carrier_tolerance || cycle > longest_cycle || pulse > longest_pulse ||
            pulse < shortest_pulse || pulse * prescaler > max_pulse_clocks(board))
            continue;
        return {static_cast<double>(board.clock_hz), prescaler, static_cast<std::uint32_t>(cycle),
                static_cast<std::uint32_t>(pulse), shortest_pulse};
    }
    throw bad_input(name_of(array),
                    fmt::format("no timer of at least 8 ticks makes a {} Hz carrier with {:.1f} % duty from a {} Hz "
                                "clock with {} timing bits (at most {} ticks a cycle), {} pulse bits and pulses of {} "
                                "to {} clocks; "
                                "choose a clock that is a multiple of the carrier, or a smaller duty",
                                array.carrier_hz, 100.0 * array.duty, board.clock_hz, board.timing_bits, longest_cycle,
                                board.pulse_bits, board.min_pulse_clocks, max_pulse_clocks(board)));
}

Timer choose_amplitude_timer(const Array& array, const Core& core) {
    const interface::CoreParameters& board = core.parameters;
    if (board.width_bits == 0)
        throw bad_input(core.name, "its pulses have no amplitudes of their own; take a board that has, or records",
                        {"records", "board"});
    const double clocks = board.clock_hz / array.carrier_hz;
    const double cycle = std::round(clocks);
    if (std::abs(cycle / clocks - 1.0) > carrier_tolerance || cycle < least_amplitude_cycle(board) ||
        cycle > most_amplitude_cycle(board))
        throw bad_input(name_of(array),
                        fmt::format("a {} Hz carrier is {:.1f} clocks of {} Hz; with amplitudes {} plays whole clocks, "
                                    "{} to {}; choose another clock, or records",
                                    array.carrier_hz, clocks, board.clock_hz, core.name, least_amplitude_cycle(board),
                                    most_amplitude_cycle(board)),
                        {"records", "board", "array"});
    const auto ticks = static_cast<std::uint32_t>(cycle);
    return {static_cast<double>(board.clock_hz), 1, ticks,
            static_cast<std::uint32_t>(std::lround(std::min(array.duty, 0.5) * ticks)), 1};
}

std::uint32_t pulse_ticks(const Timer& timer, double amplitude) {
    if (amplitude >= 1.0) return timer.pulse_ticks;
    const double full = std::sin(std::numbers::pi * timer.duty());
    const double ticks = timer.cycle_ticks / std::numbers::pi * std::asin(std::max(0.0, amplitude) * full);
    if (ticks < timer.shortest_pulse_ticks)
        return 2.0 * ticks < timer.shortest_pulse_ticks ? 0 : timer.shortest_pulse_ticks;
    return static_cast<std::uint32_t>(std::lround(ticks));
}

}  // namespace haptogram
