// SPDX-License-Identifier: Apache-2.0
#include "haptogram/format/schedule.hpp"

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

std::vector<std::uint32_t> even_dwells(double carrier_hz, double rate_hz, std::size_t count,
                                       std::uint32_t most_periods) {
    const double total = carrier_hz / rate_hz;
    const double each = total / static_cast<double>(count);
    const double fastest_hz = carrier_hz / static_cast<double>(count);
    if (each < 1.0)
        throw impossible(
            "rate",
            fmt::format(
                "{} points at {} Hz leave {:.2f} carrier cycles a point, and a focus lasts at least "
                "one; at most {:.6g} Hz can be reached with these points{}",
                count, rate_hz, each, fastest_hz,
                total >= 1.0 ? fmt::format(", or {} points at this rate", static_cast<std::size_t>(total)) : ""));
    if (each > most_periods)
        throw impossible("rate", fmt::format("{} points at {} Hz leave {:.4g} carrier cycles a point, and a sequence "
                                             "entry holds {}; at least {:.6g} Hz",
                                             count, rate_hz, each, most_periods, fastest_hz / most_periods));
    std::vector<std::uint32_t> dwells;
    std::uint64_t given = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const auto until = static_cast<std::uint64_t>(std::llround(each * static_cast<double>(i + 1)));
        dwells.push_back(static_cast<std::uint32_t>(until - given));
        given = until;
    }
    return dwells;
}

Path path_through(const std::vector<Vec3>& points, const std::vector<std::uint32_t>& dwells) {
    Path path;
    for (std::size_t i = 0; i < points.size(); ++i) path.steps.push_back({{{points[i]}}, dwells.at(i)});
    return path;
}

Formation formation(const Array& array, const Core& core, Vec3 focus, std::uint32_t foci) {
    double nearest = distance(focus, array.elements.front().position);
    double farthest = nearest;
    for (const Element& element : array.elements) {
        const double range = distance(focus, element.position);
        nearest = std::min(nearest, range);
        farthest = std::max(farthest, range);
    }
    Formation result;
    result.flight_spread_s = (farthest - nearest) / array.medium.speed_m_s;
    result.periods = static_cast<std::uint32_t>(std::ceil(array.carrier_hz * result.flight_spread_s));
    result.formation_s = result.periods / array.carrier_hz +
                         load_clocks(core.parameters, foci) / static_cast<double>(core.parameters.clock_hz);
    const double time_constant = 1.0 / (std::numbers::pi * array.transducer.bandwidth_hz);
    result.ring_up_s = std::log(10.0) * time_constant;
    return result;
}

Formation slowest_formation(const Array& array, const Core& core, std::span<const Vec3> points, std::uint32_t foci) {
    Formation slowest;
    for (const Vec3& point : points) {
        const Formation one = formation(array, core, point, foci);
        slowest.flight_spread_s = std::max(slowest.flight_spread_s, one.flight_spread_s);
        slowest.periods = std::max(slowest.periods, one.periods);
        slowest.formation_s = std::max(slowest.formation_s, one.formation_s);
        slowest.ring_up_s = std::max(slowest.ring_up_s, one.ring_up_s);
    }
    return slowest;
}

std::uint32_t most_points(double rate_hz, double formation_s) {
    return static_cast<std::uint32_t>(std::floor(1.0 / (rate_hz * formation_s)));
}

}  // namespace haptogram
