// SPDX-License-Identifier: Apache-2.0
// rtl/amplitudes/drive_player.v with a memory and a source of entries that the test drives by itself: records of
// amplitudes and of timings in every order, and preempts at any clock. Every pulse at the pins is compared with the
// host's model, to the clock.
#include <Vdrive_player.h>

#include <deque>
#include <vector>

#include "../period_check.hpp"
#include "bench.hpp"

using namespace haptogram;
using namespace haptogram::test;

namespace {
constexpr std::uint32_t channels = PARAMETER_CHANNELS;
constexpr std::uint32_t record_words = channels + 4;
constexpr std::uint32_t lead = channels + 44;

struct Entry {
    std::uint16_t index, dwell;
};

/// A drive_player, a memory of records, and whatever is offered to it next; it records what the pins do.
class Instrument {
public:
    Bench<Vdrive_player> bench;
    std::vector<std::uint16_t> memory = std::vector<std::uint16_t>(PARAMETER_RECORDS * record_words);
    std::deque<Entry> entries;
    Book book;
    std::vector<Pulse> pulses;
    std::vector<MeasuredCycle> cycles;
    std::uint64_t now = 0;
    std::size_t underruns = 0, refused = 0;

    Instrument() {
        bench->i_preempt = bench->i_entry = bench->i_enable = bench->i_disable = 0;
        bench->i_together = bench->i_hold = bench->i_streams = bench->i_fades = 0;
        bench->i_set_parameter = bench->i_set_geometry = bench->i_set_sample = bench->i_modulate = 0;
        bench->i_drop = bench->i_mute = bench->i_tag = bench->i_modulates = bench->i_at_pass_end = 0;
        bench->i_set_address = bench->i_set_word = bench->i_read_address = bench->i_word = 0;
        bench->i_divider = bench->i_length = bench->i_form = bench->i_index = bench->i_dwell = 0;
        bench.reset();
    }

    void clock() {
        bench->i_entry = !entries.empty();
        if (!entries.empty()) {
            bench->i_index = entries.front().index;
            bench->i_dwell = entries.front().dwell;
        }
        bench->eval();
        if (bench->o_take) entries.pop_front();
        const std::uint16_t read = memory[bench->o_address % memory.size()];
        bench.clock();
        bench->i_word = coming_;
        coming_ = read;
        bench->i_preempt = bench->i_enable = bench->i_disable = bench->i_modulate = 0;
        bench->eval();
        ++now;
        if (bench->o_cycle_start) cycles.push_back({now, bench->o_index});
        underruns += bench->o_underrun;
        refused += bench->o_refused;
        for (std::uint32_t k = 0; k < channels; ++k) {
            const bool high = (bench->o_pins >> k & 1) != 0;
            if (high && !high_[k]) rise_[k] = now;
            if (!high && high_[k]) pulses.push_back({rise_[k], now, k, bench->o_index});
            high_[k] = high;
        }
    }
    void run(std::uint64_t clocks) {
        for (std::uint64_t i = 0; i < clocks; ++i) clock();
    }
    void enable() {
        bench->i_enable = 1;
        clock();
    }
    /// As a command: drops what was offered, and asks for a change.
    void select(std::uint16_t index, std::uint16_t dwell) {
        entries = {{index, dwell}};
        if (index != 0 && dwell != 0) entries.push_back({0, 0});
        bench->i_preempt = 1;
        clock();
    }
    /// The clocks until a cycle of this record begins at the pins.
    std::uint64_t wait_for(std::uint16_t index, std::uint64_t limit = 100'000) {
        const std::uint64_t from = now;
        const std::size_t seen = cycles.size();
        while (cycles.size() == seen || cycles.back().index != index) {
            clock();
            REQUIRE(now - from < limit);
        }
        return now - from;
    }
    void amplitudes(std::uint16_t index, std::uint32_t cycle) {
        std::vector<std::uint16_t> words;
        for (std::uint32_t k = 0; k < channels; ++k) words.push_back(static_cast<std::uint16_t>(bench.random()));
        store(index, amplitude_record(cycle, words));
        book[index] = played(cycle, words);
    }
    void timings(std::uint16_t index, std::uint32_t cycle, std::uint8_t pulse) {
        std::vector<std::uint16_t> words = {static_cast<std::uint16_t>(cycle), static_cast<std::uint16_t>(pulse << 8),
                                            1, 0};
        book[index] = Played{{}, cycle, true, pulse};
        for (std::uint32_t k = 0; k < channels; ++k) {
            words.push_back(static_cast<std::uint16_t>(bench.number(0, static_cast<int>(cycle) + 9)));
            book[index].emissions.push_back({65535, words.back()});
        }
        store(index, words);
    }
    void store(std::uint16_t index, const std::vector<std::uint16_t>& words) {
        std::copy(words.begin(), words.end(), memory.begin() + (index - 1) * record_words);
    }
    Comparison compare(std::size_t begin, std::size_t end) {
        EmissionModel model(channels, PARAMETER_TIMING_BITS, PARAMETER_WIDTH_BITS, PARAMETER_MIN_PULSE_CLOCKS);
        return compare_periods(
            cycles, pulses, book, begin, end, [](std::size_t) { return Setting{}; }, model);
    }

private:
    std::uint16_t coming_ = 0;
    bool high_[channels] = {};
    std::uint64_t rise_[channels] = {};
};

void require_right(const Comparison& comparison, std::size_t least) {
    INFO(comparison.first);
    REQUIRE(comparison.wrong == 0);
    REQUIRE(comparison.pulses >= least);
}
}  // namespace

