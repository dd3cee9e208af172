// SPDX-License-Identifier: Apache-2.0
// Contract 14: an event's pulse and its stamp name the clock of what happened at the pins, a trigger's stamp that of
// its edge, and nothing at the trigger input turns outputs on. Clocks are those of the bench, which counts edges by
// itself.
#include <algorithm>

#include "../refusal.hpp"
#include "bench.hpp"
#include "haptogram/link/trigger.hpp"

using namespace haptogram;
using namespace haptogram::test;

namespace {

using link::Event;
using link::TriggerSettings;
using link::TriggerTimes;
using link::When;

constexpr std::uint32_t period_clocks = 1250;
constexpr double clock_s = 1 / 50e6;
constexpr std::uint32_t mark_bit = 0x8000;  // of an entry in sequence memory

struct TriggerBench : Bench {
    std::vector<sim::TriggerChange> changes;

    /// Three records, each for two cycles, the second one with a mark.
    TriggerBench() {
        std::vector<Record> records;
        for (const std::uint16_t timing : std::initializer_list<std::uint16_t>{10, 20, 30})
            records.push_back(record(channels(), 250, 5, 100, timing));
        Image image = image_of(channels(), std::move(records));
        for (SequenceEntry& e : image.sequence) e.dwell = 2;
        load(image);
        board.sequence_memory()[2] |= mark_bit;
        board.on_trigger([this](const sim::TriggerChange& c) { changes.push_back(c); });
        client.identify();
        client.set_watchdog(0);
    }

    void set(const TriggerSettings& settings) { link::set_trigger(client, settings); }
    [[nodiscard]] TriggerTimes times() { return link::trigger_times(client); }

    /// Clocks of the cycles, from this one on, in which a record with this index begins to play.
    [[nodiscard]] std::vector<std::uint64_t> beginnings(std::uint16_t index, std::uint64_t from) const {
        std::vector<std::uint64_t> found;
        const auto& all = recorder.cycles();
        for (std::size_t i = 1; i < all.size(); ++i)
            if (all[i].clock >= from && all[i].enabled && all[i].index == index && all[i - 1].index != index)
                found.push_back(all[i].clock);
        return found;
    }
    [[nodiscard]] std::vector<std::uint64_t> rises() const {
        std::vector<std::uint64_t> found;
        for (const sim::TriggerChange& c : changes)
            if (c.level) found.push_back(c.clock);
        return found;
    }
    [[nodiscard]] bool any_pulse(std::uint64_t from, std::uint64_t to) const {
        return std::ranges::any_of(recorder.pulses(), [&](const Pulse& p) { return p.rise >= from && p.rise < to; });
    }
    void toggle(std::uint64_t high_clocks) {
        board.drive_trigger(true);
        board.run(high_clocks);
        board.drive_trigger(false);
    }
};

/// The clock behind each of these.
std::vector<std::uint64_t> behind(std::vector<std::uint64_t> clocks) {
    for (std::uint64_t& clock : clocks) ++clock;
    return clocks;
}

}  // namespace

TEST_CASE("contract 14: a pulse comes one clock behind each beginning of a marked entry, with its stamp") {
    TriggerBench bench;
    bench.set({.event = Event::mark, .pulse_s = 700 * clock_s});
    bench.client.enable();
    const std::uint64_t from = bench.board.now();
    bench.client.start(1, 3, 0);
    bench.board.run(40 * period_clocks);
    bench.client.stop();
    bench.board.run(4 * period_clocks);  // nothing happens any more, so what is told is of all
    const auto marks = bench.beginnings(2, from);
    REQUIRE(marks.size() >= 5);
    REQUIRE(bench.rises() == behind(marks));
    for (std::size_t i = 1; i < bench.changes.size(); i += 2)
        REQUIRE(bench.changes[i].clock - bench.changes[i - 1].clock == 700);
    const TriggerTimes told = bench.times();
    REQUIRE(told.out_count == bench.rises().size());
    REQUIRE(told.out == bench.rises().back() + 1);  // the clock that begins with this edge
}

