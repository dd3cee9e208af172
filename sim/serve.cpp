// SPDX-License-Identifier: Apache-2.0
#include "serve.hpp"

#include <fmt/format.h>

#include <chrono>
#include <string>
#include <vector>

#include "haptogram/base/error.hpp"

namespace haptogram::sim {

void LinkCounters::in(std::span<const std::uint8_t> bytes) {
    bytes_in += bytes.size();
    for (const std::uint8_t byte : bytes) {
        frames += byte == 0 && in_frame_ ? 1 : 0;
        in_frame_ = byte != 0;
    }
}

void LinkCounters::out(std::span<const std::uint8_t> bytes) {
    bytes_out += bytes.size();
    std::vector<link::Reply> replies;
    for (const std::uint8_t& byte : bytes) {
        if (place_ >= header_) decoder_.feed({&byte, 1}, replies);
        place_ = byte == 0 ? 0 : place_ + 1;
    }
    for (const link::Reply& reply : replies)
        ++(reply.status == interface::Status::ok         ? applied
           : reply.status == interface::Status::repeated ? repeated
                                                         : refused);
}

Served serve(Board& board, HostLine& line, const ServeOptions& options,
             const std::function<bool(const Served&)>& watch) {
    constexpr std::uint64_t slice = 2000;  // clocks, less than one byte at 115,200 baud
    const double clock_hz = board.parameters().clock_hz;
    Served served;
    Pace pace(most_behind_s);
    const auto go_on = [&] {
        served.simulated_s = static_cast<double>(board.now()) / clock_hz;
        served.wall_s = pace.wall_s();
        served.index = board.present().index;
        served.enabled = board.present().enabled;
        return watch(served) && (options.seconds == 0.0 || served.simulated_s < options.seconds);
    };
    while (go_on()) {
        pace.give_up(served.simulated_s);
        const double ahead_s = pace.ahead_s(served.simulated_s);
        const bool waits = options.real_time && ahead_s > 1e-3;
        const auto arrived = line.read(std::chrono::milliseconds(waits ? static_cast<int>(1e3 * ahead_s) : 0));
        board.send(arrived);
        const double before_s = pace.wall_s();
        board.run(slice);
        if (board.present().playing()) {
            served.playing_clocks += slice;
            served.playing_s += pace.wall_s() - before_s;
        }
        const auto answer = board.receive();
        line.write(answer);
        served.link.in(arrived);
        served.link.out(answer);
    }
    return served;
}

std::string_view model_with_channels(std::uint32_t channels, std::span<const interface::CoreConfiguration> models) {
    std::string known;
    for (const auto& [name, parameters] : models) {
        if (parameters.channels == channels) return name;
        known += fmt::format("{}{}", known.empty() ? "" : ", ", parameters.channels);
    }
    throw bad_argument("channels", fmt::format("no simulated board has {}; there are {}", channels, known));
}

std::vector<interface::CoreConfiguration> models_of(bool network,
                                                    std::span<const interface::CoreConfiguration> models) {
    std::vector<interface::CoreConfiguration> able;
    for (const interface::CoreConfiguration& model : models)
        if ((model.parameters.net != 0) == network) able.push_back(model);
    return able;
}

std::string_view model_like(const Core& core, std::span<const interface::CoreConfiguration> models) {
    const interface::CoreParameters& asked = core.parameters;
    const auto stands_for_it = [&asked](const interface::CoreParameters& p) {
        const bool same_indices = asked.foci == 0 || p.records == asked.records;  // focus records follow the others
        return p.channels == asked.channels && p.clock_hz == asked.clock_hz && p.records >= asked.records &&
               same_indices && p.sequence_depth >= asked.sequence_depth && p.live_depth >= asked.live_depth &&
               p.timing_bits >= asked.timing_bits && p.pulse_bits >= asked.pulse_bits &&
               p.width_bits >= asked.width_bits && p.modulation_depth >= asked.modulation_depth &&
               p.slew >= asked.slew && p.foci >= asked.foci && p.schedule >= asked.schedule && p.sync >= asked.sync &&
               p.net == asked.net;
    };
    std::string known;
    for (const auto& [name, parameters] : models) {
        if (name == core.name || stands_for_it(parameters)) return name;
        known += fmt::format("{}{}", known.empty() ? "" : ", ", name);
    }
    throw bad_argument("board",
                       fmt::format("no Verilated core can stand for {}; there are {}; take the reference board "
                                   "(--model reference), or add its name to sim/models.cmake",
                                   core.name, known));
}

}  // namespace haptogram::sim
