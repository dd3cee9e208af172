// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>

#include "../refusal.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/format/emission.hpp"

using namespace haptogram;

namespace {
/// Amplitude of a pulse's carrier, 1 for half a cycle: the Fourier sum over its ticks.
double carrier(std::uint32_t width, std::uint32_t cycle) {
    std::complex<double> sum;
    for (std::uint32_t t = 0; t < width; ++t) sum += std::polar(1.0, 2 * std::numbers::pi * t / cycle);
    return std::abs(sum) * std::sin(std::numbers::pi / cycle);
}
}  // namespace

TEST_CASE("emission: a pulse's carrier has the amplitude and the phase that were asked for", "[emission]") {
    struct Case {
        std::uint32_t cycle;
        double amplitude_error;  // half a step of the table, and half a tick: pi / (2 cycle)
    };
    for (const auto& [cycle, limit] : {Case{1250, 0.0018}, {1249, 0.0018}, {512, 0.0036}, {2046, 0.0014}}) {
        EmissionModel model(1);
        EmissionPeriod settings;
        settings.cycle_ticks = cycle;
        std::mt19937_64 random(Catch::rngSeed());
        double worst = 0.0;
        double worst_phase = 0.0;
        for (int i = 0; i < 70000; ++i) {
            const Emission wanted{static_cast<std::uint16_t>(std::min(i, 65535)), static_cast<std::uint16_t>(random())};
            const EmissionWord word = model.period(std::span(&wanted, 1), settings).front();
            const double full = carrier(cycle / 2, cycle);
            const double got = word.width == 0 ? 0.0 : carrier(word.width, cycle) / full;
            worst = std::max(worst, std::abs(got - wanted.amplitude / 65535.0));
            REQUIRE(!word.bent);
            if (word.width == 0) {
                REQUIRE(word.rise == 2047);
                REQUIRE(wanted.amplitude < 1024 * 65536 / 1000 / 20);
                continue;
            }
            REQUIRE(word.rise < cycle);
            REQUIRE((word.rise + word.width) % cycle == word.fall);
            const double middle = word.rise + word.width / 2.0;
            const double phase = wanted.phase / 65536.0 * cycle;
            worst_phase = std::max(worst_phase, std::abs(std::remainder(middle - phase, cycle)));
            // Early is a pulse that has begun before the cycle in which its middle is.
            REQUIRE(word.early == (word.rise > word.fall && phase < cycle / 2.0 && word.fall > 0));
        }
        INFO("cycle of " << cycle << ": worst amplitude " << worst);
        CHECK(worst <= limit);
        CHECK(worst > limit / 4);
        CHECK(worst_phase <= 0.5);
        CHECK(worst_phase > 0.45);
    }
}

TEST_CASE("emission: the table's steps are those of the arcsine", "[emission]") {
    CHECK(arcsine_step(0) == 0);
    CHECK(arcsine_step(1023) == 65535);
    for (std::uint32_t i = 1; i < 1023; ++i) {
        // The other way round: the sine of the width is the middle of the step.
        const double amplitude = std::sin(arcsine_step(i) * std::numbers::pi / (1 << 17));
        REQUIRE(amplitude * 1024 - i == Approx(0.5).margin(0.014));
        REQUIRE(arcsine_step(i) > arcsine_step(i - 1));
    }
    CHECK_REFUSED(arcsine_step(1024));
}

TEST_CASE("emission: no pulse is shorter than the board's shortest, and none lies nearer to what was asked for",
          "[emission]") {
    const std::uint32_t cycle = 1250;
    EmissionPeriod settings;
    settings.cycle_ticks = cycle;
    const double full = carrier(cycle / 2, cycle);
    for (const std::uint32_t least : {2U, 5U, 8U}) {
        EmissionModel model(1, 11, 10, least);
        std::uint32_t longest = 0;
        for (std::uint32_t i = 0; i < 65536; ++i) {
            const Emission wanted{static_cast<std::uint16_t>(i), 12345};
            const EmissionWord word = model.period(std::span(&wanted, 1), settings).front();
            REQUIRE((word.width == 0 || word.width >= least));
            REQUIRE(word.width >= longest);  // it grows with the amplitude
            longest = word.width;
            const double got = word.width == 0 ? 0.0 : carrier(word.width, cycle) / full;
            // Half of the shortest pulse, or what contract 8 allows.
            const double limit = std::max(0.0025, carrier(least, cycle) / full / 2 + 0.0015);
            REQUIRE(std::abs(got - i / 65535.0) <= limit);
        }
        REQUIRE(longest == cycle / 2);
    }
}

TEST_CASE("emission: modulation multiplies, 255 changes nothing, and raw pulses are not modulated", "[emission]") {
    EmissionModel model(3);
    const std::vector<Emission> wanted = {{65535, 100}, {30000, 100}, {255, 100}};
    for (const int sample : {0, 1, 77, 128, 254, 255}) {
        EmissionPeriod settings;
        settings.modulation = static_cast<std::uint8_t>(sample);
        (void)model.period(wanted, settings);
        for (std::size_t k = 0; k < wanted.size(); ++k) {
            const double product = wanted[k].amplitude * sample / 255.0;
            CHECK(std::abs(model.places()[k].amplitude - product) <= 1.0);
            if (sample == 255) CHECK(model.places()[k] == wanted[k]);
        }
    }
    EmissionPeriod raw;
    raw.raw = true;
    raw.raw_ticks = 125;
    raw.modulation = 7;
    const auto words = model.period(std::vector<Emission>{{0, 10}, {0, 1200}, {0, 1250}}, raw);
    CHECK(words[0] == EmissionWord{false, 10, 135, 125, false});
    CHECK(words[1] == EmissionWord{false, 1200, 75, 125, false});
    CHECK(words[2] == EmissionWord{false, 2047, 2047, 0, false});  // a tick that the cycle does not have
    raw.cycle_ticks = 100'000;
    CHECK(model.period(std::vector<Emission>{{0, 2046}, {0, 2047}, {0, 5000}}, raw)[0].fall == (2046 + 125) % 2048);
}