TEST_CASE("a record of amplitudes in every cycle, in the shortest, the usual and the longest") {
    for (const std::uint32_t cycle : {2 * lead, 1250U, 2046U}) {
        Instrument board;
        board.enable();
        for (std::uint16_t i = 1; i <= 100; ++i) {
            board.amplitudes(i, cycle);
            board.entries.push_back({i, 1});
        }
        board.entries.push_back({0, 0});
        board.wait_for(1);
        const std::size_t first = board.cycles.size() - 1;
        board.wait_for(0, 100 * 2050);
        board.run(6 * cycle);
        for (std::uint16_t i = 1; i <= 100; ++i) {
            REQUIRE(board.cycles[first + i - 1].index == i);
            REQUIRE(board.cycles[first + i].clock - board.cycles[first + i - 1].clock == cycle);
        }
        require_right(board.compare(first - 1, first + 104), 1400);
        REQUIRE(board.underruns == 0);
        REQUIRE(board.refused == 0);
    }
}

TEST_CASE("records of amplitudes and of timings and silence follow each other in any order") {
    Instrument board;
    board.enable();
    // A pulse of half of the longest cycle must have ended when the words of the shortest one's successor are begun.
    for (std::uint16_t i = 1; i <= 100; ++i) {
        if (board.bench.chance(0.5))
            board.amplitudes(i, static_cast<std::uint32_t>(board.bench.number(800, 1400)));
        else
            board.timings(i, static_cast<std::uint32_t>(board.bench.number(800, 1400)),
                          static_cast<std::uint8_t>(board.bench.number(1, 255)));
    }
    for (int i = 0; i < 500; ++i)
        board.entries.push_back({static_cast<std::uint16_t>(board.bench.chance(0.1) ? 0 : board.bench.number(1, 100)),
                                 static_cast<std::uint16_t>(board.bench.number(1, 3))});
    const std::deque<Entry> asked = board.entries;
    board.entries.push_back({0, 0});
    while (!board.entries.empty()) board.run(1000);
    board.run(20'000);
    std::size_t at = 1;
    while (board.cycles[at].index == 0 && asked[0].index != 0) ++at;
    if (asked[0].index != 0)
        for (std::size_t i = 0, c = at; i < asked.size(); ++i)
            for (int d = 0; d < asked[i].dwell; ++d) REQUIRE(board.cycles[c++].index == asked[i].index);
    require_right(board.compare(0, board.cycles.size() - 1), 8000);
    REQUIRE(board.underruns == 0);
    REQUIRE(board.refused == 0);
}

TEST_CASE(
    "a change that a command asks for comes within a cycle, a load and a sweep, and what plays meanwhile is whole") {
    Instrument board;
    board.enable();
    std::vector<std::uint32_t> cycle(41, 1250);
    for (std::uint16_t i = 1; i <= 40; ++i) {
        cycle[i] = static_cast<std::uint32_t>(board.bench.number(600, 1400));
        if (i % 2 == 0)
            board.amplitudes(i, cycle[i]);
        else
            board.timings(i, cycle[i], static_cast<std::uint8_t>(board.bench.number(1, 250)));
    }
    std::uint64_t worst = 0;
    for (int i = 0; i < 1000; ++i) {
        const auto index = static_cast<std::uint16_t>(board.bench.chance(0.05) ? 0 : board.bench.number(1, 40));
        const auto dwell = static_cast<std::uint16_t>(board.bench.number(0, 2));
        // Something else is on its way when the command comes, often begun already, and for long.
        if (board.bench.chance(0.7)) {
            const std::size_t seen = board.cycles.size();
            while (board.cycles.size() == seen) board.clock();
            const auto present = static_cast<int>(cycle[board.cycles.back().index]);
            const int first = board.bench.number(0, present - static_cast<int>(lead) - 1);
            const int second = board.bench.number(present - static_cast<int>(lead) - 20, present + 10);
            board.run(static_cast<std::uint64_t>(first));
            board.select(static_cast<std::uint16_t>(board.bench.number(0, 40)),
                         static_cast<std::uint16_t>(300 * board.bench.number(0, 1)));
            board.run(static_cast<std::uint64_t>(std::max(second - first, 0)));
        } else {
            board.run(static_cast<std::uint64_t>(board.bench.number(0, 1500)));
        }
        if (!board.cycles.empty() && board.cycles.back().index == index) continue;
        board.select(index, dwell);
        const std::uint64_t took = board.wait_for(index);
        worst = std::max(worst, took);
    }
    // A load, a sweep (at most `lead` clocks) before the last quarter of the longest cycle, and that cycle; the pins
    // are three clocks late.
    INFO("worst " << worst << " clocks");
    REQUIRE(worst <= 1400 + 1400 / 4 + channels + 40 + lead + 5);
    board.run(10'000);
    require_right(board.compare(0, board.cycles.size() - 1), 10'000);
    REQUIRE(board.refused == 0);
}

TEST_CASE("a record of timings in every cycle, in the shortest cycle for it") {
    // The words are begun when the old pulses have ended; and a load takes 34 clocks at least.
    for (const int pulse : {1, 20, 100}) {
        const auto shortest =
            static_cast<std::uint32_t>(std::max({pulse - 1 + static_cast<int>(channels) + 16, 34, 2 * pulse}));
        for (const std::uint32_t cycle : {shortest, shortest - 1}) {
            if (cycle < 2U * static_cast<std::uint32_t>(pulse)) continue;
            Instrument board;
            board.enable();
            for (std::uint16_t i = 1; i <= 50; ++i) {
                board.timings(i, cycle, static_cast<std::uint8_t>(pulse));
                board.entries.push_back({i, 1});
            }
            board.entries.push_back({0, 0});
            board.run(12'000);
            INFO("pulse " << pulse << ", cycle " << cycle << ", shortest " << shortest);
            REQUIRE((board.underruns == 0) == (cycle == shortest));
            if (cycle == shortest) require_right(board.compare(0, board.cycles.size() - 1), 300);
        }
    }
}
