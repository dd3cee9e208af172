// SPDX-License-Identifier: Apache-2.0
// The host's side of a stream of patterns: each pulse at the pins is measured, and compared with the pattern of the
// carrier period in which it lies: its middle with the phase, its width with Hoshi et al. 2010, eq. 7.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <map>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include "../refusal.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/link/client.hpp"
#include "haptogram/link/device_thread.hpp"
#include "haptogram/link/pattern_stream.hpp"
#include "haptogram/link/transfer.hpp"
#include "haptogram/verbs/compile.hpp"
#include "reference_board.hpp"
#include "simulated_transport.hpp"

using namespace haptogram;

namespace {

constexpr long cycle = 1250;
constexpr unsigned channels = 100;

struct Drive {
    unsigned phase, amplitude;  ///< 256ths of the cycle, 255ths
};

/// Phases all round the cycle and hardly the same twice, but so near from period to period that pulses do not touch.
Drive drive(std::uint64_t period, unsigned channel) {
    const std::uint64_t mixed = (period * 1009 + channel) * 0x9e3779b97f4a7c15ULL;
    return {static_cast<unsigned>(channel * 37 % 150 + 40 + (mixed >> 56) % 20),
            static_cast<unsigned>(100 + (mixed >> 40) % 100)};
}

std::size_t fill(std::uint64_t period, std::span<std::uint16_t> patterns) {
    for (std::size_t i = 0; i < patterns.size(); ++i) {
        const auto [phase, amplitude] = drive(period + i / channels, static_cast<unsigned>(i % channels));
        patterns[i] = static_cast<std::uint16_t>(phase | amplitude << 8);
    }
    return patterns.size() / channels;
}

/// A board behind a network port, without loss, and the host's time that passes with it.
struct Bench {
    sim::ReferenceBoard board{"colorlight-5a-75e-v7.1-net"};
    sim::SimulatedTransport line{board};
    std::uint64_t period = ~std::uint64_t{0};  ///< at the pins; the first is 0
    std::map<std::uint64_t, unsigned> right;   ///< pulses of a period that are its pattern's
    std::uint64_t wrong = 0;

    Bench() {
        board.on_cycle_start([this](const sim::CycleStart& start) {
            begun_ = start.clock;
            ++period;
        });
        rises_.resize(channels);
        board.on_edge([this](const sim::Edge& edge) {
            if (edge.rises) {
                rises_[edge.channel] = static_cast<long>(edge.clock - begun_);
                return;
            }
            const long rise = rises_[edge.channel], fall = static_cast<long>(edge.clock - begun_);
            const auto [phase, amplitude] = drive(period, edge.channel);
            const double middle = cycle * phase / 256.0,
                         width = cycle * std::asin(amplitude / 255.0) / std::numbers::pi;
            const bool good = std::abs(0.5 * static_cast<double>(rise + fall) - middle) <= 2.0 &&
                              std::abs(static_cast<double>(fall - rise) - width) <= 2.0;
            if (good)
                ++right[period];
            else
                ++wrong;
        });
    }

private:
    std::uint64_t begun_ = 0;
    std::vector<long> rises_;
};

}  // namespace

TEST_CASE("a host's patterns play each in its own carrier period", "[reference]") {
    const char* const asked = std::getenv("HAPTOGRAM_PERIODS");
    const std::uint64_t wanted = asked != nullptr ? std::stoull(asked) : 10'000;
    Bench bench;
    link::Client client(bench.line);
    client.identify();
    std::uint64_t filled = 0;
    const auto source = [&](std::uint64_t period, std::span<std::uint16_t> patterns) -> std::optional<std::size_t> {
        if (filled >= wanted) return {};
        return filled += patterns.size() / channels, fill(period, patterns);
    };
    const link::PlayedPatterns played = play_patterns(client, {}, source);
    CHECK_FALSE(client.status().enabled);
    CHECK(played.sent >= wanted);
    std::uint64_t whole = 0;
    for (const auto& [period, pulses] : bench.right) whole += pulses == channels ? 1 : 0;
    CAPTURE(played.sent, played.late, played.lost, played.early, played.repeated, played.lead, bench.wrong);
    CHECK(whole == played.sent);
    CHECK(played.late + played.lost + played.early + played.repeated == 0);
    fmt::print("{} patterns sent, {} played in their own period, {} pulses elsewhere, lead {} periods\n", played.sent,
               whole, bench.wrong, played.lead);
}

TEST_CASE("what was played until a signal came is told", "[reference]") {
    Bench bench;
    link::Client client(bench.line);
    client.identify();
    std::uint64_t filled = 0;
    unsigned signals = 0;
    client.set_interrupt([&] { return signals; });
    const auto source = [&](std::uint64_t period, std::span<std::uint16_t> patterns) -> std::optional<std::size_t> {
        if ((filled += patterns.size() / channels) >= 1000) signals = 1;
        return fill(period, patterns);
    };
    const link::PlayedPatterns played = play_patterns(client, {}, source);
    CHECK(played.interrupted);
    CHECK(played.sent >= filled / 2);
    CHECK(played.sent <= filled);
    CHECK_FALSE(bench.board.outputs().enabled);
}

TEST_CASE("the least slots still play, and fewer are refused", "[reference]") {
    Bench bench;
    link::Client client(bench.line);
    client.identify();
    std::uint64_t filled = 0;
    const auto source = [&](std::uint64_t period, std::span<std::uint16_t> patterns) -> std::optional<std::size_t> {
        if (filled >= 500) return {};
        return filled += patterns.size() / channels, fill(period, patterns);
    };
    const link::PlayedPatterns played = play_patterns(client, {.slots = 16}, source);
    CHECK(played.sent >= 500);
    std::uint64_t whole = 0;
    for (const auto& [period, pulses] : bench.right) whole += pulses == channels ? 1 : 0;
    CHECK(whole + played.late + played.early >= 500);  // 16 periods are less than the time between two sendings
    for (const std::uint32_t slots : {8U, 24U}) CHECK_REFUSED(link::PatternStream(client, {.slots = slots}));
    CHECK_REFUSED(link::PatternStream(client, {.slots = 512}));
}
