// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/play.hpp"

#include <fmt/format.h>

#include <memory>
#include <optional>
#include <string>

#include "command.hpp"
#include "haptogram/array/medium.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/link/air.hpp"
#include "haptogram/link/device.hpp"
#include "haptogram/link/rig_devices.hpp"
#include "haptogram/link/to_json.hpp"
#include "interrupt.hpp"
#include "port.hpp"
#include "progress_line.hpp"
#include "report.hpp"
#include "rig_ports.hpp"

namespace haptogram::cli {
namespace {

struct PlayOptions {
    RigPorts ports;
    std::string on_loss = "off";
    link::PlaySettings play{.warn = complain};
    bool sequence = false;  ///< the default, which may be asked for
    std::optional<std::string> am, am_law;
    std::optional<double> temperature_c;
    bool json = false;
};

int play_rig(const PlayOptions& options) {
    if (options.play.rate > 0.0 || options.am || options.temperature_c)
        throw bad_argument(options.am              ? "am"
                           : options.temperature_c ? "temperature"
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
    std::optional<link::AirOn> air;
    if (options.temperature_c) {
        const double speed_m_s = speed_of_sound(*options.temperature_c);
        air.emplace(device, speed_m_s, complain);
        complain(
            fmt::format("foci for sound of {:.1f} m/s; the image has {:.1f} m/s", speed_m_s, air->own_speed_m_s()));
    }
    ProgressLine progress("play");
    link::PlaySettings settings = options.play;
    settings.am = {options.am.value_or(""), law_of(options.am_law.value_or("pressure"))};
    const link::Played played = link::play(device, settings, [&](const link::Playing& now) {
        progress.note(settings.on_trigger && now.status.waiting
                          ? std::string("waits for the trigger")
                          : fmt::format("{:.1f} s, record {}, {} underruns", now.seconds, now.status.present_index,
                                        now.underruns));
        return !interrupted();
    });
    if (options.play.rate > 0.0)
        tell(streamed_to_json(played), options.json,
             fmt::format("{} indices, {} underruns", played.sent, played.underruns));
    else
        tell(played_to_json(played), options.json,
             fmt::format("{} underruns, {} refused records", played.underruns, played.refused_records));
    return 0;
}

}  // namespace

void add_play(CLI::App& app, Action& action) {
    auto options = std::make_shared<PlayOptions>();
    CLI::App* sub = app.add_subcommand("play",
                                       "Turn the outputs on and play what is in the memories of a board, or of a rig's "
                                       "boards, until its end or Ctrl-C; then off again");
    auto* rig = add_rig_port_options(*sub, options->ports);
    add_on_loss_option(*sub, rig, options->on_loss);
    auto* index = sub->add_option("--index", options->play.index, "One record, until Ctrl-C")->check(whole(1, 65535));
    sub->add_option("--loops", options->play.loops,
                    "Passes over the sequence; 0: until Ctrl-C (default: as the image says)")
        ->check(whole(0, 65535))
        ->excludes(index);
    sub->add_flag("--sequence", options->sequence, "The whole sequence, which is what is played without --index")
        ->excludes(index);
    sub->add_flag("--on-trigger", options->play.on_trigger,
                  "The sequence begins when the board's trigger input says so (device trigger); until then the outputs "
                  "are on, and silent")
        ->excludes(index)
        ->excludes(rig);
    sub->add_option("--rate", options->play.rate,
                    "Passes a second, instead of as it was compiled; the indices go over the link then")
        ->check(positive())
        ->excludes(index);
    sub->add_option("--seconds", options->play.seconds, "Not longer than this")->check(positive());
    sub->add_option("--temperature", options->temperature_c,
                    "Temperature of the air now, degrees C: a board that computes foci does so for this speed of sound "
                    "meanwhile")
        ->check(CLI::Range(-50.0, 100.0));
    add_am(*sub, options->am, options->am_law);
    add_watchdog_option(*sub, options->play.watchdog_ms);
    sub->add_flag("--json", options->json, "Print the outcome as JSON");
    sub->callback([options, &action] { action = [options] { return play(*options); }; });
}

}  // namespace haptogram::cli
