// SPDX-License-Identifier: Apache-2.0
// What a host does when a board or its line lies: it ends, says why, and leaves no outputs on.
#include <sys/resource.h>

#include <catch2/catch.hpp>
#include <random>
#include <set>

#include "../refusal.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/link/chain.hpp"
#include "haptogram/link/client.hpp"
#include "haptogram/link/live_feed.hpp"
#include "haptogram/link/outputs.hpp"
#include "haptogram/link/play.hpp"
#include "haptogram/link/rig.hpp"
#include "haptogram/link/transfer.hpp"
#include "lying_board.hpp"

using namespace haptogram;
using namespace haptogram::link;
using namespace haptogram::test;
using namespace std::chrono_literals;
using interface::Command;

namespace {

Request read_of(std::uint8_t mark, std::uint16_t bytes = 8) {
    return {Command::read, {mark, 0, 0, 0, static_cast<std::uint8_t>(bytes), static_cast<std::uint8_t>(bytes >> 8)}};
}

template <class Work>
ErrorCode code_of(Work work) {
    try {
        work();
    } catch (const Error& error) {
        return error.code();
    }
    return ErrorCode::failed;
}

std::vector<Reply> nothing(const Reply&) { return {}; }

/// Turns the outputs on, and then the line becomes bad.
template <class Work>
void on_and_then(Client& client, std::uint16_t watchdog_ms, Work work) {
    while_on(client, watchdog_ms, [&] {
        work();
        while (true) static_cast<void>(client.status());
    });
}

}  // namespace

TEST_CASE("lies: when all answers are lost, disable is sent, and that nobody confirmed it is an error", "[link]") {
    LyingBoard board;
    Client client(board);
    const auto lose = [&] { board.lie = nothing; };
    REQUIRE_REFUSED(on_and_then(client, 250, lose));
    REQUIRE_FALSE(board.enabled);
    REQUIRE(board.heard_of(Command::disable));
    REQUIRE(board.heard_of(Command::stop));
    LyingBoard other;
    Client second(other);
    const auto lose_there = [&] { other.lie = nothing; };
    REQUIRE_REFUSED(on_and_then(second, 0, lose_there));
    REQUIRE_FALSE(other.enabled);
}

TEST_CASE("lies: what was played and not confirmed to be off is an error of the device, not a success", "[link]") {
    LyingBoard board;
    Client client(board);
    REQUIRE(code_of([&] { while_on(client, 500, [&] { board.lie = nothing; }); }) == ErrorCode::device);
    LyingBoard good;
    Client other(good);
    REQUIRE_FALSE(while_on(other, 500, [] {}));
    REQUIRE_FALSE(good.enabled);
    REQUIRE(good.breaks == 0);
}

TEST_CASE("lies: a board that hears nothing any more is shut off by a break", "[link]") {
    LyingBoard board;
    Client client(board);
    REQUIRE_REFUSED(on_and_then(client, 0, [&] { board.hears = [] { return false; }; }));
    REQUIRE(board.breaks >= 1);
    REQUIRE_FALSE(board.enabled);
}

TEST_CASE("lies: shutting off needs no session, and any answer to disable confirms it", "[link]") {
    LyingBoard board;
    board.enabled = true;
    board.watchdog_ms = 0;
    Client client(board);
    REQUIRE(client.turn_off());
    REQUIRE_FALSE(board.enabled);
    REQUIRE_FALSE(board.heard_of(Command::identify));
    client.keep_alive();  // a session is begun before what comes next
    REQUIRE(board.heard_of(Command::identify));
    // In the midst of a window whose answers are lost.
    board.lie = nothing;
    for (int i = 0; i < 100; ++i) client.submit(read_of(1));
    client.exchange(1ms);
    board.lie = [](Reply reply) { return std::vector{std::move(reply)}; };
    board.heard.clear();
    REQUIRE(client.turn_off());
    REQUIRE(board.heard.front().command == Command::disable);
}

TEST_CASE("lies: nothing is sent behind a stop that is not answered", "[link]") {
    LyingBoard board;
    Client client(board);
    client.identify();
    board.lie = nothing;
    client.submit({Command::write, {0, 0, 0, 0, 1, 1}});
    client.submit({Command::stop, {}});
    client.submit({Command::disable, {}});
    client.submit({Command::select, {1, 0, 0, 0}});
    client.exchange(1s);
    REQUIRE(board.heard_of(Command::stop));
    REQUIRE(board.heard_of(Command::disable));
    REQUIRE_FALSE(board.heard_of(Command::select));
    board.lie = [](Reply reply) { return std::vector{std::move(reply)}; };
    client.wait();
    REQUIRE(board.heard.back().command == Command::select);
}

