// SPDX-License-Identifier: Apache-2.0
#include "rig_ports.hpp"

#include <fmt/format.h>

#include "command.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/link/rig_devices.hpp"
#include "interrupt.hpp"
#include "port.hpp"
#include "report.hpp"

namespace haptogram::cli {

link::PortSettings RigPorts::one() const {
    if (ports.size() != 1)
        throw bad_argument("--port",
                           ports.empty()
                               ? std::string("is missing; name the board's port, or a rig with --rig")
                               : fmt::format("given {} times, expected once; several boards need --rig", ports.size()));
    link::PortSettings settings;
    settings.port = ports.front();
    settings.baud = baud;
    settings.interrupt = interrupts;
    settings.found = tell_rate;
    return settings;
}

std::vector<link::PortSettings> RigPorts::of(const RigBundle& bundle) const {
    std::vector<link::PortSettings> settings = link::ports_of(bundle, ports, baud);
    for (link::PortSettings& port : settings) {
        port.interrupt = interrupts;
        port.found = tell_rate;
    }
    return settings;
}

CLI::Option* add_rig_port_options(CLI::App& sub, RigPorts& ports) {
    sub.add_option("--port", ports.ports,
                   "Serial port of the board, or of 'haptogram board run', ftdi:[VID:PID[:SERIAL]], "
                   "udp:ADDRESS[:PORT], or reference:NAME[=IMAGE] for a simulated one with an image in its memory; #N "
                   "behind it is tile N of a chain; with --rig one for each tile, in their order, or one that leads to "
                   "a chain of "
                   "them, unless the rig's file names them")
        ->expected(1)
        ->allow_extra_args(false)  // what stands behind its value may be a file
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    add_baud_option(sub, ports.baud);
    return sub.add_option("--rig", ports.rig, "Boards that play as one: the rig manifest (.json) from compile --rig");
}

void add_on_loss_option(CLI::App& sub, CLI::Option* rig, std::string& on_loss) {
    sub.add_option("--on-loss", on_loss,
                   "When a tile falls silent or out of step: all go off (off), or the rest go on (rest)")
        ->needs(rig)
        ->check(CLI::IsMember({"off", "rest"}))
        ->capture_default_str();
}

link::OnLoss on_loss_of(const std::string& name) { return name == "rest" ? link::OnLoss::rest : link::OnLoss::off; }

void tell_rig(const link::RigPlayed& played, const nlohmann::ordered_json& json, bool as_json,
              const std::string& sentence) {
    tell(json, as_json,
         fmt::format("{}, begun together in carrier period {}{}", sentence, played.period,
                     played.lost.empty() ? "" : fmt::format("; lost {}", fmt::join(played.lost, ", "))));
}

std::string words_of(const link::RigPlaying& now) {
    std::size_t left = 0;
    std::uint16_t index = 0;
    for (const auto& status : now.statuses) {
        if (!status) continue;
        ++left;
        index = status->present_index;
    }
    return fmt::format("{:.1f} s, record {}, {} of {} tiles", now.seconds, index, left, now.statuses.size());
}

}  // namespace haptogram::cli
