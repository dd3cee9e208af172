// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>

#include "command.hpp"
#include "haptogram/analysis/focus_check.hpp"
#include "haptogram/analysis/measure.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "playback.hpp"
#include "progress_line.hpp"

namespace haptogram::cli {
namespace {

struct SimulateOptions {
    std::string image;
    std::string manifest;
    std::string array;
    std::uint32_t passes = 1;
    double duration_ms = 0.0;
    std::string load = "uart";
    std::string pulses;
    std::string trace;
    std::string report;
    bool json = false;
};

/// What the pulses of one record make at its focal point.
struct PointResult {
    std::uint64_t cycles = 0;
    FocusCheck check;
    bool steady = false;  ///< played long enough that its own pulses could be told from its neighbours'
};

/// What a focus must keep to be called on target (the project's targets).
constexpr double least_pressure_kept = 0.999;
constexpr double most_peak_offset_m = 0.2e-3;

/// Channels, clock, carrier, duty, medium, transducer, and every element's place to a micrometre.
bool same_array(const Array& a, const Array& b) {
    const auto near = [](double p, double q) { return std::abs(p - q) <= 1e-6 * std::abs(q); };
    return near(a.medium.speed_m_s, b.medium.speed_m_s) && near(a.duty, b.duty) &&
           near(a.transducer.radius_m, b.transducer.radius_m) && a.board.channels == b.board.channels &&
           a.board.clock_hz == b.board.clock_hz && a.carrier_hz == b.carrier_hz &&
           std::equal(a.elements.begin(), a.elements.end(), b.elements.begin(), b.elements.end(),
                      [](Vec3 p, Vec3 q) { return distance(p, q) < 1e-6; });
}

/// The manifest must speak of these records, or every number that follows would be about something else.
void require_consistent(const Manifest& manifest, const Image& image, const std::string& where) {
    const auto require = [&](bool agrees, const std::string& what) {
        if (!agrees) throw bad_input(where, what + "; compile the two together");
    };
    require(manifest.foci.size() == image.records.size(),
            fmt::format("{} records, but the image has {}", manifest.foci.size(), image.records.size()));
    require(manifest.array.board.channels == image.channels,
            fmt::format("{} channels, but the image has {}", manifest.array.board.channels, image.channels));
    require(manifest.array.board.clock_hz == image.clock_hz,
            fmt::format("a clock of {} Hz, but the image is for {} Hz", manifest.array.board.clock_hz, image.clock_hz));
    std::vector<std::uint32_t> cycles(image.records.size());
    for (const SequenceEntry& entry : image.sequence)
        if (entry.index > 0) cycles[entry.index - 1U] += entry.dwell;
    const Timer& t = manifest.timer;
    for (std::size_t i = 0; i < image.records.size(); ++i) {
        const Record& r = image.records[i];
        if (r.cycle_length != t.cycle_ticks || r.prescaler != t.prescaler || r.pulse_length != t.pulse_ticks)
            require(false,
                    fmt::format("timer {} × {} ticks, pulse {}, but record {} of the image has {} × {}, pulse {}",
                                t.prescaler, t.cycle_ticks, t.pulse_ticks, i + 1, r.prescaler, r.cycle_length,
                                r.pulse_length));
        if (manifest.dwell_cycles[i] != cycles[i])
            require(false, fmt::format("record {} is to last {} cycles, but the image's sequence gives it {}", i + 1,
                                       manifest.dwell_cycles[i], cycles[i]));
        for (std::size_t k = manifest.array.elements.size(); k < r.timings.size(); ++k)
            if (r.timings[k] < r.cycle_length)
                require(false, fmt::format("{} elements, but record {} of the image fires channel {}",
                                           manifest.array.elements.size(), i + 1, k));
    }
}

Manifest matching_manifest(const SimulateOptions& options, const std::string& hex, const Image& image) {
    Manifest manifest = manifest_from_json(read_file(options.manifest), options.manifest);
    if (manifest.image_sha256 != sha256(hex))
        throw bad_input(
            options.manifest,
            fmt::format("it belongs to another image than {} (hash {}…, expected {}…); compile the two together",
                        options.image, sha256(hex).substr(0, 12), manifest.image_sha256.substr(0, 12)));
    require_consistent(manifest, image, options.manifest);
    if (!options.array.empty()) {
        const Array array = find_array(options.array);
        if (!same_array(array, manifest.array))
            throw bad_input(options.image,
                            fmt::format("it was compiled for {} ({} elements, {} channels, {} Hz), not for {} ({} "
                                        "elements, {} channels, {} Hz); "
                                        "compile it with --array {}",
                                        manifest.array.name, manifest.array.elements.size(), image.channels,
                                        image.clock_hz, array.name, array.elements.size(), array.board.channels,
                                        array.board.clock_hz, options.array));
    }
    return manifest;
}

std::vector<PointResult> check_points(const Manifest& manifest, const std::vector<Pulse>& pulses,
                                      const std::string& where) {
    const auto measured = measure(manifest, pulses, where);
    std::vector<PointResult> results;
    ProgressLine progress("focus check");
    for (std::size_t i = 0; i < measured.size(); ++i) {
        PointResult result;
        result.cycles = measured[i].cycles;
        result.steady = manifest.dwell_cycles[i] >= 3;
        if (result.cycles > 0) {
            // At the duty that the timer really makes, the ideal has the same pulses with exact phases.
            Array array = manifest.array;
            array.duty = manifest.timer.duty();
            result.check = check_focus(array, measured[i].drives, manifest.foci[i]);
        }
        results.push_back(result);
        progress.update(static_cast<double>(i + 1) / static_cast<double>(measured.size()));
    }
    return results;
}

struct Summary {
    std::size_t checked = 0, unsteady = 0;
    std::vector<std::size_t> off;  ///< records
    double least_kept = 1.0, mean_kept = 0.0, worst_offset_m = 0.0;
};

Summary summarise(const std::vector<PointResult>& points) {
    Summary s;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const PointResult& p = points[i];
        if (p.cycles == 0) continue;
        if (!p.steady) {
            ++s.unsteady;
            continue;
        }
        ++s.checked;
        s.least_kept = std::min(s.least_kept, p.check.pressure_kept);
        s.mean_kept += p.check.pressure_kept;
        s.worst_offset_m = std::max(s.worst_offset_m, p.check.peak_offset_m);
        if (p.check.pressure_kept < least_pressure_kept || p.check.peak_offset_m > most_peak_offset_m)
            s.off.push_back(i + 1);
    }
    if (s.checked > 0) s.mean_kept /= static_cast<double>(s.checked);
    return s;
}

nlohmann::ordered_json to_json(const Manifest& manifest, const sim::Playback& p, const std::vector<PointResult>& points,
                               const Summary& s, std::size_t hex_bytes) {
    nlohmann::ordered_json json = {
        {"points", points.size()},
        {"image_bytes", hex_bytes},
        {"timer",
         {{"prescaler", manifest.timer.prescaler},
          {"cycle_ticks", manifest.timer.cycle_ticks},
          {"pulse_ticks", manifest.timer.pulse_ticks}}},
        {"clocks", p.clocks},
        {"simulated_s", static_cast<double>(p.clocks) / manifest.timer.clock_hz},
        {"mclk_per_s", static_cast<double>(p.clocks) / p.seconds / 1e6},
        {"playing_mclk_per_s", static_cast<double>(p.playing_clocks) / p.playing_seconds / 1e6},
        {"playing_real_time_ratio",
         static_cast<double>(p.playing_clocks) / p.playing_seconds / manifest.timer.clock_hz},
        {"pulses", p.pulses.size()},
        {"pulses_equal_to_image", p.pulse_report.checked},
        {"contract_violations", p.violation_count},
        {"violations", p.violations},
        {"points_checked", s.checked},
        {"points_too_short_to_check", s.unsteady},
        {"points_off", s.off.size()},
        {"records_off", s.off},
        {"least_pressure_kept", s.least_kept},
        {"mean_pressure_kept", s.mean_kept},
        {"worst_focus_error_mm", s.worst_offset_m / millimetre},
        {"board",
         {{"underruns", p.status.underruns},
          {"refused_records", p.status.refused_records},
          {"frames_damaged", p.status.frames_damaged},
          {"frames_repeated", p.status.frames_repeated},
          {"watchdog_trips", p.status.watchdog_trips},
          {"guard_trips", p.status.guard_trips}}}};
    json["records"] = nlohmann::ordered_json::array();
    for (std::size_t i = 0; i < points.size(); ++i)
        json["records"].push_back({{"index", i + 1},
                                   {"cycles", points[i].cycles},
                                   {"pressure_pa", points[i].check.pressure_pa},
                                   {"pressure_kept", points[i].check.pressure_kept},
                                   {"focus_error_mm", points[i].check.peak_offset_m / millimetre}});
    return json;
}

void print(const Manifest& manifest, const sim::Playback& p, const Summary& s, std::size_t points,
           std::size_t hex_bytes) {
    const Timer& t = manifest.timer;
    fmt::print("points               {}\n", points);
    fmt::print("image size           {} bytes\n", hex_bytes);
    fmt::print("timer                prescaler {}, cycle {} ticks, pulse {} ticks\n", t.prescaler, t.cycle_ticks,
               t.pulse_ticks);
    fmt::print("clocks simulated     {} ({:.1f} ms)\n", p.clocks, static_cast<double>(p.clocks) / t.clock_hz * 1e3);
    fmt::print("speed                {:.2f} Mclk/s, {:.2f} while playing ({:.3f} of real time)\n",
               static_cast<double>(p.clocks) / p.seconds / 1e6,
               static_cast<double>(p.playing_clocks) / p.playing_seconds / 1e6,
               static_cast<double>(p.playing_clocks) / p.playing_seconds / t.clock_hz);
    fmt::print("pulses measured      {}, {} compared and equal to the image\n", p.pulses.size(),
               p.pulse_report.checked);
    fmt::print("focus error          {:.4f} mm at most, over {} points\n", s.worst_offset_m / millimetre, s.checked);
    fmt::print("pressure kept        {:.4f} % at least, {:.4f} % on average\n", 100.0 * s.least_kept,
               100.0 * s.mean_kept);
    if (s.unsteady > 0) fmt::print("too short to check   {} points play for fewer than 3 cycles\n", s.unsteady);
    fmt::print("contract violations  {}\n", p.violation_count);
    for (const std::string& violation : p.violations) fmt::print("  {}\n", violation);
    if (s.off.empty()) return;
    constexpr std::size_t most_listed = 10;
    const auto shown = static_cast<std::ptrdiff_t>(std::min(s.off.size(), most_listed));
    fmt::print("{} point{} off: record{} {}{}: less than {} of the pressure, or more than {} mm away\n", s.off.size(),
               s.off.size() > 1 ? "s are" : " is", s.off.size() > 1 ? "s" : "",
               fmt::join(s.off.begin(), s.off.begin() + shown, ", "),
               s.off.size() > most_listed ? fmt::format(" and {} more", s.off.size() - most_listed) : "",
               least_pressure_kept, most_peak_offset_m / millimetre);
}

/// Verilator's trace writer does not say when the disk is full. An FST file is a chain of blocks, each a type and its
/// length; the chain must end where the file does.
void require_whole_trace(const std::filesystem::path& file, const std::string& name) {
    const std::string content = read_file(file);
    std::uint64_t at = 0;
    while (at + 9 <= content.size()) {
        std::uint64_t length = 0;
        for (std::size_t i = 1; i <= 8; ++i) length = length << 8 | static_cast<unsigned char>(content[at + i]);
        if (length < 8 || length > content.size()) break;
        at += 1 + length;
    }
    if (content.empty() || at != content.size())
        throw bad_input(name, "cannot be written whole; make room, nothing was left behind");
}

int simulate(SimulateOptions options) {
    if (options.manifest.empty()) options.manifest = manifest_path(options.image);
    std::vector<NamedPath> outputs;
    if (!options.pulses.empty()) outputs.push_back({"--pulses", options.pulses});
    if (!options.report.empty()) outputs.push_back({"--report", options.report});
    if (options.json) outputs.push_back({"--json", "-"});
    if (!options.trace.empty()) outputs.push_back({"--trace", options.trace});
    require_distinct({{"the image", options.image}, {"the manifest", options.manifest}, {"--array", options.array}},
                     outputs);
    const std::string hex = read_file(options.image);
    const Image image = from_intel_hex(hex, options.image);
    const std::vector<std::string> found = problems(image);
    if (!found.empty())
        throw bad_input(
            options.image,
            fmt::format("{}{}", found.front(),
                        found.size() > 1 ? fmt::format(" (and {} more; see inspect)", found.size() - 1) : ""));
    const Manifest manifest = matching_manifest(options, hex, image);

    sim::PlaybackOptions how;
    how.load_by_uart = options.load == "uart";
    how.passes = options.passes;
    if (options.duration_ms > 0.0) how.duration_s = options.duration_ms * 1e-3;
    std::optional<StagedFile> trace;
    if (!options.trace.empty()) {
        trace.emplace(options.trace);
        how.trace = trace->beside();
        if (how.trace.empty())
            throw Error(options.trace == "-" ? ErrorCode::bad_argument : ErrorCode::bad_input, options.trace,
                        "a trace needs a file of its own; name one that is no device or pipe");
    }
    ProgressLine progress("simulate");
    how.progress = progress.callback();
    const sim::Playback playback = sim::play(image, how, options.image);
    const std::vector<PointResult> points = check_points(manifest, playback.pulses, options.image);
    const Summary summary = summarise(points);

    const auto json = to_json(manifest, playback, points, summary, hex.size());
    std::vector<std::pair<std::filesystem::path, std::string>> files;
    if (!options.pulses.empty()) files.emplace_back(options.pulses, to_csv(playback.pulses));
    if (!options.report.empty()) files.emplace_back(options.report, json.dump(1) + "\n");
    write_files(files);
    if (trace) {
        require_whole_trace(trace->beside(), options.trace);
        trace->commit();
    }
    if (options.json)
        fmt::print("{}\n", json.dump(1));
    else if (options.pulses != "-" && options.report != "-")
        print(manifest, playback, summary, points.size(), hex.size());
    return playback.violation_count == 0 && summary.off.empty() ? 0 : 1;
}

}  // namespace

