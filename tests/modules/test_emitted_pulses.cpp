// SPDX-License-Identifier: Apache-2.0
// 100 channels at 1,250 ticks a cycle: the words of the host's model of rtl/amplitudes/emission.v are committed in
// every cycle, and what the pins then do is measured as an instrument would: edges, and the 40 kHz component by its
// Fourier sum.
#include <Vwidth_pulse_generators.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <complex>
#include <cstdlib>
#include <numbers>
#include <vector>

#include "../soak.hpp"
#include "bench.hpp"
#include "haptogram/format/emission.hpp"

using namespace haptogram;

namespace {
constexpr std::size_t channels = PARAMETER_CHANNELS;
constexpr int cycle_ticks = 1250;
constexpr int bits = PARAMETER_TIMING_BITS;
using Pins = std::array<std::uint32_t, (channels + 31) / 32>;

bool high(const Pins& pins, std::size_t k) { return (pins[k / 32] >> k % 32 & 1) != 0; }

/// Plays one cycle after the other, and loads the words of each in the second half of the one before.
class Instrument {
public:
    Instrument() {
        bench_->i_allow = 1;
        bench_->i_shift = bench_->i_commit = bench_->i_tick = bench_->i_can_match = 0;
        bench_->i_count = bench_->i_longest = 0;
        bench_->i_word = 0;
        bench_->i_near = bench_->i_words = bench_->i_ahead_count = 0;
        bench_->i_centred = 1;
        bench_.reset();
    }

    /// One cycle with the words that were given in the cycle before. `see(tick, pins)` gets the pins in each tick. Pins
    /// are three clocks behind, so the first three ticks that it gets, 1,247 to 1,249, are those of the cycle before.
    template <class See>
    void cycle(const std::vector<EmissionWord>& next, See see) {
        std::uint32_t longest = 0;
        std::size_t shifted = 0;
        for (const EmissionWord& word : next) longest = std::max(longest, word.width);
        for (int count = 0; count < cycle_ticks; ++count) {
            bench_->i_tick = 1;
            bench_->i_cycle_start = count == 0;
            bench_->i_count = static_cast<std::uint16_t>(count);
            bench_->i_longest = static_cast<std::uint16_t>(longest_);
            bench_->i_can_match = longest_ > 0;
            bench_->i_shift = count >= 700 && shifted < channels;
            if (bench_->i_shift) {
                REQUIRE(bench_->o_settled);
                const EmissionWord& word = next[shifted++];
                bench_->i_word = static_cast<std::uint32_t>(word.early) << 2 * bits | word.fall << bits | word.rise;
            }
            bench_->i_near = count >= cycle_ticks - cycle_ticks / 4;
            bench_->i_words = count > 700 && shifted == channels && !bench_->i_shift;
            bench_->i_ahead_count = static_cast<std::uint16_t>(count & ((1 << PARAMETER_WIDTH_BITS) - 1));
            bench_->i_commit = count == cycle_ticks - 1;
            const int shown = count < 3 ? count - 3 + cycle_ticks : count - 3;
            Pins pins;
            std::copy_n(&bench_->o_pins[0], pins.size(), pins.begin());
            see(shown, pins);
            bench_.clock();
        }
        longest_ = longest;
    }

private:
    Bench<Vwidth_pulse_generators> bench_;
    std::uint32_t longest_ = 0;
};

void nothing(int, const Pins&) {}
}  // namespace

