// SPDX-License-Identifier: Apache-2.0
// The reference board against the Verilated core: the same bytes at the same clocks, and what they answer and show.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <cstdlib>

#include "../soak.hpp"
#include "clock.hpp"
#include "lock_step.hpp"
#include "reference_board.hpp"
#include "simulated_board.hpp"

using namespace haptogram;
using namespace haptogram::test;

namespace {

enum class Sync {
    none,
    any,   ///< the wire is driven, and the host says all roles
    slave  ///< the board is in step before the first random command, and nothing resets it
};

void send(LockStep& boards, std::uint8_t number, interface::Command command, const std::vector<std::uint8_t>& payload) {
    boards.both([&](sim::Board& board) { board.send(link::encode_request(number, command, payload)); });
}

/// Runs random commands on both boards until they differ, or until `commands` are sent and enough pulses were compared.
/// In one run of six the tile's first 300 commands start few pulses or none (81 runs; the worst needed 1,064 commands).
/// A run that needs ten times as many fails.
void compare(std::string_view configuration, std::uint64_t commands, std::uint32_t seed, bool pins = true,
             Sync sync = Sync::none) {
    sim::SimulatedBoard core(configuration);
    sim::ReferenceBoard reference(configuration);
    LockStep boards(core, reference, pins);
    RandomHost host(boards, seed);
    Wire wire(sim::carrier_period(core.parameters()), seed);
    if (sync != Sync::none) boards.wire = &wire;
    if (sync == Sync::slave) {
        host.new_image();
        send(boards, 77, interface::Command::identify, {});
        send(boards, 78, interface::Command::sync, {static_cast<std::uint8_t>(interface::Role::slave), 0});
        const std::string difference = boards.run(600ULL * sim::carrier_period(core.parameters()));
        INFO(difference);
        REQUIRE(difference.empty());
        host.keeps_role = true;
    }
    const auto compared = [&] { return !pins || boards.edges > 5 * commands; };
    while (host.commands < commands || (!compared() && host.commands < 10 * commands)) {
        const std::string difference = host.step();
        INFO(difference);
        INFO(fmt::format("{}, seed {}, command {}, clock {}", configuration, seed, host.commands, core.now()));
        REQUIRE(difference.empty());
    }
    fmt::print(
        "{}, seed {}: {} commands, {} replies, {} of them applied, {} images, {} edges, {} cycles, {} clocks; in step "
        "{} times, with the master's number {} times, {} losses\n",
        configuration, seed, host.commands, host.replies, host.applied, host.images, boards.edges, boards.cycles,
        core.now(), host.in_step, host.numbered, host.losses);
    const bool wide = core.parameters().width_bits != 0;
    if (wide)
        fmt::print("    {} cycles of foci, {} times modulated, {} bent, {} with a far focus, {} PUSH_FOCI\n",
                   boards.focus_cycles, host.modulated, host.bent, host.far, host.pushed_foci);
    if (core.parameters().stream != 0) {
        fmt::print("    {} times a stream played, with late {}, lost {}, early {}, repeated {} patterns\n",
                   host.streaming, host.late, host.lost, host.early, host.repeated);
        if (commands >= 3000)
            for (const std::uint64_t count : {host.streaming, host.late, host.lost, host.early, host.repeated})
                REQUIRE(count > 0);
    }
    if (core.parameters().trigger != 0) {
        fmt::print("    {} changes of the trigger output\n", boards.triggers);
        REQUIRE((commands < 3000 || boards.triggers > commands / 200));
    }
    if (wide && commands >= 3000) {
        REQUIRE(boards.focus_cycles > 0);
        REQUIRE(host.modulated > 0);
        REQUIRE(host.bent > 0);
        REQUIRE(host.far > 0);
        REQUIRE(host.pushed_foci > 0);
        REQUIRE(host.quick_records > 0);
    }
    if (sync == Sync::slave) {
        REQUIRE(host.in_step > 0);
        REQUIRE(host.numbered > 0);
    }
    REQUIRE(host.applied > host.commands / 8);
    REQUIRE(compared());
}

std::uint64_t size(std::uint64_t full, std::uint64_t quick) {
    if (const char* asked = std::getenv("HAPTOGRAM_COMMANDS")) return std::strtoull(asked, nullptr, 10);
    return soaked(full, quick);
}

}  // namespace

TEST_CASE("reference: no reply and no pulse differs from the small core's") {
    compare("small-16", size(100'000, 5'000), Catch::rngSeed());
}

TEST_CASE("reference: no reply and no pulse differs from the small core's behind a network port") {
    compare("small-16-net", size(100'000, 1'500), Catch::rngSeed());
}