TEST_CASE("lies: sessions begin at a random number", "[link]") {
    std::set<std::uint8_t> numbers;
    for (int i = 0; i < 20; ++i) {
        LyingBoard board;
        Client client(board);
        client.identify();
        numbers.insert(board.heard.front().number);
    }
    REQUIRE(numbers.size() > 5);
}

TEST_CASE("lies: a port that talks of other things is given up like a silent one", "[link]") {
    std::mt19937 g(Catch::rngSeed());
    const bool text = GENERATE(true, false);
    LyingBoard board;
    board.hears = [] { return false; };
    board.babbles = [&] {
        if (text) return Bytes{'$', 'G', 'P', 'G', 'G', 'A', '\r', '\n'};
        Bytes bytes(g() % 64);
        for (auto& byte : bytes) byte = static_cast<std::uint8_t>(g());
        return bytes;
    };
    Client client(board);
    REQUIRE_REFUSED(client.identify());
    REQUIRE(board.time < 4s);
    REQUIRE_FALSE(client.turn_off());
    REQUIRE(board.breaks >= 1);
}

TEST_CASE("lies: an answer that is always lost ends the link, without a flood", "[link]") {
    LyingBoard board;
    Client client(board);
    client.identify();
    board.lie = [](Reply reply) {
        const bool lost = reply.command == Command::read && !reply.data.empty() && reply.data[0] == 7;
        return lost ? std::vector<Reply>{} : std::vector{std::move(reply)};
    };
    std::vector<Request> requests;
    for (std::uint8_t i = 0; i < 30; ++i) requests.push_back(read_of(i));
    const nanoseconds begun = board.time;
    REQUIRE_THROWS_AS(client.pipeline(requests), LinkLost);
    REQUIRE(board.time - begun < 12s);
    REQUIRE(board.heard.size() < 40 * interface::link_policy::window);
}

TEST_CASE("lies: answers in another order still bring everything, without a flood", "[link]") {
    LyingBoard board;
    Client client(board);
    client.identify();
    std::optional<Reply> kept;
    board.lie = [&](Reply reply) {
        if (!kept) {
            kept = std::move(reply);
            return std::vector<Reply>{};
        }
        return std::vector<Reply>{std::move(reply), *std::exchange(kept, {})};
    };
    std::vector<Request> requests;
    for (std::uint8_t i = 0; i < 100; ++i) requests.push_back(read_of(i));
    const std::vector<Reply> replies = client.pipeline(requests);
    for (std::uint8_t i = 0; i < 100; ++i) REQUIRE(replies[i].data == Bytes(8, i));
    REQUIRE(board.heard.size() < 5 * 100 * interface::link_policy::window);
}

TEST_CASE("lies: when one answer is lost, only its request goes again", "[link]") {
    LyingBoard board;
    Client client(board);
    client.identify();
    unsigned reads = 0, told = 0;
    board.lie = [&](Reply reply) {
        const bool lost = reply.command == Command::read && ++reads == 1;
        return lost ? std::vector<Reply>{} : std::vector{std::move(reply)};
    };
    board.heard.clear();
    std::vector<unsigned> order;
    for (unsigned i = 0; i < 4; ++i)
        client.submit(read_of(static_cast<std::uint8_t>(i)), [&order, i](const Reply&) { order.push_back(i); });
    client.wait();
    for (const LyingBoard::Heard& frame : board.heard) told += frame.command == Command::read ? 1 : 0;
    CHECK(order == std::vector<unsigned>{0, 1, 2, 3});
    CHECK(told == 5);
    CHECK(client.retransmissions() == 1);
}

