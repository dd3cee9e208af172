// SPDX-License-Identifier: Apache-2.0
// Contract 12: in a chain a frame reaches the tile that it names and no other, and every answer comes back whole and
// says whose it is, whatever the other tiles say meanwhile.
#include <array>
#include <deque>
#include <map>

#include "bench.hpp"
#include "haptogram/link/chain.hpp"
#include "haptogram/link/frame.hpp"

using namespace haptogram;
using namespace haptogram::test;
using link::Bytes;

namespace {

constexpr auto model = "small-16-sync";

/// The line to the first tile, with faults by order.
class Line final : public link::Transport {
public:
    explicit Line(sim::Tiles& tiles) : wire_(tiles, 0) {}
    void write(std::span<const std::uint8_t> bytes) override {
        Bytes out(bytes.begin(), bytes.end());
        if (spoil) spoil(out);
        wire_.write(out);
    }
    [[nodiscard]] std::vector<std::uint8_t> read(std::chrono::microseconds patience) override {
        auto bytes = wire_.read(patience);
        if (spoil) spoil(bytes);
        return bytes;
    }
    [[nodiscard]] std::chrono::microseconds patience() const override { return std::chrono::milliseconds(10); }

    std::function<void(Bytes&)> spoil;

private:
    sim::TileTransport wire_;
};

struct ChainBench {
    sim::SimulatedTiles tiles;
    Line* line;  // the chain owns it
    std::shared_ptr<link::Chain> chain;
    std::vector<std::unique_ptr<link::Transport>> ways;
    std::vector<std::unique_ptr<link::Client>> hosts;

    ChainBench(std::size_t boards, std::mt19937& random)
        : tiles(model, crystals(boards, 50.0, 0.0, random), static_cast<std::uint32_t>(random())) {
        tiles.chain();
        auto port = std::make_unique<Line>(tiles);
        line = port.get();
        chain = std::make_shared<link::Chain>(std::move(port));
    }

    /// Begins a session with each.
    void open() {
        for (unsigned i = 0; i < tiles.size(); ++i) {
            ways.push_back(chain->tile(i + 1));
            hosts.push_back(std::make_unique<link::Client>(*ways.back()));
            hosts.back()->identify();
        }
    }
    std::uint64_t retransmissions() const {
        std::uint64_t all = 0;
        for (const auto& host : hosts) all += host->retransmissions();
        return all;
    }
    void run_bits(double bits) { tiles.run(static_cast<Femtoseconds>(bits * 1e15 / tiles.board(0).parameters().baud)); }
};

/// Random writes and reads to random tiles, many under way at once; in the end each memory holds what its own host
/// wrote, and each read has told what was there.
/// @return reads that told something else: on a bad line one that is asked again may tell what was written since
std::size_t write_and_read(ChainBench& bench, std::size_t steps, std::mt19937& random) {
    const std::size_t words = bench.tiles.board(0).primary_memory().size();
    std::vector<std::vector<std::uint16_t>> expected(bench.tiles.size(), std::vector<std::uint16_t>(words, 0));
    for (std::size_t i = 0; i < bench.tiles.size(); ++i) std::ranges::fill(bench.tiles.board(i).primary_memory(), 0);
    std::size_t asked = 0, told = 0, wrong = 0;
    for (std::size_t step = 0; step < steps; ++step) {
        const std::size_t tile = random() % bench.tiles.size();
        const std::size_t count = 1 + random() % 20, first = random() % (words - count);
        const auto address = static_cast<std::uint32_t>(2 * first);
        Bytes payload;
        const auto put = [&payload](std::uint32_t word) {
            payload.push_back(static_cast<std::uint8_t>(word));
            payload.push_back(static_cast<std::uint8_t>(word >> 8U));
        };
        put(address & 0xffffU);
        put(address >> 16U);
        if (random() % 2 == 0) {
            for (std::size_t i = 0; i < count; ++i) {
                // Many zeros, since those are what COBS and the places of frames hang on.
                expected[tile][first + i] = random() % 3 == 0 ? 0 : static_cast<std::uint16_t>(random());
                put(expected[tile][first + i]);
            }
            bench.hosts[tile]->submit({interface::Command::write, payload});
        } else {
            put(static_cast<std::uint32_t>(2 * count));
            Bytes here;
            for (std::size_t i = 0; i < count; ++i) {
                here.push_back(static_cast<std::uint8_t>(expected[tile][first + i]));
                here.push_back(static_cast<std::uint8_t>(expected[tile][first + i] >> 8U));
            }
            ++asked;
            bench.hosts[tile]->submit({interface::Command::read, payload}, [&, here](const link::Reply& reply) {
                ++told;
                wrong += reply.data != here ? 1 : 0;
            });
        }
        bench.hosts[tile]->flush();
        if (random() % 4 == 0) bench.hosts[random() % bench.tiles.size()]->exchange(std::chrono::microseconds(20));
    }
    for (auto& host : bench.hosts) host->wait();
    CHECK(told == asked);
    for (std::size_t i = 0; i < bench.tiles.size(); ++i) {
        CAPTURE(i);
        CHECK(std::ranges::equal(bench.tiles.board(i).primary_memory(), expected[i]));
    }
    return wrong;
}

/// What is sent to all tiles at once, as it goes on the line.
Bytes to_all(std::uint8_t number, interface::Command command) {
    Bytes out{2, 253};
    const Bytes frame = link::encode_request(number, command, {});
    out.insert(out.end(), frame.begin(), frame.end());
    return out;
}

/// Answers by the tile that they say they are from.
std::map<unsigned, std::vector<link::Reply>> answers(std::span<const std::uint8_t> bytes) {
    std::map<unsigned, std::vector<link::Reply>> found;
    Bytes frame;
    for (const std::uint8_t byte : bytes) {
        frame.push_back(byte);
        if (byte != 0) continue;
        const Bytes whole = std::exchange(frame, {});
        if (whole.size() < 4) continue;
        REQUIRE(whole[0] % 2 == 1);
        REQUIRE(whole[1] == (((~whole[0]) & 0xfe) | 1));
        link::ReplyDecoder decoder;
        decoder.feed(std::span(whole).subspan(2), found[whole[0] / 2]);
        REQUIRE(decoder.damaged() == 0);
    }
    return found;
}

}  // namespace