TEST_CASE("contract 8: how far amplitudes and widths are off by the table's steps and whole ticks", "[emission]") {
    struct Bound {
        std::uint32_t cycle;
        double amplitude, width, modulated_width;
    };
    for (const Bound& bound : {Bound{1250, 0.0025, 1.8, 18}, Bound{2046, 0.0025, 3.4, 29}}) {
        double amplitude_off = 0, width_off = 0, modulated_off = 0;
        for (std::uint32_t amplitude = 0; amplitude < 65536; ++amplitude) {
            const std::uint32_t ticks = emission_ticks(static_cast<std::uint16_t>(amplitude), bound.cycle, 1);
            const double exact = std::asin(amplitude / 65535.0) / std::numbers::pi * bound.cycle;
            const double off = std::abs(ticks - exact);
            amplitude_off = std::max(amplitude_off,
                                     std::abs(std::sin(std::numbers::pi * ticks / bound.cycle) - amplitude / 65535.0));
            modulated_off = std::max(modulated_off, off);
            if (amplitude % 257 == 0) width_off = std::max(width_off, off);  // of a record, 8 bits
        }
        CHECK(amplitude_off <= bound.amplitude);
        CHECK(width_off <= bound.width);
        CHECK(width_off > bound.width - 0.15);
        CHECK(modulated_off <= bound.modulated_width);
    }
}

TEST_CASE("emission: the slew limit by rate and by arrival", "[emission]") {
    EmissionModel model(1);
    EmissionPeriod settings;
    const Emission from{1000, 65000};
    (void)model.period(std::span(&from, 1), settings);
    const Emission to{41000, 1464};  // 2,000 on, over the end of the turn
    settings.slew = {Slew::rate, 500, 20000, 1};
    for (int n = 1; n <= 4; ++n) {
        const auto word = model.period(std::span(&to, 1), settings).front();
        CHECK(model.places()[0].phase == (65000 + 500 * n) % 65536);
        CHECK(model.places()[0].amplitude == std::min(1000 + 20000 * n, 41000));
        CHECK(word.bent == (n < 4));
    }
    settings.slew = {Slew::arrive, 1, 1, 10};
    for (int n = 1; n <= 10; ++n) {
        settings.new_target = n == 1;
        const auto word = model.period(std::span(&from, 1), settings).front();
        CHECK(std::abs(model.places()[0].amplitude - (41000 - 4000 * n)) <= 10);
        CHECK(word.bent == (n < 10));
    }
    CHECK(model.places()[0] == from);
    // What the pins did meanwhile was silence, or is not known: from amplitude 0, with the phase at its target.
    settings.slew = {Slew::rate, 500, 3000, 1};
    EmissionPeriod raw;
    raw.raw = true;
    for (const bool silence : {true, false}) {
        if (silence)
            model.start_from_silence();
        else
            (void)model.period(std::span(&from, 1), raw);
        for (int n = 1; n <= 3; ++n) {
            (void)model.period(std::span(&to, 1), settings);
            CHECK(model.places()[0] == Emission{static_cast<std::uint16_t>(3000 * n), to.phase});
        }
    }
}

TEST_CASE("emission: what cannot be played is refused, with what to do", "[emission]") {
    CHECK_REFUSED(EmissionModel(0));
    CHECK_REFUSED(EmissionModel(1, 3));
    CHECK_REFUSED(EmissionModel(1, 11, 12));
    CHECK_REFUSED(EmissionModel(1, 11, 10, 0));
    CHECK_REFUSED(EmissionModel(1, 11, 10, 1024));
    EmissionModel model(2);
    const std::vector<Emission> two(2);
    const auto refused = [&](auto change) {
        EmissionPeriod settings;
        change(settings);
        try {
            (void)model.period(two, settings);
        } catch (const Error& error) {
            CHECK(error.code() == ErrorCode::bad_input);
            return heard::Refusal(error);
        }
        return heard::Refusal();
    };
    CHECK_REFUSED(model.period(std::vector<Emission>(3), {}));
    CHECK_REFUSAL(refused([](auto& s) { s.cycle_ticks = 2047; }));
    CHECK_REFUSAL(refused([](auto& s) { s.cycle_ticks = 1; }));
    CHECK_REFUSAL(refused([](auto& s) { s.raw = true, s.cycle_ticks = 2049; }));
    CHECK_REFUSAL(refused([](auto& s) { s.raw = true, s.raw_ticks = 1024; }));
    CHECK_REFUSAL(refused([](auto& s) { s.raw = true, s.raw_ticks = s.cycle_ticks = 50; }));
    CHECK_REFUSAL(refused([](auto& s) { s.slew = {Slew::rate, 0, 1, 1}; }));
    CHECK_REFUSAL(refused([](auto& s) { s.slew = {Slew::rate, 1, 0, 1}; }));
    CHECK_REFUSAL(refused([](auto& s) { s.slew = {Slew::arrive, 1, 1, 0}; }));
    CHECK_REFUSAL(refused([](auto& s) { s.slew = {Slew::none, 1, 1, 4096}; }));
    CHECK(model.places() == two);  // nothing has moved
}
