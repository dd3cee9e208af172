// SPDX-License-Identifier: Apache-2.0
// What keeps a hand and an array safe when hosts, cables or images do what they should not.
#include <cstdlib>
#include <string>

#include "../refusal.hpp"
#include "../soak.hpp"
#include "bench.hpp"

using namespace haptogram;
using namespace haptogram::test;
using interface::Command;
using interface::Status;

namespace {

Bytes request(std::uint8_t number, Command command, std::initializer_list<std::uint16_t> arguments = {}) {
    return link::encode_request(number, command, words(arguments));
}

/// A bench that plays record 1, with outputs on and no watchdog. The next number is 4.
void play_one(Bench& bench, const Image& image) {
    bench.load(image);
    bench.open();
    bench.client.select(1);
    bench.wait_for_index(1);
    bench.board.run(3000);
    REQUIRE(bench.board.outputs().enabled);
}

Image dense() { return image_of(16, {record(16, 250, 1, 124, 0), record(16, 250, 1, 124, 100)}); }

/// So many requests for a whole record of memory, whose answers take a long time.
void ask(Bench& bench, std::uint8_t first, std::uint8_t count) {
    for (std::uint8_t i = 0; i < count; ++i)
        bench.board.send(request(static_cast<std::uint8_t>(first + i), Command::read, {0, 0, 40}));
}

void wait_sent(Bench& bench) {
    REQUIRE(bench.board.run_until([&] { return bench.board.line_idle(); }, 1'000'000));
}

}  // namespace

TEST_CASE("safety: DISABLE acts within 20 clocks of its last bit, whatever is being answered", "[safety]") {
    Bench bench;
    play_one(bench, dense());
    // An ENABLE before it must not switch on again when its turn comes.
    ask(bench, 4, 12);
    bench.board.send(request(16, Command::enable));
    bench.board.send(request(17, Command::disable));
    while (!bench.board.line_idle()) bench.board.run(1);
    bench.board.run(20);
    REQUIRE_FALSE(bench.board.outputs().enabled);
    REQUIRE_FALSE(bench.board.any_pin());
    // The answers are far from done, and nothing goes on again while they come.
    REQUIRE(bench.board.received() < 12 * 40);
    for (int i = 0; i < 400'000; ++i) {
        bench.board.run(1);
        REQUIRE_FALSE(bench.board.outputs().enabled);
    }
    std::vector<link::Reply> replies;
    link::ReplyDecoder decoder;
    decoder.feed(bench.board.receive(), replies);
    REQUIRE(replies.back().sequence == 17);
    REQUIRE(replies.back().status == Status::ok);
    // A new ENABLE works.
    REQUIRE(bench.talk(request(18, Command::enable))[0].status == Status::ok);
    REQUIRE(bench.board.outputs().enabled);
}