TEST_CASE("contract 12: every frame reaches its tile, and every answer comes back whole", "[contract12]") {
    std::mt19937 random(Catch::rngSeed());
    ChainBench bench(2 + random() % 4, random);
    CAPTURE(Catch::rngSeed(), bench.tiles.size());
    bench.open();
    // What all have under way takes longer than the patience of one line.
    for (auto& host : bench.hosts) host->set_patience(std::chrono::milliseconds(200));
    CHECK(write_and_read(bench, 250, random) == 0);
    // Nothing was lost on the way, so nothing had to be sent again.
    CHECK(bench.retransmissions() == 0);
}

TEST_CASE("contract 12: what a bad line damages reaches nobody else", "[contract12]") {
    std::mt19937 random(Catch::rngSeed());
    ChainBench bench(3, random);
    CAPTURE(Catch::rngSeed());
    bench.open();
    std::size_t faults = 0;
    bench.line->spoil = [&](Bytes& bytes) {
        for (std::size_t i = 0; i < bytes.size(); ++i) {
            if (random() % 250 != 0) continue;
            ++faults;
            if (random() % 2 == 0)
                bytes[i] ^= static_cast<std::uint8_t>(1U << random() % 8);
            else
                bytes.erase(bytes.begin() + static_cast<std::ptrdiff_t>(i));
        }
    };
    // At first less than a round takes, and at most more than all have under way.
    const std::chrono::microseconds patience(1500);
    for (auto& host : bench.hosts) host->set_patience(patience, 128 * patience);
    write_and_read(bench, 60, random);
    CHECK(faults > 0);
}

TEST_CASE("contract 12: without a chain a board is alone, and passes nothing on", "[contract12]") {
    std::mt19937 random(Catch::rngSeed());
    CAPTURE(Catch::rngSeed());
    ChainBench bench(2, random);
    sim::TileTransport wire(bench.tiles, 0);
    link::Client host(wire);
    CHECK(host.identify().core().chain == 1);
    for (int i = 0; i < 20; ++i) CHECK(host.status().frames_damaged == 0);
    // The second one has heard none of these. It counts one frame for the first tile, from before it was told of the
    // chain, and the one that told it.
    bench.open();
    CHECK(bench.hosts[1]->status().frames_good == 2);
    CHECK(bench.hosts[1]->status().frames_damaged == 2);
}

TEST_CASE("contract 12: a board without chain takes the beginning of one for a damaged frame", "[contract12]") {
    sim::SimulatedTiles tiles("small-16", std::vector<sim::Oscillator>(1), Catch::rngSeed());
    sim::TileTransport wire(tiles, 0);
    wire.write(Bytes{0, 2, 253, 0});
    link::Client host(wire);
    CHECK(host.identify().core().chain == 0);
    CHECK(host.status().frames_damaged == 1);
}

