// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <random>

#include "../refusal.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/format/focus_engine.hpp"
#include "haptogram/solve/drives.hpp"
#include "haptogram/solve/focal_law.hpp"

using namespace haptogram;

namespace {

using Exact = std::complex<long double>;
constexpr long double two_pi = 2.0L * std::numbers::pi_v<long double>;

/// A channel or a focus as whole units, chosen here and packed by hand, so that nothing is shared with the code under
/// test.
struct Place {
    long x = 0, y = 0, z = 0;
};

FocusWords words_of(const Place& focus, unsigned amplitude) {
    const auto low = [](long value) { return static_cast<std::uint16_t>(value & 0xffff); };
    const auto high = [](long value) { return static_cast<unsigned>(value >> 16 & 3); };
    return {low(focus.x), low(focus.y), low(focus.z),
            static_cast<std::uint16_t>(amplitude << 8 | high(focus.z) << 4 | high(focus.y) << 2 | high(focus.x))};
}

/// What a channel should radiate so that its waves reach the foci in phase: amplitude · e^(j·2π·(offset − distance/λ)),
/// as a lateness, summed up over the foci.
Exact ideal(const Place& channel, std::uint16_t offset, std::span<const Place> foci,
            std::span<const unsigned> amplitudes, std::uint32_t wave_number) {
    Exact sum = 0;
    for (std::size_t f = 0; f < foci.size(); ++f) {
        const long double distance =
            std::hypot(static_cast<long double>(foci[f].x - channel.x), static_cast<long double>(foci[f].y - channel.y),
                       static_cast<long double>(foci[f].z - channel.z));
        sum += std::polar(static_cast<long double>(amplitudes[f]) / 255.0L,
                          two_pi * (offset / 65536.0L - distance * wave_number / 0x1p27L));
    }
    return sum;
}

struct Worst {
    double phase = 0.0;      // of 1/256 turn
    double amplitude = 0.0;  // of one full focus
    std::size_t cases = 0;
};

/// Random records of so many foci, each on 100 channels within 100 mm, for foci within 100 mm of the axis and 20 to 280
/// mm high. Sums count when they are longer than a quarter of what their foci add up to.
Worst worst_of(std::mt19937_64& g, std::size_t records, std::size_t fewest, std::size_t most) {
    const auto any = [&](long low, long high) { return std::uniform_int_distribution<long>(low, high)(g); };
    Worst worst;
    for (std::size_t r = 0; r < records; ++r) {
        FocusEngine engine;
        engine.wave_number = static_cast<std::uint32_t>(any(115'000, 127'000));  // 40 kHz at 330 to 365 m/s
        engine.gain = gain_word(8.0);
        std::vector<Place> channels(100);
        for (Place& channel : channels) {
            channel = {any(-12'800, 12'800), any(-12'800, 12'800), any(-400, 400)};
            engine.geometry.push_back(
                {static_cast<std::uint16_t>(channel.x & 0xffff), static_cast<std::uint16_t>(channel.y & 0xffff),
                 static_cast<std::uint16_t>(channel.z & 0xffff), static_cast<std::uint16_t>(256 * any(0, 255))});
        }
        std::vector<Place> foci(static_cast<std::size_t>(any(static_cast<long>(fewest), static_cast<long>(most))));
        std::vector<unsigned> amplitudes;
        std::vector<FocusWords> words;
        double total = 0.0;
        for (Place& focus : foci) {
            focus = {any(-12'800, 12'800), any(-12'800, 12'800), any(2'560, 35'840)};
            amplitudes.push_back(static_cast<unsigned>(any(1, 255)));
            words.push_back(words_of(focus, amplitudes.back()));
            total += amplitudes.back() / 255.0;
        }
        const std::vector<ChannelDrive> drives = engine_drives(engine, words);
        for (std::size_t k = 0; k < channels.size(); ++k) {
            const Exact sum = ideal(channels[k], engine.geometry[k][3], foci, amplitudes, engine.wave_number);
            const auto length = static_cast<double>(std::abs(sum));
            worst.amplitude = std::max(worst.amplitude, std::abs(drives[k].amplitude * 8.0 / 65535.0 - length));
            if (length <= 0.25 * total) continue;
            const long double turns = std::arg(sum) / two_pi - drives[k].phase / 65536.0L;
            worst.phase = std::max(worst.phase, static_cast<double>(std::abs(std::remainder(turns, 1.0L))) * 256.0);
            ++worst.cases;
        }
    }
    return worst;
}

/// The pressure that drives make at a point, without directivity, and the most that full drives could.
std::complex<double> pressure(const Array& array, std::span<const std::complex<double>> drives, Vec3 point) {
    std::complex<double> sum = 0.0;
    for (std::size_t m = 0; m < drives.size(); ++m) {
        const double r = distance(array.elements[m], point);
        sum += std::polar(1.0 / r, -2.0 * std::numbers::pi * r / array.wavelength_m()) * drives[m];
    }
    return sum;
}

/// A drive as pulses make it: one that starts later by t has e^(−jωt).
std::vector<std::complex<double>> complex_drives(std::span<const ChannelDrive> drives) {
    std::vector<std::complex<double>> result;
    for (const ChannelDrive& drive : drives)
        result.push_back(std::polar(drive.amplitude / 65535.0, -2.0 * std::numbers::pi * drive.phase / 65536.0));
    return result;
}

Vec3 any_focus(std::mt19937_64& g) {
    std::uniform_real_distribution<double> lateral(-0.06, 0.06), height(0.05, 0.25);
    return {lateral(g), lateral(g), height(g)};
}

/// One that words hold exactly.
Vec3 whole_focus(std::mt19937_64& g) {
    const Vec3 focus = any_focus(g) * (1.0 / focus_unit_m);
    return focus_unit_m * Vec3{std::round(focus.x), std::round(focus.y), std::round(focus.z)};
}

}  // namespace

