// SPDX-License-Identifier: Apache-2.0
// What the Verilated core does at its pins with a scene's image: `haptogram simulate` in a process of its own.
#pragma once
#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

#include "haptogram/base/progress.hpp"
#include "haptogram/format/pulses.hpp"
#include "scenes.hpp"

namespace haptogram::studio {

struct Pins {
    nlohmann::ordered_json report;  ///< as `haptogram simulate --report` writes it, without its table of records
    std::vector<Pulse> pulses;      ///< in the order in which they rise
    std::uint32_t clock_hz = 0;
    double carrier_hz = 0.0;
};

inline constexpr std::uint32_t most_pulse_periods = 40;

/// Plays one pass, loaded straight into the memories, and waits for its end.
/// @throws Error{cancelled} soon after `progress` says so, Error{failed} with the simulation's own words when there is
/// no Verilated core for the image, or none was built
[[nodiscard]] Pins simulate_pins(const Scene& scene, const Progress& progress);

/// The pulses that rise within `periods` carrier periods from the first pulse of a record on: {"index", "clock_hz",
/// "from_clk", "to_clk", "pulses": [[channel, rise_clk, fall_clk, index], …]}.
/// @throws Error{bad_argument} for a record that had no pulse, or for no periods or more than most_pulse_periods
[[nodiscard]] nlohmann::ordered_json pulses_json(const Pins& pins, std::uint32_t index, std::uint32_t periods);

}  // namespace haptogram::studio
