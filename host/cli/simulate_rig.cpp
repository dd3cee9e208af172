// SPDX-License-Identifier: Apache-2.0
#include "simulate_rig.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "command.hpp"
#include "haptogram/base/file.hpp"
#include "progress_line.hpp"
#include "report.hpp"
#include "rig_simulation.hpp"

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
        .add("contract_violations", p.violation_count)
        .add("violations", p.violations)
        .add("points", s.records.size())
        .add("points_checked", s.checked)
        .add("points_too_short_to_check", s.unsteady)
        .add("points_off", s.off.size())
        .add("records_off", s.off)
        .add("least_pressure_kept", s.least_kept)
        .add("mean_pressure_kept", s.mean_kept)
        .add("worst_focus_error_mm", s.worst_offset_m / millimetre,
             fmt::format("focus error          {:.4f} mm at most, over {} points", s.worst_offset_m / millimetre,
                         s.checked))
        .tell(fmt::format("pressure kept        {:.4f} % at least, {:.4f} % on average, of a perfect array",
                          100.0 * s.least_kept, 100.0 * s.mean_kept))
        .tell(s.unsteady > 0 ? fmt::format("too short to check   {} points play for fewer than 3 cycles", s.unsteady)
                             : std::string())
        .tell(fmt::format("contract violations  {}", p.violation_count));
    for (const std::string& violation : p.violations) report.tell("  " + violation);
    if (!s.off.empty()) report.tell(words_of_those_off(bundle.whole.manifest, s));
    return report;
}

}  // namespace

std::string words_of_those_off(const Manifest& manifest, const sim::Simulation& s) {
    constexpr std::size_t most_listed = 10;
    const auto shown = static_cast<std::ptrdiff_t>(std::min(s.off.size(), most_listed));
    const auto first = static_cast<std::uint32_t>(s.off.front());
    const FocusLimits& limits = s.records[manifest.place_of(first).value()].limits;
    return fmt::format("{} point{} off: record{} {}{}: less than {:.4g} of the pressure, or more than {:.3g} mm away",
                       s.off.size(), s.off.size() > 1 ? "s are" : " is", s.off.size() > 1 ? "s" : "",
                       fmt::join(s.off.begin(), s.off.begin() + shown, ", "),
                       s.off.size() > most_listed ? fmt::format(" and {} more", s.off.size() - most_listed) : "",
                       limits.least_kept, limits.most_offset_m / millimetre);
}

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
    const Report report = report_of(bundle, simulation);
    std::vector<std::pair<std::filesystem::path, std::string>> files;
    if (!options.pulses.empty()) files.emplace_back(options.pulses, to_csv(simulation.result.playback.pulses));
    if (!options.report.empty()) files.emplace_back(options.report, report.json().dump(1) + "\n");
    write_files(files);
    if (options.json || (options.pulses != "-" && options.report != "-")) report.print(options.json);
    return simulation.result.good() ? 0 : 1;
}

}  // namespace haptogram::cli
