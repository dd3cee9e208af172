// SPDX-License-Identifier: Apache-2.0
#include "rig_simulation.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <limits>
#include <memory>
#include <random>

#include "haptogram/base/error.hpp"
#include "haptogram/link/transfer.hpp"
#include "playback.hpp"

namespace haptogram::sim {
namespace {

constexpr double most_start_spread_clocks = 2.0;  // contract 11
constexpr std::uint16_t watchdog_ms = 50;         // so that the host looks after its boards often

/// Gathers the pulses of all boards in the time that they share.
class RigRecorder {
public:
    RigRecorder(Tiles& tiles, const RigBundle& bundle) : tiles_(tiles), first_(tiles.size(), -1), begun_(tiles.size()) {
        std::uint32_t element = 0;
        for (std::size_t i = 0; i < tiles.size(); ++i) {
            const auto elements = static_cast<std::uint32_t>(bundle.parts[i].elements);
            tiles.board(i).on_edge([this, i, element](const Edge& edge) { on_edge(i, element + edge.channel, edge); });
            tiles.board(i).on_cycle_start([this, i](const CycleStart& start) {
                begun_[i] = {tiles_.now(), start.index};
                if (i == 0) cycles_.push_back(tiles_.now());
                if (start.index != 0 && first_[i] < 0) first_[i] = tiles_.now();
            });
            element += elements;
        }
        rise_.resize(element);
    }

    /// Between the first cycles of any two tiles that play anything.
    [[nodiscard]] Femtoseconds start_spread() const {
        const auto [least, most] = std::ranges::minmax(first_);
        return least < 0 ? std::numeric_limits<Femtoseconds>::max() : most - least;
    }

    /// All pulses, in clocks of the master's carrier: it has `cycle` of them, however long the crystals make them.
    [[nodiscard]] std::vector<Pulse> pulses(std::uint32_t cycle) const {
        std::vector<Pulse> found;
        found.reserve(pulses_.size());
        for (const Timed& p : pulses_)
            found.push_back({clock(p.rise, cycle), clock(p.fall, cycle), p.channel, p.index});
        return found;
    }

private:
    struct Timed {
        Femtoseconds rise, fall;
        std::uint32_t channel;
        std::uint16_t index;
    };
    struct Begun {  // a pulse, or a cycle
        Femtoseconds at = -1;
        std::uint16_t index = 0;
    };

    void on_edge(std::size_t tile, std::uint32_t channel, const Edge& edge) {
        if (edge.rises) {
            rise_[channel] = {tiles_.now(), edge.index};
            return;
        }
        const auto [rise, at_rise] = rise_[channel];
        const bool amplitudes = tiles_.board(tile).parameters().width_bits != 0;
        pulses_.push_back(
            {rise, tiles_.now(), channel,
             amplitudes ? record_of_pulse(rise, tiles_.now(), at_rise, begun_[tile].at, begun_[tile].index) : at_rise});
    }

    [[nodiscard]] std::uint64_t clock(Femtoseconds at, std::uint32_t cycle) const {
        const auto after = std::upper_bound(cycles_.begin() + 1, cycles_.end() - 1, at);
        const auto begun = std::prev(after);
        const double part = static_cast<double>(at - *begun) / static_cast<double>(*after - *begun);
        return static_cast<std::uint64_t>(
            std::llround((static_cast<double>(begun - cycles_.begin()) + part) * static_cast<double>(cycle)));
    }

