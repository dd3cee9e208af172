// SPDX-License-Identifier: Apache-2.0
// A simulated board with a client on its line and a recorder at its pins, for the co-simulation tests.
#pragma once
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <optional>
#include <random>
#include <span>
#include <string_view>
#include <vector>

#include "haptogram/format/image.hpp"
#include "haptogram/link/client.hpp"
#include "haptogram/link/outputs.hpp"
#include "haptogram/link/transfer.hpp"
#include "pulse_check.hpp"
#include "simulated_board.hpp"
#include "simulated_transport.hpp"

namespace haptogram::test {

using link::Bytes;

/// The model of this name. An executable with a netlist has no other model, so its tests run on that one.
inline std::string_view model_or_netlist(std::string_view name) {
    const auto& models = sim::available_models();
    return models.size() == 1 ? models.front().name : name;
}

/// Both small models in turn; an executable with one model would run each case twice on that.
inline std::string_view each_small_model() {
    if (sim::available_models().size() == 1) return sim::available_models().front().name;
    return GENERATE(as<std::string_view>{}, "small-16", "small-16-wide");
}

struct Bench {
    sim::SimulatedBoard board;
    sim::PulseRecorder recorder;
    sim::SimulatedTransport line;
    link::Client client;

    explicit Bench(std::string_view model = "small-16", const sim::SimulatedBoardOptions& options = {})
        : board(model_or_netlist(model), options), recorder(board), line(board), client(line) {
        client.begin_at(0);  // tests speak beside it
    }

    [[nodiscard]] std::uint32_t channels() const { return board.parameters().channels; }

    /// Puts records 1… and the sequence into the memories: beside the link where they can be reached, over it and with
    /// a reset behind it in a netlist.
    void load(const Image& image) {
        if (board.primary_memory().empty()) {
            link::Client loader(line);  // whose session the reset ends, so that the test's own client is as if new
            loader.identify();
            link::upload(loader, image);
            board.reset();
            return;
        }
        std::ranges::copy(primary_words(image), board.primary_memory().begin());
        std::ranges::copy(sequence_words(image), board.sequence_memory().begin());
    }

    /// Puts an image where the board finds it at power-up and plays it: into its memories, or into its flash. A reset
    /// must come behind it.
    void load_autostart(const Image& image) {
        if (board.parameters().sdram != 0)
            return board.write_flash(interface::flash_image::first, link::flash_image(image, true, "image"));
        load(image);
        interface::sequence_header_field::autostart.set(board.sequence_memory(), 1);
    }
    /// Clocks from the reset until it plays at the latest; a byte of flash takes 32.
    [[nodiscard]] std::uint64_t autostart_clocks() const { return board.parameters().sdram != 0 ? 80'000 : 3000; }

    /// Sends raw bytes and returns every reply; behind the last no byte comes for 60 µs.
    std::vector<link::Reply> talk(const Bytes& bytes) {
        board.send(bytes);
        REQUIRE(board.run_until([&] { return board.line_idle(); }, 10'000'000));
        std::size_t heard = 0;
        do {
            heard = board.received();
            board.run(3000);
        } while (board.received() != heard);
        std::vector<link::Reply> replies;
        link::ReplyDecoder decoder;
        decoder.feed(board.receive(), replies);
        REQUIRE(decoder.damaged() == 0);
        if (!replies.empty()) expected_ = replies.back().expected;
        return replies;
    }

    /// What the memories hold. Where they cannot be reached, a repeated frame asks, which changes only
    /// the counts of frames; talk() must have had a reply.
    [[nodiscard]] Bytes memory(std::uint32_t address, std::size_t bytes) {
        Bytes found;
        const bool primary = address < interface::sequence_base;
        for (std::uint32_t at = address; found.size() < bytes; at += 2) {
            if (board.primary_memory().empty()) {
                const auto part = std::min<std::size_t>(bytes - found.size(), 32);
                const Bytes read = ask(static_cast<std::uint32_t>(address + found.size()), part);
                found.insert(found.end(), read.begin(), read.end());
                continue;
            }
            const std::uint32_t half = (at - (primary ? interface::primary_base : interface::sequence_base)) / 2;
            const std::uint16_t word =
                primary ? board.primary_memory()[half]
                        : static_cast<std::uint16_t>(board.sequence_memory()[half / 2] >> half % 2 * 16);
            found.push_back(static_cast<std::uint8_t>(word));
            found.push_back(static_cast<std::uint8_t>(word >> 8));
        }
        return found;
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

private:
    Bytes ask(std::uint32_t address, std::size_t bytes) {
        const auto low = [&](unsigned shift) { return static_cast<std::uint8_t>(address >> shift); };
        const Bytes request = {low(0), low(8), low(16), low(24), static_cast<std::uint8_t>(bytes), 0};
        const auto replies = talk(
            link::encode_request(static_cast<std::uint8_t>(expected_.value() - 1), interface::Command::read, request));
        REQUIRE(replies.size() == 1);
        REQUIRE(replies[0].status == interface::Status::repeated);
        return replies[0].data;
    }

    std::optional<std::uint8_t> expected_;  // the board's, as the last reply had it
};

/// Words as they go over the link, low byte first.
inline Bytes words(std::span<const std::uint16_t> values) {
    Bytes bytes;
    for (const std::uint16_t value : values) {
        bytes.push_back(static_cast<std::uint8_t>(value));
        bytes.push_back(static_cast<std::uint8_t>(value >> 8));
    }
    return bytes;
}
inline Bytes words(std::initializer_list<std::uint16_t> values) {
    return words(std::span(values.begin(), values.size()));
}

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
