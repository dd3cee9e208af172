// SPDX-License-Identifier: Apache-2.0
// A simulated board with a client on its line and a recorder at its pins, for the co-simulation tests.
#pragma once
#include <catch2/catch.hpp>
#include <cstdint>
#include <optional>
#include <random>
#include <vector>

#include "board.hpp"
#include "board_transport.hpp"
#include "image/image.hpp"
#include "link/client.hpp"
#include "pulse_check.hpp"

namespace haptogram::test {

inline constexpr std::size_t tile100 = 0;  // 100 channels, 16 timing bits, 1 Mbaud
inline constexpr std::size_t small16 = 1;  // 16 channels, 12 timing bits, 3 Mbaud, watchdog 5 ms

struct Bench {
    sim::Board board;
    sim::PulseRecorder recorder;
    sim::BoardTransport line;
    link::Client client;

    explicit Bench(std::size_t model = small16, const sim::BoardOptions& options = {})
        : board(model, options), recorder(board), line(board), client(line) {}

    [[nodiscard]] std::uint32_t channels() const { return board.parameters().channels; }

    /// Puts records 1… and the sequence into the memories without the link.
    void load(const Image& image) {
        const auto primary = primary_words(image);
        for (std::size_t i = 0; i < primary.size(); ++i) board.primary_word(i) = primary[i];
        const auto sequence = sequence_words(image);
        for (std::size_t i = 0; i < sequence.size(); ++i) board.sequence_word(i) = sequence[i];
    }

    /// Starts a session that no watchdog ends, with outputs enabled.
    void open() {
        client.identify();
        client.set_watchdog(0);
        client.enable();
    }

    /// Runs until the pins' record is `index`; fails the test when it never is.
    void wait_for_index(std::uint16_t index, std::uint64_t limit = 2'000'000) {
        REQUIRE(board.run_until([&] { return board.outputs().index == index; }, limit));
    }

    /// Compares everything from the second cycle with outputs enabled to the last whole cycle with the image.
    [[nodiscard]] sim::PulseReport check(const Image& image) const {
        const auto& cycles = recorder.cycles();
        for (std::size_t i = 1; i < cycles.size(); ++i)
            if (cycles[i - 1].enabled && cycles[i].enabled)
                return sim::check_pulses(image, cycles, recorder.pulses(), cycles[i].clock, cycles.back().clock,
                                         channels());
        return {};
    }

    /// Pulses of one channel that rose in a span of clocks.
    [[nodiscard]] std::vector<Pulse> pulses(std::uint32_t channel, std::uint64_t from, std::uint64_t to) const {
        std::vector<Pulse> found;
        for (const Pulse& p : recorder.pulses())
            if (p.channel == channel && p.rise >= from && p.rise < to) found.push_back(p);
        return found;
    }
};

/// An image for a bench, with the given records and each of them for one cycle in the sequence.
inline Image image_of(std::uint32_t channels, std::vector<Record> records) {
    Image image;
    image.channels = channels;
    image.clock_hz = 50'000'000;
    image.records = std::move(records);
    for (std::size_t i = 1; i <= image.records.size(); ++i)
        image.sequence.push_back({static_cast<std::uint16_t>(i), 1});
    return image;
}

inline Record record(std::uint32_t channels, std::uint32_t cycle, std::uint32_t prescaler, std::uint8_t pulse,
                     std::uint16_t timing) {
    return {cycle, prescaler, pulse, std::vector<std::uint16_t>(channels, timing)};
}

/// Seeded by Catch's --rng-seed, which a failing run prints.
inline std::mt19937 generator() { return std::mt19937(Catch::rngSeed()); }

inline std::uint32_t random(std::mt19937& generator, std::uint32_t low, std::uint32_t high) {
    return low + static_cast<std::uint32_t>(generator()) % (high - low + 1);
}

inline Record random_record(std::mt19937& g, std::uint32_t channels, std::uint32_t cycle, std::uint32_t prescaler,
                            std::uint8_t pulse) {
    Record r{cycle, prescaler, pulse, {}};
    for (std::uint32_t k = 0; k < channels; ++k)
        r.timings.push_back(static_cast<std::uint16_t>(random(g, 0, cycle - 1)));
    return r;
}

/// A violation-free report that compared something.
inline void require_equal(const sim::PulseReport& report, std::uint64_t at_least) {
    for (const auto& line : report.first) UNSCOPED_INFO(line);
    REQUIRE(report.violations == 0);
    REQUIRE(report.checked >= at_least);
}

}  // namespace haptogram::test