TEST_CASE("safety: each DISABLE counts until its own turn, and an ENABLE behind it holds", "[safety]") {
    Bench bench;
    play_one(bench, dense());
    ask(bench, 4, 6);
    bench.board.send(request(10, Command::disable));
    bench.board.send(request(11, Command::enable));
    ask(bench, 12, 4);
    bench.board.send(request(16, Command::stop));
    wait_sent(bench);
    bench.board.run(600'000);
    REQUIRE(bench.board.outputs().enabled);
    REQUIRE(bench.board.outputs().index == 0);
}

TEST_CASE("safety: DISABLE and STOP act whatever their number", "[safety]") {
    Bench bench;
    play_one(bench, dense());
    SECTION("applied before") {
        REQUIRE(bench.talk(request(4, Command::disable))[0].status == Status::ok);
        REQUIRE(bench.talk(request(5, Command::enable))[0].status == Status::ok);
        REQUIRE(bench.board.outputs().enabled);
        REQUIRE(bench.talk(request(4, Command::disable))[0].status == Status::repeated);
    }
    SECTION("128 behind") {
        REQUIRE(bench.talk(request(static_cast<std::uint8_t>(4 + 128), Command::disable))[0].status ==
                Status::repeated);
    }
    SECTION("127 ahead") {
        REQUIRE(bench.talk(request(static_cast<std::uint8_t>(4 + 127), Command::disable))[0].status ==
                Status::out_of_order);
    }
    SECTION("a STOP that was applied before, which ends what was begun since") {
        REQUIRE(bench.talk(request(4, Command::stop))[0].status == Status::ok);
        REQUIRE(bench.talk(request(5, Command::select, {1, 0}))[0].status == Status::ok);
        bench.wait_for_index(1);
        REQUIRE(bench.talk(request(4, Command::stop))[0].status == Status::repeated);
        REQUIRE(bench.board.outputs().index == 0);
        return;
    }
    REQUIRE_FALSE(bench.board.outputs().enabled);
    bench.board.run(100'000);
    REQUIRE_FALSE(bench.board.outputs().enabled);
}

TEST_CASE("safety: DISABLE and STOP do not wait for the IDENTIFY of another session", "[safety]") {
    Bench bench;
    play_one(bench, dense());
    ask(bench, 4, 8);
    bench.board.send(request(150, Command::identify));
    const bool stops = GENERATE(false, true);
    bench.board.send(request(151, stops ? Command::stop : Command::disable));
    while (!bench.board.line_idle()) bench.board.run(1);
    bench.board.run(stops ? 20 + 250 + 1 + 3 : 20);
    if (stops)
        REQUIRE(bench.board.outputs().index == 0);
    else
        REQUIRE_FALSE(bench.board.outputs().enabled);
    REQUIRE(bench.board.received() < 8 * 40);
}

TEST_CASE("safety: a DISABLE acts although there is no room for it", "[safety]") {
    Bench bench;
    play_one(bench, dense());
    // So many requests that the board's memory for frames is full, and stays so for long.
    ask(bench, 4, 100);
    bench.board.send(request(120, Command::disable));
    while (!bench.board.line_idle()) bench.board.run(1);
    bench.board.run(20);
    REQUIRE_FALSE(bench.board.outputs().enabled);
    bench.board.run(1'000'000);
    REQUIRE_FALSE(bench.board.outputs().enabled);
    static_cast<void>(bench.board.receive());
    link::Client host(bench.line);
    host.identify();
    REQUIRE(host.status().frames_damaged > 0);
}

TEST_CASE("safety: an ENABLE is on its way from its first start bit's edge on", "[safety]") {
    Bench bench;
    play_one(bench, dense());
    const unsigned bit = bench.board.parameters().clock_hz / bench.board.parameters().baud;
    bench.board.send(request(4, Command::watchdog, {0}));
    wait_sent(bench);
    bench.board.run(20'000);
    std::uint8_t number = 5;
    for (unsigned clocks = 1; clocks < 25 * bit; clocks += clocks < 12 * bit ? 1 : 7) {
        CAPTURE(clocks);
        bench.board.send(request(number++, Command::enable));
        bench.board.run(clocks);
        bench.board.press_stop(true);
        bench.board.run(1);
        bench.board.press_stop(false);
        wait_sent(bench);
        bench.board.run(4'000);
        REQUIRE_FALSE(bench.board.outputs().enabled);
        bench.board.send(request(number++, Command::enable));
        wait_sent(bench);
        bench.board.run(4'000);
        REQUIRE(bench.board.outputs().enabled);
    }
    // Nothing else is: neither what comes after it, nor behind a glitch.
    for (const bool glitches : {false, true}) {
        bench.board.press_stop(true);
        if (glitches) {
            bench.board.run(10);
            bench.board.force_line(false);
            bench.board.run(bit / 4);
            bench.board.force_line({});
        }
        bench.board.run(5);
        bench.board.press_stop(false);
        bench.board.run(glitches ? bit : 8);
        bench.board.send(request(number++, Command::enable));
        wait_sent(bench);
        bench.board.run(4'000);
        REQUIRE(bench.board.outputs().enabled);
    }
}

TEST_CASE("safety: a break ends half a frame, so what comes first behind it counts", "[safety]") {
    Bench bench;
    play_one(bench, dense());
    const double bit = static_cast<double>(bench.board.parameters().clock_hz) / bench.board.parameters().baud;
    bench.board.send(Bytes{9, 1, 2, 3});
    wait_sent(bench);
    bench.board.run(static_cast<std::uint64_t>(2 * bit));
    bench.board.force_line(false);
    bench.board.run(static_cast<std::uint64_t>(25 * bit));
    bench.board.force_line({});
    bench.board.run(100);
    REQUIRE_FALSE(bench.board.outputs().enabled);
    static_cast<void>(bench.board.receive());
    REQUIRE(bench.talk(request(4, Command::disable))[0].status == Status::ok);
}

// Whatever switches outputs off, an ENABLE that was sent before it does not switch them on when its turn comes.
TEST_CASE("safety: what was sent before a switch-off is answered and not done", "[safety]") {
    Bench bench;
    play_one(bench, dense());
    const double bit = static_cast<double>(bench.board.parameters().clock_hz) / bench.board.parameters().baud;
    const std::string by = GENERATE("break", "break in a frame", "stop input", "watchdog", "DISABLE");
    CAPTURE(by);
    bench.board.send(request(4, Command::watchdog, {by == "watchdog" ? std::uint16_t{1} : std::uint16_t{0}}));
    // What was applied before and only asks is answered again, but does not keep the watchdog quiet.
    const std::uint8_t number = by == "watchdog" ? 5 : 17;
    for (std::uint8_t i = 0; i < 12; ++i)
        bench.board.send(
            request(by == "watchdog" ? std::uint8_t{4} : static_cast<std::uint8_t>(5 + i), Command::read, {0, 0, 40}));
    const Bytes enable = request(number, Command::enable);
    const std::size_t last = by == "break in a frame" ? 1 : 0;
    bench.board.send(Bytes(enable.begin(), enable.end() - static_cast<std::ptrdiff_t>(last)));
    wait_sent(bench);
    bench.board.run(static_cast<std::uint64_t>(2 * bit));  // the last stop bit, too
    const auto hold = [&](bool level, double bits) {
        bench.board.force_line(level);
        bench.board.run(static_cast<std::uint64_t>(bits * bit));
        bench.board.force_line({});
    };
    if (by.starts_with("break")) hold(false, 25.0);
    if (by == "stop input") {
        bench.board.press_stop(true);
        bench.board.run(100);
        bench.board.press_stop(false);
    }
    if (by == "watchdog") REQUIRE(bench.board.run_until([&] { return !bench.board.outputs().enabled; }, 200'000));
    if (by == "DISABLE") bench.board.send(request(200, Command::disable));
    if (last != 0) {
        bench.board.run(100);
        bench.board.send(Bytes{0});
    }
    REQUIRE(bench.board.run_until([&] { return !bench.board.outputs().enabled; }, 10'000));
    REQUIRE(bench.board.received() < 12 * 40);
    bench.board.run_until([&] { return bench.board.outputs().enabled; }, 800'000);
    REQUIRE_FALSE(bench.board.outputs().enabled);
    std::vector<link::Reply> replies;
    link::ReplyDecoder decoder;
    decoder.feed(bench.board.receive(), replies);
    const auto answer = std::ranges::find(replies, Command::enable, &link::Reply::command);
    REQUIRE(answer != replies.end());
    REQUIRE(answer->status == Status::ok);
    // One that is sent afterwards does.
    REQUIRE(bench.talk(request(static_cast<std::uint8_t>(number + 1), Command::enable)).back().status == Status::ok);
    REQUIRE(bench.board.outputs().enabled);
}

// Anything may wait, or be half sent, when outputs are switched off; after that the host says nothing more.
TEST_CASE("safety: after a switch-off in a storm of commands nothing goes on by itself", "[safety][storm]") {
    auto g = generator();
    // `make soak` has the two minutes that sixty rounds take.
    const std::size_t rounds = soaked(60, 6);
    Bench bench(each_small_model());
    play_one(bench, dense());
    const auto byte = [&] { return static_cast<std::uint8_t>(random(g, 0, 255)); };
    const double bit = static_cast<double>(bench.board.parameters().clock_hz) / bench.board.parameters().baud;
    std::size_t waited = 0;
    for (std::size_t round = 0; round < rounds; ++round) {
        CAPTURE(round);
        std::uint8_t number = byte();
        bench.talk(request(number++, Command::identify));
        bench.talk(request(number++, Command::watchdog, {0}));
        bench.talk(request(number++, Command::enable));
        REQUIRE(bench.board.outputs().enabled);
        const std::uint32_t by = random(g, 0, 4);
        const bool expires = by == 3;
        if (expires) bench.board.send(request(number++, Command::watchdog, {1}));
        for (std::uint32_t left = random(g, 0, 14); left > 0; --left) {
            switch (random(g, 0, 9)) {
                case 0: bench.board.send(request(number++, Command::select, {1, 0})); break;
                case 1: bench.board.send(request(number++, Command::start, {1, 2, 0})); break;
                case 2: bench.board.send(request(number++, Command::push, {0, 1, 1})); break;
                case 3: bench.board.send(request(number = byte(), Command::identify)), ++number; break;
                case 4: bench.board.send(Bytes{random(g, 0, 1) == 0 ? std::uint8_t{0} : byte()}); break;
                case 5: bench.board.send(request(number++, Command::gate, {50, 0, 0})); break;
                default: bench.board.send(request(number++, Command::read, {0, 0, 40})); break;
            }
        }
        for (std::uint32_t left = random(g, 1, 3); left > 0; --left)
            bench.board.send(request(number++, Command::enable));
        if (by < 3) {  // at any bit of all that
            bench.board.run(random(g, 0, static_cast<std::uint32_t>(150 * bit * 10)));
            if (random(g, 0, 1) == 0) wait_sent(bench);
            bench.board.unplug();
            bench.board.run(static_cast<std::uint64_t>(12 * bit));  // so that a byte that was cut has ended
        }
        if (by == 0) {
            bench.board.force_line(false);
            bench.board.run(static_cast<std::uint64_t>(25 * bit));
            bench.board.force_line({});
        }
        if (by == 1) {
            bench.board.press_stop(true);
            bench.board.run(random(g, 5, 2000));
            bench.board.press_stop(false);
        }
        if (by == 2 || by == 4) bench.board.send(Bytes{0});
        if (by == 2) bench.board.send(request(byte(), Command::disable));
        if (by == 4) {  // in a session that another host begins
            bench.board.send(request(byte(), Command::identify));
            bench.board.send(request(byte(), Command::disable));
        }
        if (expires) {
            // What is newly applied keeps the watchdog quiet, so it may be long until it has expired.
            REQUIRE(bench.board.run_until([&] { return !bench.board.outputs().enabled; }, 3'000'000));
        } else {
            wait_sent(bench);
            bench.board.run(25);
        }
        REQUIRE_FALSE(bench.board.outputs().enabled);
        const std::size_t answered = bench.board.received();
        REQUIRE_FALSE(bench.board.run_until([&] { return bench.board.outputs().enabled; }, 700'000));
        waited += bench.board.received() > answered ? 1 : 0;
        static_cast<void>(bench.board.receive());
        bench.board.send(Bytes{0});
    }
    REQUIRE(waited > rounds / 6);  // so that something was still to be answered
}

TEST_CASE("safety: a DISABLE ahead of a lost frame acts although it is refused, and so does one before a session",
          "[safety]") {
    Bench bench;
    play_one(bench, dense());
    REQUIRE(bench.talk(request(7, Command::disable))[0].status == Status::out_of_order);
    REQUIRE_FALSE(bench.board.outputs().enabled);
    REQUIRE(bench.talk(request(4, Command::enable))[0].status == Status::ok);
    REQUIRE(bench.board.outputs().enabled);
    if (bench.board.sequence_memory().empty()) return;  // a netlist's memories cannot be filled before it starts
    Bench alone;
    alone.load_autostart(dense());
    alone.board.reset();
    alone.wait_for_index(1);
    REQUIRE(alone.board.outputs().enabled);
    static_cast<void>(alone.talk(request(200, Command::disable)));
    REQUIRE_FALSE(alone.board.outputs().enabled);
}

TEST_CASE("safety: STOP acts at the next cycle boundary, whatever is being answered", "[safety]") {
    Bench bench;
    play_one(bench, dense());
    // What was sent before it must not start to play when its turn comes.
    ask(bench, 4, 8);
    bench.board.send(request(12, Command::select, {2, 0}));
    bench.board.send(request(13, Command::push, {0, 2, 2}));
    bench.board.send(request(14, Command::start, {1, 2, 0}));
    bench.board.send(request(15, Command::stop));
    while (!bench.board.line_idle()) bench.board.run(1);
    bench.board.run(20 + 250 + 1 + 3);
    REQUIRE(bench.board.outputs().index == 0);
    REQUIRE(bench.board.outputs().enabled);
    REQUIRE(bench.board.received() < 8 * 40);
    for (int i = 0; i < 400'000; ++i) {
        bench.board.run(1);
        REQUIRE(bench.board.outputs().index == 0);
    }
    const auto replies = bench.talk(request(16, Command::select, {2, 0}));
    REQUIRE(replies.back().status == Status::ok);
    REQUIRE(replies.back().live_level == 0);
    REQUIRE(bench.board.outputs().index == 2);
}

TEST_CASE("safety: a line break disables, a byte of zeros does not, nor a line that was never connected", "[safety]") {
    Bench bench;
    play_one(bench, dense());
    const double bit = 50e6 / 3e6;
    for (int i = 0; i < 20; ++i) bench.board.send(Bytes{0x00});
    wait_sent(bench);
    REQUIRE(bench.board.outputs().enabled);
    bench.board.force_line(false);
    bench.board.run(static_cast<std::uint64_t>(18 * bit));
    bench.board.force_line({});
    bench.board.run(1000);
    REQUIRE(bench.board.outputs().enabled);
    bench.board.force_line(false);
    bench.board.run(static_cast<std::uint64_t>(20 * bit) + 5);
    REQUIRE_FALSE(bench.board.outputs().enabled);
    REQUIRE_FALSE(bench.board.any_pin());
    bench.board.run(10'000);
    REQUIRE_FALSE(bench.board.outputs().enabled);
    bench.board.force_line({});
    bench.board.run(1000);
    bench.client.enable();
    REQUIRE(bench.board.outputs().enabled);

    if (bench.board.sequence_memory().empty()) return;
    Bench alone;
    alone.load_autostart(dense());
    alone.board.force_line(false);
    alone.board.reset();
    alone.board.run(100'000);
    REQUIRE(alone.board.outputs().enabled);
}

TEST_CASE("safety: the stop input is the last word on outputs, and ENABLE says so", "[safety]") {
    Bench bench;
    play_one(bench, dense());
    bench.board.press_stop(true);
    bench.board.run(5);
    REQUIRE_FALSE(bench.board.outputs().enabled);
    REQUIRE_FALSE(bench.board.any_pin());
    REQUIRE(bench.client.status().stopped);
    REQUIRE_REFUSED(bench.client.enable());
    REQUIRE_FALSE(bench.board.outputs().enabled);
    bench.board.press_stop(false);
    bench.board.run(100'000);
    REQUIRE_FALSE(bench.board.outputs().enabled);
    REQUIRE_FALSE(bench.client.status().stopped);
    bench.client.enable();
    REQUIRE(bench.board.run_until([&] { return bench.board.any_pin(); }, 1000));
}

TEST_CASE("safety: while outputs are off, no long cycle delays a change of record", "[safety][contract6]") {
    Bench bench;
    Image image = image_of(16, {record(16, 0x800001, 5, 200, 0), record(16, 250, 1, 124, 0)});  // 0.84 s a cycle
    bench.load(image);
    bench.open();
    bench.client.select(1);
    bench.wait_for_index(1, 20'000'000);
    SECTION("asked for before") {
        bench.client.select(2);
        bench.board.run(100'000);
        REQUIRE(bench.board.outputs().index == 1);
        bench.client.disable();
    }
    SECTION("asked for afterwards") {
        bench.client.disable();
        bench.client.select(2);
    }
    bench.board.run(2000);
    REQUIRE(bench.board.outputs().index == 2);
    // Until the record is loaded the cycle goes on: only the change itself may come right after a start.
    std::size_t adjacent = 0;
    const auto& cycles = bench.recorder.cycles();
    for (std::size_t i = 1; i < cycles.size(); ++i) adjacent += cycles[i].clock - cycles[i - 1].clock == 1 ? 1 : 0;
    REQUIRE(adjacent <= 1);
    const std::uint64_t enabled = bench.board.now();
    bench.client.enable();
    bench.board.run(5000);
    for (const Pulse& p : bench.recorder.pulses())
        if (p.rise > enabled) REQUIRE((p.index == 2 && p.fall - p.rise == 124));
    REQUIRE(bench.recorder.pulses().back().rise > enabled);
}

TEST_CASE("safety: while outputs are off, a sequence keeps its time", "[safety][contract6]") {
    Bench bench;
    Image image = dense();
    image.sequence = {{1, 5}, {2, 3}};
    bench.load(image);
    bench.client.identify();
    bench.client.start(1, 2, 40);
    bench.board.run(30'000);
    const std::vector<sim::Dwell> dwells = bench.recorder.dwells();
    std::size_t seen = 0;
    for (std::size_t i = 1; i + 1 < dwells.size(); ++i) {  // the first and the last may be parts
        if (dwells[i].index == 0) continue;
        ++seen;
        REQUIRE(dwells[i].cycles == (dwells[i].index == 1 ? 5 : 3));
        REQUIRE(dwells[i].end - dwells[i].begin == dwells[i].cycles * 250ULL);
    }
    REQUIRE(seen > 10);
}

TEST_CASE("safety: RESET leaves nothing but memories and session", "[safety]") {
    Bench bench;
    const Image image = dense();
    play_one(bench, image);
    bench.client.set_watchdog(77);
    bench.client.push({1, 2, 1, 2}, 0);
    bench.client.reset();
    REQUIRE_FALSE(bench.board.outputs().enabled);
    REQUIRE_FALSE(bench.board.any_pin());
    bench.board.run(100'000);
    const link::Status status = bench.client.status();
    REQUIRE(status.mode == interface::Mode::idle);
    REQUIRE(status.watchdog_ms == bench.board.parameters().watchdog_ms);
    REQUIRE(status.live_level == 0);
    REQUIRE(status.frames_good <= 2);
    REQUIRE(bench.board.outputs().index == 0);
    bench.client.set_watchdog(0);
    bench.client.enable();
    bench.client.start(1, 2, 0);
    bench.wait_for_index(2);
    const std::uint64_t begin = bench.recorder.cycles().back().clock;
    bench.board.run(10'000);
    require_equal(sim::check_pulses(image, bench.recorder.cycles(), bench.recorder.pulses(), begin,
                                    bench.recorder.cycles().back().clock, 16),
                  16 * 30);
}

TEST_CASE("safety: only what is newly applied keeps the watchdog quiet", "[safety][watchdog]") {
    Bench bench;
    play_one(bench, dense());
    bench.client.set_watchdog(2);
    const std::uint64_t limit = bench.board.now() + 2 * 50'000 + 2;
    Bytes bytes;
    SECTION("a repeated frame does not") { bytes = request(4, Command::watchdog, {2}); }
    SECTION("nor does IDENTIFY, with which a scan begins") { bytes = request(9, Command::identify); }
    SECTION("nor does a refused frame") { bytes = request(5, Command::select, {999, 0}); }
    while (bench.board.now() < limit) {
        bench.board.send(bytes);
        bench.board.run(10'000);
    }
    REQUIRE_FALSE(bench.board.outputs().enabled);
    REQUIRE(bench.board.outputs().fault);
}

TEST_CASE("safety: KEEP_ALIVE keeps the watchdog quiet and does nothing else", "[safety][watchdog]") {
    Bench bench;
    play_one(bench, dense());
    bench.client.set_watchdog(1);
    for (int i = 0; i < 20; ++i) {
        bench.board.run(30'000);
        bench.client.keep_alive();
        REQUIRE(bench.board.outputs().enabled);
        REQUIRE(bench.board.outputs().index == 1);
    }
}

TEST_CASE("safety: an ENABLE that comes as the watchdog expires holds, or does not switch on again",
          "[safety][watchdog][slow]") {
    std::uint64_t expires = 0;
    {
        Bench bench;
        play_one(bench, dense());
        bench.client.set_watchdog(1);
        while (!bench.board.outputs().fault) bench.board.run(1);
        expires = bench.board.now();
    }
    const Bytes enable = request(5, Command::enable);
    const auto frame = static_cast<std::uint64_t>(static_cast<double>(10 * enable.size()) * 50e6 / 3e6);
    bool before = false;
    bool after = false;
    for (std::uint64_t early = frame; early < frame + 80; ++early) {
        Bench bench;
        play_one(bench, dense());
        bench.client.set_watchdog(1);
        bench.board.run(expires - early - bench.board.now());
        bench.board.send(enable);
        bool fell = false;
        for (std::uint64_t i = 0; i < frame + 100; ++i) {
            bench.board.run(1);
            fell = fell || !bench.board.outputs().enabled;
        }
        REQUIRE(bench.board.outputs().enabled == !fell);
        (fell ? after : before) = true;
    }
    REQUIRE(before);  // so that the clock in question lay between
    REQUIRE(after);
}

TEST_CASE("safety: a STOP in the clocks after RESET leaves a START by the header what it is", "[safety][slow]") {
    const Bytes stop = request(9, Command::stop);
    const auto frame = static_cast<std::uint64_t>(static_cast<double>(10 * stop.size()) * 50e6 / 3e6);
    const auto begin = [&](Bench& bench) {
        play_one(bench, dense());
        ask(bench, 4, 4);  // RESET waits behind the answers, STOP does not
        bench.board.send(request(8, Command::reset));
        return bench.board.now();
    };
    std::uint64_t resets = 0;
    {
        Bench bench;
        begin(bench);
        while (bench.board.outputs().enabled) bench.board.run(1);
        resets = bench.board.now();
    }
    for (std::uint64_t early = frame - 20; early < frame + 10; ++early) {
        CAPTURE(early);
        Bench bench;
        const std::uint64_t now = begin(bench);
        bench.board.run(resets - early - now);
        bench.board.send(stop);
        bench.board.run(20'000);
        static_cast<void>(bench.board.receive());
        link::Client host(bench.line);
        host.identify();
        host.enable();
        host.start(1, 0, 0);
        bench.wait_for_index(1, 100'000);
    }
}

TEST_CASE("safety: START by a header whose length is out of range is refused", "[safety]") {
    Bench bench;
    bench.load(dense());
    bench.board.reset();  // so that the header is looked at
    bench.open();
    bench.client.start(1, 0, 0);
    for (const std::uint16_t bad : {std::uint16_t{0}, std::uint16_t{64}, std::uint16_t{0x7fff}}) {
        bench.client.write(interface::sequence_base, words({bad, 0}));
        REQUIRE_REFUSED(bench.client.start(1, 0, 0));
    }
    bench.client.write(interface::sequence_base, words({2, 0}));
    bench.client.stop();
    bench.client.start(1, 0, 0);
    bench.wait_for_index(2);
}

TEST_CASE("safety: an autostart goes on after a reset, until a host has taken over", "[safety]") {
    Bench bench;
    if (bench.board.sequence_memory().empty()) return;  // a netlist's memories cannot be filled before it starts
    bench.load_autostart(dense());
    const auto starts = [&] {
        bench.board.reset();
        bench.board.run(bench.autostart_clocks());
        return bench.board.outputs().enabled && bench.board.outputs().playing;
    };
    REQUIRE(starts());
    REQUIRE(starts());
    bench.client.identify();
    REQUIRE(bench.client.status().enabled);
    REQUIRE(starts());  // a host that only asks
    link::Client host(bench.line);
    host.identify();
    host.stop();
    REQUIRE_FALSE(starts());
    REQUIRE_FALSE(starts());
}

TEST_CASE("safety: the board says its bounds and keeps to them", "[safety][tile100]") {
    Bench bench("tile-100");
    const interface::CoreParameters p = bench.board.parameters();
    const link::Identity identity = bench.client.identify();
    REQUIRE(identity.min_pulse_clocks == p.min_pulse_clocks);
    REQUIRE(identity.max_duty_256 == p.max_duty_256);
    REQUIRE(identity.max_pulse_clocks == (p.max_high_clocks / 2 - 2) / 5);
    REQUIRE(identity.max_cycle_clocks == p.clock_hz);
    REQUIRE(identity.core().max_high_clocks <= p.max_high_clocks);
    struct Case {
        std::uint32_t cycle, prescaler;
        std::uint8_t pulse;
        bool plays;
    };
    for (const Case& c : {Case{250, 5, 125, true}, Case{250, 5, 126, false}, Case{1250, 1, 4, false},
                          Case{1250, 1, 5, true}, Case{625, 2, 2, false}, Case{625, 2, 3, true}, Case{250, 5, 0, true},
                          Case{500, 9, 111, true}, Case{500, 9, 112, false}, Case{400, 5, 199, true},
                          Case{400, 5, 200, false}, Case{12'500'000, 4, 3, true}, Case{12'500'001, 4, 3, false}}) {
        CAPTURE(c.cycle, c.prescaler, static_cast<int>(c.pulse));
        const Image image = image_of(100, {record(100, c.cycle, c.prescaler, c.pulse, 3)});
        const std::uint16_t before = bench.client.status().refused_records;
        bench.load(image);
        bench.client.select(1);
        bench.board.run(5000);
        REQUIRE((bench.client.status().refused_records == before) == c.plays);
        if (c.pulse > 0 && c.cycle < 1'000'000) {
            if (c.plays)
                REQUIRE_NOTHROW(link::require_fits(image, identity, "image"));
            else
                REQUIRE_REFUSED(link::require_fits(image, identity, "image"));
        }
    }
}

TEST_CASE("safety: the pin for a monostable changes as long as there is a clock", "[safety]") {
    Bench bench;
    std::uint64_t changed = bench.board.now();
    bool level = bench.board.outputs().alive;
    std::size_t changes = 0;
    for (int i = 0; i < 200'000; ++i) {
        bench.board.run(1);
        if (bench.board.outputs().alive == level) continue;
        level = !level;
        if (changes++ > 0) REQUIRE(bench.board.now() - changed == 9999);
        changed = bench.board.now();
    }
    REQUIRE(changes >= 19);
}