TEST_CASE("reference: a STOP and a break of the network act at the same clock") {
    std::mt19937 random(Catch::rngSeed());
    for (int round = 0; round < 300; ++round) {
        sim::SimulatedBoard core("small-16-net");
        sim::ReferenceBoard reference("small-16-net");
        LockStep boards(core, reference, false);
        std::vector<std::uint16_t> record(20, 0);
        interface::record_field::cycle_length.set(record, 1250);
        interface::record_field::prescaler.set(record, 1);
        interface::record_field::kind.set(record, 1);
        boards.both([&](sim::Board& board) { std::ranges::copy(record, board.primary_memory().begin()); });
        const bool on = random() % 2 != 0, breaks = random() % 2 != 0, stops = random() % 2 != 0;
        const bool lost = random() % 4 == 0, ends = random() % 4 == 0, waits = random() % 2 != 0;
        send(boards, 0, interface::Command::identify, {});
        if (on) send(boards, 1, interface::Command::enable, {});
        send(boards, on ? 2 : 1, interface::Command::select, {1, 0, 0, 0});
        std::string difference = boards.run(3000 + random() % 4000);
        if (waits) {  // in the port
            const std::vector<std::uint8_t> noise(200, 0x55);
            boards.both([&](sim::Board& board) { board.send(noise), board.send(std::vector<std::uint8_t>{0}); });
            for (unsigned number = 10; number < 16; ++number)
                send(boards, static_cast<std::uint8_t>(number),
                     random() % 2 != 0 ? interface::Command::enable : interface::Command::status, {});
            if (difference.empty()) difference = boards.run(random() % 300);
            if (random() % 4 == 0) {
                boards.both([](sim::Board& board) { board.press_stop(true); });
                if (difference.empty()) difference = boards.run(1 + random() % 50);
                boards.both([](sim::Board& board) { board.press_stop(false); });
            }
        }
        boards.both([&](sim::Board& board) {
            if (breaks) board.network_break();
            if (stops) board.network_stop();
            if (lost) board.network_lost();
            if (ends) board.network_end();
        });
        if (random() % 2 != 0) send(boards, on ? 3 : 2, interface::Command::stop, {});
        if (difference.empty()) difference = boards.run(4000);
        INFO(difference);
        INFO(fmt::format("on {}, breaks {}, stops {}, round {}", on, breaks, stops, round));
        REQUIRE(difference.empty());
    }
}

TEST_CASE("reference: of a stream of timings that ends, a pattern plays in its own period or not at all") {
    constexpr std::uint16_t first = 10, slots = 16;
    constexpr std::uint64_t cycle = 1250;
    sim::SimulatedBoard core("small-16-net");
    std::vector<sim::CycleStart> starts;
    core.on_cycle_start([&](const sim::CycleStart& start) { starts.push_back(start); });
    std::vector<std::uint16_t> record(20, 100);
    std::fill_n(record.begin(), interface::record_header_words, 0);
    interface::record_field::cycle_length.set(record, cycle);
    interface::record_field::prescaler.set(record, 1);
    interface::record_field::pulse_length.set(record, 100);
    for (std::size_t slot = 0; slot < slots; ++slot)
        std::ranges::copy(record, core.primary_memory().begin() + static_cast<std::ptrdiff_t>(20 * (first - 1 + slot)));
    const auto say = [&](std::uint8_t number, interface::Command command, const std::vector<std::uint8_t>& payload) {
        core.send(link::encode_request(number, command, payload));
    };
    const auto bytes = [](std::initializer_list<std::uint32_t> values) {
        std::vector<std::uint8_t> all;
        for (const std::uint32_t value : values)
            all.insert(all.end(), {static_cast<std::uint8_t>(value), static_cast<std::uint8_t>(value >> 8)});
        return all;
    };
    std::uint8_t number = 0;
    unsigned played = 0, dropped = 0;
    for (std::uint64_t before = 2200; before > 40; before -= 30) {
        const std::uint8_t session = number;
        say(number++, interface::Command::identify, {});
        say(number++, interface::Command::watchdog, bytes({0}));
        say(number++, interface::Command::write, bytes({0, 0x9000, first, 4, 0, 65535}));
        say(number++, interface::Command::enable, {});
        core.run(4 * cycle);
        const std::uint64_t period = starts.size() + 5, begins = starts.back().clock + 5 * cycle;
        std::vector<std::uint8_t> pattern = bytes({static_cast<std::uint32_t>(period & 0xffff), 0, 0});
        pattern.resize(6 + 32, 1);
        say(session, interface::Command::stream, pattern);
        core.run(begins - before - core.now());
        const std::size_t from = starts.size();
        if (before % 60 == 40)
            say(number++, interface::Command::identify, {});
        else
            say(number++, interface::Command::write, bytes({4, 0x9000, 0}));
        core.run(12 * cycle);
        bool seen = false;
        for (std::size_t k = from; k < starts.size(); ++k) {
            if (starts[k].index == 0 || starts[k].index == starts[from - 1].index) continue;
            if (!seen) {
                CAPTURE(before, k, period, starts[k].index);
                CHECK(k + 1 == period);
            }
            seen = true;
        }
        ++(seen ? played : dropped);
        say(number++, interface::Command::stop, {});
        core.run(4 * cycle);
    }
    CHECK(played > 5);
    CHECK(dropped > 5);
}

