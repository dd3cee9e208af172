// SPDX-License-Identifier: Apache-2.0
// Random records with a width a channel, on small pulse generators. What the pins should do is written down as marks on
// a line of ticks: a pulse marks as many ticks as it is wide, whatever else is marked. A pin is high in a marked tick,
// and in one between two.
#include <Vwidth_pulse_generators.h>

#include <algorithm>
#include <array>
#include <vector>

#include "../soak.hpp"
#include "bench.hpp"

namespace {
constexpr int channels = PARAMETER_CHANNELS;
constexpr int bits = PARAMETER_TIMING_BITS;
constexpr int longest_possible = (1 << PARAMETER_WIDTH_BITS) - 1;
constexpr int furthest = (longest_possible + 1) / 2;  // ticks that a cycle can be near its end
constexpr int never = (1 << bits) - 1;

struct Pulse {
    int start = 0;  // tick of the cycle
    int width = 0;  // 0: none
    bool early = false;
};

struct Record {
    int cycle = 100;
    int prescaler = 1;
    std::array<Pulse, channels> pulses{};
    [[nodiscard]] int longest() const {
        return std::max_element(pulses.begin(), pulses.end(), [](auto& a, auto& b) { return a.width < b.width; })
            ->width;
    }
};

// The ticks in which a channel is to be high; the line is as long as no pulse is, and used round and round.
class Marks {
public:
    void mark(long from, int ticks) {
        for (long t = from; t < from + ticks; ++t) at(t) = true;
    }
    [[nodiscard]] bool pin(long tick) { return at(tick) || (at(tick - 1) && at(tick + 1)); }
    [[nodiscard]] bool filled(long tick) { return pin(tick) && !at(tick); }
    void forget(long tick) { at(tick) = false; }
    void clear() { line_.fill(false); }

private:
    bool& at(long tick) { return line_[static_cast<std::size_t>(tick + 1024) % line_.size()]; }
    std::array<bool, 1024> line_{};
};

std::uint32_t word_of(const Pulse& pulse, int cycle) {
    if (pulse.width == 0) return static_cast<std::uint32_t>(never << bits | never);
    const int fall = (pulse.start + pulse.width) % cycle & never;
    return static_cast<std::uint32_t>(pulse.early << 2 * bits | fall << bits | pulse.start);
}

using Generators = Bench<Vwidth_pulse_generators>;

class Player {
public:
    long commits = 0, ahead = 0, early = 0, filled = 0, off = 0, wrong = 0, pulses = 0;
    bool centred = false;  // no pulse that is not early lasts for more than half of its width beyond its cycle

