// SPDX-License-Identifier: Apache-2.0
#include "haptogram/calibration/calibrate.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <charconv>
#include <cmath>
#include <ctime>
#include <exception>
#include <filesystem>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <thread>

#include "command.hpp"
#include "extras.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/picture.hpp"
#include "haptogram/base/process.hpp"
#include "haptogram/base/shipped.hpp"
#include "haptogram/calibration/files.hpp"
#include "haptogram/link/device.hpp"
#include "haptogram/link/play.hpp"
#include "haptogram/link/transfer.hpp"
#include "haptogram/verbs/compile.hpp"
#include "haptogram/verbs/level.hpp"
#include "haptogram/verbs/source.hpp"
#include "interrupt.hpp"
#include "level_options.hpp"
#include "port.hpp"
#include "report.hpp"

namespace haptogram::cli {

void add_calibrate(CLI::App& app, Action& action);
namespace {

struct CalibrateCommand {
    std::optional<std::string> array, board;
    std::vector<std::string> recordings, places;
    double place_error_mm = 2.0;
    std::optional<double> temperature_c;
    std::optional<std::string> microphone, focus, steps;
    std::optional<std::string> part;
    LevelOptions level;
    std::string output, picture, drive = "full";
    bool json = false;
};

ProjectInstrument instrument_of(const CalibrateCommand& command) {
    Project project;
    project.array = command.array;
    project.board = command.board;
    return haptogram::instrument_of(project);
}

CodePart part_of(const std::string& text) {
    CodePart part;
    const char* const end = text.data() + text.size();
    const auto number = std::from_chars(text.data(), end, part.number);
    const bool divided = number.ec == std::errc() && number.ptr != end && *number.ptr == '/';
    const auto of = std::from_chars(divided ? number.ptr + 1 : end, end, part.of);
    if (!divided || of.ec != std::errc() || of.ptr != end || part.number < 1 || part.number > part.of)
        throw bad_argument("part", fmt::format("expected a part and how many there are, such as 1/3, found '{}'", text),
                           {});
    return part;
}

int write_code(const CalibrateCommand& command) {
    const ProjectInstrument instrument = instrument_of(command);
    const CodePart part = command.part ? part_of(*command.part) : CodePart{};
    const Image image =
        command.steps ? steps_image(instrument.array, instrument.core, parse_point_mm("steps", *command.steps), part)
                      : calibration_image(instrument.array, instrument.core, part);
    write_file(command.output, to_intel_hex(image));
    return 0;
}

struct RecordCommand {
    std::optional<std::string> array, board;
    link::PortSettings port;
    std::string output, card = "default";
    unsigned rate_hz = 192000;
};

/// A recording's name, or that of one of its parts.
std::string part_name(const std::string& output, CodePart part) {
    if (part.of == 1) return output;
    const std::filesystem::path path(output);
    return (path.parent_path() / fmt::format("{}-{}{}", path.stem().string(), part.number, path.extension().string()))
        .string();
}

/// Plays the image, and lets ALSA's program record meanwhile.
void record_part(const RecordCommand& command, link::Device& device, const Image& image, const std::string& file) {
    double seconds = 0.5;  // two passes, and for the outputs to come on
    for (const SequenceEntry& entry : image.sequence) {
        const Record& record = image.records[entry.index - 1U];
        seconds += 2.0 * entry.dwell * record.cycle_length * record.prescaler / image.clock_hz;
    }
    StagedFile staged(file);
    const std::string target = staged.beside().empty() ? file : staged.beside().string();
    ProcessResult recorded;
    std::exception_ptr failed;
    std::atomic<bool> ended = false;
    std::thread recorder;
    const auto record = [&] {
        try {
            recorded = run_process(std::filesystem::current_path(),
                                   {"arecord", "--quiet", "--device=" + command.card, "--format=S32_LE",
                                    fmt::format("--rate={}", command.rate_hz), "--channels=1", "--file-type=wav",
                                    fmt::format("--duration={}", static_cast<unsigned>(std::ceil(seconds))), target});
        } catch (...) {
            failed = std::current_exception();
        }
        ended = true;
    };
    link::PlaySettings settings;
    settings.loops = 0;
    settings.warn = complain;
    try {
        link::play(device, settings, [&](const link::Playing&) {
            if (!recorder.joinable()) recorder = std::thread(record);
            return !ended && !interrupted();
        });
    } catch (...) {
        if (recorder.joinable()) recorder.join();
        throw;
    }
    if (recorder.joinable()) recorder.join();
    if (interrupted()) throw Error(ErrorCode::cancelled, file, "nothing was recorded, because a signal asked to end");
    if (failed) std::rethrow_exception(failed);
    if (!recorded.succeeded)
        throw Error(ErrorCode::failed, "arecord",
                    fmt::format("it recorded nothing: {}; arecord --list-devices has names for --card", recorded.said));
    staged.commit();
}

int record(const RecordCommand& command) {
    catch_interrupts();
    Project project;
    project.array = command.array;
    project.board = command.board;
    const ProjectInstrument instrument = haptogram::instrument_of(project);
    const std::size_t parts = parts_of_code(instrument.array, instrument.core);
    std::vector<std::string> files;
    for (std::size_t number = 1; number <= parts; ++number) {
        const CodePart part{number, parts};
        files.push_back(part_name(command.output, part));
        const Image image = calibration_image(instrument.array, instrument.core, part);
        link::UploadSettings settings;
        settings.image = "the code";
        settings.port = command.port.port;
        link::upload([&] { return std::make_unique<link::Device>(command.port); }, image, settings);
        link::Device device(command.port);
        record_part(command, device, image, files.back());
    }
    fmt::print("haptogram calibrate fit {} --at X,Y,Z\n", fmt::join(files, ","));
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

int calibrate(const CalibrateCommand& command) {
    if (command.recordings.size() != command.places.size())
        throw bad_argument("at",
                           fmt::format("{} places for {} recordings; give one for each, in their order",
                                       command.places.size(), command.recordings.size()),
                           {});
    if (command.focus && !command.level.given())
        throw bad_argument("focus",
                           "says where a level was measured; give --measured-mn, or --measured-mv and "
                           "--sensitivity");
    std::vector<NamedPath> outputs;
    if (!command.output.empty()) outputs.push_back({"--output", command.output});
    if (!command.picture.empty()) outputs.push_back({"--picture", command.picture});
    std::vector<NamedPath> inputs;
    for (const std::string& recording : command.recordings)
        for (const std::string& file : files_of_recording(recording)) inputs.push_back({"the recording", file});
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
            std::ranges::move(hear(command.recordings[k], one, parse_point_mm("at", command.places[k])),
                              std::back_inserter(heard));
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
    if (command.level.given()) {
        const Array real = calibrated(array, found.calibration, array.file);
        const MeasuredLevel level =
            measured_level(real, parse_point_mm("focus", command.focus.value_or("")), command.level.reading());
        found.calibration.source_pa_m = level.source_pa_m;
        found.calibration.measured = level.measured;
        if (const auto fault = supply_fault(array.transducer, level)) found.faults.push_back(*fault);
    }
    if (!command.output.empty()) write_file(command.output, to_text(found.calibration));
    if (!command.picture.empty()) draw(command.picture, array, found);
    if (command.output != "-") report_of(found, heard, names).print(command.json);
    return 0;
}

template <class Command>
void add_instrument(CLI::App& sub, Command& command) {
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
    CLI::App* sub =
        calibrate_app->add_subcommand("code", "Make the image that the array plays during a recording, over and over");
    add_instrument(*sub, *code);
    sub->add_option(
        "--steps", code->steps,
        "For a meter of amplitudes instead, with the microphone at x,y,z (mm): four records an element, for "
        "play --index");
    sub->add_option("--part", code->part, "For a board that holds too few records: the part N of OF, such as 1/3");
    sub->add_option("-o,--output", code->output, "The image, Intel HEX; - is standard output")->required();
    sub->callback([code, &action] { action = [code] { return write_code(*code); }; });

    auto take = std::make_shared<RecordCommand>();
    sub = calibrate_app->add_subcommand(
        "record", "Uploads the code, plays it, and lets arecord record it; on a board of few records, part by part");
    add_instrument(*sub, *take);
    add_port_options(*sub, take->port);
    sub->add_option("--card", take->card, "The sound card, as arecord --list-devices names it, such as hw:1")
        ->capture_default_str();
    sub->add_option("--rate", take->rate_hz, "Samples a second")->check(whole(96000, 1000000))->capture_default_str();
    sub->add_option("-o,--output", take->output, "The recording, .wav; of parts -1, -2 and so on before the ending")
        ->required();
    sub->callback([take, &action] { action = [take] { return record(*take); }; });

    auto fit = std::make_shared<CalibrateCommand>();
    sub = calibrate_app->add_subcommand("fit", "The calibration, from recordings of the code");
    sub->add_option("recordings", fit->recordings,
                    "Sound files of one channel, 96 kHz or more (.wav), an oscilloscope's .csv of time and "
                    "voltage, a .csv index,reading of the records of code --steps, or a scanning stage's .csv "
                    "x_mm,y_mm,z_mm,index,re,im of the code's records, or ,reading of those of code --steps; those of "
                    "a code's parts joined by commas")
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
    sub->add_option("--focus", fit->focus, "Where the level was measured, x,y,z in mm");
    add_level_options(*sub, fit->level, "The level, with this calibration, ");
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

void register_calibration(Extras& extras) { extras.commands[Purpose::play].push_back(add_calibrate); }

}  // namespace haptogram::cli
