// SPDX-License-Identifier: Apache-2.0
// rtl/amplitudes/emission.v against the host's model, word for word, with random settings in each period. What the
// model itself computes is held against double precision in tests/unit/test_emission.cpp.
#include <Vemission.h>

#include <algorithm>
#include <cstdlib>
#include <vector>

#include "bench.hpp"
#include "haptogram/format/emission.hpp"

using namespace haptogram;

namespace {
constexpr std::uint32_t channels = PARAMETER_CHANNELS;
constexpr std::uint32_t bits = PARAMETER_TIMING_BITS;
constexpr std::uint32_t ticks = 1U << bits;
constexpr std::uint32_t longest = (1U << PARAMETER_WIDTH_BITS) - 1;
constexpr bool slews = PARAMETER_SLEW != 0;

EmissionPeriod random_period(Bench<Vemission>& bench, const EmissionPeriod& before) {
    const auto number = [&](std::uint32_t low, std::uint32_t high) {
        return static_cast<std::uint32_t>(bench.number(static_cast<int>(low), static_cast<int>(high)));
    };
    EmissionPeriod period = before;
    period.raw = number(0, 9) == 0;
    if (period.raw) {
        period.cycle_ticks = number(0, 3) ? number(2, ticks) : number(ticks + longest + 1, 1U << 20);
        period.raw_ticks = number(0, std::min(longest, period.cycle_ticks - 1));
    } else if (before.raw || number(0, 3) == 0) {
        period.cycle_ticks = number(0, 2) == 0 ? number(2, 2 * longest) : std::min(1250U, 2 * longest);
    }
    period.modulation = static_cast<std::uint8_t>(number(0, 2) ? 255 : number(0, 255));
    period.new_target = number(0, 9) == 0;
    if (slews && number(0, 5) == 0) {
        period.slew.mode = static_cast<Slew>(number(0, 2));
        period.slew.phase_rate = static_cast<std::uint16_t>(number(1, number(0, 1) ? 65535 : 3000));
        period.slew.amplitude_rate = static_cast<std::uint16_t>(number(1, number(0, 1) ? 65535 : 3000));
        period.slew.arrival_periods = static_cast<std::uint16_t>(number(1, number(0, 1) ? 4095 : 12));
    }
    return period;
}

void set(Bench<Vemission>& bench, const EmissionPeriod& period) {
    bench->i_modulation = period.modulation;
    bench->i_cycle = static_cast<std::uint16_t>(period.cycle_ticks > ticks ? 2 * ticks - 1 : period.cycle_ticks);
    bench->i_raw = period.raw;
    bench->i_raw_width = static_cast<std::uint16_t>(period.raw_ticks);
    bench->i_slew = static_cast<std::uint8_t>(period.slew.mode);
    bench->i_phase_rate = period.slew.phase_rate;
    bench->i_amplitude_rate = period.slew.amplitude_rate;
    bench->i_arrival_periods = period.slew.arrival_periods;
    bench->i_new_target = period.new_target;
}
}  // namespace

TEST_CASE("the words of emission.v are those of the host's model") {
    Bench<Vemission> bench;
    EmissionModel model(channels, bits, PARAMETER_WIDTH_BITS, PARAMETER_LEAST_WIDTH);
    EmissionPeriod period;
    period.cycle_ticks = std::min(1250U, 2 * longest);
    set(bench, period);
    bench->i_begin = bench->i_valid = bench->i_last = bench->i_off = 0;
    bench->i_amplitude = bench->i_phase = 0;
    bench.reset();
    std::vector<Emission> emissions(channels);
    long words = 0, wrong = 0, early = 0, bent = 0, silent = 0, raw = 0;
    while (words < (slews ? 2'200'000 : 300'000)) {
        period = random_period(bench, period);
        for (Emission& e : emissions)
            if (bench.number(0, 4) == 0) {
                const int kind = bench.number(0, 9);
                e.amplitude = static_cast<std::uint16_t>(kind == 0 ? 0 : kind == 1 ? 65535 : bench.number(0, 65535));
                // Few ticks when raw, so that most of them can be played; otherwise often near the cycle's start.
                e.phase =
                    static_cast<std::uint16_t>(bench.number(0, 3) ? bench.number(0, 65535) : bench.number(-400, 400));
            }
        std::vector<Emission> given = emissions;
        if (period.raw)
            for (Emission& e : given)
                e.phase = static_cast<std::uint16_t>(e.phase % (bench.chance(0.9) ? ticks + 9 : 65536));
        if (bench.chance(0.02)) {
            bench->i_off = 1;
            bench.clock();
            bench->i_off = 0;
            model.start_from_silence();
        }
        const std::vector<EmissionWord> expected = model.period(given, period);

        set(bench, period);
        bench->i_begin = 1;
        bench.clock();
        bench->i_begin = 0;
        bench->i_new_target = 0;
        int waited = 0;
        while (!bench->o_ready) {
            REQUIRE(++waited < 20);
            bench.clock();
        }
        const bool gaps = bench.chance(0.1);
        std::size_t sent = 0, got = 0;
        for (int clock = 0; got < channels; ++clock) {
            REQUIRE(clock < 20 * static_cast<int>(channels) + 20);
            bench->i_valid = sent < channels && (!gaps || bench.chance(0.5));
            if (bench->i_valid) {
                bench->i_amplitude = given[sent].amplitude;
                bench->i_phase = given[sent].phase;
                bench->i_last = ++sent == channels;
            }
            if (bench->o_valid) {
                const EmissionWord& e = expected[got++];
                const std::uint32_t word = static_cast<std::uint32_t>(e.early) << 2 * bits | e.fall << bits | e.rise;
                if (bench->o_word != word || bench->o_width != e.width || bench->o_bent != e.bent ||
                    bench->o_last != (got == channels))
                    ++wrong;
                ++words;
                early += e.early;
                bent += e.bent;
                silent += e.width == 0;
                raw += period.raw && e.width > 0;
            }
            bench.clock();
        }
        bench->i_valid = 0;
        REQUIRE(!bench->o_valid);
    }
    INFO(words << " words, " << early << " early, " << bent << " bent, " << silent << " silent, " << raw << " raw, "
               << wrong << " wrong");
    CHECK(wrong == 0);
    CHECK(early > words / 100);
    CHECK((bent > words / 20) == slews);
    CHECK(silent > words / 100);
    CHECK(raw > words / 100);
    if (std::getenv("HAPTOGRAM_FIGURES"))
        WARN(words << " words, " << early << " early, " << bent << " bent, " << silent << " silent, " << raw << " raw, "
                   << wrong << " wrong");
}

TEST_CASE("a reset in the middle of a period leaves no words behind") {
    Bench<Vemission> bench;
    set(bench, {});
    bench->i_begin = bench->i_valid = bench->i_last = bench->i_off = 0;
    bench->i_amplitude = 65535;
    bench->i_phase = 32768;
    bench.reset();
    bench->i_valid = 1;
    for (int i = 0; i < 7; ++i) bench.clock();
    bench->i_valid = 0;
    bench->rst = 1;
    bench.clock();
    bench->rst = 0;
    for (int i = 0; i < 20; ++i) {
        bench.clock();
        CHECK(!bench->o_valid);
    }
}