TEST_CASE("contract 12: what is for all switches all off, and all answer", "[contract12]") {
    std::mt19937 random(Catch::rngSeed());
    CAPTURE(Catch::rngSeed());
    ChainBench bench(4, random);
    bench.open();
    for (auto& host : bench.hosts) {
        host->set_watchdog(0);
        host->enable();
    }
    for (std::size_t i = 0; i < 4; ++i) REQUIRE(bench.tiles.board(i).outputs().enabled);
    sim::TileTransport wire(bench.tiles, 0);
    const auto number = static_cast<std::uint8_t>(random());
    // The hosts chose their sessions' numbers at random, and an IDENTIFY with the same one would be a late copy.
    wire.write(to_all(static_cast<std::uint8_t>(number + 100), interface::Command::identify));
    bench.run_bits(10 * 4 * 120);
    static_cast<void>(wire.read(std::chrono::microseconds(0)));
    for (std::size_t i = 0; i < 4; ++i) REQUIRE(bench.tiles.board(i).outputs().enabled);
    wire.write(to_all(number, interface::Command::identify));
    wire.write(to_all(static_cast<std::uint8_t>(number + 1), interface::Command::disable));
    while (!bench.tiles.board(0).line_idle()) bench.run_bits(0.1);
    // Half a bit later with each tile, and within 20 clocks then.
    bench.run_bits(0.5 * 4 + 1 + 20 * 3e6 / 50e6);
    for (std::size_t i = 0; i < 4; ++i) CHECK_FALSE(bench.tiles.board(i).outputs().enabled);
    bench.run_bits(10 * 4 * 120);
    const auto told = answers(wire.read(std::chrono::microseconds(0)));
    REQUIRE(told.size() == 4);
    for (const auto& [tile, replies] : told) {
        CAPTURE(tile);
        REQUIRE(replies.size() == 2);
        CHECK(replies[1].command == interface::Command::disable);
        CHECK(replies[1].status == interface::Status::ok);
    }
}

// Tiles count the first two bytes of a frame, whatever they are, so a zero must stay a zero in each place.
TEST_CASE("contract 12: whatever bytes came before, a DISABLE for all behind a zero reaches all", "[contract12]") {
    std::mt19937 random(Catch::rngSeed());
    CAPTURE(Catch::rngSeed());
    ChainBench bench(3, random);
    bench.open();
    const auto below = [&random](unsigned count) { return static_cast<unsigned>(random()) % count; };
    for (int round = 0; round < 60; ++round) {
        for (auto& host : bench.hosts) {
            host->identify();  // whose numbers may have been used by what came before
            host->set_watchdog(0);
            host->enable();
        }
        for (std::size_t i = 0; i < 3; ++i) REQUIRE(bench.tiles.board(i).outputs().enabled);
        Bytes bytes{0x11};  // what it was found with
        if (round > 0) {
            bytes.clear();
            for (unsigned left = below(8); left > 0; --left)
                bytes.push_back(static_cast<std::uint8_t>(below(4) == 0 ? below(4) : random()));
        }
        CAPTURE(round, bytes);
        bytes.push_back(0);
        const Bytes off = to_all(77, interface::Command::disable);
        bytes.insert(bytes.end(), off.begin(), off.end());
        bench.tiles.board(0).send(bytes);
        while (!bench.tiles.board(0).line_idle()) bench.run_bits(0.1);
        bench.run_bits(0.5 * 3 + 1 + 20 * 3e6 / 50e6);
        for (std::size_t i = 0; i < 3; ++i) REQUIRE_FALSE(bench.tiles.board(i).outputs().enabled);
        bench.run_bits(10 * 3 * 120);
        static_cast<void>(sim::TileTransport(bench.tiles, 0).read(std::chrono::microseconds(0)));
    }
}

TEST_CASE("contract 12: a break turns all outputs off and ends the chain", "[contract12]") {
    std::mt19937 random(Catch::rngSeed());
    CAPTURE(Catch::rngSeed());
    ChainBench bench(3, random);
    bench.open();
    for (auto& host : bench.hosts) {
        host->set_watchdog(0);
        host->enable();
    }
    bench.tiles.board(0).force_line(false);
    bench.run_bits(20 + 3 * 0.5 + 2);
    for (std::size_t i = 0; i < 3; ++i) CHECK_FALSE(bench.tiles.board(i).outputs().enabled);
    bench.tiles.board(0).force_line({});
    bench.run_bits(20);
    sim::TileTransport wire(bench.tiles, 0);
    link::Client host(wire);
    CHECK(host.identify().channels == 16);
    // And it can be begun again.
    bench.hosts.clear();
    bench.ways.clear();
    bench.open();
    CHECK(write_and_read(bench, 20, random) == 0);
}

TEST_CASE("contract 12: a tile that falls silent in the middle of an answer holds nobody up", "[contract12]") {
    std::mt19937 random(Catch::rngSeed());
    CAPTURE(Catch::rngSeed());
    ChainBench bench(3, random);
    bench.open();
    const auto patience = std::chrono::microseconds(1000);
    for (auto& host : bench.hosts) host->set_patience(patience, patience);
    bench.hosts[1]->submit({interface::Command::read, Bytes{0, 0, 0, 0, 40, 0}});
    bench.hosts[1]->flush();
    bench.run_bits(120.0 + static_cast<double>(random() % 500));
    bench.tiles.cut_chain(1, true);
    for (int i = 0; i < 20; ++i) static_cast<void>(bench.hosts[0]->status());
    CHECK(bench.hosts[0]->retransmissions() <= 1);
    CHECK_THROWS_AS(bench.hosts[2]->status(), link::LinkLost);
    bench.tiles.cut_chain(1, false);
    bench.hosts[2]->identify();
    CHECK(bench.hosts[2]->status().frames_good > 0);
}
