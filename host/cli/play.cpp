// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/play.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "command.hpp"
#include "haptogram/array/medium.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/live_input.hpp"
#include "haptogram/link/air.hpp"
#include "haptogram/link/device.hpp"
#include "haptogram/link/rig_devices.hpp"
#include "haptogram/link/to_json.hpp"
#include "haptogram/link/transfer.hpp"
#include "haptogram/verbs/project.hpp"
#include "haptogram/verbs/trigger_reader.hpp"
#include "interrupt.hpp"
#include "port.hpp"
#include "progress_line.hpp"
#include "report.hpp"
#include "rig_ports.hpp"

namespace haptogram::cli {
namespace {

constexpr double least_c = -50.0, most_c = 100.0;  // of the air

struct PlayOptions {
    RigPorts ports;
    std::string on_loss = "off";
    link::PlaySettings play{.warn = complain};
    bool sequence = false;  ///< the default, which may be asked for
    std::optional<std::string> am, am_law;
    std::optional<double> temperature_c;
    std::string temperature_from;  ///< a sensor's lines; "": there is none
    std::string triggers;          ///< a project that has them; "": it does not wait for any
    bool json = false;
};

/// The foci of a board follow what was said of the air: once, or by lines of a sensor, as they come.
class Air {
public:
    Air(const PlayOptions& options, link::Device& device) {
        if (!options.temperature_from.empty()) sensor_.emplace(options.temperature_from);
        std::optional<double> celsius = options.temperature_c;
        while (sensor_ && !celsius && !sensor_->ended() && !interrupted())
            celsius = next(std::chrono::milliseconds(100));
        if (!celsius && sensor_ && !interrupted())
            throw bad_input(sensor_->where(),
                            "it ended without a temperature; expected lines of degrees C, such as 21.5");
        if (!celsius) return;
        const double speed_m_s = speed_of_sound(*celsius);
        on_.emplace(device, speed_m_s, complain);
        complain(
            fmt::format("foci for sound of {:.1f} m/s; the image has {:.1f} m/s", speed_m_s, on_->own_speed_m_s()));
    }
    void follow() {
        if (!sensor_ || !on_) return;
        std::optional<double> last;
        while (const auto celsius = next(std::chrono::milliseconds(0))) last = celsius;
        if (last) on_->set(speed_of_sound(*last));
    }

private:
    /// The next line that says one; of others it is told that they do not count.
    std::optional<double> next(std::chrono::milliseconds patience) {
        while (const auto line = sensor_->next(patience)) {
            double celsius = 0.0;
            const char* const end = line->data() + line->size();
            const auto [at, error] = std::from_chars(line->data(), end, celsius);
            if (error == std::errc() &&
                line->find_first_not_of(" \t\r", static_cast<std::size_t>(at - line->data())) == std::string::npos &&
                celsius >= least_c && celsius <= most_c)
                return celsius;
            complain(fmt::format("{}: expected degrees C from {} to {}, found '{}'; the air stays as it was",
                                 sensor_->where(), least_c, most_c, *line));
        }
        return {};
    }

