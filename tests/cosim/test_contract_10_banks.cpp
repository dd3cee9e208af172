// SPDX-License-Identifier: Apache-2.0
// Contract 10: no carrier period plays entries of two banks, and switching adds no gap. A bank is a stretch of sequence
// memory. The records of the two are disjoint, so each cycle at the pins says which bank it belongs to.
#include <memory>

#include "../refusal.hpp"
#include "bench.hpp"

using namespace haptogram;
using namespace haptogram::test;

namespace {

using link::When;

struct Bank {
    std::uint16_t first = 1;
    std::vector<SequenceEntry> entries;

    [[nodiscard]] std::uint16_t length() const { return static_cast<std::uint16_t>(entries.size()); }
    /// The record of each cycle of one pass.
    [[nodiscard]] std::vector<std::uint16_t> cycles() const {
        std::vector<std::uint16_t> all;
        for (const SequenceEntry& e : entries) all.insert(all.end(), e.dwell, e.index);
        return all;
    }
};

/// Two banks of random length with records of their own: of timings, or of amplitudes where the board has them.
struct Banks : Bench {
    explicit Banks(std::mt19937& g, std::string_view model = "small-16") : Bench(model) {
        const bool amplitudes = board.parameters().width_bits != 0;
        Image image;
        image.channels = channels();
        image.clock_hz = 50'000'000;
        for (int i = 0; i < 16; ++i)
            image.records.push_back(test::random_record(g, channels(), cycle, 1, amplitudes ? 0 : 20));
        image.sequence.push_back({1, 1});
        for (Bank* bank : {&a, &b}) {
            bank->first = static_cast<std::uint16_t>(1 + image.sequence.size());
            const auto lowest = static_cast<std::uint16_t>(bank == &a ? 1 : 9);
            for (std::uint32_t n = random(g, 1, 7); n > 0; --n)
                bank->entries.push_back({static_cast<std::uint16_t>(lowest + bank->entries.size()),
                                         static_cast<std::uint16_t>(random(g, 1, 3))});
            image.sequence.insert(image.sequence.end(), bank->entries.begin(), bank->entries.end());
        }
        if (amplitudes)
            for (Record& r : image.records) r.kind = interface::Kind::amplitudes;
        load(image);
        // A netlist was reset after it had been loaded over the link: cycles are numbered from there, as the board
        // does.
        std::destroy_at(&recorder);
        std::construct_at(&recorder, board);
        open();
    }

    void start(const Bank& bank, When when = {}, std::uint16_t loops = 0) {
        client.start(bank.first, bank.length(), loops, when);
    }

    /// The number of the first cycle, from `from` on, that plays a record of this bank.
    [[nodiscard]] std::size_t first_of(const Bank& bank, std::size_t from) const {
        const auto all = recorder.cycles();
        std::size_t i = from;
        while (i < all.size() && !belongs(bank, all[i].index)) ++i;
        return i;
    }
    [[nodiscard]] static bool belongs(const Bank& bank, std::uint16_t index) {
        return std::ranges::any_of(bank.entries, [index](const SequenceEntry& e) { return e.index == index; });
    }
    /// Whether the cycles `begin` to `end` are whole passes of this bank, of which the last may be cut off.
    [[nodiscard]] bool plays(const Bank& bank, std::size_t begin, std::size_t end, bool whole) const {
        const auto pass = bank.cycles();
        if (whole && (end - begin) % pass.size() != 0) return false;
        for (std::size_t i = begin; i < end; ++i)
            if (recorder.cycles()[i].index != pass[(i - begin) % pass.size()]) return false;
        return true;
    }
    /// Runs until this bank plays; @return the number of its first cycle
    std::size_t wait_for(const Bank& bank, std::size_t from) {
        REQUIRE(board.run_until([&] { return first_of(bank, from) < recorder.cycles().size(); }, 2'000'000));
        return first_of(bank, from);
    }

    static constexpr std::uint32_t cycle = 500;
    Bank a, b;
};

}  // namespace