TEST_CASE("lies: an identity is believed within the ranges of the interface only", "[link]") {
    struct Lie {
        unsigned word;
        std::uint16_t value;
        const char* field;
    };
    for (const Lie& lie : std::vector<Lie>{{9, 0, "CHANNELS"},          {9, 1, "CHANNELS"},
                                           {9, 1001, "CHANNELS"},       {10, 0, "RECORDS"},
                                           {11, 0, "SEQUENCE_DEPTH"},   {11, 1, "SEQUENCE_DEPTH"},
                                           {12, 0, "LIVE_DEPTH"},       {12, 1, "LIVE_DEPTH"},
                                           {12, 2, "LIVE_DEPTH"},       {12, 3, "LIVE_DEPTH"},
                                           {12, 255, "LIVE_DEPTH"},     {12, 65535, "LIVE_DEPTH"},
                                           {13, 0, "TIMING_BITS"},      {13, 0x0910, "PULSE_BITS"},
                                           {15, 0, "CLOCK_HZ"},         {15, 0xffff, "CLOCK_HZ"},
                                           {17, 4, "frame_bytes"},      {18, 0, "MIN_PULSE_CLOCKS"},
                                           {19, 0, "MIN_PULSE_CLOCKS"}, {20, 0, "MAX_DUTY_256"},
                                           {20, 256, "MAX_DUTY_256"},   {22, 0xffff, "max_cycle_clocks"},
                                           {23, 3, "WIDTH_BITS"},       {24, 9, "FOCI"},
                                           {25, 3, "MODULATION_DEPTH"}}) {
        LyingBoard board;
        board.identity = identity_block({{lie.word, lie.value}});
        Client client(board);
        INFO(lie.field << " " << lie.value);
        REQUIRE_REFUSED(client.identify());
        REQUIRE(code_of([&] { client.identify(); }) == ErrorCode::device);
    }
    for (const std::size_t bytes : {0U, 1U, 16U, 18U, 50U}) {
        LyingBoard board;
        board.identity.resize(bytes);
        Client client(board);
        REQUIRE(code_of([&] { client.identify(); }) == ErrorCode::device);
    }
}

TEST_CASE("lies: a name goes to the terminal in letters", "[link]") {
    LyingBoard board;
    board.identity[0] = 0x1b;
    board.identity[1] = '[';
    Client client(board);
    REQUIRE_REFUSED(client.identify());
}

TEST_CASE("lies: answers of another length than was asked for are errors that say so", "[link]") {
    LyingBoard board;
    Client client(board);
    client.identify();
    const int by = GENERATE(-1, 1, 1000, -8);
    const Command of = GENERATE(Command::read, Command::digest, Command::status, Command::keep_alive);
    if (by < 0 && of == Command::keep_alive) return;
    board.lie = [&](Reply reply) {
        if (reply.command == of)
            reply.data.resize(static_cast<std::size_t>(std::max(0, static_cast<int>(reply.data.size()) + by)));
        return std::vector{std::move(reply)};
    };
    const auto ask = [&] {
        if (of == Command::read) static_cast<void>(client.read(0, 8));
        if (of == Command::digest) client.request({of, read_of(0).payload});
        if (of == Command::status) static_cast<void>(client.status());
        if (of == Command::keep_alive) client.keep_alive();
    };
    REQUIRE_REFUSED(ask());
    REQUIRE(code_of(ask) == ErrorCode::device);
}

TEST_CASE("lies: a status or a level that no board can have is an error", "[link]") {
    LyingBoard board;
    Client client(board);
    client.identify();
    board.role = 3;
    REQUIRE_REFUSED(client.status());
    board.role = 0;
    board.lie = [](Reply reply) {
        if (reply.command != Command::identify) reply.live_level = 65535;
        return std::vector{std::move(reply)};
    };
    REQUIRE_REFUSED(LiveFeed(client, client.identity()));
}

TEST_CASE("lies: after a signal nothing is enabled, ever", "[link]") {
    unsigned signals = 0;
    const std::string when = GENERATE("identify", "watchdog", "late", "enable");
    LyingBoard board;
    board.on_frame = [&](const LyingBoard::Heard& frame) {
        if (to_string(frame.command) == when) signals = 1;
    };
    if (when == "late") {
        board.late = [] { return nanoseconds(500ms); };
        board.on_frame = [&](const LyingBoard::Heard&) { signals = 1; };
    }
    Client client(board);
    client.set_interrupt([&] { return signals; });
    bool interrupted = false;
    try {
        client.identify();
        interrupted = while_on(client, 500, [&] {
            while (true) static_cast<void>(client.status());
        });
    } catch (const Interrupted&) {
        interrupted = true;
    }
    REQUIRE(interrupted);
    REQUIRE_FALSE(board.enabled);
    board.pass(60s);
    REQUIRE_FALSE(board.enabled);
    if (when != "enable") REQUIRE_FALSE(board.heard_of(Command::enable));
    REQUIRE_THROWS_AS(client.enable(), Error);
    if (when != "enable") REQUIRE_FALSE(board.heard_of(Command::enable));
}

