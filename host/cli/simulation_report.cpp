// SPDX-License-Identifier: Apache-2.0
#include "simulation_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <utility>
#include <vector>

#include "haptogram/array/millimetres.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/format/pulses.hpp"

namespace haptogram::cli {
namespace {

/// The points that missed their target.
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

}  // namespace

void add_checks(Report& report, const Manifest& manifest, const sim::Simulation& s) {
    const sim::Playback& p = s.playback;
    report.add("contract_violations", p.violation_count)
        .add("violations", p.violations)
        .add("points_checked", s.checked)
        .add("points_too_short_to_check", s.unsteady)
        .add("points_off", s.off.size())
        .add("records_off", s.off)
        .add("least_pressure_kept", s.least_kept)
        .add("mean_pressure_kept", s.mean_kept)
        .add("worst_focus_error_mm", s.worst_offset_m / millimetre,
             fmt::format("focus error          {:.4f} mm at most, over {} points", s.worst_offset_m / millimetre,
                         s.checked))
        .tell(fmt::format("pressure kept        {:.4f} % at least, {:.4f} % on average", 100.0 * s.least_kept,
                          100.0 * s.mean_kept));
    if (!manifest.quantise.empty())
        report.tell(fmt::format("expected             {:.2f} % with the phases of {}; at least {:.2f} % is a pass",
                                100.0 * s.records.front().limits.expected_kept, manifest.quantise,
                                100.0 * s.records.front().limits.least_kept));
    if (s.unsteady > 0)
        report.tell(fmt::format("too short to check   {} points play for fewer than 3 cycles", s.unsteady));
    report.tell(fmt::format("contract violations  {}", p.violation_count));
    for (const std::string& violation : p.violations) report.tell("  " + violation);
    if (!s.off.empty()) report.tell(words_of_those_off(manifest, s));
}

int finish(const Report& report, const sim::Simulation& simulation, const std::string& pulses, const std::string& file,
           bool json) {
    std::vector<std::pair<std::filesystem::path, std::string>> files;
    if (!pulses.empty()) files.emplace_back(pulses, to_csv(simulation.playback.pulses));
    if (!file.empty()) files.emplace_back(file, report.json().dump(1) + "\n");
    write_files(files);
    if (json || (pulses != "-" && file != "-")) report.print(json);
    return simulation.good() ? 0 : 1;
}

}  // namespace haptogram::cli