TEST_CASE("contract 10: a bank follows the other at its end, whole pass behind whole pass, at any time of switching",
          "[contract10][wide]") {
    auto g = generator();
    Banks bench(g, each_small_model());
    const Bank* present = &bench.a;
    const Bank* other = &bench.b;
    bench.start(*present);
    std::size_t begin = bench.wait_for(*present, 0);
    for (int round = 0; round < 25; ++round) {
        bench.board.run(random(g, 0, 12 * Banks::cycle));
        bench.start(*other, When::at_end());
        const std::size_t next = bench.wait_for(*other, begin);
        INFO("round " << round << ", cycles " << begin << " to " << next);
        REQUIRE(bench.plays(*present, begin, next, true));
        begin = next;
        std::swap(present, other);
    }
    const link::Status status = bench.client.status();
    REQUIRE(status.underruns == 0);
    REQUIRE_FALSE(status.waiting);
    REQUIRE(status.late_changes == 0);
}

TEST_CASE("contract 10: a bank begins in the carrier period that START names, and nothing between the two plays",
          "[contract10][wide]") {
    auto g = generator();
    Banks bench(g, each_small_model());
    const Bank* present = &bench.a;
    const Bank* other = &bench.b;
    bench.start(*present);
    std::size_t begin = bench.wait_for(*present, 0);
    for (int round = 0; round < 25; ++round) {
        bench.board.run(random(g, 0, 5 * Banks::cycle));
        const std::uint64_t period = bench.client.status().period.value() + random(g, 60, 120);
        bench.start(*other, When::at_period(period));
        REQUIRE(bench.client.status().waiting);
        const std::size_t next = bench.wait_for(*other, begin);
        INFO("round " << round << ", period " << period << ", cycles " << begin << " to " << next);
        REQUIRE(next + 1 == period);  // the first cycle is period 1
        REQUIRE(bench.plays(*present, begin, next, false));
        begin = next;
        std::swap(present, other);
    }
    REQUIRE(bench.client.status().late_changes == 0);
    SECTION("a period that has gone is at once, and counted") {
        bench.start(*other, When::at_period(3));
        const std::size_t sent = bench.recorder.cycles().size();
        const std::size_t next = bench.wait_for(*other, begin);
        REQUIRE(next <= sent + 2);
        REQUIRE(bench.plays(*present, begin, next, false));
        REQUIRE(bench.client.status().late_changes == 1);
    }
    REQUIRE(bench.client.status().underruns == 0);
}

TEST_CASE("contract 10: at once, at random times, a bank begins with its first entry when that is loaded",
          "[contract10][wide]") {
    auto g = generator();
    Banks bench(g, each_small_model());
    const Bank* present = &bench.a;
    const Bank* other = &bench.b;
    bench.start(*present);
    std::size_t begin = bench.wait_for(*present, 0);
    for (int round = 0; round < 25; ++round) {
        bench.board.run(random(g, 0, 12 * Banks::cycle));
        bench.start(*other);
        const std::size_t next = bench.wait_for(*other, begin);
        INFO("round " << round << ", cycles " << begin << " to " << next);
        // The record before plays on for a cycle when the first one of the new bank was not loaded by its end.
        const bool waited = !bench.plays(*present, begin, next, false);
        REQUIRE(bench.plays(*present, begin, waited ? next - 1 : next, false));
        if (waited) REQUIRE(bench.recorder.cycles()[next - 1].index == bench.recorder.cycles()[next - 2].index);
        REQUIRE(bench.recorder.cycles()[next].clock - bench.recorder.cycles()[next - 1].clock == Banks::cycle);
        begin = next;
        std::swap(present, other);
    }
    REQUIRE(bench.client.status().underruns == 0);
}