    Tiles& tiles_;
    std::vector<Femtoseconds> cycles_;  // of the master
    std::vector<Femtoseconds> first_;
    std::vector<Begun> begun_;  // of each tile, the cycle
    std::vector<Begun> rise_;
    std::vector<Timed> pulses_;
};

void count(Playback& playback, std::uint64_t times, const char* what) {
    if (times == 0) return;
    playback.violation_count += times;
    playback.violations.push_back(fmt::format("the boards count {} {}", times, what));
}

double pass_seconds(const Bundle& whole) {
    std::uint64_t periods = 0;
    for (const SequenceEntry& entry : whole.image.sequence) periods += entry.dwell;
    return static_cast<double>(periods) * whole.manifest.timer.period_s();
}

}  // namespace

std::vector<Oscillator> random_oscillators(std::size_t boards, double drift_ppm, std::uint32_t seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> share(-1.0, 1.0);
    constexpr double metre_s = 5e-9;
    std::vector<Oscillator> found;
    for (std::size_t i = 0; i < boards; ++i)
        found.push_back({.offset_ppm = drift_ppm * share(random),
                         .wander_ppm = 0.0,
                         .phase = 1250.0 * (1.0 + share(random)),
                         .wire_delay_s = i == 0 ? 0.0 : metre_s * (2.0 + share(random)) / 2.0});
    const double sign = share(random) < 0.0 ? -1.0 : 1.0;
    if (boards > 1) found[0].offset_ppm = sign * drift_ppm, found[1].offset_ppm = -sign * drift_ppm;
    return found;
}

std::string_view model_for(const RigBundle& bundle) {
    std::vector<interface::CoreConfiguration> able;
    for (const interface::CoreConfiguration& model : available_models())
        if (model.parameters.sync != 0 && model.parameters.schedule != 0) able.push_back(model);
    std::string_view model;
    for (const Bundle& tile : bundle.tiles) {
        const std::string_view one = model_for(tile.image, tile.name, able);
        if (!model.empty() && one != model)
            throw bad_input(bundle.name, fmt::format("its tiles need the simulated boards {} and {}; rigs are "
                                                     "simulated on boards that are alike",
                                                     model, one));
        model = one;
    }
    return model;
}

RigSimulation simulate(const RigBundle& bundle, const RigSimulationOptions& options) {
    RigSimulation simulation;
    const auto begun = std::chrono::steady_clock::now();
    simulation.oscillators = random_oscillators(bundle.tiles.size(), options.drift_ppm, options.seed);
    SimulatedTiles tiles(model_for(bundle), simulation.oscillators, options.seed);
    std::vector<std::unique_ptr<TileTransport>> lines;
    std::vector<std::unique_ptr<link::Client>> hosts;
    std::vector<link::Tile> rig;
    for (std::size_t i = 0; i < tiles.size(); ++i) {
        lines.push_back(std::make_unique<TileTransport>(tiles, i));
        hosts.push_back(std::make_unique<link::Client>(*lines.back()));
        hosts.back()->identify();
        const Bundle& tile = bundle.tiles[i];
        link::require_fits(tile.image, hosts.back()->identity(), tile.name);
        const double part = 1.0 / static_cast<double>(tiles.size());
        link::upload(*hosts.back(), tile.image,
                     options.progress.in_stage("upload").between(part * static_cast<double>(i),
                                                                 part * static_cast<double>(i + 1)));
        rig.push_back({*hosts.back(), tile.image, fmt::format("tile {}", i + 1)});
    }
    link::keep_together(rig);  // now, so that what is recorded is not reset any more
    RigRecorder recorder(tiles, bundle);
    const double wanted_s = pass_seconds(bundle.whole) * options.passes;
    const Femtoseconds from = tiles.now();
    simulation.played = link::play(
        rig, {.loops = static_cast<std::uint16_t>(options.passes), .watchdog_ms = watchdog_ms},
        [&](const link::RigPlaying&) {
            options.progress(std::min(1.0, 1e-15 * static_cast<double>(tiles.now() - from) / wanted_s), "play");
            return true;
        });
    tiles.run(200 * microsecond);  // to the end of the last pulse
    const Timer& timer = bundle.whole.manifest.timer;
    simulation.start_spread_clocks = static_cast<double>(recorder.start_spread()) * 1e-15 * timer.clock_hz;
    Playback playback;
    playback.pulses = recorder.pulses(timer.cycle_ticks * timer.prescaler);
    count(playback, simulation.played.underruns, "underruns: a record was not loaded in time");
    count(playback, simulation.played.refused_records, "refused records");
    count(playback, simulation.played.watchdog_trips, "watchdog trips");
    count(playback, simulation.played.guard_trips, "output guard trips: a pin was high for too long");
    if (simulation.start_spread_clocks > most_start_spread_clocks) {
        ++playback.violation_count;
        playback.violations.push_back(fmt::format("the tiles' sequences begin {:.3g} clocks apart, more than {:g}",
                                                  simulation.start_spread_clocks, most_start_spread_clocks));
    }
    if (playback.pulses.empty()) {
        ++playback.violation_count;
        playback.violations.emplace_back("no pulse was measured");
    }
    simulation.simulated_s = 1e-15 * static_cast<double>(tiles.now());
    playback.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
    simulation.result = judged(bundle.whole, std::move(playback), options.progress);
    return simulation;
}

}  // namespace haptogram::sim
