// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "haptogram/base/progress.hpp"
#include "haptogram/format/rig_bundle.hpp"
#include "haptogram/link/rig.hpp"
#include "simulate.hpp"
#include "tiles.hpp"

namespace haptogram::sim {

struct RigSimulationOptions {
    std::uint32_t passes = 1;  ///< over the sequence
    double drift_ppm = 50.0;   ///< crystals differ by up to so much from their nominal frequency, to either side
    std::uint32_t seed = 1;    ///< of drifts, of the phases in which the boards start, and of their power-up
    Progress progress{};
};

/// What a run of a rig's images on as many Verilated boards showed.
struct RigSimulation {
    link::RigPlayed played;
    Simulation result;  ///< of the pulses of all boards, as those of one array; its playback has the pulses, the broken
                        ///< contracts and the times, and nothing else
    double start_spread_clocks = 0.0;  ///< between the tiles' first carrier cycles of the sequence
    double simulated_s = 0.0;
    std::vector<Oscillator> oscillators;
};

/// Crystals that differ by up to `drift_ppm` to either side, with the master's at one end and a slave's at the other,
/// on wires of some metres, at random phases.
[[nodiscard]] std::vector<Oscillator> random_oscillators(std::size_t boards, double drift_ppm, std::uint32_t seed);

/// The Verilated core that every image of a rig can be played on, with SYNC and schedule.
/// @throws Error{bad_input} when there is none
[[nodiscard]] std::string_view model_for(const RigBundle& bundle);

/// Runs a Verilated board for each tile, each with a clock of its own; uploads the tiles' images over their serial
/// lines, plays them in step from an agreed period on, as link::play() does with real boards, and checks at all pins
/// together what the rig's whole image asks for: the focus of every record, and that all tiles began in one period.
[[nodiscard]] RigSimulation simulate(const RigBundle& bundle, const RigSimulationOptions& options);

}  // namespace haptogram::sim