    /// Plays so many cycles of the records that `next` makes of the present one. In each clock i_allow falls with the
    /// one probability; at each cycle's end the next record is committed with the other, if it could be loaded.
    template <class Next>
    void play(long cycles, double off_chance, double commit_chance, Next next) {
        bench_->i_allow = 1;
        bench_->i_shift = bench_->i_commit = bench_->i_tick = bench_->i_can_match = 0;
        bench_->i_count = bench_->i_longest = bench_->i_word = 0;
        bench_->i_cycle_start = bench_->i_near = bench_->i_words = bench_->i_ahead_count = bench_->i_centred = 0;
        bench_.reset();
        for (long cycle = 0; cycle < cycles; ++cycle) {
            bool commit = false;
            const bool will_commit = bench_.chance(commit_chance);
            for (int count = 0; count < present_.cycle; ++count)
                for (int part = 0; part < present_.prescaler; ++part) {
                    bench_->i_tick = part == 0;
                    bench_->i_cycle_start = part == 0 && count == 0;
                    bench_->i_count = static_cast<std::uint32_t>(count & never);
                    bench_->i_longest = static_cast<std::uint32_t>(present_.longest());
                    bench_->i_can_match = bench_->i_longest != 0 && count < never;
                    if (low_ == 0 && bench_.chance(off_chance)) low_ = bench_.number(1, 5), ++off;
                    const int left = present_.cycle - 1 - count;  // ticks
                    bench_->i_near = present_.prescaler == 1 && left < std::min(present_.cycle / 4, furthest);
                    bench_->i_words = will_commit && shifted_ == channels;
                    bench_->i_ahead_count = static_cast<std::uint32_t>((coming_.cycle - 1 - left) & longest_possible);
                    bench_->i_centred = centred;
                    bench_->i_allow = low_ == 0;
                    if (low_ > 0) --low_;
                    bench_->eval();
                    // Words are shifted after a clock in which all was settled; never in the first clock after a
                    // commit.
                    const bool fresh = committed_ && count == 0 && part == 0;
                    bench_->i_shift = settled_ && !fresh && shifted_ < channels && bench_.chance(0.9);
                    if (bench_->i_shift) {
                        if (shifted_ == 0) coming_ = next(present_);
                        bench_->i_word = word_of(coming_.pulses[static_cast<std::size_t>(shifted_++)], coming_.cycle);
                    }
                    const bool last = count == present_.cycle - 1 && part == present_.prescaler - 1;
                    commit = last && will_commit && shifted_ == channels && bench_->o_settled;
                    bench_->i_commit = commit;
                    settled_ = !fresh && bench_->o_settled;
                    expect(count);
                }
            committed_ = commit;
            if (commit) {
                present_ = coming_;
                shifted_ = 0;
                settled_ = false;
                ++commits;
            }
        }
    }

private:
    // One clock. The channels compare with a tick in the clock after it, and a pin is a tick behind.
    void expect(int count) {
        const bool allowed = bench_->i_allow;
        if (!allowed)
            for (Marks& m : marks_) m.clear(), pins_ = 0;
        else if (ticked_) {
            pins_ = 0;
            for (std::size_t k = 0; k < channels; ++k) {
                const Pulse& pulse = compared_.pulses[k];
                if (pulse.width > 0 && compared_count_ == pulse.start && !pulse.early)
                    marks_[k].mark(tick_, pulse.width), ++pulses;
                const Pulse& next = next_.pulses[k];
                if (compared_ahead_ && next.early && next_count_ == next.start)
                    marks_[k].mark(tick_, next.width), ++pulses, ++ahead;
                if (pulse.width > 0 && compared_count_ == 0 && pulse.early)
                    marks_[k].mark(tick_, pulse.start + pulse.width - compared_.cycle), ++early;
                if (marks_[k].pin(tick_ - 1)) pins_ |= 1U << k;
                if (marks_[k].filled(tick_ - 1)) ++filled;
            }
        }
        if (ticked_) {
            for (Marks& m : marks_) m.forget(tick_ - 2);
            ++tick_;
        }
        if (ticked_ = bench_->i_tick; ticked_) {
            compared_count_ = count;
            compared_ = present_;
            compared_ahead_ = bench_->i_near && bench_->i_words;
            next_count_ = coming_.cycle - present_.cycle + count;
            next_ = coming_;
        }
        bench_.clock();
        if (bench_->o_pins != pins_) ++wrong;
    }

    Generators bench_;
    Record present_, compared_, coming_, next_;
    std::array<Marks, channels> marks_{};
    int shifted_ = 0;  // words of the coming record that are in the chain
    bool committed_ = false, settled_ = true;
    bool ticked_ = false;
    bool compared_ahead_ = false;
    int compared_count_ = 0, next_count_ = 0;
    long tick_ = 0;  // of all ticks
    int low_ = 0;    // clocks for which i_allow stays low
    std::uint32_t pins_ = 0;
};

/// Any pulses, that is, starts and widths that have nothing to do with those before.
Record any_record(std::mt19937_64& random, int cycle) {
    const auto number = [&](int low, int high) { return std::uniform_int_distribution<int>(low, high)(random); };
    Record record;
    record.cycle = cycle;
    record.prescaler = number(0, 3) ? 1 : number(2, 3);
    const int longest = std::min(longest_possible, number(0, 9) ? cycle / 2 : cycle - 1);
    for (Pulse& pulse : record.pulses) {
        if (number(0, 15) == 0) continue;
        pulse.width = number(1, number(0, 1) ? std::min(4, longest) : longest);
        pulse.start = std::min(number(0, cycle - 1), never - 1);
        const int over = pulse.start + pulse.width - cycle;
        if (over >= 0 && cycle > never + 1) pulse.width = 0;  // no pulse runs over the end of so long a cycle
        pulse.early = pulse.width > 0 && over > 0 && number(0, 1);
    }
    if (number(0, 20) == 0) record.pulses = {};
    return record;
}
}  // namespace

TEST_CASE("pulses of any widths that change in every cycle: each completes, and overlapping ones merge") {
    Player player;
    std::mt19937_64 random(Catch::rngSeed());
    const double off_chance = GENERATE(0.0, 0.001);
    const auto cycles = static_cast<long>(haptogram::test::soaked(110'000, 25'000));
    player.play(cycles, off_chance, GENERATE(1.0, 0.6), [&](const Record& present) {
        const bool same = random() % 3 != 0;
        return any_record(random, same ? present.cycle : std::uniform_int_distribution<int>(20, 300)(random));
    });
    INFO(player.commits << " commits, " << player.pulses << " pulses, " << player.early << " early ones, "
                        << player.ahead << " ahead, " << player.filled << " gaps filled, " << player.off
                        << " times off");
    CHECK(player.wrong == 0);
    CHECK(player.commits > cycles * 5 / 11);
    CHECK(player.pulses > cycles * 40 / 11);
    CHECK(player.early > cycles / 11);
    CHECK(player.ahead > cycles / 110);
    CHECK(player.filled > cycles / 370);
    CHECK((player.off > 0) == (off_chance > 0));
}