TEST_CASE("contract 10: a bank follows without a gap what was selected, pushed, or played a number of times",
          "[contract10][wide]") {
    auto g = generator();
    Banks bench(g, each_small_model());
    const std::uint16_t dwell = 400;  // longer than the commands take
    std::size_t begin = 0, end = 0;
    SECTION("a selected record, for its dwell") {
        bench.client.select(1, dwell);
        end = dwell;
    }
    SECTION("indices, for their dwells") {
        bench.client.push({1, 2}, dwell / 2);
        end = dwell;
    }
    SECTION("the last loop of a sequence") {
        bench.a.first = 40;  // where there is room for two entries
        bench.a.entries = {{1, static_cast<std::uint16_t>(dwell / 4)}, {2, static_cast<std::uint16_t>(dwell / 4)}};
        Bytes entries = words({1, dwell / 4, 2, dwell / 4});
        bench.client.write(interface::sequence_base + 4 * bench.a.first, entries);
        bench.client.start(bench.a.first, 2, 2);
        end = dwell;
    }
    REQUIRE(bench.board.run_until([&] { return bench.board.outputs().index == 1; }, 100'000));
    while (bench.recorder.cycles()[begin].index != 1) ++begin;
    // In the dwell of the last entry, too, when the silence behind it has been prepared already.
    bench.board.run(random(g, 0, (dwell - 120) * Banks::cycle));
    bench.start(bench.b, When::at_end());
    const std::size_t next = bench.wait_for(bench.b, begin);
    for (std::size_t i = begin; i < next; ++i) REQUIRE(bench.recorder.cycles()[i].index != 0);
    REQUIRE(next - begin == end);
    REQUIRE(bench.client.status().underruns == 0);
}

TEST_CASE("contract 10: where nothing is left, a bank follows in the next period", "[contract10]") {
    auto g = generator();
    Banks bench(g);
    SECTION("before anything") {}
    SECTION("a record without end") { bench.client.select(1, 0); }
    SECTION("a sequence that has ended") { bench.start(bench.a, {}, 1); }
    SECTION("silence") { bench.client.stop(); }
    bench.board.run(100 * Banks::cycle);
    const std::size_t sent = bench.recorder.cycles().size();
    bench.start(bench.b, When::at_end());
    REQUIRE(bench.wait_for(bench.b, sent) < bench.recorder.cycles().size() + 3);
    REQUIRE(bench.client.status().mode == link::Mode::sequence);
}

TEST_CASE("contract 10: pushed indices wait for their period, behind those that were pushed before",
          "[contract10][live]") {
    auto g = generator();
    Banks bench(g);
    bench.start(bench.a);
    bench.wait_for(bench.a, 0);
    for (int round = 0; round < 15; ++round) {
        bench.board.run(random(g, 0, 5 * Banks::cycle));
        const bool live = random(g, 0, 1) == 0;
        if (live) bench.client.push({7}, 0);
        if (live) bench.wait_for_index(7);
        const std::uint64_t period = bench.client.status().period.value() + random(g, 60, 120);
        bench.client.push({14, 15}, 1, When::at_period(period));
        bench.client.push({16}, 0);
        const link::Status status = bench.client.status();
        REQUIRE(status.waiting);
        REQUIRE(status.live_level == 3);
        REQUIRE(status.mode == (live ? link::Mode::live : link::Mode::sequence));
        bench.wait_for_index(16);
        REQUIRE(bench.recorder.cycles().size() >= period + 2);
        const auto index = [&](std::size_t number) { return bench.recorder.cycles()[number - 1].index; };
        REQUIRE(index(period - 1) < 14);
        REQUIRE(index(period - 1) != 0);
        REQUIRE(index(period) == 14);
        REQUIRE(index(period + 1) == 15);
        REQUIRE(index(period + 2) == 16);
        bench.start(bench.a);
        bench.wait_for(bench.a, bench.recorder.cycles().size());
    }
    REQUIRE(bench.client.status().late_changes == 0);
}

TEST_CASE("contract 10: of a START and a PUSH that wait for the same period the later one plays",
          "[contract10][live]") {
    auto g = generator();
    Banks bench(g);
    bench.client.select(16);
    bench.wait_for_index(16);
    const bool push_is_later = GENERATE(true, false);
    const std::uint64_t period = bench.client.status().period.value() + 400;
    const auto push = [&] { bench.client.push({9, 10, 11}, 2, When::at_period(period)); };
    if (!push_is_later) push();
    bench.start(bench.a, When::at_period(period));
    if (push_is_later) push();
    REQUIRE(bench.client.status().waiting);
    bench.board.run(500 * Banks::cycle);
    REQUIRE_FALSE(bench.client.status().waiting);
    std::vector<std::uint16_t> played;
    for (const sim::Dwell& dwell : bench.recorder.dwells())
        if (dwell.index != 0 && dwell.index != 16) played.push_back(dwell.index);
    REQUIRE(played.size() >= 3);
    if (push_is_later)
        REQUIRE(std::vector(played.begin(), played.begin() + 3) == std::vector<std::uint16_t>{9, 10, 11});
    else
        for (const std::uint16_t index : played) REQUIRE(index < 9);
}

TEST_CASE("contract 10: a push into which a start falls is kept whole or not at all", "[contract10][live]") {
    auto g = generator();
    Banks bench(g);
    int kept = 0;
    for (int round = 0; round < 30; ++round) {
        bench.client.push({14}, 0);
        bench.wait_for_index(14);
        const std::uint64_t period = bench.client.status().period.value() + 60;
        bench.start(bench.b, When::at_period(period));
        const std::size_t begin = bench.recorder.cycles().size();
        REQUIRE(
            bench.board.run_until([&] { return bench.recorder.cycles().size() >= period - random(g, 2, 5); }, 100'000));
        bench.board.run(random(g, 0, Banks::cycle));
        bench.client.push({1, 2, 3, 4, 5, 6, 7, 8}, 1);
        bench.board.run(40 * Banks::cycle);
        std::vector<std::uint16_t> found;
        bool started = false;
        for (std::size_t i = begin; i < bench.recorder.cycles().size(); ++i) {
            const std::uint16_t index = bench.recorder.cycles()[i].index;
            started = started || Banks::belongs(bench.b, index);
            if (started && index <= 8 && (found.empty() || found.back() != index)) found.push_back(index);
        }
        INFO("round " << round);
        REQUIRE((found.empty() || found == std::vector<std::uint16_t>{1, 2, 3, 4, 5, 6, 7, 8}));
        kept += found.empty() ? 0 : 1;
        REQUIRE(bench.client.status().live_level == 0);
    }
    INFO(kept << " of 30 came after the start");
    REQUIRE(kept > 0);
}

TEST_CASE("contract 10: the count of carrier periods is that of the pins, and stays whole in a reply",
          "[contract10][slow]") {
    auto g = generator();
    Banks bench(g);
    const Record slow = record(bench.channels(), 1000, 300, 1, 5);  // 300,000 clocks, longer than a reply takes
    const auto image = image_of(bench.channels(), {slow});
    bench.client.write(interface::primary_base, words(primary_words(image)));
    bench.client.select(1, 0);
    bench.wait_for_index(1);
    for (int i = 0; i < 5; ++i) {
        bench.board.run(1000);
        REQUIRE(bench.client.status().period == bench.recorder.cycles().size());
        const std::size_t now = bench.recorder.cycles().size();
        REQUIRE(bench.board.run_until([&] { return bench.recorder.cycles().size() > now; }, 400'000));
    }
    bench.client.reset();
    REQUIRE(bench.client.status().period.value() < 10);  // which a reset and a question take at most
}

TEST_CASE("contract 10: a gate that cannot be is refused, and a stop takes back what waits", "[contract10][link]") {
    auto g = generator();
    Banks bench(g);
    const auto never = When::at_period(std::uint64_t{1} << 40);
    bench.start(bench.a, never);
    REQUIRE(bench.client.status().waiting);
    REQUIRE_REFUSED(bench.start(bench.b, When::at_period(5)));
    bench.start(bench.b, never);           // of two, the later one
    bench.start(bench.a, When::at_end());  // which now waits for nothing
    bench.wait_for(bench.a, 0);
    REQUIRE_FALSE(bench.client.status().waiting);
    REQUIRE_REFUSED(bench.client.push({1}, 1, When::at_end()));
    bench.start(bench.b);  // the gate of the refused push is gone, too
    REQUIRE_FALSE(bench.client.status().waiting);
    bench.client.stop();
    bench.client.push({1}, 0);
    bench.wait_for_index(1);
    bench.client.push({2}, 0, never);
    bench.start(bench.b, never);
    REQUIRE(bench.client.status().live_level == 1);
    bench.client.stop();
    const link::Status status = bench.client.status();
    REQUIRE_FALSE(status.waiting);
    REQUIRE(status.live_level == 0);
    bench.board.run(20 * Banks::cycle);
    REQUIRE(bench.board.outputs().index == 0);
    // A new session does not begin with the last one's gate.
    bench.client.request({interface::Command::gate, words({0, 0, 0x100})});
    bench.client.identify();
    bench.start(bench.a);
    bench.wait_for(bench.a, bench.recorder.cycles().size());
    REQUIRE_THROWS_AS(When::at_period(0), Error);
    REQUIRE_THROWS_AS(When::at_period(When::at_end().gate), Error);
}

TEST_CASE("contract 10: a board that keeps no time says so, and its status is as before", "[contract10][tile100]") {
    Bench bench("tile-100");
    bench.client.identify();
    REQUIRE(bench.client.status().period == std::nullopt);
    REQUIRE_REFUSED(bench.client.start(1, 1, 1, When::at_end()));
    REQUIRE_REFUSED(bench.client.request({interface::Command::gate, words({1, 0, 0})}));
    REQUIRE_REFUSED(bench.client.read(interface::status_base + 2 * interface::status_untimed_words, 2));
    REQUIRE_REFUSED(bench.client.push_foci(std::vector<std::uint16_t>(4), 1));
}