    std::optional<LiveText> sensor_;
    std::optional<link::AirOn> on_;
};

link::Played play_parts(const PlayOptions& options, link::Device& device, const link::PlaySettings& settings,
                        const link::Watch& watch) {
    const Project project = load_project(options.triggers);
    if (project.triggers.empty())
        throw bad_input(options.triggers, "it has no [[trigger]]; add one, or play without --triggers");
    const link::DeviceSequence sequence = link::download_sequence(device, "board");
    const auto carried = std::ranges::find_if(sequence.entries, [](const SequenceEntry& e) { return e.index != 0; });
    if (carried == sequence.entries.end())
        throw Error(ErrorCode::device, "board", "the sequence in its memory plays no record; upload an image first");
    const auto parts = parts_of(project.triggers, sequence.entries, link::record_carrier_hz(device, carried->index));
    std::optional<LiveText> lines;
    if (std::ranges::any_of(project.triggers, [](const Trigger& trigger) { return trigger.on != Trigger::On::pin; }))
        lines.emplace("-");
    TriggerReader input(project.triggers, std::move(lines), complain, device.clock());
    return link::play(device, settings, parts, input, watch);
}

int play_rig(const PlayOptions& options) {
    if (options.play.rate > 0.0 || options.am || options.temperature_c || !options.temperature_from.empty())
        throw bad_argument(options.am                          ? "am"
                           : options.temperature_c             ? "temperature"
                           : !options.temperature_from.empty() ? "temperature-from"
                                                               : "rate",
                           "a rig plays as it was compiled; compile it with that setting, or play one board");
    const RigBundle bundle = load_rig_bundle(options.ports.rig);
    const link::RigDevices devices(bundle, options.ports.of(bundle));
    const link::RigSettings settings{.index = options.play.index,
                                     .loops = options.play.loops,
                                     .seconds = options.play.seconds,
                                     .watchdog_ms = options.play.watchdog_ms,
                                     .on_loss = on_loss_of(options.on_loss),
                                     .warn = complain};
    ProgressLine progress("play");
    const link::RigPlayed played = link::play(devices.tiles(), settings, [&](const link::RigPlaying& now) {
        progress.note(words_of(now));
        return !interrupted();
    });
    tell_rig(played, link::to_json(played), options.json,
             fmt::format("{} underruns, {} refused records", played.underruns, played.refused_records));
    return 0;
}

int play(const PlayOptions& options) {
    catch_interrupts();
    if (options.ports.is_rig()) return play_rig(options);
    link::Device device(options.ports.one());
    Air air(options, device);
    if (interrupted()) return 0;
    ProgressLine progress("play");
    link::PlaySettings settings = options.play;
    settings.am = {options.am.value_or(""), law_of(options.am_law.value_or("pressure"))};
    double seconds = 0.0;
    const auto watch = [&](const link::Playing& now) {
        seconds = now.seconds;
        air.follow();
        progress.note((settings.on_trigger && now.status.waiting) || (!options.triggers.empty() && is_over(now.status))
                          ? std::string("waits for the trigger")
                          : fmt::format("{:.1f} s, record {}, {} underruns", now.seconds, now.status.present_index,
                                        now.underruns));
        return !interrupted();
    };
    const link::Played played =
        options.triggers.empty() ? link::play(device, settings, watch) : play_parts(options, device, settings, watch);
    if (options.play.rate > 0.0)
        tell(streamed_to_json(played), options.json,
             fmt::format("{} indices, {} underruns, {} refused records in {:.1f} s", played.sent, played.underruns,
                         played.refused_records, seconds));
    else
        tell(played_to_json(played), options.json,
             fmt::format("{} underruns, {} refused records in {:.1f} s", played.underruns, played.refused_records,
                         seconds));
    return 0;
}

}  // namespace

void add_play(CLI::App& app, Action& action) {
    auto options = std::make_shared<PlayOptions>();
    CLI::App* sub = app.add_subcommand(
        "play", "Play what a board, or a rig's boards, hold: outputs go on, and off at the end or at Ctrl-C");
    auto* rig = add_rig_port_options(*sub, options->ports);
    add_on_loss_option(*sub, rig, options->on_loss);
    auto* index = sub->add_option("--index", options->play.index, "One record, until Ctrl-C")->check(whole(1, 65535));
    auto* loops = sub->add_option("--loops", options->play.loops,
                                  "Passes over the sequence; 0: until Ctrl-C (default: as the image says)")
                      ->check(whole(0, 65535))
                      ->excludes(index);
    auto* triggers =
        sub->add_option("--triggers", options->triggers,
                        "Play the parts that the triggers of this project start: by its pin, and by lines of standard "
                        "input, a key, a word, or a scene of haptogram live; until they end or Ctrl-C")
            ->check(CLI::ExistingFile)
            ->excludes(index)
            ->excludes(loops)
            ->excludes(rig);
    sub->add_flag("--sequence", options->sequence, "The whole sequence, which is what is played without --index")
        ->excludes(index);
    sub->add_flag("--on-trigger", options->play.on_trigger,
                  "The sequence begins when the board's trigger input says so (device trigger); until then the outputs "
                  "are on, and silent")
        ->excludes(index)
        ->excludes(rig)
        ->excludes(triggers);
    sub->add_option("--rate", options->play.rate,
                    "Passes a second, instead of as it was compiled; the indices go over the link then")
        ->check(positive())
        ->excludes(index)
        ->excludes(triggers);
    sub->add_option("--seconds", options->play.seconds, "Not longer than this")->check(positive());
    auto* temperature = sub->add_option("--temperature", options->temperature_c,
                                        "Temperature of the air now, degrees C: a board that computes foci does so for "
                                        "this speed of sound meanwhile")
                            ->check(CLI::Range(least_c, most_c));
    sub->add_option("--temperature-from", options->temperature_from,
                    "Temperatures as a sensor sends them, a line each, degrees C: a pipe or device, or - for standard "
                    "input; playing begins with the first")
        ->excludes(temperature)
        ->excludes(triggers);
    add_am(*sub, options->am, options->am_law);
    add_watchdog_option(*sub, options->play.watchdog_ms);
    sub->add_flag("--json", options->json, "Print the outcome as JSON");
    sub->callback([options, &action] { action = [options] { return play(*options); }; });
}

}  // namespace haptogram::cli
