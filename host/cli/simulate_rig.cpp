// SPDX-License-Identifier: Apache-2.0
#include "simulate_rig.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <vector>

#include "command.hpp"
#include "progress_line.hpp"
#include "report.hpp"
#include "rig_simulation.hpp"
#include "simulation_report.hpp"

namespace haptogram::cli {
namespace {

Report report_of(const RigBundle& bundle, const sim::RigSimulation& simulation) {
    const sim::Simulation& s = simulation.result;
    const sim::Playback& p = s.playback;
    std::vector<double> drifts;
    for (const sim::Oscillator& oscillator : simulation.oscillators) drifts.push_back(oscillator.offset_ppm);
    Report report;
    report.add("rig", bundle.rig, fmt::format("rig                  {}, {} tiles", bundle.rig, bundle.tiles.size()))
        .add("tiles", bundle.tiles.size())
        .add("crystals_ppm", drifts, fmt::format("crystals             {:.1f} ppm", fmt::join(drifts, ", ")))
        .add("period", simulation.played.period,
             fmt::format("begun together in    carrier period {}, after {} attempt{}", simulation.played.period,
                         simulation.played.attempts, simulation.played.attempts == 1 ? "" : "s"))
        .add("attempts", simulation.played.attempts)
        .add("start_spread_clocks", simulation.start_spread_clocks,
             fmt::format("start                {:.3f} clocks between the first and the last tile",
                         simulation.start_spread_clocks))
        .add("simulated_s", simulation.simulated_s,
             fmt::format("simulated            {:.1f} ms in {:.1f} s", 1e3 * simulation.simulated_s, p.seconds))
        .add("seconds", p.seconds)
        .add("pulses", p.pulses.size(), fmt::format("pulses measured      {}", p.pulses.size()))
        .add("points", s.records.size());
    add_checks(report, bundle.whole.manifest, s);
    return report;
}

}  // namespace

int simulate_rig(const SimulateRigOptions& options) {
    std::vector<NamedPath> outputs;
    if (!options.pulses.empty()) outputs.push_back({"--pulses", options.pulses});
    if (!options.report.empty()) outputs.push_back({"--report", options.report});
    if (options.json) outputs.push_back({"--json", "-"});
    require_distinct({{"--rig", options.rig}}, outputs);
    const RigBundle bundle = load_rig_bundle(options.rig);
    sim::RigSimulation simulation;
    {
        ProgressLine progress("simulate");
        simulation = sim::simulate(bundle, {options.passes, options.drift_ppm, options.seed, progress.callback()});
    }
    return finish(report_of(bundle, simulation), simulation.result, options.pulses, options.report, options.json);
}

}  // namespace haptogram::cli
