// SPDX-License-Identifier: Apache-2.0
// What the slew limiter promises, without its formula: how far a channel goes in a period, and when it arrives.
#include <Vslew_limiter.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "bench.hpp"

namespace {
constexpr std::size_t channels = PARAMETER_CHANNELS;
struct Place {
    int amplitude = 0;
    int phase = 0;
    friend bool operator==(const Place&, const Place&) = default;
};
using Places = std::array<Place, channels>;

class Limiter {
public:
    Bench<Vslew_limiter> bench;
    std::array<bool, channels> bent{};

    Limiter() {
        bench->i_begin = bench->i_new_target = bench->i_hold = bench->i_off = bench->i_valid = 0;
        bench->i_mode = 0;
        bench->i_phase_rate = bench->i_amplitude_rate = 65535;
        bench->i_arrival_periods = 1;
        bench->i_amplitude = bench->i_phase = 0;
        bench.reset();
    }

    Places period(const Places& targets, bool new_target = false) {
        bench->i_begin = 1;
        bench->i_new_target = new_target;
        bench.clock();
        bench->i_begin = bench->i_new_target = 0;
        while (!bench->o_ready) bench.clock();
        Places result{};
        for (std::size_t clock = 0; clock < channels + 7; ++clock) {
            bench->i_valid = clock < channels;
            if (clock < channels) {
                bench->i_amplitude = static_cast<std::uint16_t>(targets[clock].amplitude);
                bench->i_phase = static_cast<std::uint16_t>(targets[clock].phase);
            }
            if (clock >= 5 && clock < channels + 5) result[clock - 5] = {bench->o_amplitude, bench->o_phase};
            if (clock >= 6 && clock < channels + 6) bent[clock - 6] = bench->o_bent;
            bench.clock();
        }
        bench->i_valid = 0;
        return result;
    }
    Places random_places() {
        Places result;
        for (Place& p : result) p = {bench.number(0, 65535), bench.number(0, 65535)};
        return result;
    }
};

/// From one phase to another the shorter way round, −32768…32767.
int turn(int from, int to) { return static_cast<std::int16_t>(to - from); }
}  // namespace

TEST_CASE(
    "rate: at most so much a period, straight on, the phase the shorter way round, and exactly there at the end") {
    Limiter limiter;
    for (int round = 0; round < 60; ++round) {
        limiter.bench->i_mode = 0;
        const Places from = limiter.random_places();
        REQUIRE(limiter.period(from) == from);
        Places to = limiter.random_places();
        to[0].phase = (from[0].phase + 32767) & 65535;
        to[1].phase = (from[1].phase + 32769) & 65535;
        to[2].phase = (from[2].phase + 32768) & 65535;  // exactly opposite: backwards
        limiter.bench->i_mode = 1;
        const int phase_rate = limiter.bench.number(100, 8000), amplitude_rate = limiter.bench.number(100, 8000);
        limiter.bench->i_phase_rate = static_cast<std::uint16_t>(phase_rate);
        limiter.bench->i_amplitude_rate = static_cast<std::uint16_t>(amplitude_rate);
        Places now = from;
        for (int n = 1; n <= 660; ++n) {
            const Places next = limiter.period(to);
            for (std::size_t k = 0; k < channels; ++k) {
                const int way = turn(from[k].phase, to[k].phase), rise = to[k].amplitude - from[k].amplitude;
                // n periods bring it n times the rate along its way, and never past its end.
                const int phase = std::min(std::abs(way), n * phase_rate) * (way < 0 ? -1 : 1);
                const int amplitude = std::min(std::abs(rise), n * amplitude_rate) * (rise < 0 ? -1 : 1);
                REQUIRE(turn(from[k].phase, next[k].phase) == phase);
                REQUIRE(next[k].amplitude - from[k].amplitude == amplitude);
                REQUIRE(limiter.bent[k] == (next[k] != to[k]));
            }
            now = next;
            if (now == to) break;
        }
        REQUIRE(now == to);
    }
}

