// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "command.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/link/device.hpp"
#include "haptogram/live/depth_folder.hpp"
#include "haptogram/live/loop.hpp"
#include "haptogram/live/source.hpp"
#include "haptogram/live/to_json.hpp"
#include "haptogram/verbs/source.hpp"
#include "interrupt.hpp"
#include "live_board.hpp"
#include "port.hpp"
#include "report.hpp"

namespace haptogram::cli {
namespace {

constexpr const char* reference_prefix = "reference:";

struct LiveCommand {
    std::string from, object = "cube:40", at = "0,0,170", array = "tile-10x10", record, scene;
    std::string predict = "none", focus = "dynamic", method = "distance-weighted";
    link::PortSettings port;
    double mass_g = 0.0, latency_ms = 35.0, distance_mm = 300.0;
    live::CameraOptions cameras;
    std::vector<CLI::Option*> of_cameras;
    live::LoopOptions loop;
    std::optional<double> magnitude;
    double press_radius_mm = PressOptions{}.radius_m / millimetre;
    bool json = false;
};

FocusMotion motion_of(const std::string& focus) {
    if (focus == "static") return FocusMotion::still;
    return focus == "press" ? FocusMotion::pressing : FocusMotion::revolving;
}

class PortBoard final : public LiveBoard {
public:
    explicit PortBoard(const link::PortSettings& port) : device_(port) {}
    link::Client& client() override { return device_; }
    live::Clock clock() override { return live::steady_clock(); }

private:
    link::Device device_;
};

std::unique_ptr<LiveBoard> open_board(link::PortSettings port) {
    port.interrupt = interrupts;
    if (port.port.starts_with(reference_prefix))
        return reference_board(port.port.substr(std::string(reference_prefix).size()));
    return std::make_unique<PortBoard>(port);
}

/// "cube:40" is a cube of 40 mm.
void parse_object(const std::string& text, SceneOptions& scene) {
    const std::size_t colon = std::min(text.find(':'), text.size());
    scene.kind = text.substr(0, colon);
    if (colon == text.size()) return;
    double size_mm = 0.0;
    const auto [end, error] = std::from_chars(text.data() + colon + 1, text.data() + text.size(), size_mm);
    if (error != std::errc() || end != text.data() + text.size() || !(size_mm > 0.0))
        throw bad_argument("object",
                           fmt::format("found \"{}\", expected a kind and its size in mm, such as cube:40", text));
    scene.size_m = scene.height_m = size_mm * millimetre;
}

live::LoopOptions options_of(const LiveCommand& command) {
    live::LoopOptions options = command.loop;
    parse_object(command.object, options.scene);
    options.scene.pose.origin = parse_point_mm("at", command.at);
    options.scene.mass_kg = command.mass_g * 1e-3;
    // The floor is what the object stands on when it begins.
    options.scene.world.low.z = options.scene.pose.origin.z - 0.5 * options.scene.size_m;
    options.scene.world.high.z = options.scene.world.low.z + 0.25;
    options.ring.motion = motion_of(command.focus);
    options.magnitude = command.magnitude;
    options.ring.press.radius_m = command.press_radius_mm * millimetre;
    options.predict.kind = live::prediction_of(command.predict);
    options.predict.ahead_s = command.latency_ms * 1e-3;
    options.method = method_of(command.method, "method");
    return options;
}

void tell_run(Report& report, const live::LoopReport& done, const live::Latency& at_pins) {
    report.tell(fmt::format(
        "shots             {}, {} of them with rings; {} lost, {} out of order, {} empty, {} without a camera",
        done.shots, done.with_rings, done.lost, done.out_of_order, done.empty, done.without_camera));
    for (std::size_t i = 0; i < done.without_picture.size(); ++i)
        if (done.without_picture[i] > 0)
            report.tell(fmt::format("camera {:<10} gave no picture in {} shots", i + 1, done.without_picture[i]));
    if (done.blind > 0)
        report.tell(fmt::format("all cameras       gave no picture in {} shots, which were missed", done.blind));
    report.tell(fmt::format(
        "fingers           {} behind the middle, {} without a section, {} seen from one side, {} out of reach",
        done.through, done.no_section, done.constrained, done.out_of_reach));
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
        report.tell("latency           unknown: the board does not count carrier periods (its parameter SCHEDULE)");
}

/// Cameras of its own are what they are, whatever is asked of simulated ones.
void require_simulated(const LiveCommand& command) {
    if (!live::has_cameras(command.from)) return;
    for (const CLI::Option* option : command.of_cameras)
        if (option->count() > 0)
            throw bad_argument(option->get_name().substr(2),
                               fmt::format("{} has cameras of its own; this is for simulated ones", command.from));
}

const std::vector<OptionOf> of_focus = {
    {"--press-frequency", {"press"}}, {"--press-radius", {"press"}}, {"--press-foci", {"press"}}};
const std::vector<OptionOf> of_prediction = {{"--latency", {"velocity", "kalman"}}};

int live_loop(const LiveCommand& command, const std::vector<std::string>& given) {
    require_effect(given, of_focus, command.focus, "the focus");
    require_effect(given, of_prediction, command.predict, "the prediction");
    require_simulated(command);
    require_distinct({{"--from", command.from}}, {{"--scene", command.scene}});
    live::LoopOptions options = options_of(command);
    live::CameraOptions cameras = command.cameras;
    cameras.target = options.scene.pose.origin;
    cameras.distance_m = command.distance_mm * millimetre;
    const auto source = live::open_depth(command.from, cameras, options.scene.pose.origin, 0.5 * options.scene.size_m);
    if (source->live() && command.port.port.starts_with(reference_prefix))
        throw bad_argument("port", fmt::format("{} keeps its own time, in which live shots come at odd times; start "
                                               "'haptogram board run --model reference' and name its port",
                                               command.port.port));
    options.rate_hz = source->rate_hz();
    std::optional<DepthRecorder> recorder;
    if (!command.record.empty()) recorder.emplace(command.record, source->cameras(), options.rate_hz);
    catch_interrupts();  // before this, while a pipe says nothing, nothing is on
    const auto board = open_board(command.port);
    live::Loop loop(board->client(), board->clock(), find_array(command.array), options);
    std::string scene;
    const live::LoopReport done = loop.run(
        *source,
        [&](const live::ShotReport& shot, const DepthShot& pictures) {
            if (recorder) recorder->write(pictures);
            if (!command.scene.empty()) scene += live::to_json(shot).dump() + "\n";
            for (const std::string& trouble : shot.troubles) complain(fmt::format("shot {}: {}", shot.number, trouble));
            return !interrupted();
        },
        [] { return !interrupted(); });
    if (!command.scene.empty()) write_file(command.scene, scene);
    const auto latency = live::latency_of(done.rings, board->starts());
    Report report(live::to_json(done, latency));
    tell_run(report, done, latency);
    if (command.focus == "static")
        report.tell(fmt::format("focus             static, modulated at {:g} Hz", options.ring.still_am_hz));
    if (options.magnitude)
        report.tell(fmt::format("magnitude         {:g}, on a palm; {} shots with a finger that cannot feel so",
                                *options.magnitude, done.without_magnitude));
    if (!command.record.empty())
        write_file(std::filesystem::path(command.record) / "run.json", live::run_to_json(done, latency).dump(1) + "\n");
    report.print(command.json);
    return 0;
}

void add_press(CLI::App& sub, LiveCommand& options) {
    PressOptions& press = options.loop.ring.press;
    sub.add_option("--press-frequency", press.turns_hz, "Of press: turns a second")
        ->check(positive())
        ->capture_default_str();
    sub.add_option("--press-radius", options.press_radius_mm, "Of press: of the circle, mm")
        ->check(positive())
        ->capture_default_str();
    sub.add_option("--press-foci", press.foci, "Of press: on each finger")->check(whole(1, 16))->capture_default_str();
}

/// Options of simulated cameras.
void add_cameras(CLI::App& sub, LiveCommand& options) {
    live::CameraOptions& cameras = options.cameras;
    options.of_cameras = {
        sub.add_option("--cameras", cameras.count, "Simulated ones, around the object; 1: below it")
            ->check(whole(1, 8)),
        sub.add_option("--distance", options.distance_mm, "Of simulated cameras from the object, mm")
            ->check(positive()),
        sub.add_option("--rate", cameras.rate_hz, "Of simulated cameras, shots a second")->check(positive()),
        sub.add_option("--seconds", cameras.seconds, "Of simulated cameras; 0: as long as recording or script is")
            ->check(not_negative()),
        sub.add_option("--seed", cameras.noise.seed, "Of the simulated cameras' noise")->check(whole(0, UINT64_MAX))};
    for (CLI::Option* option : options.of_cameras) option->capture_default_str();
}

}  // namespace

void add_live(CLI::App& app, Action& action) {
    auto options = std::make_shared<LiveCommand>();
    CLI::App* sub = app.add_subcommand(
        "live", "Bare fingers touch an object, as in Fingers: depth cameras to rings of foci on a board, as it comes");
    sub->add_option(
           "--from", options->from,
           "depth:FOLDER (a recording of cameras), depth-pipe:- (cameras of another program, such as "
           "haptogram-realsense, on standard input or a named pipe), leap:FILE, poses:FILE or "
           "synthetic:SCRIPT:HEIGHT (hands as render takes them, which simulated cameras see), leap-pipe:- (the "
           "same from haptogram-leap), fingers:press (scripted fingers)")
        ->required();
    sub->add_option("--object", options->object,
                    "cube, sphere, cylinder, cone, pyramid or half-space, and its size: KIND:MM")
        ->capture_default_str();
    sub->add_option("--at", options->at, "Its middle: x,y,z mm; of a half-space, its surface")->capture_default_str();
    sub->add_option("--mass", options->mass_g, "g; 0: it stays where it is. Cube, sphere or cylinder, on a floor")
        ->check(not_negative())
        ->capture_default_str();
    add_port_options(*sub, options->port);
    sub->get_option("--port")->description(
        "Serial port of the board, or of 'haptogram board run', or reference:CONFIGURATION: the reference board in "
        "this "
        "process, whose time the loop then keeps");
    sub->add_option("--array", options->array, "Array file or shipped array")->capture_default_str();
    sub->add_option("--focus", options->focus,
                    "dynamic: ten points around each finger's section, 100 times a second; "
                    "static: one in its middle, modulated; press: several that turn slowly around the middle, felt as "
                    "steady pressure, as render's algorithm L")
        ->check(CLI::IsMember({"dynamic", "static", "press"}))
        ->capture_default_str();
    add_press(*sub, *options);
    sub->add_option("--magnitude", options->magnitude,
                    "How strong the static focus feels to a palm, from the array's force and the Multimodal paper's "
                    "tables (see haptogram magnitude)")
        ->check(positive());
    sub->add_option("--method", options->method, "For several fingers at once, as solve has them")
        ->capture_default_str();
    sub->add_option("--predict", options->predict, "Takes fingers forward over the latency")
        ->check(CLI::IsMember({"none", "velocity", "kalman"}))
        ->capture_default_str();
    sub->add_option("--latency", options->latency_ms, "Over which --predict does, ms")
        ->check(not_negative())
        ->capture_default_str();
    add_cameras(*sub, *options);
    add_watchdog_option(*sub, options->loop.watchdog_ms);
    sub->add_option("--record", options->record, "A new folder for the shots, which depth:FOLDER plays again");
    sub->add_option("--scene", options->scene, "Also write what happened in each shot, a line of JSON each");
    sub->add_flag("--json", options->json, "Print as JSON");
    sub->callback(
        [options, sub, &action] { action = [options, given = given_to(*sub)] { return live_loop(*options, given); }; });
}

}  // namespace haptogram::cli
