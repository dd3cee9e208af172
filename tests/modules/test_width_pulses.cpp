// SPDX-License-Identifier: Apache-2.0
// Random records with a width a channel, on small pulse generators. What the pins should do is written down as marks on a line of
// ticks: a pulse marks as many ticks as it is wide, whatever else is marked. A pin is high in a marked tick, and in one between two.
#include <Vwidth_pulse_generators.h>

#include <algorithm>
#include <array>
#include <vector>

#include "bench.hpp"

namespace {
constexpr int channels = PARAMETER_CHANNELS;
constexpr int bits = PARAMETER_TIMING_BITS;
constexpr int longest_possible = (1 << PARAMETER_WIDTH_BITS) - 1;
constexpr int never = (1 << bits) - 1;

struct Pulse {
    int start = 0;  // tick of the cycle
    int width = 0;  // 0: none
    bool early = false;
};

struct Record {
    int cycle = 100;
    int prescaler = 1;
    int longest = 0;
    std::array<Pulse, channels> pulses{};
};

/// The ticks from some moment on, in which a channel is to be high.
class Marks {
public:
    void mark(long from, int ticks) {
        for (long t = from; t < from + ticks; ++t) at(t) = true;
    }
    bool level(long tick) { return at(tick) || (at(tick - 1) && at(tick + 1)); }
    void forget(long tick) { at(tick) = false; }
    void clear() { ring_.fill(false); }

private:
    bool& at(long tick) { return ring_[static_cast<std::size_t>(tick + 1024) % ring_.size()]; }
    std::array<bool, 1024> ring_{};
};

std::uint32_t word(const Pulse& pulse, int cycle) {
    if (pulse.width == 0) return static_cast<std::uint32_t>(never) << bits;
    const int end = pulse.start + pulse.width;
    const int fall = (end >= cycle ? end - cycle : end) & never;
    return static_cast<std::uint32_t>(pulse.early << 2 * bits | pulse.start << bits | fall);
}

struct Counts {
    long cycles = 0, commits = 0, early = 0, filled = 0, off = 0, wrong = 0, high = 0;
};

/// Plays `cycles` cycles of records that `next` makes of the present one.
template <class Next>
Counts play(Bench<Vwidth_pulse_generators>& bench, long cycles, double off_chance, double commit_chance, Next next) {
    Counts counts;
    bench->i_allow = 1;
    bench->i_shift = bench->i_commit = bench->i_tick = bench->i_can_match = 0;
    bench->i_count = bench->i_longest = bench->i_word = 0;
    bench.reset();

    Record present, coming;
    std::vector<Marks> marks(channels);
    int shifted = -1;                 // words of the coming record that are in the chain; -1: it is not known yet
    bool committed = false;           // in the last clock
    long tick = 0;                    // number of the next tick, of all ticks
    std::array<long, 2> off_until{};  // clock
    long clocks = 0;
    struct { bool is = false, first = false; int count = 0; } compared;  // the tick that was issued in the last clock
    std::uint32_t pins = 0;
    int low = 0;

    for (counts.cycles = 0; counts.cycles < cycles; ++counts.cycles) {
        bool commit = false;
        for (int count = 0; count < present.cycle; ++count)
            for (int part = 0; part < present.prescaler; ++part, ++clocks) {
                const bool ticks = part == 0;
                bench->i_tick = ticks;
                bench->i_count = static_cast<std::uint32_t>(count & never);
                bench->i_can_match = present.longest != 0 && count < never;
                bench->i_longest = static_cast<std::uint32_t>(present.longest);
                if (low == 0 && bench.chance(off_chance)) low = bench.number(1, 5), ++counts.off;
                bench->i_allow = low == 0;
                if (low > 0) --low;
                bench->eval();

                const bool fresh = count == 0 && part == 0 && committed;
                bench->i_shift = 0;
                if (shifted < 0 && bench->o_settled && !fresh) {
                    coming = next(present);
                    shifted = 0;
                    continue_shifting = false;
                }
                if (shifted >= 0 && shifted < channels && !fresh && idle) {
                    bench->i_word = word(coming.pulses[static_cast<std::size_t>(shifted++)], coming.cycle);
                    bench->i_shift = 1;
                }
            }
    }
    return counts;
}
}  // namespace
