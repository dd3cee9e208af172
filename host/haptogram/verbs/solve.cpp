// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/solve.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <nlohmann/json.hpp>
#include <numbers>

#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/picture.hpp"
#include "haptogram/format/schedule.hpp"
#include "haptogram/solve/drives.hpp"
#include "haptogram/solve/segments.hpp"
#include "haptogram/verbs/field.hpp"
#include "haptogram/verbs/level.hpp"
#include "haptogram/verbs/rig.hpp"

namespace haptogram {
namespace {

using nlohmann::ordered_json;

/// Three or four numbers with commas between them; empty when that is not what the text is.
std::vector<double> numbers_in(std::string_view text) {
    std::vector<double> numbers;
    while (true) {
        const std::size_t begin = text.find_first_not_of(" \t");
        if (begin == std::string_view::npos) return {};
        text.remove_prefix(begin);
        double value = 0.0;
        const auto [next, error] = std::from_chars(text.data(), text.data() + text.size(), value);
        if (error != std::errc() || !std::isfinite(value)) return {};
        numbers.push_back(value);
        text.remove_prefix(static_cast<std::size_t>(next - text.data()));
        const std::size_t comma = text.find_first_not_of(" \t");
        if (comma == std::string_view::npos) break;
        if (text[comma] != ',') return {};
        text.remove_prefix(comma + 1);
    }
    return numbers.size() == 3 || numbers.size() == 4 ? numbers : std::vector<double>{};
}

Focus focus_of(const std::vector<double>& numbers) {
    return {from_mm(numbers[0], numbers[1], numbers[2]), numbers.size() == 4 ? numbers[3] : 1.0};
}

/// The drives that a record's pulses make, of whole ticks in length as in place; 1 is the timer's own pulse.
std::vector<std::complex<double>> drives_of(const Record& record, std::size_t elements, const Timer& timer) {
    const double amplitude = std::sin(std::numbers::pi * record.pulse_length / record.cycle_length) /
                             std::sin(std::numbers::pi * timer.duty());
    std::vector<std::complex<double>> drives(elements);
    for (std::size_t m = 0; m < elements; ++m)
        if (record.fires(m))
            drives[m] = std::polar(amplitude, -2.0 * std::numbers::pi * record.timings[m] / record.cycle_length);
    return drives;
}

ordered_json to_json(const Quality& quality) {
    ordered_json json = {{"pressure_pa", quality.pressure_pa},
                         {"spread", quality.spread},
                         {"least_over_mean", quality.least_over_mean},
                         {"efficiency", quality.efficiency}};
    if (quality.null_share) json["null_share"] = *quality.null_share;
    return json;
}

ordered_json to_json(const SolvedStep& step) {
    ordered_json json;
    json["foci"] = ordered_json::array();
    for (const Focus& f : step.foci)
        json["foci"].push_back(
            {{"position_mm", {f.position.x / millimetre, f.position.y / millimetre, f.position.z / millimetre}},
             {"amplitude", f.amplitude}});
    json["drives"] = ordered_json::array();
    for (const auto& drive : step.drives)
        json["drives"].push_back({{"amplitude", std::abs(drive)}, {"phase_rad", std::arg(drive)}});
    json["record"] = {{"cycle_length", step.record.cycle_length},
                      {"prescaler", step.record.prescaler},
                      {"pulse_length", step.record.pulse_length},
                      {"timings", step.record.timings}};
    json["quality"] = {{"exact", to_json(step.exact)}, {"quantised", to_json(step.quantised)}};
    return json;
}

ordered_json to_json(const Solved& solved) {
    ordered_json json = {{"array", solved.array.name},
                         {"board", solved.core.name},
                         {"solver", name_of(solved.options.method)},
                         {"amplitudes", solved.options.amplitudes},
                         {"level", solved.options.level == Level::reachable ? "reachable" : "pressure"},
                         {"source_level", level_json(solved.array.transducer)},
                         {"steps", ordered_json::array()}};
    if (!solved.quantise.empty()) json["quantise"] = solved.quantise;
    for (const SolvedStep& step : solved.steps) json["steps"].push_back(to_json(step));
    return json;
}

/// Pressure in the plane at the foci's mean height, wide enough to show all of them and the array.
Field field_around(const Solved& solved, const SolvedStep& step) {
    double height = 0.0, reach = 0.0;
    for (const Focus& focus : step.foci) {
        height += focus.position.z / static_cast<double>(step.foci.size());
        reach = std::max({reach, std::abs(focus.position.x), std::abs(focus.position.y)});
    }
    Excitation excitation{solved.array, {step.drives}, {1.0}, {}, {}};
    for (auto& drive : excitation.drives.front()) drive *= solved.array.transducer.source_pa_m;
    for (const Focus& focus : step.foci) excitation.foci.push_back(focus.position);
    const double half = std::ceil((reach + 0.02) / 0.01) * 0.01;
    const Reach wide{half, half / 100.0, {}, {}, {}};
    return field(excitation, parse_region("plane", fmt::format("xy@z={:.3f}", height / millimetre), wide),
                 Quantity::rms, 0, {});
}

void draw(const std::string& path, const Solved& solved) {
    Picture picture("shipped:tools/plot_solved.py");
    picture.add("plot_field.py", read_file("shipped:tools/plot_field.py"));
    picture.add("solved.json", to_json_text(solved));
    const Field around = field_around(solved, solved.steps.front());
    picture.add("field.npy", to_npy(around));
    picture.add("about.json", about(around));
    picture.draw(path, ".csv and .json");
}

}  // namespace

std::vector<std::vector<Focus>> foci_from_text(std::string_view text, const std::string& where) {
    std::vector<std::vector<Focus>> steps(1);
    std::size_t number = 0;
    while (!text.empty()) {
        ++number;
        std::string_view line = text.substr(0, text.find('\n'));
        text.remove_prefix(std::min(text.size(), line.size() + 1));
        if (line.ends_with('\r')) line.remove_suffix(1);
        const bool comment = line.find('#') != std::string_view::npos;
        line = line.substr(0, line.find('#'));
        if (line.find_first_not_of(" \t") == std::string_view::npos) {
            if (!comment && !steps.back().empty()) steps.emplace_back();
            continue;
        }
        const std::vector<double> numbers = numbers_in(line);
        if (numbers.empty())
            throw bad_input(fmt::format("{}:{}", where, number),
                            "expected x,y,z or x,y,z,amplitude: millimetres, and 0 to 1");
        steps.back().push_back(focus_of(numbers));
    }
    if (steps.back().empty()) steps.pop_back();
    if (steps.empty()) throw bad_input(where, "there is no focus in it; expected lines x,y,z in mm");
    return steps;
}

Focus parse_focus_mm(const std::string& setting, const std::string& line) {
    const std::vector<double> numbers = numbers_in(line);
    if (numbers.empty())
        throw bad_argument(setting,
                           fmt::format("expected x,y,z or x,y,z,amplitude in mm and 0 to 1, found '{}'", line));
    return focus_of(numbers);
}

Solved solve_steps(const std::vector<std::vector<Focus>>& steps, const Array& array, const Core& core,
                   const SolveOptions& options, bool follow, const Progress& progress, const std::string& device) {
    require_channels(array, core);
    Solved solved{array, core, {}, choose_timer(array, core), options, follow, device, {}};
    std::optional<Segments> segments;
    if (!device.empty()) segments = segments_of(device);
    std::vector<std::complex<double>> last;
    for (std::size_t i = 0; i < steps.size(); ++i) {
        progress(static_cast<double>(i) / static_cast<double>(steps.size()), "solving");
        SolvedStep step;
        step.foci = steps[i];
        try {
            for (std::size_t k = 0; k < step.foci.size(); ++k)
                if (const std::string why = array.unreachable(step.foci[k].position); !why.empty())
                    throw bad_input(fmt::format("focus {}", k + 1), why);
            SolveOptions these = options;
            if (follow && i == 0) these.rounds.reset();
            step.drives = solve(array, step.foci, these, follow ? last : std::vector<std::complex<double>>{});
            step.exact = quality_of(array, step.foci, step.drives, options.level);
            step.record = quantise(step.drives, solved.timer, core.parameters.channels);
            if (segments) step.record = in_segments(step.record, solved.timer, *segments);
            if (step.record.pulse_length == 0)
                throw bad_input("amplitude",
                                "the foci are so weak that their pulse would have no length; make them "
                                "stronger");
            const auto pulses = segments ? in_segments(step.drives, *segments)
                                         : drives_of(step.record, array.elements.size(), solved.timer);
            step.quantised = quality_of(array, step.foci, pulses, options.level);
        } catch (const Error& error) {
            if (steps.size() == 1) throw;
            throw Error(error.code(), fmt::format("set {}", i + 1), error.what(), error.remedies());
        }
        last = step.drives;
        solved.steps.push_back(std::move(step));
    }
    progress(1.0, "solving");
    return solved;
}

namespace {

Path path_of(const Solved& solved, double rate_hz) {
    SolveOptions as_compiled;
    as_compiled.method = solved.options.method;
    if (solved.options != as_compiled || solved.follow)
        throw bad_argument("output",
                           "an image is made by phases alone, for the reachable level, with the solver's own "
                           "number of rounds, and each set by itself; leave those options out");
    const std::vector<std::uint32_t> dwells = even_dwells(solved.timer.carrier_hz(), rate_hz, solved.steps.size(),
                                                          interface::sequence_entry_field::dwell.most());
    Path path;
    for (std::size_t i = 0; i < solved.steps.size(); ++i) path.steps.push_back({solved.steps[i].foci, dwells[i]});
    return path;
}

/// The files of images that play the sets in turn.
std::vector<std::pair<std::filesystem::path, std::string>> image_files(const Solved& solved, double rate_hz,
                                                                       const std::string& name) {
    const Path path = path_of(solved, rate_hz);
    const Method solver = solved.options.method;
    if (!solved.rig.empty())
        return files_of(compile_rig(path, solver, solved.quantise, solved.rig, manifest_path(name)).bundle);
    const Bundle image =
        compile(path, solved.array, solved.core, 0, name, solver, solved.quantise, ImageKind::records).bundle;
    return {{name, image.hex}, {manifest_path(name), to_text(image.manifest)}};
}

}  // namespace

std::string to_json_text(const Solved& solved) { return to_json(solved).dump(1) + "\n"; }

std::string to_csv(const Solved& solved) {
    fmt::memory_buffer text;
    fmt::format_to(std::back_inserter(text), "step,element,amplitude,phase_rad,tick\n");
    for (std::size_t i = 0; i < solved.steps.size(); ++i)
        for (std::size_t m = 0; m < solved.array.elements.size(); ++m) {
            const SolvedStep& step = solved.steps[i];
            fmt::format_to(std::back_inserter(text), "{},{},{:.9g},{:.9g},{}\n", i + 1, m + 1, std::abs(step.drives[m]),
                           std::arg(step.drives[m]), step.record.timings[m]);
        }
    return fmt::to_string(text);
}

void check_solved_path(const std::string& path) {
    const std::string kind = ending_of(path);
    if (path != "-" && kind != ".csv" && kind != ".json" && kind != ".png" && kind != ".hex")
        throw bad_argument("output",
                           fmt::format("'{}' is no ending that is known; .csv, .json, .png and .hex are", kind));
}

void write_solved(const std::string& path, const Solved& solved, double rate_hz) {
    check_solved_path(path);
    const std::string kind = ending_of(path);
    if (kind == ".hex") {
        write_files(image_files(solved, rate_hz, path));
    } else if (kind == ".png")
        draw(path, solved);
    else
        write_file(path, kind == ".json" ? to_json_text(solved) : to_csv(solved));
}

}  // namespace haptogram