void add_simulate(CLI::App& app, Action& action) {
    auto options = std::make_shared<SimulateOptions>();
    CLI::App* sub = app.add_subcommand(
        "simulate",
        "Play an image on the Verilated FPGA, measure its pins, check contracts and foci; exit code 1 when one is off");
    sub->add_option("image", options->image, "Intel HEX image")->required();
    sub->add_option("--manifest", options->manifest, "Manifest (default: the image's name with .json)");
    sub->add_option("--array", options->array, "Insist that the image was compiled for this array");
    auto* passes = sub->add_option("--passes", options->passes, "Passes over the sequence")
                       ->check(whole(1, 65535))
                       ->capture_default_str();
    sub->add_option("--duration", options->duration_ms, "Play for this many ms instead")
        ->check(positive())
        ->excludes(passes);
    sub->add_option("--load", options->load, "Through the simulated serial line, or straight into the memories")
        ->check(CLI::IsMember({"uart", "direct"}))
        ->capture_default_str();
    sub->add_option("--pulses", options->pulses, "Write the measured pulses (CSV)");
    sub->add_option("--trace", options->trace, "Write every signal (FST, for GTKWave)");
    sub->add_option("--report", options->report, "Write the report (JSON)");
    sub->add_flag("--json", options->json, "Print the report as JSON");
    sub->callback([options, &action] { action = [options] { return simulate(*options); }; });
}

}  // namespace haptogram::cli
