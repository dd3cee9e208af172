// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/calibrate.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>

#include "command.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/picture.hpp"
#include "haptogram/base/shipped.hpp"
#include "haptogram/verbs/compile.hpp"
#include "haptogram/verbs/level.hpp"
#include "haptogram/verbs/source.hpp"
#include "recording.hpp"
#include "report.hpp"

namespace haptogram::cli {
namespace {

struct CalibrateCommand {
    std::optional<std::string> array, board;
    std::vector<std::string> recordings, places;
    double place_error_mm = 2.0;
    std::optional<double> temperature_c, measured_mn;
    std::optional<std::string> microphone, focus, steps;
    std::string output, picture, drive = "full";
    bool json = false;
};

ProjectInstrument instrument_of(const CalibrateCommand& command) {
    Project project;
    project.array = command.array;
    project.board = command.board;
    return haptogram::instrument_of(project);
}

int write_code(const CalibrateCommand& command) {
    const ProjectInstrument instrument = instrument_of(command);
    const Image image = command.steps
                            ? steps_image(instrument.array, instrument.core, parse_point_mm("steps", *command.steps))
                            : calibration_image(instrument.array, instrument.core);
    write_file(command.output, to_intel_hex(image));
    return 0;
}

/// The array as its file describes it: a calibration is made anew.
Array array_of(const CalibrateCommand& command) {
    Array array = instrument_of(command).array;
    for (const Element& element : array.elements)
        if (!element.plain())
            throw bad_argument(
                "array", fmt::format("{} is a calibration already; name the array file that it is of", array.file), {});
    if (command.temperature_c) array.medium.speed_m_s = speed_of_sound(*command.temperature_c);
    return array;
}

/// How a calibration at `output` names its array: as a shipped one, or by the way to its file.
std::string name_beside(const std::string& output, const Array& array) {
    const std::filesystem::path file(array.file);
    if (array.file.starts_with(shipped_prefix)) return file.stem().string();
    return std::filesystem::relative(file, std::filesystem::absolute(output.empty() ? "." : output).parent_path())
        .string();
}

Report report_of(const Calibrated& found, const std::vector<HeardAt>& heard, const std::vector<std::string>& names) {
    Report report;
    nlohmann::ordered_json recordings = nlohmann::ordered_json::array();
    for (std::size_t k = 0; k < heard.size(); ++k) {
        const ElementSounds& sounds = heard[k].heard;
        const Vec3 at = found.places[k];
        double mean = 0.0;
        for (const auto& sound : sounds.sounds) mean += std::norm(sound) / static_cast<double>(sounds.sounds.size());
        const double ratio_db = 10.0 * std::log10(mean / (sounds.noise * sounds.noise));
        recordings.push_back({{"file", names[k]},
                              {"start_s", sounds.start_s},
                              {"passes", sounds.passes},
                              {"clock_ppm", sounds.clock_ppm},
                              {"element_over_noise_db", ratio_db},
                              {"place_mm", {at.x / millimetre, at.y / millimetre, at.z / millimetre}},
                              {"place_error_mm", found.place_errors_m[k] / millimetre}});
        const std::string code =
            sounds.passes == 0 ? "readings"
                               : fmt::format("code from {:.3f} s on, {} pass{}, clock {:+.0f} ppm", sounds.start_s,
                                             sounds.passes, sounds.passes == 1 ? "" : "es", sounds.clock_ppm);
        report.tell(fmt::format(
            "{}: {}, an element {:.0f} dB over the noise; from ({:.1f}, {:.1f}, {:.1f}) ± {:.1f} mm", names[k], code,
            ratio_db, at.x / millimetre, at.y / millimetre, at.z / millimetre, found.place_errors_m[k] / millimetre));
    }
    report.add("recordings", recordings)
        .add("speed_m_s", *found.calibration.speed_m_s,
             fmt::format("speed of sound {:.1f} ± {:.1f} m/s", *found.calibration.speed_m_s, found.speed_error_m_s))
        .add("speed_error_m_s", found.speed_error_m_s)
        .add("residual", *found.calibration.residual,
             fmt::format("the fit leaves {:.1f} % of the elements' sounds", 100.0 * *found.calibration.residual));
    nlohmann::ordered_json faults = nlohmann::ordered_json::array();
    for (const CalibrationFault& fault : found.faults) {
        faults.push_back(
            {{"cause", fault.cause}, {"elements", fault.elements}, {"what", fault.what}, {"advice", fault.advice}});
        report.tell(fmt::format("{}; {}", fault.what, fault.advice));
    }
    report.add("faults", faults, faults.empty() ? "no fault was found" : "");
    if (heard.size() < 4) report.tell("exchanged wires are told from three places on, inputs that float from four");
    report.add("focus_before", found.focus_before)
        .add("focus_after", found.focus_after,
             fmt::format("a focus keeps {:.1f} % of the ideal pressure without this calibration, and about {:.1f} % "
                         "with it",
                         100.0 * found.focus_before, 100.0 * found.focus_after))
        .tell(fmt::format("what the recordings cannot tell: a shift of all foci by some {:.1f} mm",
                          *std::ranges::max_element(found.place_errors_m) / millimetre));
    return report;
}

void draw(const std::string& path, const Array& array, const Calibrated& found) {
    nlohmann::ordered_json json = nlohmann::ordered_json::array();
    for (std::size_t m = 0; m < array.elements.size(); ++m) {
        const MeasuredElement& e = found.calibration.elements[m];
        const Vec3 at = array.elements[m].position;
        json.push_back({{"x_mm", at.x / millimetre},
                        {"y_mm", at.y / millimetre},
                        {"gain", e.gain},
                        {"phase_deg", e.phase_rad * 180.0 / std::numbers::pi},
                        {"reversed", e.reversed},
                        {"dead", e.dead},
                        {"element", m},
                        {"channel", e.channel}});
    }
    Picture picture("shipped:tools/plot_calibration.py");
    picture.add("elements.json", json.dump());
    picture.draw(path, ".toml and --json");
}

/// What a stage read at its places; its zero is at `zero`.
void hear_scan(const Scan& scan, const std::string& file, const Array& array, Vec3 zero, std::vector<HeardAt>& heard) {
    for (const StageReadings& place : scan.places) {
        ElementSounds sounds;
        if (scan.amplitudes) {
            std::vector<double> readings;
            for (const auto& reading : place.readings) readings.push_back(reading.real());
            sounds = from_steps(array, readings, zero, file);
        } else {
            sounds = from_patterns(place.readings, array.elements.size(), file);
        }
        heard.push_back({std::move(sounds), zero + place.off});
    }
}

void hear(const std::string& file, const Array& array, Vec3 place, std::vector<HeardAt>& heard) {
    if (const auto scan = read_scan(file))
        hear_scan(*scan, file, array, place, heard);
    else if (const auto readings = read_steps(file))
        heard.push_back({from_steps(array, *readings, place, file), place});
    else
        heard.push_back({decode(read_recording(file), array.elements.size(), array.carrier_hz), place});
}

int calibrate(const CalibrateCommand& command) {
    if (command.recordings.size() != command.places.size())
        throw bad_argument("at",
                           fmt::format("{} places for {} recordings; give one for each, in their order",
                                       command.places.size(), command.recordings.size()),
                           {});
    std::vector<NamedPath> outputs;
    if (!command.output.empty()) outputs.push_back({"--output", command.output});
    if (!command.picture.empty()) outputs.push_back({"--picture", command.picture});
    std::vector<NamedPath> inputs;
    for (const std::string& file : command.recordings) inputs.push_back({"the recording", file});
    require_distinct(inputs, outputs);
    const Array array = array_of(command);
    CalibrateOptions options;
    options.place_error_m = command.place_error_mm * millimetre;
    if (command.temperature_c) options.speed_error = 1e-3;
    if (command.microphone) options.microphone = find_transducer(*command.microphone);
    std::vector<std::string> names;  // of the files in which they were
    const auto hear_all = [&](const Array& one) {
        std::vector<HeardAt> heard;
        names.clear();
        for (std::size_t k = 0; k < command.recordings.size(); ++k) {
            hear(command.recordings[k], one, parse_point_mm("at", command.places[k]), heard);
            names.resize(heard.size(), command.recordings[k]);
        }
        return heard;
    };
    std::vector<HeardAt> heard;
    Calibrated found;
    try {
        heard = hear_all(array);
        found = haptogram::calibrate(array, heard, options);
    } catch (const Error& error) {
        if (error.code() != ErrorCode::bad_input) throw;
        const auto other = other_array(array, {}, hear_all, options);
        if (!other) throw;
        throw bad_input(error.where(), fmt::format("{}; they are those of the array {}: --array names another one",
                                                   error.message(), *other));
    }
    if (const auto other = other_array(
            array, found.fits, [&](const Array&) { return heard; }, options))
        found.faults.push_back(
            {"array",
             {},
             fmt::format("the sounds come from where {} has its elements, and not {}", *other, array.name),
             fmt::format("--array {}, and a new code for it", *other)});
    found.calibration.array = name_beside(command.output, array);
    found.calibration.date = fmt::format("{:%F}", fmt::gmtime(std::time(nullptr)));
    found.calibration.temperature_c = command.temperature_c;
    found.calibration.drive =
        std::ranges::find(drive_names, command.drive, [](const auto& d) { return std::string(d.second); })->first;
    if (command.measured_mn) {
        const Array real = calibrated(array, found.calibration, array.file);
        const MeasuredLevel level =
            measured_level(real, parse_point_mm("focus", command.focus.value_or("")), *command.measured_mn * 1e-3);
        found.calibration.source_pa_m = level.source_pa_m;
        found.calibration.measured = level.measured;
        if (const auto fault = supply_fault(array.transducer, level)) found.faults.push_back(*fault);
    }
    if (!command.output.empty()) write_file(command.output, to_text(found.calibration));
    if (!command.picture.empty()) draw(command.picture, array, found);
    if (command.output != "-") report_of(found, heard, names).print(command.json);
    return 0;
}

void add_instrument(CLI::App& sub, CalibrateCommand& command) {
    sub.add_option("--array", command.array, "Array file or shipped array (default: the board's, or tile-10x10)");
    sub.add_option("--board", command.board,
                   "Board file, shipped board or configuration (default: what the array's file says)");
}

std::vector<std::string> names_of_drives() {
    std::vector<std::string> names;
    for (const auto& [drive, name] : drive_names) names.emplace_back(name);
    return names;
}

}  // namespace

void add_calibrate(CLI::App& app, Action& action) {
    CLI::App* calibrate_app = app.add_subcommand(
        "calibrate", "What each element of a real array is like, from what a microphone hears of a code");
    calibrate_app->require_subcommand(1);

    auto code = std::make_shared<CalibrateCommand>();
    CLI::App* sub = calibrate_app->add_subcommand("code", "The image that the array plays meanwhile, over and over");
    add_instrument(*sub, *code);
    sub->add_option(
        "--steps", code->steps,
        "For a meter of amplitudes instead, with the microphone at x,y,z (mm): four records an element, for "
        "play --index");
    sub->add_option("-o,--output", code->output, "The image, Intel HEX; - is standard output")->required();
    sub->callback([code, &action] { action = [code] { return write_code(*code); }; });

    auto fit = std::make_shared<CalibrateCommand>();
    sub = calibrate_app->add_subcommand("fit", "The calibration, from recordings of the code");
    sub->add_option("recordings", fit->recordings,
                    "Sound files of one channel, 96 kHz or more (.wav, .flac), an oscilloscope's .csv of time and "
                    "voltage, a .csv index,reading of the records of code --steps, or a scanning stage's .csv "
                    "x_mm,y_mm,z_mm,index,re,im of the code's records, or ,reading of those of code --steps")
        ->required();
    sub->add_option("--at", fit->places,
                    "Where the microphone was, or a stage's zero, x,y,z in mm; once for each recording")
        ->required()
        ->allow_extra_args(false);
    add_instrument(*sub, *fit);
    sub->add_option("--place-error", fit->place_error_mm, "How well these places are known, in each direction, mm")
        ->check(positive())
        ->capture_default_str();
    sub->add_option("--temperature", fit->temperature_c,
                    "Temperature of the air, degrees C (default: the array file's speed of sound, to 0.4 %)")
        ->check(CLI::Range(-50.0, 100.0));
    sub->add_option("--microphone", fit->microphone,
                    "A transducer whose directivity it has, facing the array: shipped, or a file (default: it hears "
                    "all directions alike)");
    auto* focus = sub->add_option("--focus", fit->focus, "Where --measured-mn was measured, x,y,z in mm");
    auto* measured =
        sub->add_option("--measured-mn", fit->measured_mn,
                        "A balance's reading at --focus, on a flat disc of 20 mm, at full steady drive with "
                        "this calibration, mN: it makes the level calibrated");
    measured->check(positive())->needs(focus);
    focus->needs(measured);
    sub->add_option("--drive", fit->drive,
                    "On boards that compute foci: all elements alike, weighed by their gains, or equalised to the "
                    "weakest that is alive")
        ->check(CLI::IsMember(names_of_drives()))
        ->capture_default_str();
    sub->add_option("-o,--output", fit->output,
                    "The calibration, TOML, which --array takes wherever it takes an array; - is standard output");
    sub->add_option("--picture", fit->picture, "The array with gains, phases and faults, .png or .svg");
    sub->add_flag("--json", fit->json, "The report as JSON on standard output");
    sub->callback([fit, &action] { action = [fit] { return calibrate(*fit); }; });
}

}  // namespace haptogram::cli