TEST_CASE("pulses whose middle stays while their width changes a little in every cycle") {
    Player player;
    player.centred = true;
    std::mt19937_64 random(Catch::rngSeed());
    const double commit_chance = GENERATE(1.0, 0.8);
    const auto cycles = static_cast<long>(haptogram::test::soaked(60'000, 20'000));
    player.play(cycles, 0.0, commit_chance, [&](const Record& present) {
        Record record = present;
        for (std::size_t k = 0; k < channels; ++k) {
            const int middle = static_cast<int>(k) - 2;  // some start before tick 0
            Pulse& pulse = record.pulses[k];
            pulse.width =
                std::clamp(pulse.width + std::uniform_int_distribution<int>(-6, 6)(random), 1, record.cycle / 2);
            const int start = middle - pulse.width / 2;
            pulse.early = start < 0 && start + pulse.width > 0;
            pulse.start = (start + record.cycle) % record.cycle;
        }
        return record;
    });
    CHECK(player.wrong == 0);
    CHECK(player.commits > (commit_chance == 1.0 ? cycles * 59 / 60 : cycles * 2 / 3));
    CHECK(player.early > cycles);
    CHECK(player.ahead > cycles);
}

TEST_CASE("a gap of one tick is filled, one of two is not, and pins are low in the clock after i_allow falls") {
    Generators bench;
    bench->i_allow = 1;
    bench->i_shift = bench->i_commit = bench->i_tick = bench->i_can_match = 0;
    bench->i_count = bench->i_longest = bench->i_word = 0;
    bench->i_cycle_start = bench->i_near = bench->i_words = bench->i_ahead_count = bench->i_centred = 0;
    bench.reset();
    // Every channel ends at tick 0 of the next cycle in the first record; in the second, channel k starts at tick k.
    const auto shift = [&](auto pulse_of) {
        for (int k = 0; k < channels; ++k) {
            bench->i_shift = 1;
            bench->i_word = word_of(pulse_of(k), 40);
            bench.clock();
        }
        bench->i_shift = 0;
    };
    const auto cycle = [&](int longest, bool commit, auto each) {
        for (int count = 0; count < 40; ++count) {
            bench->i_tick = 1;
            bench->i_count = static_cast<std::uint32_t>(count);
            bench->i_can_match = longest > 0;
            bench->i_longest = static_cast<std::uint32_t>(longest);
            bench->i_commit = commit && count == 39;
            each(count);
            bench.clock();
        }
        bench->i_tick = bench->i_commit = 0;
    };
    shift([](int) { return Pulse{30, 10, false}; });
    cycle(0, true, [](int) {});
    // In the second half of the cycle all is settled; the words wait for the commit.
    int sent = 0;
    cycle(10, true, [&](int count) {
        bench->i_shift = count >= 20 && sent < channels;
        if (bench->i_shift) bench->i_word = word_of(Pulse{sent++, 5, false}, 40);
    });
    std::array<int, channels> low{};
    cycle(5, false, [&](int count) {
        bench->i_shift = 0;
        // A pin follows its tick by one tick and two clocks: in clock c it shows tick c − 3.
        if (count >= 3 && count < 3 + channels)
            for (int k = 0; k < channels; ++k) low[static_cast<std::size_t>(k)] += !(bench->o_pins >> k & 1);
    });
    CHECK(low[0] == 3);  // tick 0 starts without a gap; its pulse of 5 leaves three of these eight ticks low
    CHECK(low[1] == 2);  // high from tick 0 on: the gap of one tick is filled
    CHECK(low[2] == 3);  // a gap of two ticks stays, and one tick after the pulse
    CHECK(low[5] == 5);

    shift([](int) { return Pulse{10, 19, false}; });
    cycle(5, true, [](int) {});
    cycle(19, false, [&](int count) {
        if (count == 20) {
            CHECK(bench->o_pins == (1U << channels) - 1);
            bench->i_allow = 0;
        }
        if (count > 20) CHECK(bench->o_pins == 0);
        if (count > 20) CHECK(bench->o_settled);
        if (count == 22) bench->i_allow = 1;  // the rest of a pulse does not come back
    });
}