TEST_CASE("contract 8: the carrier's phase does not depend on its amplitude, which is right to 0.25 %") {
    Instrument instrument;
    EmissionModel model(channels);
    std::vector<Emission> emissions(channels);
    std::mt19937_64 random(Catch::rngSeed());
    for (std::size_t k = 0; k < channels; ++k)  // also across the cycle's start
        emissions[k].phase = static_cast<std::uint16_t>(k < 20 ? 52 * k + 65536 - 520 : random());
    std::vector<std::complex<double>> turn(cycle_ticks);
    for (int t = 0; t < cycle_ticks; ++t)  // the middle of a tick
        turn[static_cast<std::size_t>(t)] = std::polar(1.0, 2 * std::numbers::pi * (t + 0.5) / cycle_ticks);
    double worst_amplitude = 0, worst_phase = 0;
    std::array<double, channels> spread_low{}, spread_high{};
    bool any = false;
    for (int step = 0; step <= 120; ++step) {
        for (Emission& e : emissions)
            e.amplitude = static_cast<std::uint16_t>(step == 120 ? 65535 : step * 546 + random() % 546);
        const std::vector<EmissionWord> words = model.period(emissions, {});
        instrument.cycle(words, nothing);
        instrument.cycle(words, nothing);  // the last pulses of the amplitude before end in it
        std::array<std::complex<double>, channels> sum{};
        instrument.cycle(words, [&](int tick, const Pins& pins) {
            for (std::size_t k = 0; k < channels; ++k)
                if (high(pins, k)) sum[k] += turn[static_cast<std::size_t>(tick)];
        });
        for (std::size_t k = 0; k < channels; ++k) {
            const double got = std::abs(sum[k]) * std::numbers::pi / cycle_ticks;  // a pulse of half the cycle has 1
            const double wanted = emissions[k].amplitude / 65535.0;
            worst_amplitude = std::max(worst_amplitude, std::abs(got - wanted));
            if (std::abs(sum[k]) < 0.5) continue;  // no pulse, no phase
            const double ticks = std::arg(sum[k]) / (2 * std::numbers::pi) * cycle_ticks;
            const double off = std::remainder(ticks - emissions[k].phase / 65536.0 * cycle_ticks, cycle_ticks);
            worst_phase = std::max(worst_phase, std::abs(off));
            if (!any) spread_low[k] = spread_high[k] = off;
            spread_low[k] = std::min(spread_low[k], off);
            spread_high[k] = std::max(spread_high[k], off);
        }
        any = any || step > 1;
    }
    double worst_spread = 0;
    for (std::size_t k = 0; k < channels; ++k) worst_spread = std::max(worst_spread, spread_high[k] - spread_low[k]);
    INFO("worst amplitude " << worst_amplitude << " of full, worst phase " << worst_phase << " ticks, over amplitudes "
                            << worst_spread);
    CHECK(worst_amplitude <= 0.0025);
    CHECK(worst_amplitude > 0.0005);
    CHECK(worst_phase <= 0.501);
    CHECK(worst_spread <= 0.501);
    CHECK(worst_spread > 0.4);
    if (std::getenv("HAPTOGRAM_FIGURES"))
        WARN("worst amplitude " << worst_amplitude << " of full, worst phase " << worst_phase
                                << " ticks, over amplitudes " << worst_spread);
}

TEST_CASE("amplitude modulation of full depth at 200 Hz on all channels loses no pulse") {
    Instrument instrument;
    EmissionModel model(channels);
    std::vector<Emission> emissions(channels);
    for (std::size_t k = 0; k < channels; ++k)  // the first ones around the cycle's start
        emissions[k] = {65535, static_cast<std::uint16_t>(k < 30 ? 65536 - 900 + 60 * k : 655 * k)};
    // The channels whose pulse has its middle in a tick.
    std::vector<std::vector<std::size_t>> middles(cycle_ticks);
    for (std::size_t k = 0; k < channels; ++k) middles[emissions[k].phase * 1250U >> 16].push_back(k);
    std::vector<EmissionWord> before(channels), playing(channels), next(channels);
    Pins last{};
    long wanted = 0, lost = 0, edges = 0, early = 0;
    const auto cycles = static_cast<int>(haptogram::test::soaked(3400, 800));  // 17 or 4 periods of the modulation
    for (int n = 0; n < cycles; ++n) {
        EmissionPeriod period;
        period.modulation =
            static_cast<std::uint8_t>(std::lround(255 * (0.5 - 0.5 * std::cos(2 * std::numbers::pi * 200 * n / 40e3))));
        before = playing;
        playing = next;
        next = model.period(emissions, period);
        for (std::size_t k = 0; k < channels; ++k) {
            wanted += playing[k].width > 0;
            early += playing[k].early;
        }
        instrument.cycle(next, [&](int tick, const Pins& pins) {
            for (std::size_t i = 0; i < pins.size(); ++i) edges += std::popcount(pins[i] & ~last[i]);
            last = pins;
            for (const std::size_t k : middles[static_cast<std::size_t>(tick)])
                lost += (tick < cycle_ticks - 3 ? playing : before)[k].width > 1 && !high(pins, k);
        });
    }
    INFO(wanted << " pulses wanted, " << lost << " lost, " << edges << " edges, " << early << " early");
    CHECK(wanted >= cycles * 88L);
    CHECK(early > cycles * 3);
    CHECK(lost == 0);
    CHECK(std::abs(edges - wanted) <= static_cast<long>(channels));  // those at the very end
    if (std::getenv("HAPTOGRAM_FIGURES"))
        WARN(wanted << " pulses wanted, " << lost << " lost, " << edges << " edges, " << early << " early");
}

