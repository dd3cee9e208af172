// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "command.hpp"
#include "extras.hpp"
#include "haptogram/array/rig.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/live/depth_source.hpp"
#include "haptogram/live/hand_feeler.hpp"
#include "haptogram/live/hand_source.hpp"
#include "haptogram/live/loop.hpp"
#include "haptogram/live/pipeline.hpp"
#include "haptogram/live/players.hpp"
#include "haptogram/live/scene_input.hpp"
#include "haptogram/live/scene_output.hpp"
#include "haptogram/live/shot_rings.hpp"
#include "haptogram/live/source.hpp"
#include "haptogram/verbs/level.hpp"
#include "haptogram/verbs/source.hpp"
#include "interrupt.hpp"
#include "live_board.hpp"
#include "object_options.hpp"
#include "port.hpp"
#include "report.hpp"
#include "settings_file.hpp"
#include "touch_options.hpp"

namespace haptogram::cli {

void add_live(CLI::App& app, Action& action);
void add_task(CLI::App& app, Action& action);
namespace {

const std::vector<std::string> rings = {"ring", "still"};

struct LiveCommand {
    std::vector<std::string> from;
    std::string algorithm = "ring", array = "tile-10x10", rig, record, scene, scene_in, settings;
    std::string low, high;
    ObjectArguments object{.name = "cube"};
    std::string predict = "velocity", method = "distance-weighted";
    RigPorts ports;
    double mass_g = 0.0, distance_mm = 300.0;
    std::optional<double> latency_ms;
    live::CameraOptions cameras;
    std::vector<CLI::Option*> of_cameras;
    live::FingerOptions fingers;
    live::LoopOptions loop;
    TouchArguments touch;
    bool json = false;
    std::vector<std::string> given;