TEST_CASE("lies: after a signal a silent board is waited for two seconds at most, after a second one not at all",
          "[link]") {
    const unsigned second = GENERATE(1U, 2U);
    unsigned signals = 0;
    LyingBoard board;
    Client client(board);
    client.set_interrupt([&] { return signals; });
    nanoseconds asked{0};
    const auto play = [&] {
        signals = second;
        board.hears = [] { return false; };
        asked = board.time;
    };
    REQUIRE_REFUSED(on_and_then(client, 500, play));
    // What cleans up is told at once.
    REQUIRE_THROWS_AS(client.modulate(0, 0, false), LinkLost);
    REQUIRE(board.time - asked < (second == 1 ? nanoseconds(2s) : nanoseconds(50ms)));
    REQUIRE(board.breaks == 1);
    REQUIRE_FALSE(board.enabled);
}

TEST_CASE("lies: after a signal what cleans up can still be done", "[link]") {
    unsigned signals = 0;
    LyingBoard board;
    Client client(board);
    client.set_interrupt([&] { return signals; });
    REQUIRE(while_on(client, 500, [&] {
        signals = 1;
        static_cast<void>(client.status());
    }));
    client.write(0, {1, 2});
    REQUIRE(board.heard.back().command == Command::write);
}

TEST_CASE("lies: 1 % of drops and 200 ms of jitter trip no watchdog of 500 ms", "[link]") {
    std::mt19937 g(Catch::rngSeed());
    LyingBoard board;
    board.late = [&] { return nanoseconds(std::chrono::microseconds(g() % 100'000)); };  // 200 ms there and back
    Client client(board);
    client.identify();
    while_on(client, 500, [&] {
        board.hears = [&] { return g() % 100 != 0; };
        board.lie = [&](Reply reply) { return g() % 100 == 0 ? std::vector<Reply>{} : std::vector{std::move(reply)}; };
        const nanoseconds until = board.time + 120s;
        while (board.time < until) {
            static_cast<void>(client.status());
            board.pass(100ms);
        }
    });
    REQUIRE(board.trips == 0);
}

TEST_CASE("lies: something new is said every 100 ms while an answer is late", "[link]") {
    LyingBoard board;
    Client client(board);
    client.identify();
    while_on(client, 500, [&] {
        board.lie = [&](Reply reply) {
            return reply.command == Command::read ? std::vector<Reply>{} : std::vector{std::move(reply)};
        };
        client.submit(read_of(1));
        const nanoseconds until = board.time + 700ms;
        while (board.time < until) client.exchange(300ms);
        board.lie = [](Reply reply) { return std::vector{std::move(reply)}; };
        client.wait();
    });
    REQUIRE(board.trips == 0);
    REQUIRE(std::ranges::count(board.heard, Command::keep_alive, &LyingBoard::Heard::command) >= 6);
}

TEST_CASE("lies: a device that comes back and answers nothing more has not come back", "[link]") {
    LyingBoard board;
    board.its_patience = 20ms;
    board.lie = [](Reply reply) {
        return reply.command == Command::identify ? std::vector{std::move(reply)} : std::vector<Reply>{};
    };
    Image image;
    image.channels = 100;
    image.clock_hz = 50'000'000;
    image.records.push_back({1250, 1, 100, std::vector<std::uint16_t>(100, 1)});
    image.sequence.push_back({1, 1});
    const nanoseconds begun = board.time;
    const auto connect = [&]() -> std::unique_ptr<Commands> {
        auto client = std::make_unique<Client>(board);
        client->identify();
        return client;
    };
    REQUIRE_REFUSED(upload(connect, image, {.image = "image", .port = "port", .wait_s = 0.2}));
    REQUIRE(board.time - begun < 2500ms);
}

TEST_CASE("lies: an upload of which one digest is never answered ends", "[link]") {
    LyingBoard board;
    const auto silent = GENERATE(0U, 7U, 30U);
    unsigned digests = 0;
    std::uint8_t number = 0;
    board.lie = [&](Reply reply) {
        if (reply.command == Command::identify) digests = 0;
        if (reply.command != Command::digest) return std::vector{std::move(reply)};
        if (digests++ == silent) number = reply.sequence;
        return digests > silent && reply.sequence == number ? std::vector<Reply>{} : std::vector{std::move(reply)};
    };
    Image image;
    image.channels = 100;
    image.clock_hz = 50'000'000;
    for (int i = 0; i < 60; ++i) image.records.push_back({1250, 1, 100, std::vector<std::uint16_t>(100, 1)});
    image.sequence.push_back({1, 1});
    const nanoseconds begun = board.time;
    const auto connect = [&]() -> std::unique_ptr<Commands> {
        auto client = std::make_unique<Client>(board);
        client->identify();
        return client;
    };
    REQUIRE_REFUSED(upload(connect, image, {.image = "image", .port = "port", .wait_s = 15.0}));
    REQUIRE(board.time - begun < 35s);
}

TEST_CASE("lies: a link is lost after ten seconds, however long the patience has grown", "[link]") {
    LyingBoard board;
    Client client(board);
    client.identify();
    board.late = [] { return nanoseconds(900ms); };
    client.set_patience(300ms, 2s);
    for (int i = 0; i < 3; ++i) client.request({Command::keep_alive, {}});
    REQUIRE(client.slowness() > 2);
    board.hears = [] { return false; };
    const nanoseconds begun = board.time;
    REQUIRE_THROWS_AS(client.request({Command::keep_alive, {}}), LinkLost);
    CHECK((board.time - begun) / 1ms >= 9000);
    CHECK((board.time - begun) / 1ms <= 11000);
}

TEST_CASE("lies: what a line loses is asked for again within the line's patience, however often", "[link]") {
    LyingBoard board;
    board.its_patience = 10ms;
    Client client(board);
    client.identify();
    std::mt19937 g(Catch::rngSeed());
    const auto loses = [&g] { return g() % 20 == 0; };
    board.hears = [&] { return !loses(); };
    board.lie = [&](Reply reply) { return loses() ? std::vector<Reply>{} : std::vector{std::move(reply)}; };
    const nanoseconds begun = board.time;
    for (int i = 0; i < 1000; ++i) client.request({Command::keep_alive, {}});
    REQUIRE(client.retransmissions() > 50);
    CHECK(client.slowness() == 1);
    CHECK((board.time - begun) / 1ms <= 12 * static_cast<long>(client.retransmissions()) + 1000);
}

TEST_CASE("lies: a slow spell makes a client no more patient than twice what an answer took", "[link]") {
    LyingBoard board;
    Client client(board);
    client.identify();
    board.late = [] { return 600ms; };  // each way: four frames go out four times before the first answer
    for (int i = 0; i < 4; ++i) client.submit({Command::keep_alive, {}});
    client.wait(0);
    board.late = [] { return 0ms; };
    for (int i = 0; i < 4; ++i) client.request({Command::keep_alive, {}});
    REQUIRE(client.retransmissions() >= 4);
    CHECK(client.slowness() > 1);
    CHECK(client.slowness() <= 2 * 1200 / 300);
}

TEST_CASE("lies: a rig whose master's count of periods stands still is told so, and can be interrupted", "[link]") {
    using interface::Feature;
    const auto features = static_cast<std::uint16_t>(15U | 1U << static_cast<unsigned>(Feature::schedule) |
                                                     1U << static_cast<unsigned>(Feature::sync));
    LyingBoard boards[2];
    std::vector<std::unique_ptr<Client>> clients;
    Image image;
    std::vector<Tile> tiles;
    unsigned signals = 0;
    for (LyingBoard& board : boards) {
        board.identity = identity_block({{16, features}});
        board.timed = true;
        board.period = 1234;
        clients.push_back(std::make_unique<Client>(board));
        clients.back()->set_interrupt([&] { return signals; });
        clients.back()->identify();
        tiles.push_back({*clients.back(), image, clients.size() == 1 ? "tile 1" : "tile 2"});
    }
    REQUIRE_REFUSED(keep_together(tiles));
    boards[0].on_frame = [&](const auto&) { signals = 1; };
    REQUIRE_THROWS_AS(keep_together(tiles), Interrupted);
}

TEST_CASE("lies: a line without an end of a frame fills no memory", "[link]") {
    const auto used_kib = [] {
        rusage usage{};
        getrusage(RUSAGE_SELF, &usage);
        return usage.ru_maxrss;
    };
    ReplyDecoder decoder;
    std::vector<Reply> replies;
    auto line = std::make_unique<LyingBoard>();
    line->babbles = [] { return Bytes(1 << 16, 0x55); };
    const auto chain = std::make_shared<Chain>(std::move(line));
    const auto tile = chain->tile(1);
    const auto before = used_kib();
    for (int i = 0; i < 1000; ++i) decoder.feed(Bytes(1 << 16, 0x55), replies);
    for (int i = 0; i < 1000; ++i) REQUIRE(tile->read(std::chrono::microseconds(1)).empty());
    REQUIRE(used_kib() - before < 16 << 10);
}