TEST_CASE("contract 14: a pass is told each time, also where one entry is all of it") {
    TriggerBench bench;
    bench.set({.event = Event::pass, .pulse_s = 10 * clock_s});
    bench.client.enable();
    const std::uint64_t from = bench.board.now();
    bench.client.start(3, 1, 5);
    bench.board.run(20 * period_clocks);
    const auto first = bench.beginnings(3, from);
    REQUIRE(first.size() == 1);
    std::vector<std::uint64_t> passes;
    for (std::uint64_t pass = 0; pass < 5; ++pass) passes.push_back(first.front() + pass * 2 * period_clocks + 1);
    REQUIRE(bench.rises() == passes);
}

TEST_CASE("contract 14: each third carrier period is told, whatever plays, and none twice") {
    TriggerBench bench;
    bench.set({.event = Event::period, .every_periods = 3, .pulse_s = 10 * clock_s});
    bench.board.run(30 * period_clocks);
    const auto rises = bench.rises();
    REQUIRE(rises.size() >= 9);
    for (std::size_t i = 1; i < rises.size(); ++i) REQUIRE(rises[i] - rises[i - 1] == 3ULL * period_clocks);
}

TEST_CASE("contract 14: playing begins once, and a mark of what is not heard is none") {
    TriggerBench bench;
    bench.set({.event = Event::mark});
    bench.client.start(1, 3, 0);
    bench.board.run(20 * period_clocks);
    REQUIRE(bench.changes.empty());
    bench.set({.event = Event::start, .pulse_s = 10 * clock_s});
    bench.client.enable();
    bench.board.run(20 * period_clocks);
    REQUIRE(bench.rises().size() == 1);
    bench.client.disable();
    bench.client.enable();
    bench.board.run(20 * period_clocks);
    REQUIRE(bench.rises().size() == 2);
}

TEST_CASE(
    "contract 14: a trigger's stamp is the clock of its edge, whatever must last how long, and shorter ones do not "
    "count") {
    auto g = generator();
    TriggerBench bench;
    unsigned counted = 0;
    for (unsigned round = 0; round < 40; ++round) {
        const std::uint32_t least = random(g, 0, 300);
        const bool low = round % 2 != 0;
        bench.board.drive_trigger(low);
        bench.set({.active_low = low, .settle_s = least * clock_s});
        bench.board.run(1000);
        const std::uint16_t before = bench.times().in_count;
        bench.board.run(random(g, 0, 2000));
        const std::uint64_t edge = bench.board.now();
        const std::uint32_t lasts = random(g, least > 20 ? least - 20 : 1, least + 20);
        bench.board.drive_trigger(!low);
        bench.board.run(lasts);
        bench.board.drive_trigger(low);
        bench.board.run(1000);
        const TriggerTimes told = bench.times();
        INFO(least << " clocks asked for, " << lasts << " driven");
        REQUIRE(told.in_count == static_cast<std::uint16_t>(before + (lasts > least ? 1 : 0)));
        if (lasts <= least) continue;
        REQUIRE(told.in == edge);
        ++counted;
    }
    REQUIRE(counted > 10);
}

TEST_CASE("contract 14: from a trigger to the first pulse is the same time, but for less than a carrier period") {
    auto g = generator();
    TriggerBench bench;
    bench.client.enable();
    std::vector<std::uint64_t> delays;
    for (unsigned round = 0; round < 60; ++round) {
        bench.client.start(1, 3, 1, When::at_trigger());
        bench.board.run(random(g, 5000, 9000));
        REQUIRE(bench.board.outputs().index == 0);
        const std::uint64_t edge = bench.board.now();
        bench.toggle(50);
        bench.board.run(10 * period_clocks);
        const auto begun = bench.beginnings(1, edge);
        REQUIRE(begun.size() == 1);
        delays.push_back(begun.front() - edge);
    }
    const auto [least, most] = std::ranges::minmax(delays);
    INFO("from " << least << " to " << most << " clocks");
    REQUIRE(most - least <= period_clocks);
    REQUIRE(most - least > period_clocks / 2);  // the moments were of all kinds
}

