// SPDX-License-Identifier: Apache-2.0
#include "haptogram/hand/render.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/hand/project.hpp"
#include "haptogram/hand/recording.hpp"
#include "haptogram/shape/path_file.hpp"
#include "haptogram/verbs/compile.hpp"
#include "haptogram/verbs/level.hpp"
#include "haptogram/verbs/source.hpp"
#include "object_options.hpp"
#include "progress_line.hpp"
#include "report.hpp"
#include "touch_options.hpp"

namespace haptogram::cli {
namespace {

using nlohmann::ordered_json;

struct RenderCommand {
    ObjectArguments object;
    HandSource hand;
    Given<HandSource> of_hand;
    std::string algorithm = "A";
    std::optional<std::string> array, board;
    std::optional<std::size_t> points;
    std::optional<std::uint32_t> dwell;
    bool report = false, json = false;
    std::optional<std::string> am, am_law;
    std::optional<double> magnitude;
    double amplitude = 1.0;
    TouchArguments touch;
    std::uint64_t seed = 1;
    std::vector<std::string> outputs;
    std::vector<std::string> given;  ///< names of the options on the command line
};

RenderOptions options_of(const RenderCommand& command) {
    RenderOptions options;
    options.algorithm = algorithm_of(command.algorithm);
    options.touch = touch_of(command.touch, command.seed);
    options.frame = command.hand.frame;
    options.points = command.points;
    options.dwell = command.dwell;
    options.am = command.am.value_or("");
    if (command.am_law) options.am_law = law_of(*command.am_law);
    options.magnitude = command.magnitude;
    options.amplitude = command.amplitude;
    return options;
}

/// What no algorithm, hand or object of this kind has is refused.
void check_options(const RenderCommand& command) {
    require_touch_effect(command.given, std::string(1, name_of(algorithm_of(command.algorithm)).letter), command.touch);
    command.of_hand.require_effect(command.hand, "the hand is no .pose file");
}

/// What is rendered, and on what.
struct Subject {
    Project project;
    RenderOptions options;
};

/// The project file's settings. A frame, an array or a board on the command line take the place of the file's.
Subject subject_in_file(const RenderCommand& command) {
    for (const std::string& name : command.given)
        if (name != "object" && name != "--frame" && name != "--array" && name != "--board" && name != "--report" &&
            name != "--json" && name != "--output")
            throw bad_argument(name, fmt::format("is a setting of the project file {}; change it there, or name the "
                                                 "object and --hand instead of the project",
                                                 command.object.name));
    Subject subject{load_project(command.object.name), {}};
    Project& project = subject.project;
    if (!project.hand)
        throw bad_input(command.object.name,
                        "it has no [hand] that feels an object; 'haptogram compile' takes it as it is");
    if (command.hand.frame) project.hand->frame = command.hand.frame;
    if (command.array) project.array = from_here(*command.array);
    if (command.board) project.board = from_here(*command.board);
    open_hand(project);
    subject.options = render_options(project);
    return subject;
}

Subject subject_of(const RenderCommand& command) {
    if (is_project(command.object.name)) return subject_in_file(command);
    if (command.hand.recording.empty())
        throw bad_argument("hand", "is missing; name a recording of hands, or a script such as synthetic:slide");
    check_options(command);
    Subject subject{{}, options_of(command)};
    subject.project.array = command.array;
    subject.project.board = command.board;
    HandSource& hand = subject.project.hand.emplace(command.hand);
    hand.touched = std::make_shared<const TouchObject>(open_object(object_of(command.object)));
    hand.hands = std::make_shared<const HandRecording>(open_hands(hand.recording, hand.model, hand.rate_hz));
    return subject;
}

void print_frames(const std::vector<FrameReport>& frames) {
    fmt::print("{:>6} {:>8} {:>5} {:>5} {:>10} {:>8} {:>9} {:>7} {:>7} {:>7} {:>8}\n", "frame", "time s", "lines",
               "foci", "length mm", "draw Hz", "Pa", "cos²", "weak %", "lost %", "ms");
    for (const FrameReport& f : frames)
        fmt::print("{:6} {:8.3f} {:5} {:5} {:10.1f} {:8.2f} {:9.2f} {:7.3f} {:7.1f} {:7.1f} {:8.3f}\n", f.frame,
                   f.time_s, f.lines, f.foci, f.length_m / millimetre, f.draw_hz, f.strength_pa, f.tilt, 100.0 * f.weak,
                   100.0 * f.out_of_reach, f.compute_s * 1e3);
}

int render(const RenderCommand& command) {
    std::string path, picture;
    std::vector<NamedPath> inputs, outputs;
    if (!command.object.name.empty()) inputs.push_back({"the object", command.object.name});
    if (!command.hand.recording.empty()) inputs.push_back({"--hand", command.hand.recording});
    for (const std::string& output : command.outputs) {
        std::string& place = output.ends_with(".png") ? picture : path;
        if (output != "-" && !output.ends_with(".png") && !output.ends_with(".json"))
            throw bad_argument("output",
                               fmt::format("found \"{}\", expected a .json path, a .png picture, or -", output));
        if (!place.empty())
            throw bad_argument("output", "there are two of one kind; give one .json and one .png at most");
        place = output;
        outputs.push_back({"--output", output});
    }
    require_distinct(inputs, outputs);
    if (path == "-" && (command.report || command.json))
        throw bad_argument("output", "the path would go to standard output with the report; give it a file");
    const Subject subject = subject_of(command);
    const RenderOptions& options = subject.options;
    const TouchObject& object = *subject.project.hand->touched;
    const HandRecording& hands = *subject.project.hand->hands;
    const ProjectInstrument instrument = instrument_of(subject.project);
    const double carrier_hz = choose_timer(instrument.array, instrument.core).carrier_hz();
    Rendered rendered;
    {
        ProgressLine progress("render");
        rendered = haptogram::render(object, hands, instrument.array, carrier_hz, options, progress.callback());
    }
    if (!path.empty()) write_file(path, to_json_text(rendered.path, carrier_hz));
    if (!picture.empty()) draw_render(picture, object, hands, instrument.array, carrier_hz, options, rendered);
    for (const std::string& warning : rendered.warnings) complain("warning: " + warning);
    if (path == "-") return 0;
    double length = 0.0, strength = 0.0, compute = 0.0, slowest = 0.0;
    std::size_t touching = 0;
    ordered_json frames = ordered_json::array();
    for (const FrameReport& frame : rendered.frames) {
        frames.push_back(to_json(frame));
        compute += frame.compute_s / static_cast<double>(rendered.frames.size());
        slowest = std::max(slowest, frame.compute_s);
        if (frame.foci == 0) continue;
        ++touching;
        length += frame.length_m;
        strength += frame.strength_pa;
    }
    const auto count = static_cast<double>(std::max<std::size_t>(touching, 1));
    const double seconds = static_cast<double>(rendered.path.periods()) / carrier_hz;
    if (command.report && !command.json) print_frames(rendered.frames);
    Report report;
    report.add(
        "algorithm", std::string(1, name_of(options.algorithm).letter),
        fmt::format("algorithm         {}: {}", name_of(options.algorithm).letter, name_of(options.algorithm).about));
    report.add("object", object.name, fmt::format("object            {}", object.name));
    report.add("array", instrument.array.name, fmt::format("array             {}", instrument.array.name));
    report.add("steps", rendered.path.steps.size(),
               fmt::format("path              {} steps, {:.4g} s{}", rendered.path.steps.size(), seconds,
                           path.empty() ? "" : ", " + path));
    report.add("seconds", seconds);
    report.add("touching", touching,
               fmt::format("touching          {} of {} frames, {:.1f} mm of lines on average, {:.2f} Pa by estimate",
                           touching, rendered.frames.size(), length / count / millimetre, strength / count));
    if (rendered.magnitude)
        report
            .add("least_command", rendered.magnitude->least_command,
                 fmt::format(
                     "magnitude         commands {:.4f}…{:.4f}{}", rendered.magnitude->least_command,
                     rendered.magnitude->most_command,
                     rendered.magnitude->moves ? "; it was measured with a focus that rests, and this one moves" : ""))
            .add("most_command", rendered.magnitude->most_command)
            .add("focus_moves", rendered.magnitude->moves);
    report.add("length_mm", length / count / millimetre).add("strength_pa", strength / count);
    report.add("level", level_json(instrument.array.transducer),
               "                  " + level_text(instrument.array.transducer));
    report.add("compute_ms", compute * 1e3,
               fmt::format("computed in       {:.3f} ms a frame, {:.3f} ms at most", compute * 1e3, slowest * 1e3));
    if (command.report) report.add("frames", frames);
    report.add("warnings", rendered.warnings);
    report.print(command.json);
    return 0;
}

}  // namespace

void add_render(CLI::App& app, Action& action) {
    auto options = std::make_shared<RenderCommand>();
    CLI::App* sub = app.add_subcommand(
        "render",
        "Let recorded or synthetic hands feel a solid object: a path for compile, a report for each frame, a picture");
    sub->add_option(
           "object", options->object.name,
           fmt::format(
               "{}; or a project (.toml, .haptogram) with a [hand], which has all settings but --frame, --array and "
               "--board",
               object_words()))
        ->required();
    add_settings(*sub, hand_settings(), options->of_hand);
    std::string about;
    std::vector<std::string> letters;
    for (const AlgorithmName& one : algorithm_names()) {
        about += fmt::format("{}{} ({})", about.empty() ? "" : ", ", one.letter, one.about);
        letters.emplace_back(1, one.letter);
    }
    sub->add_option("--algorithm", options->algorithm, about)
        ->check(CLI::IsMember(letters, CLI::ignore_case))
        ->capture_default_str();
    add_settings(*sub, object_settings(), options->object.given);
    sub->add_option("--array", options->array, "Array file or shipped array; by default the board's, or tile-10x10");
    sub->add_option("--board", options->board, "Board file, shipped board or configuration");
    auto* points = sub->add_option("--points", options->points, "Points of the pass of one frame, instead of --dwell")
                       ->check(whole(1, 1'000'000));
    sub->add_option("--dwell", options->dwell, "Carrier periods of a step (default: 10; of K and L 400)")
        ->check(whole(1, 1'000'000))
        ->excludes(points);
    add_touch_options(*sub, options->touch);
    add_am(*sub, options->am, options->am_law);
    sub->add_option("--amplitude", options->amplitude,
                    "Amplitude of all foci, as a fraction of the pressure that the array can make there")
        ->check(positive())
        ->capture_default_str();
    sub->add_option("--magnitude", options->magnitude,
                    "How strong each focus feels to a palm under --am or the algorithm's own modulation, from the "
                    "array's force and the Multimodal paper's tables (see haptogram magnitude)")
        ->check(positive());
    sub->add_option("--seed", options->seed, "Seed of what is random")
        ->check(whole(0, UINT64_MAX))
        ->capture_default_str();
    sub->add_flag("--report", options->report,
                  "A line for each frame: length, draw frequency, strength, tilt, what is lost, time");
    sub->add_flag("--json", options->json, "Print as JSON");
    sub->add_option("-o,--output", options->outputs,
                    "The path as .json (- is standard output), or a .png picture; may be repeated");
    sub->callback([sub, options, &action] {
        options->given = given_to(*sub);
        options->of_hand.put(options->hand);
        action = [options] { return render(*options); };
    });
}

}  // namespace haptogram::cli
