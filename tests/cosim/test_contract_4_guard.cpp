// SPDX-License-Identifier: Apache-2.0
#include "bench.hpp"

using namespace haptogram;
using namespace haptogram::test;

namespace {

/// Clocks from when `off` is first seen to when every pin is low, watched clock by clock.
std::uint64_t clocks_until_low(Bench& bench, const std::function<bool()>& off, std::uint64_t limit = 1'000'000) {
    for (std::uint64_t i = 0; !off(); ++i) {
        REQUIRE(i < limit);
        bench.board.run(1);
    }
    const std::uint64_t begin = bench.board.now();
    while (bench.board.any_pin()) bench.board.run(1);
    return bench.board.now() - begin;
}

/// A bench on which at least one pin is high at almost every clock.
void play_dense(Bench& bench) {
    Image image = image_of(16, {record(16, 250, 1, 125, 0)});
    for (std::uint16_t k = 0; k < 16; ++k) image.records[0].timings[k] = static_cast<std::uint16_t>(k * 15);
    bench.load(image);
    bench.client.identify();
    bench.client.enable();
    bench.client.select(1);
    bench.wait_for_index(1);
    bench.board.run(1000);
}

}  // namespace

TEST_CASE("contract 4: outputs are low from power-up until enabled, whatever the registers hold",
          "[contract4][power-up]") {
    const std::uint32_t seed = GENERATE(1U, 7U, 0x1234567U, 0xdeadbeefU, 0xfffffff1U);
    CAPTURE(seed);
    Bench bench("small-16", {.power_up_seed = seed, .reset_clocks = 4});
    bool was_high = false;
    bench.board.on_edge([&](const sim::Edge& edge) { was_high = was_high || edge.rises; });
    bench.board.run(200'000);
    REQUIRE_FALSE(was_high);
    REQUIRE_FALSE(bench.board.outputs().enabled);
    // It works like any other after such a start.
    auto g = generator();
    sim::PulseRecorder recorder(bench.board);
    const Image image = image_of(16, {random_record(g, 16, 250, 5, 125), random_record(g, 16, 250, 5, 125)});
    bench.load(image);
    bench.client.identify();
    REQUIRE(bench.client.status().watchdog_ms == 5);
    bench.client.select(1);
    bench.board.run(20'000);
    REQUIRE(recorder.pulses().empty());  // playing, not enabled
    bench.client.enable();
    bench.board.run(30'000);
    const auto& cycles = recorder.cycles();
    std::size_t first = 1;
    while (!cycles[first - 1].enabled || !cycles[first].enabled) ++first;
    require_equal(sim::check_pulses(image, cycles, recorder.pulses(), cycles[first].clock, cycles.back().clock, 16),
                  16 * 15);
}

TEST_CASE("contract 4: low within 2 clocks of disable", "[contract4]") {
    auto g = generator();
    Bench bench;
    play_dense(bench);
    for (int i = 0; i < 30; ++i) {
        bench.board.run(random(g, 0, 250));
        REQUIRE(bench.board.outputs().enabled);
        bench.board.send(link::encode_request(static_cast<std::uint8_t>(3 + 2 * i), interface::Command::disable, {}));
        bool was_high = false;
        while (!bench.board.line_idle()) {
            bench.board.run(1);
            was_high = was_high || bench.board.any_pin();
        }
        REQUIRE(was_high);
        // The frame's stop bit, 17 clocks, has just begun. To read, judge and obey the frame takes less than as long
        // again.
        bench.board.run(34);
        REQUIRE_FALSE(bench.board.outputs().enabled);
        REQUIRE_FALSE(bench.board.any_pin());
        bench.board.run(5000);
        REQUIRE_FALSE(bench.board.any_pin());
        bench.board.send(link::encode_request(static_cast<std::uint8_t>(4 + 2 * i), interface::Command::enable, {}));
        bench.board.run(10'000);
    }
}

TEST_CASE("contract 4: low within 2 clocks of reset, and enabling is needed again", "[contract4]") {
    Bench bench;
    play_dense(bench);
    while (!bench.board.any_pin()) bench.board.run(1);
    bench.board.reset(1);
    REQUIRE_FALSE(bench.board.any_pin());
    bench.board.run(100'000);
    REQUIRE_FALSE(bench.board.any_pin());
    bench.client.identify();
    bench.client.select(1);
    bench.board.run(10'000);
    REQUIRE_FALSE(bench.board.any_pin());
}

TEST_CASE("contract 4: a reset of one clock at any moment leaves nothing enabled", "[contract4]") {
    const link::Bytes enable = link::encode_request(1, interface::Command::enable, {});
    std::size_t enabled_first = 0;
    for (unsigned wait = 0; wait < 40; ++wait) {
        Bench bench;
        bench.client.identify();
        bench.board.send(enable);
        REQUIRE(bench.board.run_until([&] { return bench.board.line_idle(); }, 100'000));
        bench.board.run(wait);
        enabled_first += bench.board.outputs().enabled ? 1 : 0;
        bench.board.reset(1);
        bench.board.run(20'000);
        REQUIRE_FALSE(bench.board.outputs().enabled);
        REQUIRE(bench.board.receive().size() < 12);  // at most the answer that was already under way
    }
    REQUIRE(enabled_first > 0);
    REQUIRE(enabled_first < 40);  // so some of the resets came before it took effect, and some after
}

TEST_CASE("contract 4: registers that hold anything cannot enable outputs before the first reset",
          "[contract4][power-up]") {
    const std::uint32_t seed = GENERATE(range(1U, 65U));
    CAPTURE(seed);
    Bench bench("small-16", {.power_up_seed = seed, .reset_clocks = 0});
    for (int i = 0; i < 500; ++i) {
        bench.board.run(1);
        REQUIRE_FALSE(bench.board.any_pin());
        REQUIRE_FALSE(bench.board.outputs().enabled);
    }
}

TEST_CASE("contract 4: low within the time-out and 2 clocks when the host falls silent", "[contract4][watchdog]") {
    const std::uint16_t milliseconds = GENERATE(std::uint16_t{1}, std::uint16_t{3});
    Bench bench;
    play_dense(bench);
    bench.client.set_watchdog(milliseconds);
    // The reply's last bit has just arrived; the frame was accepted before that.
    const std::uint64_t latest = bench.board.now() + milliseconds * 50'000ULL + 2;
    REQUIRE(clocks_until_low(bench, [&] { return !bench.board.outputs().enabled; }) <= 1);
    REQUIRE(bench.board.now() <= latest);
    REQUIRE(bench.board.now() + 20'000 > latest);  // nor much too early: a reply takes some 6,000 clocks
    REQUIRE(bench.board.outputs().fault);
    REQUIRE(bench.client.status().watchdog_trips == 1);
    bench.board.run(100'000);
    REQUIRE_FALSE(bench.board.any_pin());
    bench.client.enable();
    bench.board.run(1000);
    REQUIRE(bench.board.any_pin());
    REQUIRE_FALSE(bench.board.outputs().fault);
}

TEST_CASE("contract 4: low within the time-out and 2 clocks when the line is wedged", "[contract4][watchdog]") {
    const int how = GENERATE(1, 2);  // held high, chattering; held low, it is a break
    CAPTURE(how);
    auto g = generator();
    Bench bench;
    play_dense(bench);
    bench.client.set_watchdog(1);
    const std::uint64_t latest = bench.board.now() + 50'000ULL + 2;
    bench.board.force_line(how == 1);
    while (bench.board.outputs().enabled) {
        if (how == 2) bench.board.force_line(g() % 2 == 0);
        bench.board.run(1);
        REQUIRE(bench.board.now() <= latest);
    }
    bench.board.run(1);
    REQUIRE_FALSE(bench.board.any_pin());
    bench.board.run(100'000);
    REQUIRE_FALSE(bench.board.any_pin());
    bench.board.force_line({});
    bench.board.run(1000);
    static_cast<void>(bench.board.receive());
    link::Client fresh(bench.line);
    fresh.identify();
    REQUIRE(fresh.status().watchdog_trips == 1);
}

TEST_CASE("contract 4: a host that speaks keeps the watchdog quiet, damaged frames do not", "[contract4][watchdog]") {
    Bench bench;
    play_dense(bench);
    bench.client.set_watchdog(2);
    for (int i = 0; i < 10; ++i) {
        bench.board.run(80'000);
        REQUIRE(bench.board.outputs().enabled);
        static_cast<void>(bench.client.status());
    }
    link::Bytes damaged = link::encode_request(0, interface::Command::status, {});
    damaged[2] ^= 0x40U;
    for (int i = 0; i < 4; ++i) {
        bench.board.send(damaged);
        bench.board.run(40'000);
    }
    REQUIRE_FALSE(bench.board.outputs().enabled);
}

TEST_CASE("contract 4: no pin is high for longer than the bound, whatever is in memory", "[contract4]") {
    Bench bench;
    const std::uint64_t bound = bench.board.parameters().max_high_clocks;
    // A record that asks for it by itself is refused. What is left are pulses that reach into a record with longer
    // ticks.
    const std::uint32_t prescaler = GENERATE(90U, 1999U, 9999U);
    Image image = image_of(16, {record(16, 256, 1, 250, 255), record(16, 300, prescaler, 0, 0)});
    bench.load(image);
    bench.open();
    bench.client.start(1, static_cast<std::uint16_t>(image.records.size()), 0);
    bench.board.run(4 * bound + 20'000);
    REQUIRE_FALSE(bench.board.any_pin());
    REQUIRE_FALSE(bench.board.outputs().enabled);
    REQUIRE(bench.board.outputs().fault);
    REQUIRE(bench.client.status().guard_trips == 1);
    REQUIRE_FALSE(bench.recorder.pulses().empty());
    for (const Pulse& p : bench.recorder.pulses()) REQUIRE(p.fall - p.rise <= bound);
}

TEST_CASE("contract 4: the longest ordinary pulses do not trip the guard", "[contract4]") {
    Bench bench;
    const Image image = image_of(16, {record(16, 256, 7, 255, 9)});  // 1,785 clocks high of 1,792, bound 20,000
    bench.load(image);
    bench.open();
    bench.client.select(1);
    bench.board.run(200'000);
    REQUIRE(bench.client.status().guard_trips == 0);
    require_equal(bench.check(image), 16 * 100);
}

TEST_CASE("contract 4: a record beyond the bounds of the board is refused and reported, not played", "[contract4]") {
    const Record bad =
        GENERATE(Record{100, 1, 100, {}}, Record{100, 1, 255, {}}, Record{0, 1, 0, {}}, Record{100, 0, 10, {}},
                 Record{0, 0, 0, {}}, Record{200, 1, 200, {}}, Record{200, 50, 40, {}}, Record{250, 0x10000, 1, {}},
                 Record{0xffffff, 3, 1, {}}, Record{12'500'001, 4, 1, {}}, Record{3, 0xffffff, 0, {}});
    CAPTURE(bad.cycle_length, bad.prescaler, static_cast<int>(bad.pulse_length));
    Bench bench;
    Record r = bad;
    r.timings.assign(16, 5);
    const Image image = image_of(16, {record(16, 200, 1, 50, 7), r, record(16, 200, 1, 50, 8)});
    bench.load(image);
    bench.open();
    bench.client.start(1, 3, 2);
    bench.board.run(3000);
    const link::Status status = bench.client.status();
    REQUIRE(status.refused_records == 2);
    REQUIRE(status.underruns == 0);
    // Silence took its place and its time, at the present cycle length.
    std::vector<std::uint16_t> order;
    for (const sim::Dwell& dwell : bench.recorder.dwells())
        if (order.empty() || order.back() != dwell.index) order.push_back(dwell.index);
    REQUIRE(order == std::vector<std::uint16_t>{0, 1, 2, 3, 1, 2, 3, 0});
    for (const Pulse& p : bench.recorder.pulses()) REQUIRE(p.index != 2);
}