TEST_CASE(
    "contract 8: each pulse is of one sample, its middle within half a tick of its phase, whatever comes before and "
    "after it") {
    enum class Samples { alternating, random, sine };
    const auto kind = GENERATE(Samples::alternating, Samples::random, Samples::sine);
    Instrument instrument;
    EmissionModel model(channels);
    std::mt19937_64 random(Catch::rngSeed());
    std::vector<Emission> emissions(channels);  // phases 0 and 32/256, many about tick 0, and others
    for (std::size_t k = 0; k < channels; ++k)
        emissions[k].phase = static_cast<std::uint16_t>(k == 0   ? 0
                                                        : k == 1 ? 32 << 8
                                                        : k < 40 ? 52 * k + 65536 - 1040
                                                                 : random());
    struct Wanted {
        double middle;
        long width;
    };
    struct Edges {
        long rise, fall;
    };
    std::array<std::vector<Wanted>, channels> wanted;
    std::array<std::vector<Edges>, channels> seen;
    Pins last{};
    for (int n = 0; n < 400; ++n) {
        for (Emission& e : emissions)
            e.amplitude = static_cast<std::uint16_t>(kind == Samples::alternating ? (n % 2 == 0 ? 65535U : 0U)
                                                     : kind == Samples::random
                                                         ? random() % 65536
                                                         : std::lround(32767.5 + 32767.5 * std::cos(n / 2.0)));
        const std::vector<EmissionWord> next = model.period(emissions, {});
        for (std::size_t k = 0; k < channels; ++k) {
            // From the emission itself, not from the word: a middle and a width.
            const auto width = static_cast<long>(emission_ticks(emissions[k].amplitude, cycle_ticks, 1));
            if (width == 0) continue;
            wanted[k].push_back({(n + 1) * cycle_ticks + emissions[k].phase / 65536.0 * cycle_ticks, width});
        }
        instrument.cycle(next, [&](int tick, const Pins& pins) {
            const long now = static_cast<long>(n - (tick >= cycle_ticks - 3)) * cycle_ticks + tick;
            for (std::size_t k = 0; k < channels; ++k) {
                if (high(pins, k) && !high(last, k)) seen[k].push_back({now, now});
                if (!high(pins, k) && high(last, k)) seen[k].back().fall = now;
            }
            last = pins;
        });
    }
    std::size_t compared = 0, wrong = 0;
    for (std::size_t k = 0; k < channels; ++k)
        for (std::size_t i = 0; i + 2 < wanted[k].size(); ++i, ++compared) {
            REQUIRE(i < seen[k].size());
            const auto [rise, fall] = seen[k][i];
            const double middle = static_cast<double>(rise + fall) / 2;
            wrong += fall - rise != wanted[k][i].width || std::abs(middle - wanted[k][i].middle) > 0.501;
        }
    CHECK(compared > (kind == Samples::alternating ? 19'000U : 35'000U));
    CHECK(wrong == 0);
}