TEST_CASE("reference: a board that plays by itself plays on when its network is lost, until a host has taken over") {
    sim::SimulatedBoard core("small-16-net");
    sim::ReferenceBoard reference("small-16-net");
    LockStep boards(core, reference);
    std::vector<std::uint16_t> record(20, 0);
    interface::record_field::cycle_length.set(record, 1250);
    interface::record_field::prescaler.set(record, 1);
    interface::record_field::pulse_length.set(record, 100);
    boards.both([&](sim::Board& board) {
        std::ranges::copy(record, board.primary_memory().begin());
        board.sequence_memory()[0] = 1U << 15 | 1;
        board.sequence_memory()[1] = 1U << 16 | 1;
        board.reset(4);
    });
    const auto on_after = [&](std::uint64_t clocks) {
        const std::string difference = boards.run(clocks);
        INFO(difference);
        REQUIRE(difference.empty());
        return core.outputs().enabled;
    };
    const auto loses = [&] { boards.both([](sim::Board& board) { board.network_lost(); }); };
    REQUIRE(on_after(5000));
    loses();
    REQUIRE(on_after(5000));
    send(boards, 3, interface::Command::identify, {});  // which only asks
    REQUIRE(on_after(5000));
    loses();
    REQUIRE(on_after(5000));
    send(boards, 4, interface::Command::identify, {});
    send(boards, 5, interface::Command::keep_alive, {});
    REQUIRE(on_after(5000));
    loses();
    REQUIRE_FALSE(on_after(5000));
}

