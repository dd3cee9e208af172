// SPDX-License-Identifier: Apache-2.0
#include "board_run_tiles.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "haptogram/link/chain.hpp"
#include "interrupt.hpp"
#include "rig_simulation.hpp"
#include "serve_tiles.hpp"

namespace haptogram::cli {
namespace {

/// One line, so that a program can read it while the boards run.
std::unique_ptr<sim::Tiles> make_boards(const RunTilesOptions& options,
                                        const std::vector<sim::Oscillator>& oscillators) {
    if (!options.reference)
        return std::make_unique<sim::SimulatedTiles>(
            sim::tile_model_with_channels(options.channels, sim::available_models()), oscillators, options.seed);
    return std::make_unique<sim::ReferenceTiles>(
        sim::tile_model_with_channels(options.channels, interface::core_configurations), oscillators, options.seed);
}

}  // namespace

void tell_line(const nlohmann::ordered_json& report, bool as_json, const std::string& sentence) {
    fmt::print("{}\n", as_json ? report.dump() : sentence);
    std::fflush(stdout);
}

int run_boards(const RunTilesOptions& options) {
    std::vector<sim::TileFault> faults;
    for (const std::string& fault : options.faults) faults.push_back(sim::parse_fault(fault, options.count));
    const std::vector<sim::Oscillator> oscillators =
        sim::random_oscillators(options.count, options.drift_ppm, options.seed);
    const std::unique_ptr<sim::Tiles> boards = make_boards(options, oscillators);
    sim::Tiles& tiles = *boards;
    if (options.chain) tiles.chain();
    catch_interrupts();
    std::vector<std::unique_ptr<sim::PseudoTerminal>> terminals;
    nlohmann::ordered_json ports = nlohmann::ordered_json::array(), drifts = nlohmann::ordered_json::array();
    const interface::CoreParameters& p = tiles.board(0).parameters();
    for (std::size_t i = 0; i < options.count; ++i) {
        if (!options.chain || i == 0)
            terminals.push_back(std::make_unique<sim::PseudoTerminal>(
                p.baud, options.pty.empty() || options.chain ? options.pty : fmt::format("{}-{}", options.pty, i + 1)));
        const std::string port = terminals.back()->name();
        ports.push_back(options.chain ? link::name_of({port, static_cast<unsigned>(i + 1)}) : port);
        drifts.push_back(oscillators[i].offset_ppm);
    }
    tell_line({{"ports", ports},
               {"model", options.reference ? "reference" : "rtl"},
               {"configuration", tiles.board(0).name()},
               {"channels", p.channels},
               {"clock_hz", p.clock_hz},
               {"baud", p.baud},
               {"crystals_ppm", drifts}},
              options.json, fmt::format("{}", fmt::join(ports.get<std::vector<std::string>>(), "\n")));
    const sim::ServedTiles served = sim::serve(tiles, terminals, {options.real_time, options.seconds}, faults,
                                               [](const sim::ServedTiles&) { return !interrupted(); });
    const double times_real_time = served.wall_s > 0.0 ? served.simulated_s / served.wall_s : 0.0;
    tell_line({{"simulated_s", served.simulated_s},
               {"wall_s", served.wall_s},
               {"times_real_time", times_real_time},
               {"frames_in", served.frames},
               {"frames_applied", served.applied},
               {"enabled", served.enabled}},
              options.json,
              fmt::format("{:.3f} s simulated in {:.1f} s, {:.3f} times real time, {} frames in, {} applied",
                          served.simulated_s, served.wall_s, times_real_time, served.frames, served.applied));
    return 0;
}

}  // namespace haptogram::cli