TEST_CASE("focus engine: the phases of a million lone foci and of a million sums", "[focus_engine]") {
    std::mt19937_64 g(Catch::rngSeed());
    const Worst lone = worst_of(g, 10'000, 1, 1);
    const Worst sums = worst_of(g, 14'000, 2, 8);
    INFO("lone foci: " << lone.cases << ", phase " << lone.phase << "/256 turn, amplitude " << lone.amplitude
                       << "; sums: " << sums.cases << ", phase " << sums.phase << "/256 turn, amplitude "
                       << sums.amplitude);
    CHECK(lone.cases == 1'000'000);
    CHECK(lone.phase <= 0.02);
    CHECK(lone.phase > 0.01);  // the phase has 16 bits, rounded down
    CHECK(sums.cases >= 1'000'000);
    CHECK(sums.phase <= 0.15);
    CHECK(sums.phase > 0.08);
    CHECK(lone.amplitude <= 0.001);
    CHECK(sums.amplitude <= 0.005);
}

TEST_CASE("focus engine: phases are the focal law's but for a constant", "[focus_engine]") {
    std::mt19937_64 g(Catch::rngSeed());
    const Array array = find_array("tile-10x10");
    const Timer timer = choose_timer(array, Core{});
    const FocusEngine engine = focus_engine(array);
    const std::size_t elements = array.elements.size();
    double worst_ticks = 0.0;
    double worst_turns = 0.0;
    for (int i = 0; i < 200; ++i) {
        const Vec3 focus = whole_focus(g);
        const std::vector<FocusWords> words{pack_focus({focus, 1.0})};
        const std::vector<ChannelDrive> drives = engine_drives(engine, words);
        const std::vector<std::uint16_t> ticks = focal_law(array, timer, std::vector<Vec3>{focus});
        const auto superposed = superposed_drives(array, std::vector<Focus>{{focus, 1.0}});
        REQUIRE(drives.size() == elements);
        const auto late = [&](std::size_t m) { return -std::arg(superposed[m]) / (2.0 * std::numbers::pi); };
        // The constant, as the mean over the elements.
        std::complex<double> mean = 0.0;
        for (std::size_t m = 0; m < elements; ++m)
            mean += std::polar(1.0, 2.0 * std::numbers::pi * (drives[m].phase / 65536.0 - late(m)));
        const double constant = std::arg(mean) / (2.0 * std::numbers::pi);
        for (std::size_t m = 0; m < elements; ++m) {
            const double phase = drives[m].phase / 65536.0 - constant;
            worst_turns = std::max(worst_turns, std::abs(std::remainder(phase - late(m), 1.0)));
            const double tick = static_cast<double>(ticks[m]) / timer.cycle_ticks;
            worst_ticks = std::max(worst_ticks, std::abs(std::remainder(phase - tick, 1.0)) * timer.cycle_ticks);
        }
    }
    INFO("worst: " << worst_turns * 256.0 << "/256 turn from the drives, " << worst_ticks
                   << " ticks from the focal law");
    CHECK(worst_turns * 256.0 <= 0.05);  // among it the wave number's 18 bits
    CHECK(worst_ticks <= 0.55);          // which rounds to whole ticks
    CHECK(worst_ticks > 0.45);
}

TEST_CASE("focus engine: an offset makes a channel later, whole turns do not count", "[focus_engine]") {
    FocusEngine engine = focus_engine(find_array("tile-10x10"));
    const std::vector<FocusWords> words{pack_focus({{0.01, 0.02, 0.15}, 1.0})};
    const std::uint16_t before = engine_drives(engine, words)[3].phase;
    const Array array = find_array("tile-10x10");
    for (const double turns : {0.25, -0.75, 7.25}) {
        engine.geometry[3] = pack_geometry(array.elements[3].position, turns);
        CHECK(engine_drives(engine, words)[3].phase == static_cast<std::uint16_t>(before + 0x4000));
    }
    CHECK(pack_geometry({}, 0.999)[3] == 0);  // rounds to a whole turn
}

TEST_CASE("focus engine: the pressure at the foci is the ideal one", "[focus_engine]") {
    std::mt19937_64 g(Catch::rngSeed());
    const Array array = find_array("tile-10x10");
    SECTION("one focus: 99.9 % of the sum of all amplitudes") {
        const FocusEngine engine = focus_engine(array);
        double worst = 1.0;
        for (int i = 0; i < 1'000; ++i) {
            const Vec3 focus = any_focus(g);
            const std::vector<FocusWords> words{pack_focus({focus, 1.0})};
            double most = 0.0;
            for (const Element& element : array.elements) most += 1.0 / distance(element, focus);
            worst =
                std::min(worst, std::abs(pressure(array, complex_drives(engine_drives(engine, words)), focus)) / most);
        }
        INFO("worst: " << worst);
        CHECK(worst >= 0.999);
        CHECK(worst <= 1.0);
    }
    SECTION("up to eight foci: within 0.1 % of the strongest, of what the exact sums make at each") {
        double worst_of_all = 0.0;
        for (int i = 0; i < 500; ++i) {
            const std::size_t count = std::uniform_int_distribution<std::size_t>(2, most_record_foci)(g);
            const FocusEngine engine = focus_engine(array, static_cast<double>(count));
            std::vector<Focus> foci;
            std::vector<FocusWords> words;
            for (std::size_t f = 0; f < count; ++f) {
                foci.push_back({whole_focus(g), std::uniform_int_distribution<int>(60, 255)(g) / 255.0});
                words.push_back(pack_focus(foci.back()));
            }
            std::vector<std::complex<double>> exact(array.elements.size());
            for (std::size_t m = 0; m < exact.size(); ++m)
                for (const Focus& focus : foci)
                    exact[m] += std::polar(
                        focus.amplitude / static_cast<double>(count),
                        2.0 * std::numbers::pi * distance(array.elements[m], focus.position) / array.wavelength_m());
            const auto drives = complex_drives(engine_drives(engine, words));
            double strongest = 0.0;
            double worst = 0.0;
            for (const Focus& focus : foci) {
                const double want = std::abs(pressure(array, exact, focus.position));
                strongest = std::max(strongest, want);
                worst = std::max(worst, std::abs(std::abs(pressure(array, drives, focus.position)) - want));
            }
            worst_of_all = std::max(worst_of_all, worst / strongest);
        }
        INFO("worst: " << worst_of_all);
        CHECK(worst_of_all <= 0.001);
    }
}

TEST_CASE("focus engine: amplitude, gain, whole channels and silence", "[focus_engine]") {
    const Array array = find_array("tile-10x10");
    const Focus full{{0.0, 0.0, 0.15}, 1.0};
    const Focus none{{0.0, 0.0, 0.15}, 0.0};
    const Focus half{{0.0, 0.0, 0.15}, 128.0 / 255.0};
    const auto amplitudes = [&](double of_full, std::vector<Focus> foci, bool whole) {
        std::vector<FocusWords> words;
        for (const Focus& focus : foci) words.push_back(pack_focus(focus));
        return engine_drives(focus_engine(array, of_full), words, whole)[0].amplitude;
    };
    CHECK(amplitudes(1.0, {full}, false) >= 65'400);
    CHECK(amplitudes(0.9, {full}, false) == 65'535);  // cut off
    CHECK(amplitudes(1.0, {half}, false) == Approx(65'535.0 * 128 / 255).epsilon(0.002));
    CHECK(amplitudes(8.0, std::vector<Focus>(8, full), false) >= 65'400);
    CHECK(amplitudes(8.0, {full}, false) == Approx(65'535.0 / 8).epsilon(0.002));
    CHECK(amplitudes(8.0, {half, none}, true) == 65'535);
    CHECK(amplitudes(1.0, {none}, false) == 0);
    CHECK(amplitudes(1.0, {none, none}, true) == 0);
    CHECK(amplitudes(1.0, {none}, true) == 0);
}

TEST_CASE("focus engine: a channel has its weight of the amplitude, also of one that is cut off", "[focus_engine]") {
    const Array array = find_array("tile-10x10");
    FocusEngine engine = focus_engine(array, 0.8);
    const auto amplitude = [&](double weight, double of, bool whole) {
        engine.geometry[3] = pack_geometry(array.elements[3].position, 0.0, weight);
        const std::vector<FocusWords> words{pack_focus({{0.0, 0.0, 0.15}, of})};
        return engine_drives(engine, words, whole)[3].amplitude / 65535.0;
    };
    for (const double weight : {1.0, 0.999, 0.75, 0.5, 0.3, 0.01, 0.0}) {
        CHECK(amplitude(weight, 1.0, false) == Approx(weight).margin(0.004));
        CHECK(amplitude(weight, 1.0, true) == Approx(weight).margin(0.004));
        CHECK(amplitude(weight, 0.4, false) == Approx(0.5 * weight).margin(0.004));
    }
    CHECK(amplitude(1.0, 1.0, false) == 1.0);
    CHECK(amplitude(0.0, 1.0, true) == 0.0);
}

TEST_CASE("focus engine: a focus that is too far is silent and reported", "[focus_engine]") {
    FocusEngine engine;
    engine.geometry = {pack_geometry({-0.25, 0.0, 0.0}), pack_geometry({0.0, 0.0, 0.0})};
    engine.wave_number = wave_number_word(0.00858);
    engine.gain = gain_word(1.0);
    const FocusWords far = pack_focus({{0.9, 0.0, 0.3}, 1.0});
    const FocusWords near = pack_focus({{0.0, 0.01, 0.1}, 1.0});
    const auto alone = engine_drives(engine, std::vector<FocusWords>{far});
    CHECK(alone[0] == ChannelDrive{0, 0, true});
    CHECK(alone[1].amplitude > 65'000);
    CHECK(!alone[1].far);
    const auto both = engine_drives(engine, std::vector<FocusWords>{near, far});
    const auto only = engine_drives(engine, std::vector<FocusWords>{near});
    CHECK(both[0].far);
    CHECK(std::abs(static_cast<std::int16_t>(both[0].phase - only[0].phase)) < 0.1 * 256);
    CHECK(both[0].amplitude == only[0].amplitude);
}

TEST_CASE("focus engine: words by hand", "[focus_engine]") {
    // 100 mm is 12,800 units = 0x3200; −1/128 mm is all ones; 600 mm is 76,800 = 0x12c00; half of 255 rounds to 128.
    CHECK(pack_focus({from_mm(100.0, -1.0 / 128.0, 600.0), 0.5}) == FocusWords{0x3200, 0xffff, 0x2c00, 0x801c});
    CHECK(pack_focus({from_mm(-1024.0, 1024.0 - 1.0 / 128.0, 0.0), 1.0}) == FocusWords{0x0000, 0xffff, 0x0000, 0xff06});
    CHECK(pack_geometry(from_mm(-45.0, 0.004, 255.99), -0.5) == GeometryWords{0xe980, 0x0001, 0x7fff, 0x8000});
    CHECK(pack_geometry({}, 0.25, 1.0)[3] == 0x4000);
    CHECK(pack_geometry({}, 0.25, 0.4)[3] == 0x4099);
    CHECK(pack_geometry({}, 0.25, 0.0)[3] == 0x40ff);
    CHECK(wave_number_word(343.2 / 40e3) == 122'212);  // 2^27 / 128 / 8.58 mm
    CHECK(gain_word(1.0) == 39'953);
}

TEST_CASE("focus engine: bad input is named", "[focus_engine]") {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const double infinity = std::numeric_limits<double>::infinity();
    CHECK_REFUSED(pack_geometry(from_mm(0.0, 256.0, 0.0)));
    CHECK_REFUSED(pack_geometry({nan, 0.0, 0.0}));
    CHECK_REFUSED(pack_geometry({}, infinity));
    CHECK_REFUSED(pack_geometry({}, 0.0, 1.1));
    CHECK_REFUSED(pack_focus({from_mm(0.0, 0.0, -1024.1), 1.0}));
    CHECK_REFUSED(pack_focus({from_mm(1024.0, 0.0, 0.0), 1.0}));
    CHECK_REFUSED(pack_focus({{0.0, infinity, 0.0}, 1.0}));
    CHECK_REFUSED(pack_focus({{}, 1.01}));
    CHECK_REFUSED(pack_focus({{}, nan}));
    CHECK_REFUSED(wave_number_word(0.004));
    for (const double wavelength : {0.0, -0.01, nan, infinity}) CHECK_THROWS_AS(wave_number_word(wavelength), Error);
    for (const double full : {0.0, 0.6, 8.1, nan}) CHECK_REFUSED(gain_word(full));

    FocusEngine engine{{GeometryWords{}}, 1, 1};
    const FocusWords focus{};
    CHECK_REFUSED(engine_drives(engine, {}));
    CHECK_REFUSED(engine_drives(engine, std::vector<FocusWords>(9, focus)));
    CHECK_REFUSED(engine_drives(engine, std::vector<FocusWords>{focus, {0, 0, 0, 0x0040}}));
    CHECK_REFUSED(engine_drives({}, std::vector<FocusWords>{focus}));
    engine.wave_number = 1U << 18U;
    CHECK_REFUSED(engine_drives(engine, std::vector<FocusWords>{focus}));
}
