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

Served serve(Board& board, PseudoTerminal& terminal, const ServeOptions& options,
             const std::function<bool(const Served&)>& watch) {
    using Clock = std::chrono::steady_clock;
    constexpr std::uint64_t slice = 2000;  // clocks, less than one byte at 115,200 baud
    constexpr double most_behind_s = 0.1;
    const double clock_hz = board.parameters().clock_hz;
    const auto begun = Clock::now();
    const auto wall = [begun] { return std::chrono::duration<double>(Clock::now() - begun).count(); };
    Served served;
    double given_up_s = 0.0;  // real time that a slow simulation has lost, and does not try to make up for
    const auto go_on = [&] {
        served.simulated_s = static_cast<double>(board.now()) / clock_hz;
        served.wall_s = wall();
        served.index = board.outputs().index;
        served.enabled = board.outputs().enabled;
        return watch(served) && (options.seconds == 0.0 || served.simulated_s < options.seconds);
    };
    while (go_on()) {
        const double ahead_s = served.simulated_s + given_up_s - wall();
        if (ahead_s < -most_behind_s) given_up_s -= ahead_s + most_behind_s;
        const bool waits = options.real_time && ahead_s > 1e-3;
        const auto arrived = terminal.read(std::chrono::milliseconds(waits ? static_cast<int>(1e3 * ahead_s) : 0));
        board.send(arrived);
        const double before_s = wall();
        board.run(slice);
        if (board.outputs().playing) {
            served.playing_clocks += slice;
            served.playing_s += wall() - before_s;
        }
        const auto answer = board.receive();
        terminal.write(answer);
        served.link.in(arrived);
        served.link.out(answer);
    }
    return served;
}

std::string_view model_with_channels(std::uint32_t channels, std::span<const interface::CoreConfiguration> models) {
    std::string known;
    for (const auto& [name, parameters, about] : models) {
        if (parameters.channels == channels) return name;
        known += fmt::format("{}{}", known.empty() ? "" : ", ", parameters.channels);
    }
    throw bad_argument("channels", fmt::format("no simulated board has {}; there are {}", channels, known));
}

}  // namespace haptogram::sim