TEST_CASE("reference: no reply and no pulse differs from the tile's") {
    compare("tile-100", size(100'000, 300), Catch::rngSeed());
}

TEST_CASE("reference: no reply, no pulse and no edge of SYNC differs, whatever a board's role") {
    compare("tile-100-sync", size(100'000, 600), Catch::rngSeed(), true, Sync::any);
}

TEST_CASE("reference: no reply and no pulse of a slave differs, in step or not") {
    compare("tile-100-sync", size(100'000, 600), Catch::rngSeed(), true, Sync::slave);
}

TEST_CASE("reference: no reply of a slave differs when nobody looks at the pins") {
    compare("tile-100-sync", size(100'000, 1'000), Catch::rngSeed(), false, Sync::slave);
}

TEST_CASE("reference: no reply differs when nobody looks at the pins") {
    compare("small-16", size(100'000, 1'000), Catch::rngSeed() + 1, false);
}

TEST_CASE("reference: no reply differs with amplitudes when nobody looks at the pins") {
    compare("small-16-wide", size(100'000, 1'000), Catch::rngSeed() + 1, false);
}

TEST_CASE("reference: pulses that merge at every change trip the guard at the same clock") {
    sim::SimulatedBoard core("small-16");
    sim::ReferenceBoard reference("small-16");
    const bool pins = GENERATE(true, false);
    LockStep boards(core, reference, pins);
    std::vector<std::uint16_t> record(20, interface::silent_timing);
    interface::record_field::cycle_length.set(record, 20);
    interface::record_field::pulse_length.set(record, 19);
    interface::record_field::prescaler.set(record, 100);
    interface::record_field::kind.set(record, 0);
    record[4 + 5] = 7;
    boards.both([&](sim::Board& board) {
        std::ranges::copy(record, board.primary_memory().begin());
        for (std::uint32_t i = 1; i <= 2; ++i) board.sequence_memory()[i] = 1U | 1U << 16;
        board.send(link::encode_request(0, interface::Command::identify, {}));
        board.send(link::encode_request(1, interface::Command::watchdog, std::vector<std::uint8_t>{0, 0}));
        board.send(link::encode_request(2, interface::Command::enable, {}));
        board.send(link::encode_request(3, interface::Command::start, std::vector<std::uint8_t>{1, 0, 2, 0, 0, 0}));
    });
    for (std::uint8_t round = 0; round < 4; ++round) {
        REQUIRE(boards.run(60'000).empty());
        REQUIRE(core.outputs().fault);
        boards.both([&](sim::Board& board) {
            board.send(link::encode_request(static_cast<std::uint8_t>(4 + 2 * round), interface::Command::status, {}));
            board.send(link::encode_request(static_cast<std::uint8_t>(5 + 2 * round), interface::Command::enable, {}));
        });
    }
}

TEST_CASE("reference: one wrong timing in one record is noticed") {
    sim::SimulatedBoard core("small-16");
    sim::ReferenceBoard reference("small-16");
    LockStep boards(core, reference);
    const std::vector<std::uint16_t> record = {250, 20 << 8, 1, 0,  1,  2,  3,  4,  5,  6,
                                               7,   8,       9, 10, 11, 12, 13, 14, 15, 16};
    boards.both([&](sim::Board& board) { std::ranges::copy(record, board.primary_memory().begin()); });
    SECTION("equal") {}
    SECTION("a timing") { reference.primary_memory()[7] = 44; }
    SECTION("the last timing") { reference.primary_memory()[19] = 17; }
    SECTION("the pulse") { reference.primary_memory()[1] = 21 << 8; }
    const bool equal = std::ranges::equal(core.primary_memory(), reference.primary_memory());
    boards.both([](sim::Board& board) {
        board.send(link::encode_request(0, interface::Command::identify, {}));
        board.send(link::encode_request(1, interface::Command::enable, {}));
        board.send(link::encode_request(2, interface::Command::select, std::vector<std::uint8_t>{1, 0, 0, 0}));
    });
    REQUIRE(boards.run(30'000).empty() == equal);
    REQUIRE(boards.edges > 1000);
}

TEST_CASE("reference: in one go or clock by clock, with or without an audience, it does the same") {
    const auto seed = Catch::rngSeed();
    const auto play = [&](bool watched, bool by_clocks) {
        sim::ReferenceBoard board("small-16");
        Seen seen;
        board.on_arrival([&](const sim::Arrival& a) { seen.arrivals.push_back(a); });
        board.on_cycle_start([&](const sim::CycleStart& c) { seen.cycles.push_back(c); });
        if (watched) board.on_edge([&](const sim::Edge& e) { seen.edges.push_back(e); });
        std::mt19937 g(seed);
        for (auto& word : board.primary_memory()) word = static_cast<std::uint16_t>(g() % 250);
        for (std::size_t i = 0; i < board.primary_memory().size(); i += 20) {
            const std::vector<std::uint16_t> head = {250, static_cast<std::uint16_t>((1 + g() % 249) << 8), 1, 0};
            std::ranges::copy(head, board.primary_memory().begin() + static_cast<std::ptrdiff_t>(i));
        }
        std::uint8_t number = 0;
        const auto send = [&](interface::Command command, const std::vector<std::uint8_t>& payload = {}) {
            board.send(link::encode_request(number++, command, payload));
        };
        send(interface::Command::identify);
        send(interface::Command::watchdog, {0, 0});
        for (int i = 0; i < 200; ++i) {
            send(interface::Command::enable);
            std::vector<std::uint8_t> push = {1, 0};
            for (int k = 0; k < 5; ++k) push.insert(push.end(), {static_cast<std::uint8_t>(1 + g() % 40), 0});
            send(interface::Command::push, push);
            const std::uint64_t clocks = 9000 + g() % 2000;
            for (std::uint64_t done = 0; done < clocks; done += by_clocks ? 1 : clocks)
                board.run(by_clocks ? 1 : clocks);
            // A look at the pins in the middle must change nothing.
            if (i % 7 == 0) seen.arrivals.push_back({board.now(), static_cast<std::uint8_t>(board.outputs().pins[0])});
        }
        return seen;
    };
    const Seen once = play(true, false);
    const Seen stepped = play(true, true);
    const Seen alone = play(false, false);
    REQUIRE(once.edges == stepped.edges);
    REQUIRE(once.cycles == stepped.cycles);
    REQUIRE(once.arrivals == stepped.arrivals);
    REQUIRE(once.cycles == alone.cycles);
    REQUIRE(once.arrivals == alone.arrivals);
    REQUIRE(once.edges.size() > 10'000);
}

TEST_CASE(
    "reference: no reply and no pulse differs from the small core's with amplitudes, modulation, slew limit and foci") {
    compare("small-16-wide", size(100'000, 1'500), Catch::rngSeed());
}

TEST_CASE("reference: no reply and no pulse differs from the small core's in a chain") {
    compare("small-16-sync", size(100'000, 3'000), Catch::rngSeed(), true, Sync::any);
}

TEST_CASE("reference: no reply, no pulse and no edge of SYNC differs from those of the tile with everything") {
    compare("tile-100-wide", size(100'000, 300), Catch::rngSeed(), true, Sync::any);
}