TEST_CASE("contract 14: what goes on at a trigger has no gap before it: the next bank") {
    TriggerBench bench;
    bench.client.enable();
    bench.client.start(1, 1, 0);
    bench.wait_for_index(1);
    bench.client.start(3, 1, 0, When::at_trigger());
    bench.board.run(20 * period_clocks);
    REQUIRE(bench.board.outputs().index == 1);
    const std::uint64_t edge = bench.board.now();
    bench.toggle(10);
    bench.board.run(10 * period_clocks);
    REQUIRE(bench.beginnings(3, edge).size() == 1);
    for (const sim::CycleStart& c : bench.recorder.cycles())
        if (c.clock > edge) REQUIRE(c.index != 0);
}

TEST_CASE(
    "contract 14: a trigger turns nothing on that the host did not, and what switched outputs off ends the wait") {
    TriggerBench bench;
    SECTION("outputs were never on") {
        bench.client.start(1, 3, 0, When::at_trigger());
        bench.toggle(10);
        bench.board.run(20 * period_clocks);
        REQUIRE_FALSE(bench.board.outputs().enabled);
        REQUIRE_FALSE(bench.any_pulse(0, bench.board.now()));
    }
    SECTION("disabled and enabled anew") {
        bench.client.enable();
        bench.client.start(1, 3, 0, When::at_trigger());
        bench.client.disable();
        bench.client.enable();
    }
    SECTION("the stop input") {
        bench.client.enable();
        bench.client.start(1, 3, 0, When::at_trigger());
        bench.board.press_stop(true);
        bench.board.run(100);
        bench.board.press_stop(false);
        bench.board.run(100);
        bench.client.enable();
    }
    SECTION("the watchdog") {
        bench.client.set_watchdog(1);
        bench.client.enable();
        bench.client.start(1, 3, 0, When::at_trigger());
        bench.board.run(100'000);
        REQUIRE_FALSE(bench.board.outputs().enabled);
        bench.client.set_watchdog(0);
        bench.client.enable();
    }
    SECTION("a break of the line") {
        bench.client.enable();
        bench.client.start(1, 3, 0, When::at_trigger());
        bench.board.force_line(false);
        bench.board.run(1000);
        bench.board.force_line({});
        bench.board.run(1000);
        bench.client.enable();
    }
    SECTION("STOP") {
        bench.client.enable();
        bench.client.start(1, 3, 0, When::at_trigger());
        bench.client.stop();
    }
    SECTION("the outputs are off when it is asked for") {
        bench.client.start(1, 3, 0, When::at_trigger());
        bench.board.press_stop(true);
        bench.board.run(100);
        bench.board.press_stop(false);
        bench.board.run(100);
        bench.client.enable();
    }
    const std::uint64_t from = bench.board.now();
    bench.toggle(10);
    bench.board.run(20 * period_clocks);
    REQUIRE_FALSE(bench.any_pulse(from, bench.board.now()));
    if (bench.board.outputs().enabled) {  // and what is asked for now begins
        bench.client.start(1, 3, 0, When::at_trigger());
        bench.toggle(10);
        bench.board.run(20 * period_clocks);
        REQUIRE(bench.any_pulse(from, bench.board.now()));
    }
}

TEST_CASE(
    "contract 14: while the stop input is active a gate for the trigger is refused, and what it would gate, too") {
    TriggerBench bench;
    bench.client.enable();
    bench.board.press_stop(true);
    bench.board.run(100);
    REQUIRE_REFUSED(bench.client.start(1, 3, 0, When::at_trigger()));
    bench.board.press_stop(false);
    bench.board.run(100);
    bench.client.enable();
    bench.toggle(100);
    bench.board.run(20 * period_clocks);
    CHECK(bench.recorder.pulses().empty());
    bench.client.start(1, 3, 0, When::at_trigger());  // and one behind it begins as ever
    bench.toggle(100);
    bench.board.run(20 * period_clocks);
    CHECK_FALSE(bench.recorder.pulses().empty());
}

TEST_CASE("contract 14: while the input gates, no pin is high, and the sequence goes on in time") {
    TriggerBench bench;
    bench.set({.gates = true});
    bench.client.enable();
    bench.client.start(1, 3, 0);
    bench.board.run(20 * period_clocks);
    REQUIRE_FALSE(bench.any_pulse(0, bench.board.now()));
    const std::uint64_t edge = bench.board.now();
    bench.board.drive_trigger(true);
    bench.board.run(20 * period_clocks);
    REQUIRE(bench.any_pulse(edge, edge + 2 * period_clocks));
    const std::uint64_t end = bench.board.now();
    bench.board.drive_trigger(false);
    bench.board.run(20 * period_clocks);
    REQUIRE_FALSE(bench.any_pulse(end + 10, bench.board.now()));
    REQUIRE(bench.board.outputs().enabled);
    const auto begun = bench.beginnings(1, 0);
    REQUIRE(begun.size() >= 9);
    for (std::size_t i = 1; i < begun.size(); ++i) REQUIRE(begun[i] - begun[i - 1] == 6ULL * period_clocks);
}

TEST_CASE("contract 14: the test output shows a pin, the cycles, or the changes of index") {
    TriggerBench bench;
    bench.set({.test = link::Test::carrier, .channel = 5});
    bench.client.enable();
    bench.client.start(1, 3, 0);
    bench.wait_for_index(1);
    unsigned high = 0;
    for (std::uint32_t i = 0; i < 3 * period_clocks; ++i) {
        bench.board.run(1);
        REQUIRE(bench.board.outputs().test == bench.board.pin(5));
        high += bench.board.pin(5) ? 1 : 0;
    }
    REQUIRE(high == 3 * 500);
    for (const link::Test what : {link::Test::cycle, link::Test::index}) {
        bench.set({.test = what});
        bool before = bench.board.outputs().test, due = false;
        std::uint16_t index = bench.board.outputs().index;
        unsigned changes = 0;
        for (std::uint32_t i = 0; i < 12 * period_clocks; ++i) {
            bench.board.run(1);
            const auto& now = bench.board.outputs();
            if (i > 0) REQUIRE((now.test != before) == due);
            changes += i > 0 && due ? 1 : 0;
            due = what == link::Test::cycle ? now.cycle_start : now.index != index;
            before = now.test;
            index = now.index;
        }
        REQUIRE(changes >= (what == link::Test::cycle ? 11U : 5U));
    }
}

TEST_CASE("contract 14: what makes no sense is refused by name, and what can only be read cannot be written") {
    TriggerBench bench;
    REQUIRE_REFUSED(bench.set({.channel = 16}));
    REQUIRE_REFUSED(bench.set({.pulse_s = 1.0}));
    REQUIRE_REFUSED(bench.set({.settle_s = 1.0}));
    REQUIRE_REFUSED(bench.client.push({1}, 1, When::at_trigger()));
    REQUIRE_REFUSED(bench.client.write(interface::trigger_base + 2 * interface::trigger_settings,
                                       words(std::vector<std::uint16_t>{1})));
    const TriggerSettings all{.event = Event::samples,
                              .every_periods = 7,
                              .pulse_s = 70'000 * clock_s,
                              .active_low = true,
                              .by_level = true,
                              .gates = true,
                              .settle_s = 123 * clock_s,
                              .test = link::Test::carrier,
                              .channel = 15};
    bench.set(all);
    const TriggerSettings found = link::trigger_settings(bench.client);
    REQUIRE(found.event == all.event);
    REQUIRE(found.every_periods == 7);
    REQUIRE(std::abs(found.pulse_s - all.pulse_s) < clock_s / 100);
    REQUIRE((found.active_low && found.by_level && found.gates));
    REQUIRE(std::abs(found.settle_s - all.settle_s) < clock_s / 100);
    REQUIRE((found.test == all.test && found.channel == 15));
}