    [[nodiscard]] bool has_rings() const { return std::ranges::find(rings, algorithm) != rings.end(); }
};

live::PredictorOptions prediction_of(const LiveCommand& command, bool hands) {
    // Of a depth camera with its line of records, and of a hand tracker.
    const double usual_ms = hands ? 20.0 : 35.0;
    return {.kind = live::prediction_of(command.predict), .ahead_s = 1e-3 * command.latency_ms.value_or(usual_ms)};
}

/// What rings need to know of the object.
live::FingerOptions fingers_of(const LiveCommand& command, const ObjectSource& source, bool hands) {
    live::FingerOptions options = command.fingers;
    if (!command.low.empty()) options.cloud.low = parse_point_mm("workspace-low", command.low);
    if (!command.high.empty()) options.cloud.high = parse_point_mm("workspace-high", command.high);
    live::OpenedObjects opened;
    options.object = opened.told("object", source);
    SceneOptions& scene = options.scene;
    scene.pose = options.object.pose;
    scene.mass_kg = command.mass_g * 1e-3;
    if (names_mesh(source)) {
        if (scene.mass_kg > 0.0)
            throw bad_argument("mass", "an object that moves is a cube, a sphere or a cylinder; a mesh stays still");
        const TouchObject object = opened.open(source);
        scene.solid = object.solid;
        scene.pose = {};
        const Vec3 extent = object.high - object.low;
        scene.size_m = std::min({extent.x, extent.y, extent.z});
    } else {
        scene.kind = source.name;
        scene.size_m = options.object.size_m;
        scene.height_m = options.object.height_m.value_or(scene.size_m);
    }
    // The floor is what the object stands on when it begins.
    scene.world.low.z = source.centre.z - 0.5 * scene.size_m;
    scene.world.high.z = scene.world.low.z + 0.25;
    if (command.algorithm == "still") options.ring.motion = FocusMotion::still;
    if (command.algorithm == "L") options.ring.motion = FocusMotion::pressing;
    options.ring.press = command.touch.touch.press;
    options.predict = prediction_of(command, hands);
    return options;
}

live::HandOptions hand_options_of(const LiveCommand& command) {
    live::HandOptions options;
    options.algorithm = algorithm_of(command.algorithm);
    options.touch = touch_of(command.touch, command.cameras.noise.seed);
    options.predict = prediction_of(command, true);
    return options;
}

void tell_run(Report& report, const live::LoopReport& done, const live::Latency& at_pins) {
    report.tell(fmt::format(
        "shots             {}, {} of them with foci; {} lost, {} out of order, {} empty, {} without a camera",
        done.shots, done.with_rings, done.lost, done.out_of_order, done.empty, done.without_camera));
    if (done.skipped > 0)
        report.tell(fmt::format("skipped           {} shots, for which the line has no time", done.skipped));
    for (std::size_t i = 0; i < done.without_picture.size(); ++i)
        if (done.without_picture[i] > 0)
            report.tell(fmt::format("camera {:<10} gave no picture in {} shots", i + 1, done.without_picture[i]));
    if (done.blind > 0)
        report.tell(fmt::format("all cameras       gave no picture in {} shots, which were missed", done.blind));
    report.tell(fmt::format(
        "fingers           {} behind the middle, {} without a section, {} seen from one side, {} out of reach",
        done.through, done.no_section, done.constrained, done.out_of_reach));
    if (done.hidden > 0 || done.unweighed > 0)
        report.tell(
            fmt::format("rings             {} had places behind the finger, which were silent; {} were not weighed, "
                        "of fingers too thick or thin",
                        done.hidden, done.unweighed));
    report.tell(fmt::format("deadlines         {} missed, {} fades, {} underruns of the board", done.missed, done.fades,
                            done.underruns));
    const auto line = [](const live::Latency& latency, const std::string& by) {
        return fmt::format("latency           {:.1f} / {:.1f} / {:.1f} ms least, median, most: {} rings {}",
                           1e3 * latency.least_s, 1e3 * latency.median_s, 1e3 * latency.most_s, latency.rings, by);
    };
    if (at_pins.rings > 0) report.tell(line(at_pins, "at the pins"));
    if (const live::Latency stamped = live::latency_of(done.rings); stamped.rings > 0)
        report.tell(
            line(stamped, fmt::format("by the board's carrier periods, ± {:.2f} ms", 1e3 * stamped.uncertain_s)));
    else if (at_pins.rings == 0 && !done.rings.empty())
        report.tell(
            "latency           unknown: the board does not count carrier periods (its parameter SCHEDULE), or ran dry "
            "too often");
}

/// Options of simulated cameras are for those alone; a recording of hands can be cut, too.
void require_simulated(const LiveCommand& command) {
    if (std::ranges::any_of(command.from, live::has_simulated_cameras)) return;
    const bool recorded = std::ranges::any_of(command.from, [](const std::string& name) {
        return name.starts_with("leap:") || name.starts_with("poses:") || name.starts_with("synthetic:");
    });
    for (const CLI::Option* option : command.of_cameras)
        if (option->count() > 0 && option->get_name() != "--seed" && !(recorded && option->get_name() == "--seconds"))
            throw bad_argument(
                option->get_name().substr(2),
                fmt::format("{} has no simulated cameras; this is for those", fmt::join(command.from, ", ")));
}

/// @param hands  the source gives hands, not depth
void check_options(const LiveCommand& command, bool hands) {
    const std::vector<std::string_view> with_rings = {"ring", "still"};
    require_effect(command.given, {{"--press-frequency", {"L"}}, {"--magnitude", {"still"}}}, command.algorithm,
                   "the algorithm");
    std::vector<std::string> of_touch = command.given;
    if (std::ranges::any_of(command.from, live::has_simulated_cameras))
        std::erase(of_touch, "--seed");  // their noise's
    require_touch_effect(of_touch, command.algorithm, command.touch);
    require_effect(command.given, {{"--latency", {"velocity", "kalman"}}}, command.predict, "the prediction");
    if (hands) require_effect(command.given, {{"--mass", with_rings}}, command.algorithm, "the algorithm");
    const std::vector<std::string_view> depth = {"depth"}, fingers = {"depth", "a tracker's hands with rings"};
    const std::vector<std::string_view> bones = {"a tracker's hands"};
    require_effect(command.given,
                   {{"--speed", bones},
                    {"--frequency", bones},
                    {"--jump", bones},
                    {"--workspace-low", depth},
                    {"--workspace-high", depth},
                    {"--filter", depth},
                    {"--voxel", depth},
                    {"--cluster", fingers},
                    {"--stiffness", fingers},
                    {"--damping", fingers},
                    {"--static-friction", fingers},
                    {"--dynamic-friction", fingers}},
                   !hands                ? "depth"
                   : command.has_rings() ? "a tracker's hands with rings"
                                         : "a tracker's hands",
                   "the source");
    if (!hands && !command.has_rings() && command.algorithm != "L")
        throw bad_argument(
            "algorithm",
            fmt::format("{} draws on the skin of a hand whose bones are known; depth takes ring, still "
                        "or L, or take a tracker (leap-pipe:, joints-pipe:, leap:, joints:, poses:, synthetic:)",
                        command.algorithm));
    if (hands && !command.record.empty())
        throw bad_argument("record", "is of cameras' pictures; a tracker's frames are recorded by its own program");
    if (!command.scene_in.empty() && (!hands || command.has_rings()))
        throw bad_argument("scene-in",
                           "rings are around one object, which stays or is moved by hands; take a tracker "
                           "and an algorithm from A to L");
    if (std::ranges::count_if(command.from, [](const std::string& name) { return name.ends_with("-pipe:-"); }) > 1)
        throw bad_argument("from", "standard input can be that of one source alone; give the others named pipes");
    if (command.from.size() > 1 && !command.record.empty())
        throw bad_argument("record", "keeps the pictures of one source; take one");
    if (command.scene_in == "-" && std::ranges::any_of(command.from, [](const std::string& name) {
            return name.find("-pipe:-") != std::string::npos;
        }))
        throw bad_argument("scene-in", "standard input has the tracker's frames; give the lines a named pipe");
    require_simulated(command);
    std::vector<NamedPath> inputs;
    for (const std::string& name : command.from) inputs.push_back({"--from", name});
    if (!command.scene_in.empty()) inputs.push_back({"--scene-in", command.scene_in});
    require_distinct(inputs, {{"--scene", command.scene}});
    if (command.scene == "-" && command.json)
        throw bad_argument("scene", "the lines would go to standard output with the report; give them a file");
}

/// What makes paths of frames, and for what kind of paths the player is.
std::unique_ptr<live::Feeler> feeler_of(const LiveCommand& command, const live::OpenedSource& source,
                                        const ObjectSource& object, const Array& array, live::PlayerOptions& player,
                                        std::shared_ptr<live::SceneInput>& scene) {
    const bool hands = source.only_hands();
    if (hands && !command.has_rings()) {
        const live::HandOptions options = hand_options_of(command);
        player.pace.foci = live::most_foci(options);
        player.slow = live::is_slow(options);
        scene = std::make_shared<live::SceneInput>(object, command.scene_in);
        return std::make_unique<live::HandFeeler>(
            array, array.carrier_hz, [scene](double time_s) { return scene->at(time_s); }, options);
    }
    live::FingerOptions options = fingers_of(command, object, hands);
    options.rate_hz = player.rate_hz;
    player.steps = options.ring.points;
    constexpr std::size_t fingers = 2;  // at a time, of which more play in turn
    player.pace = {fingers * options.ring.foci(),
                   static_cast<std::uint32_t>(array.carrier_hz /
                                              (options.ring.passes_hz() * static_cast<double>(options.ring.points)))};
    return std::make_unique<live::ShotRings>(array, array.carrier_hz, options, source.cameras());
}

/// What is said of some settings alone.
void tell_setting(Report& report, const LiveCommand& command, const live::LoopReport& done, LiveBoard& board,
                  const Transducer& transducer) {
    if (const std::size_t boards = board.parts().size(); boards > 0) {
        report.add("begun_together", board.beginnings());
        report.tell(
            fmt::format("rig               {} boards, which have begun together {} times", boards, board.beginnings()));
    }
    if (command.algorithm == "still")
        report.tell(fmt::format("focus             still, modulated at {:g} Hz", command.fingers.ring.still_am_hz));
    if (command.fingers.magnitude) {
        report.tell(fmt::format("magnitude         {:g}, on a palm; {} shots with a finger that cannot feel so",
                                *command.fingers.magnitude, done.without_magnitude));
    }
    report.add("level", level_json(transducer), "level             " + level_text(transducer));
}

/// What came in and made no sense, and what went out and found no room.
void tell_dropped(Report& report, const live::OpenedSource& source, const live::SceneInput* objects,
                  std::uint64_t dropped) {
    std::uint64_t junk = 0;
    const auto tell = [&](const std::pair<std::uint64_t, std::string>& found, std::string_view what) {
        junk += found.first;
        if (found.first > 0)
            report.tell(fmt::format("junk              {} {}; the first: {}", found.first, what, found.second));
    };
    for (const live::HandPipe* tracker : source.trackers) tell(tracker->junk(), "lines were no frames");
    for (const auto& cameras : source.depth) tell(cameras->junk(), "shots were torn, and the next one searched for");
    report.add("junk", junk);
    if (objects != nullptr && objects->junk().first > 0)
        report.tell(fmt::format("scene-in          {} lines made no sense and changed nothing; the first: {}",
                                objects->junk().first, objects->junk().second));
    if (dropped > 0)
        report.tell(fmt::format("scene             {} lines found no room in the pipe and were dropped", dropped));
}

int live_loop(const LiveCommand& command) {
    if (command.from.empty())
        throw bad_argument("from", "is missing; name what sees the hand, such as leap-pipe:- or fingers:press");
    const ObjectSource object = object_of(command.object);
    live::CameraOptions cameras = command.cameras;
    cameras.target = object.centre;
    cameras.distance_m = command.distance_mm * millimetre;
    const live::OpenedSource source =
        live::open_sources(command.from, cameras, object.centre, 0.5 * object.size_m.value_or(ObjectMeasures{}.size));
    const bool hands = source.only_hands();
    check_options(command, hands);
    const bool simulated_time = keeps_own_time(command.ports);
    if (source.frames->live() && simulated_time)
        throw bad_argument("port", fmt::format("{} keeps its own time, in which live frames come at odd times; start "
                                               "'haptogram board run --model reference' and name its port",
                                               command.ports.ports.front()));
    std::optional<Rig> rig;
    if (!command.rig.empty()) rig = find_rig(command.rig);
    const Array array = rig ? joined(*rig) : find_array(command.array);
    live::PlayerOptions player_options{.method = method_of(command.method, "method"),
                                       .rate_hz = source.frames->rate_hz(),
                                       .watchdog_ms = command.loop.watchdog_ms};
    std::shared_ptr<live::SceneInput> objects;
    const auto feeler = feeler_of(command, source, object, array, player_options, objects);
    std::optional<DepthRecorder> recorder;
    if (!command.record.empty()) recorder.emplace(command.record, source.cameras(), player_options.rate_hz);
    std::optional<LineOutput> scene;
    if (!command.scene.empty()) scene.emplace(command.scene);
    catch_interrupts();  // before this, while a pipe says nothing, nothing is on
    const auto board = open_live_board(command.ports, rig, command.loop.watchdog_ms);
    link::Clock& clock = board->clock();
    player_options.parts = board->parts();
    const live::ChosenPlayer chosen = live::choose_player(board->client(), clock, array, player_options);
    if (const std::string words = feeler->about(); !words.empty()) complain(words);
    complain(chosen.about);
    if (!chosen.shortfall.empty()) complain("warning: " + chosen.shortfall);
    live::LoopOptions loop_options = command.loop;
    loop_options.interval_s = chosen.interval_s;
    live::Loop loop(board->client(), clock, *chosen.player, loop_options);
    const auto told = [&](const live::ShotReport& shot, const live::Frame& frame, const std::optional<Path>& path) {
        if (recorder) recorder->write(std::get<DepthShot>(frame.seen));
        if (scene) scene->write(live::to_json(shot, frame, path).dump());
        for (const std::string& news : shot.news) complain(news);
        for (const std::string& trouble : shot.troubles) complain(fmt::format("shot {}: {}", shot.number, trouble));
        return !interrupted();
    };
    const auto waits = [] { return !interrupted(); };
    live::LoopReport done;
    if (simulated_time) {  // all is done between two moments of the board's
        done = loop.run(*source.frames, *feeler, told, waits);
    } else {
        live::Pipeline pipeline(*source.frames, *feeler, clock);
        done = loop.run(pipeline, pipeline, told, waits);
    }
    const auto latency = live::latency_of(done.rings, board->starts());
    Report report(live::to_json(done, latency));
    tell_run(report, done, latency);
    tell_setting(report, command, done, *board, array.transducer);
    tell_dropped(report, source, objects.get(), scene ? scene->dropped() : 0);
    if (!command.record.empty())
        write_file(std::filesystem::path(command.record) / "run.json", live::run_to_json(done, latency).dump(1) + "\n");
    report.print(command.json);
    if (const std::string words = live::overtaken_in_words(done); !words.empty()) complain("warning: " + words);
    if (!interrupted()) live::require_played(done);  // who stops it at once has had nothing played
    return 0;
}

/// Options of what is seen, and of what fingers do to an object.
void add_fingers(CLI::App& sub, LiveCommand& options) {
    CloudOptions& cloud = options.fingers.cloud;
    SceneOptions& scene = options.fingers.scene;
    sub.add_option("--workspace-low", options.low,
                   "With depth cameras: x,y,z mm of the box out of which all is background (default: -150,-150,20)");
    sub.add_option("--workspace-high", options.high, "Its other corner (default: 150,150,320)");
    sub.add_option("--filter", cloud.window_px,
                   "With depth cameras: pixels of the bilateral filter's window, odd; 1: none")
        ->check(whole(1, 31))
        ->capture_default_str();
    add_mm(sub, "--voxel", cloud.cell_m, "With depth cameras: edge of the voxels that points are thinned to, mm");
    add_mm(sub, "--cluster", scene.cluster_m, "Points at most so far apart belong to one finger, mm");
    add_number(sub, "--stiffness", scene.contact.stiffness_n_m, "Stiffness of a finger's spring, N/m");
    add_number(sub, "--damping", scene.contact.damping_n_s_m, "Damping of a finger's damper, N s/m");
    add_number(sub, "--static-friction", scene.contact.static_friction, "Between finger and object");
    add_number(sub, "--dynamic-friction", scene.contact.dynamic_friction, "The same while it slides");
}

/// Options of simulated cameras.
void add_cameras(CLI::App& sub, LiveCommand& options) {
    live::CameraOptions& cameras = options.cameras;
    options.of_cameras = {
        sub.add_option("--cameras", cameras.count, "Simulated ones, around the object; 1: below it")
            ->check(whole(1, 8)),
        sub.add_option("--distance", options.distance_mm, "Distance of simulated cameras from the object, mm")
            ->check(positive()),
        sub.add_option("--rate", cameras.rate_hz, "Rate of simulated cameras, shots a second")->check(positive()),
        sub.add_option("--seconds", cameras.seconds,
                       "Seconds of simulated cameras, or recorded hands; 0: as long as the script or recording is")
            ->check(not_negative()),
        sub.add_option("--seed", cameras.noise.seed,
                       "Seed of the simulated cameras' noise, and of what is random in an algorithm")
            ->check(whole(0, UINT64_MAX))};
    for (CLI::Option* option : options.of_cameras) option->capture_default_str();
}

}  // namespace

void add_live(CLI::App& app, Action& action) {
    auto options = std::make_shared<LiveCommand>();
    CLI::App* sub = app.add_subcommand(
        "live", "Bare hands touch an object: what depth cameras or a tracker see becomes foci on a board, as it comes");
    sub->add_option("--from", options->from,
                    "Given again, several at a time: "
                    "depth:FOLDER (a recording of cameras), depth-pipe:- (cameras of another program, such as "
                    "haptogram-realsense, on standard input or a named pipe), leap-pipe:- (hands from haptogram-leap), "
                    "joints-pipe:- (hands of any tracker, as extras/hands/README.md has them), leap:FILE, joints:FILE, "
                    "poses:FILE or synthetic:SCRIPT:HEIGHT (hands as render takes them; @MOUNTING behind a "
                    "file, from align, says where the tracker is), fingers:press (scripted fingers, which simulated "
                    "cameras see)");
    std::vector<std::string> algorithms = rings;
    for (const AlgorithmName& one : algorithm_names()) algorithms.emplace_back(1, one.letter);
    sub->add_option("--algorithm", options->algorithm,
                    "ring: ten points around each finger's section, 100 times a second; still: one in its middle, "
                    "modulated; A to L as render has them, of a tracker's hands, and L of depth, too")
        ->check(CLI::IsMember(algorithms, CLI::ignore_case))
        ->capture_default_str();
    sub->add_option("--object", options->object.name, object_words())->capture_default_str();
    add_settings(*sub, object_settings(), options->object.given);
    sub->add_option("--scene-in", options->scene_in,
                    "With A to L: lines of JSON that bring, move and take away objects: a file, whose lines are due at "
                    "their time_s, a named pipe or -")
        ->check(CLI::ExistingPath | CLI::IsMember({"-"}));
    sub->add_option("--mass", options->mass_g, "g; 0: it stays where it is. Cube, sphere or cylinder, on a floor")
        ->check(not_negative())
        ->capture_default_str();
    sub->add_option(
        "--port", options->ports.ports,
        "Port of the board, as of play, or of 'haptogram board run'; or reference:CONFIGURATION, a simulated board "
        "in this process, whose time the loop then keeps. "
        "Given again, once for each array of --rig");
    add_baud_option(*sub, options->ports.baud);
    auto* array = sub->add_option("--array", options->array, "Array file or shipped array")->capture_default_str();
    sub->add_option(
           "--rig", options->rig,
           "Rig file or shipped rig instead: with a --port for each array, boards that play as one, kept in step over "
           "SYNC; with one --port, all arrays on the channels of one board, in their order")
        ->excludes(array);
    add_touch_options(*sub, options->touch);
    sub->add_option("--press-frequency", options->touch.touch.press.turns_hz, "With L: turns a second")
        ->check(positive())
        ->excludes("--frequency")
        ->capture_default_str();
    sub->add_option("--magnitude", options->fingers.magnitude,
                    "How strong the still focus feels to a palm, from the array's force and the Multimodal paper's "
                    "tables (see haptogram magnitude)")
        ->check(positive());
    sub->add_option("--method", options->method, "For several foci at once on boards of records, as solve has them")
        ->capture_default_str();
    sub->add_option("--predict", options->predict, "Takes fingers forward over the latency")
        ->check(CLI::IsMember({"none", "velocity", "kalman"}))
        ->capture_default_str();
    sub->add_option("--latency", options->latency_ms,
                    "Over which --predict does, ms (default: 35, of a tracker's hands 20)")
        ->check(not_negative());
    add_fingers(*sub, *options);
    add_cameras(*sub, *options);
    sub->add_option("--settings", options->settings,
                    "A TOML file whose table [live] has options by their names, with _ for -; those of the command "
                    "line come first")
        ->configurable(false)
        ->check(CLI::ExistingFile);
    add_watchdog_option(*sub, options->loop.watchdog_ms);
    sub->add_option("--record", options->record, "A new folder for the shots, which depth:FOLDER plays again");
    sub->add_option("--scene", options->scene,
                    "What happens, a line of JSON a frame, as it happens: to a file or named pipe, - or "
                    "udp:ADDRESS:PORT");
    sub->add_flag("--json", options->json, "Print as JSON");
    sub->callback([options, sub, &action] {
        action = [options, sub] {
            if (!options->settings.empty()) take_live_table(*sub, options->settings);
            options->given = given_to(*sub);
            return live_loop(*options);
        };
    });
}

void register_live(Extras& extras) {
    for (const AddCommand add : {add_live, add_task}) extras.commands[Purpose::hands].push_back(add);
}

}  // namespace haptogram::cli