TEST_CASE("arrive: exactly there in the last of n periods, on a straight way, the phase the shorter way round") {
    Limiter limiter;
    double worst = 0;
    for (const int n : {1, 2, 3, 7, 40, 200, 1000, 4095}) {
        for (int round = 0; round < (n > 500 ? 2 : 20); ++round) {
            limiter.bench->i_mode = 0;
            const Places from = limiter.random_places(), to = limiter.random_places();
            limiter.period(from);
            limiter.bench->i_mode = 2;
            limiter.bench->i_arrival_periods = static_cast<std::uint16_t>(n);
            Places before = from;
            for (int p = 1; p <= n; ++p) {
                const Places now = limiter.period(to, p == 1);
                for (std::size_t k = 0; k < channels; ++k) {
                    const double part = static_cast<double>(p) / n;
                    const double phase_off =
                        turn(from[k].phase, now[k].phase) - part * turn(from[k].phase, to[k].phase);
                    const double amplitude_off =
                        now[k].amplitude - from[k].amplitude - part * (to[k].amplitude - from[k].amplitude);
                    const int rise = to[k].amplitude - from[k].amplitude;
                    // Rounding 1/r down bends the way by n / 2^17 of it. Each step is rounded down by less than a unit,
                    // of which r/r' is left when r' periods have become r: in all r · ln(n/r), which is largest at r =
                    // n/e.
                    const double slack = 2 + n / std::numbers::e;
                    REQUIRE(std::abs(phase_off) <= 32768.0 * n / 131072 + slack);
                    REQUIRE(std::abs(amplitude_off) <= std::abs(rise) * (n / 131072.0) + slack);
                    worst = std::max(worst, std::abs(amplitude_off) / n);
                    REQUIRE(std::abs(turn(now[k].phase, to[k].phase)) <= std::abs(turn(before[k].phase, to[k].phase)));
                    REQUIRE(limiter.bent[k] == (now[k] != to[k]));
                }
                before = now;
            }
            REQUIRE(before == to);
            const Places later = limiter.random_places();  // and then as if there were no limit
            REQUIRE(limiter.period(later) == later);
        }
    }
    INFO("worst off the straight way: " << worst << " units a period of n");
    CHECK(worst < 1);
    CHECK(worst > 0.01);
}

TEST_CASE("a limiter that is switched on starts from where the channels are") {
    Limiter limiter;
    const Places from = limiter.random_places();
    limiter.period(from);
    limiter.bench->i_mode = 1;
    limiter.bench->i_phase_rate = limiter.bench->i_amplitude_rate = 5;
    const Places now = limiter.period(limiter.random_places());
    for (std::size_t k = 0; k < channels; ++k) {
        CHECK(std::abs(turn(from[k].phase, now[k].phase)) <= 5);
        CHECK(std::abs(now[k].amplitude - from[k].amplitude) <= 5);
    }
}

TEST_CASE(
    "behind a reset, raw words and outputs that were off, a limit starts from silence, each phase where it is to be") {
    Limiter limiter;
    enum class Before { reset, raw, off, off_in_begin };
    const auto before = GENERATE(Before::reset, Before::raw, Before::off, Before::off_in_begin);
    const int mode = GENERATE(1, 2);
    limiter.period(limiter.random_places());
    switch (before) {
        case Before::reset: limiter.bench.reset(); break;
        case Before::raw: {
            limiter.bench->i_hold = 1;
            const Places raw = limiter.random_places();
            CHECK(limiter.period(raw) == raw);
            CHECK(std::none_of(limiter.bent.begin(), limiter.bent.end(), [](bool b) { return b; }));
            limiter.bench->i_hold = 0;
            break;
        }
        case Before::off:
            limiter.bench->i_off = 1;
            limiter.bench.clock();
            limiter.bench->i_off = 0;
            break;
        case Before::off_in_begin:  // this period is silent for its first clocks, so the next one starts anew
            limiter.bench->i_off = 1;
            limiter.bench->i_begin = 1;
            limiter.bench.clock();
            limiter.bench->i_off = limiter.bench->i_begin = 0;
            break;
    }
    limiter.bench->i_mode = static_cast<std::uint8_t>(mode);
    limiter.bench->i_phase_rate = 5;
    limiter.bench->i_amplitude_rate = 900;
    limiter.bench->i_arrival_periods = 10;
    const Places to = limiter.random_places();
    for (int n = 1; n <= 3; ++n) {
        const Places now = limiter.period(to, n == 1);
        for (std::size_t k = 0; k < channels; ++k) {
            CHECK(now[k].phase == to[k].phase);
            const int way = mode == 1 ? std::min(900 * n, to[k].amplitude) : to[k].amplitude * n / 10;
            CHECK(std::abs(now[k].amplitude - way) <= (mode == 1 ? 0 : 5));
        }
    }
    const Places other = limiter.random_places();  // and from then on from where they are
    const Places now = limiter.period(other, true);
    for (std::size_t k = 0; k < channels; ++k)
        if (std::abs(turn(to[k].phase, other[k].phase)) > 100) CHECK(now[k].phase != other[k].phase);
}

TEST_CASE("a new target on the way counts from there") {
    Limiter limiter;
    const Places from = limiter.random_places(), first = limiter.random_places(), second = limiter.random_places();
    limiter.period(from);
    limiter.bench->i_mode = 2;
    limiter.bench->i_arrival_periods = 10;
    for (int p = 0; p < 4; ++p) limiter.period(first, p == 0);
    Places now{};
    for (int p = 0; p < 10; ++p) {
        REQUIRE(now != second);
        now = limiter.period(second, p == 0);
    }
    REQUIRE(now == second);
}
