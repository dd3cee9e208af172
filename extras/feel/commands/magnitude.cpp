// SPDX-License-Identifier: Apache-2.0
#include "haptogram/perception/magnitude.hpp"

#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/verbs/level.hpp"
#include "haptogram/verbs/source.hpp"
#include "report.hpp"

namespace haptogram::cli {
namespace {

using namespace perception;

struct MagnitudeOptions {
    std::string tables = "multimodal", array, focus = "0,0,200";
    std::string region = "palm", waveform = "square", weighing = "fundamental";
    double magnitude = 0.0, command = 0.0;
    double frequency_hz = 200.0, grip_n = 1.0, duty = 0.5;
    bool json = false;
};

/// What can be felt at the frequency at all.
int print_range(const MagnitudeOptions& options, const Tables& tables) {
    const FrequencyFit fit = fit_at(tables, options.frequency_hz);
    const perception::Region region = perception::region_of(options.region);
    const Interval interval = threshold_interval(tables, region, options.grip_n);
    const double least = least_felt_gf(tables, region, options.frequency_hz, options.grip_n);
    const double full = full_output_gf(fit);
    Report report;
    report.add("tables", tables.name, fmt::format("{}: {}", tables.name, tables.source));
    report.add("frequency_hz", options.frequency_hz);
    report.add("region", options.region).add("grip_n", options.grip_n);
    report.add("threshold_interval_gf", {interval.low_gf, interval.high_gf});
    report.add(
        "least_felt_gf", least,
        fmt::format("least felt by a {} at {:g} Hz and a grip of {:g} N: {:.4f} gf = {:.3f} mN ({:.4f}…{:.4f} gf "
                    "over all frequencies)",
                    options.region, options.frequency_hz, options.grip_n, least, least * gram_force_n * 1e3,
                    interval.low_gf, interval.high_gf));
    report.add("full_output_gf", full,
               fmt::format("output at full command: {:.4f} gf = {:.3f} mN", full, full * gram_force_n * 1e3));
    if (region == perception::Region::palm) {
        const double low = magnitude_of_output(fit, least), high = magnitude_of_output(fit, full);
        report.add("magnitudes", {low, high},
                   fmt::format("perceived magnitudes: {:.3f}…{:.3f}, commands {:.4f}…1", low, high,
                               command_of_output(fit, least)));
    }
    report.print(options.json);
    return 0;
}

/// What a command of the measured device makes.
int print_command(const MagnitudeOptions& options, const Tables& tables) {
    const FrequencyFit fit = fit_at(tables, options.frequency_hz);
    const double output = output_of_command(fit, options.command);
    const double least =
        least_felt_gf(tables, perception::region_of(options.region), options.frequency_hz, options.grip_n);
    Report report;
    report.add("command", options.command).add("frequency_hz", options.frequency_hz);
    report.add("output_gf", output, fmt::format("output {:.4f} gf", output));
    report.add("felt", output >= least,
               fmt::format("{} by a {}: the least felt is {:.4f} gf", output >= least ? "felt" : "not felt",
                           options.region, least));
    if (perception::region_of(options.region) == perception::Region::palm) {
        const double magnitude = magnitude_of_output(fit, output);
        report.add("magnitude", magnitude, fmt::format("perceived magnitude {:.4f}", magnitude));
    }
    report.print(options.json);
    return 0;
}

int print_setting(const MagnitudeOptions& options, const Tables& tables) {
    const Wanted wanted{options.magnitude,
                        options.frequency_hz,
                        perception::region_of(options.region),
                        options.grip_n,
                        waveform_of(options.waveform),
                        options.duty,
                        weighing_of(options.weighing)};
    const perception::Setting setting = options.array.empty() ? setting_for(tables, wanted)
                                                              : setting_for(tables, wanted, find_array(options.array),
                                                                            parse_point_mm("focus", options.focus));
    Report report;
    report.add("tables", tables.name, fmt::format("{}: {}", tables.name, tables.source));
    report.add("device", options.array.empty() ? tables.name : options.array);
    report.add("magnitude", options.magnitude).add("frequency_hz", options.frequency_hz);
    report.add("output_gf", setting.output_gf,
               fmt::format("magnitude {:g} at {:g} Hz is an output of {:.4f} gf; the least felt is {:.4f} gf",
                           options.magnitude, options.frequency_hz, setting.output_gf, setting.least_felt_gf));
    report.add("least_felt_gf", setting.least_felt_gf);
    report.add("waveform_factor", setting.waveform_factor).add("duty_factor", setting.duty_factor);
    report.add("needed_gf", setting.needed_gf,
               fmt::format("with the waveform {} ({:.3f} of the square wave's) it takes {:.4f} gf of {:.4f} gf",
                           options.waveform, setting.waveform_factor / setting.duty_factor, setting.needed_gf,
                           setting.full_gf));
    report.add("full_gf", setting.full_gf);
    report.add("command", setting.command,
               fmt::format("command {:.4f}: pulses of {:.2f} % of the carrier period", setting.command,
                           100.0 * setting.pulse_duty));
    report.add("pulse_duty", setting.pulse_duty);
    if (!options.array.empty()) {
        const Transducer transducer = find_array(options.array).transducer;
        report.add("level", level_json(transducer), level_text(transducer));
    }
    report.print(options.json);
    return 0;
}

}  // namespace

void add_magnitude(CLI::App& app, Action& action) {
    auto options = std::make_shared<MagnitudeOptions>();
    CLI::App* sub = app.add_subcommand(
        "magnitude",
        "How strong a focus feels: the command and the pulse for a perceived magnitude, or what can be felt");
    auto* magnitude =
        sub->add_option("magnitude", options->magnitude,
                        "Perceived magnitude that is wanted; without it, what can be felt at the frequency")
            ->check(positive());
    auto* command =
        sub->add_option("--command", options->command, "What this command of the measured device makes, instead")
            ->excludes(magnitude)
            ->check(not_negative());
    sub->add_option("--frequency", options->frequency_hz, "Frequency of the modulation, Hz")
        ->check(positive())
        ->capture_default_str();
    sub->add_option("--region", options->region, "palm or finger; magnitudes are known for the palm only")
        ->check(CLI::IsMember({"palm", "finger"}))
        ->capture_default_str();
    sub->add_option("--grip", options->grip_n, "Grip force of the hand, N; 1 N for a bare hand")
        ->check(positive())
        ->capture_default_str();
    std::vector<std::string> waveforms;
    for (const Waveform waveform : all_waveforms()) waveforms.push_back(name_of(waveform));
    sub->add_option("--waveform", options->waveform, "Waveform of the modulation")
        ->needs(magnitude)
        ->check(CLI::IsMember(waveforms))
        ->capture_default_str();
    sub->add_option("--duty", options->duty, "Duty of the square wave, 0 to 1")
        ->needs(magnitude)
        ->check(positive())
        ->capture_default_str();
    sub->add_option("--weighing", options->weighing,
                    "Compare waveforms by their fundamental, which skin feels, or their mean, which a balance shows")
        ->needs(magnitude)
        ->check(CLI::IsMember({"fundamental", "mean"}))
        ->capture_default_str();
    auto* array = sub->add_option("--array", options->array,
                                  "The command for this array, from physics, instead of the measured device")
                      ->needs(magnitude);
    sub->add_option("--focus", options->focus, "Focus of the array: x,y,z (mm)")->needs(array)->capture_default_str();
    sub->add_option("--tables", options->tables, "Shipped perception file, or a file")->capture_default_str();
    sub->add_flag("--json", options->json, "Print as JSON");
    sub->callback([options, magnitude, command, &action] {
        action = [options, magnitude, command] {
            const Tables tables = find_tables(options->tables);
            if (!magnitude->empty()) return print_setting(*options, tables);
            return command->empty() ? print_range(*options, tables) : print_command(*options, tables);
        };
    });
}

}  // namespace haptogram::cli
