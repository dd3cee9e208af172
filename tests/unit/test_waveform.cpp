// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <numbers>

#include "../refusal.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/format/waveform.hpp"
#include "haptogram/verbs/compile.hpp"

using namespace haptogram;
using Catch::Contains;

namespace {

constexpr double carrier_hz = 40e3;
constexpr double pi = std::numbers::pi;

/// One value a carrier period.
std::vector<double> over_time(const Modulation& modulation) {
    std::vector<double> values;
    for (const double sample : modulation.samples) values.insert(values.end(), modulation.periods_a_sample, sample);
    return values;
}

/// Amplitude of the part that goes `periods` times through the values.
double amplitude(const std::vector<double>& values, std::size_t periods) {
    std::complex<double> sum;
    for (std::size_t i = 0; i < values.size(); ++i)
        sum += values[i] * std::polar(1.0, -2.0 * pi * static_cast<double>(periods * i % values.size()) /
                                               static_cast<double>(values.size()));
    return 2.0 * std::abs(sum) / static_cast<double>(values.size());
}

/// The largest part below 1 kHz that is no harmonic of `fundamental`, over that; in dB.
double spurious_db(const std::vector<double>& values, std::size_t fundamental, bool harmonics_count) {
    double largest = 1e-300;
    for (std::size_t k = 1; static_cast<double>(k) * carrier_hz / static_cast<double>(values.size()) < 1000.0; ++k)
        if (k != fundamental && (harmonics_count || k % fundamental != 0))
            largest = std::max(largest, amplitude(values, k));
    return 20.0 * std::log10(largest / amplitude(values, fundamental));
}

std::vector<double> squared(std::vector<double> values) {
    for (double& value : values) value *= value;
    return values;
}

MadeModulation made(const std::string& text, AmplitudeLaw law = AmplitudeLaw::pressure) {
    return modulation_of(text, law, carrier_hz);
}

template <class Value>
void put(std::string& bytes, Value value) {
    for (std::size_t i = 0; i < sizeof value; ++i) bytes += static_cast<char>(value >> (8 * i) & 0xFF);
}

/// @param bits  8, 16, 24 or 32 for PCM, 132 for float
std::string wav(const std::vector<double>& samples, std::uint32_t rate, unsigned bits, std::uint16_t channels = 1) {
    std::string data;
    for (const double sample : samples) {
        if (bits == 132) {
            const auto value = static_cast<float>(sample);
            std::uint32_t word = 0;
            std::memcpy(&word, &value, sizeof word);
            put(data, word);
        } else if (bits == 8) {
            put(data, static_cast<std::uint8_t>(std::lround(128.0 + 127.0 * sample)));
        } else {
            const auto value =
                static_cast<std::int64_t>(std::llround(sample * (std::ldexp(1.0, static_cast<int>(bits) - 1) - 1.0)));
            for (unsigned i = 0; i < bits; i += 8) data += static_cast<char>(value >> i & 0xFF);
        }
    }
    const auto width = static_cast<std::uint16_t>(bits == 132 ? 4 : bits / 8);
    std::string bytes = "RIFF";
    put(bytes, static_cast<std::uint32_t>(36 + data.size()));
    bytes += "WAVEfmt ";
    put(bytes, std::uint32_t{16});
    put(bytes, static_cast<std::uint16_t>(bits == 132 ? 3 : 1));
    put(bytes, channels);
    put(bytes, rate);
    put(bytes, rate * width);
    put(bytes, width);
    put(bytes, static_cast<std::uint16_t>(8 * width));
    bytes += "data";
    put(bytes, static_cast<std::uint32_t>(data.size()));
    return bytes + data;
}

std::string in_temporary_file(const std::string& name, const std::string& content) {
    const std::filesystem::path path =
        std::filesystem::temp_directory_path() / ("haptogram_test_waveform_" + std::to_string(getpid()) + "_" + name);
    write_file(path, content);
    return path.string();
}

}  // namespace

TEST_CASE("waveform: means and fundamentals are those of the waveforms", "[waveform]") {
    // Mean of the square, and fundamental of the square, both by the integrals.
    const auto [text, mean_square, fundamental] = GENERATE(table<std::string, double, double>({
        {"square:100", 0.5, 2.0 / pi},
        {"square:100:0.25", 0.25, 2.0 / pi * std::sin(0.25 * pi)},
        {"abs-sine:100", 0.5, 0.5},
        {"sine:100", 0.375, 0.5},
        {"triangle:100", 1.0 / 3.0, 0.4053},
        {"sawtooth:100", 1.0 / 3.0, 0.3340},
        {"static", 1.0, 0.0},
    }));
    CAPTURE(text);
    const MadeModulation m = made(text);
    CHECK(mean_square_of(m.modulation) == Approx(mean_square).margin(2e-3));
    if (fundamental > 0.0) {
        CHECK(m.frequencies_hz == std::vector<double>{100.0});
        CHECK(over_time(m.modulation).size() == 400);
        CHECK(amplitude(squared(over_time(m.modulation)), 1) == Approx(fundamental).margin(1e-3));
        CHECK(mean_of(made(text, AmplitudeLaw::radiation).modulation) > mean_of(m.modulation) - 1e-12);
        // Linear in radiation pressure: its square is the waveform.
        const std::vector<double> pressure = made(text, AmplitudeLaw::radiation).modulation.samples;
        for (std::size_t i = 0; i < pressure.size(); ++i)
            CHECK(pressure[i] * pressure[i] == Approx(m.modulation.samples[i]).margin(1e-12));
    }
}

TEST_CASE("waveform: the spectrum of a sine is one line", "[waveform]") {
    const double hertz = GENERATE(1.0, 5.0, 33.3, 100.0, 200.0, 210.175, 512.481, 640.4, 987.0, 1000.0);
    const MadeModulation m = made("sine:" + std::to_string(hertz));
    CHECK(m.frequencies_hz.front() == Approx(hertz).epsilon(1e-3));
    const std::vector<double> values = over_time(m.modulation);
    const auto line = static_cast<std::size_t>(
        std::lround(m.frequencies_hz.front() * static_cast<double>(values.size()) / carrier_hz));
    CAPTURE(hertz, values.size(), line);
    CHECK(20.0 * std::log10(amplitude(values, line) / 0.5) == Approx(0.0).margin(0.1));
    CHECK(spurious_db(values, line, true) <= -40.0);
}

TEST_CASE("waveform: a square has its fundamental and harmonics and nothing else below 1 kHz", "[waveform]") {
    const std::size_t i = GENERATE(range(0, 32));
    const double hertz = hoshi_frequencies_hz().at(i);
    const MadeModulation m = made("square:" + std::to_string(hertz));
    const std::vector<double> values = over_time(m.modulation);
    const auto line = static_cast<std::size_t>(
        std::lround(m.frequencies_hz.front() * static_cast<double>(values.size()) / carrier_hz));
    CAPTURE(hertz, values.size(), line);
    CHECK(m.frequencies_hz.front() == Approx(hertz).epsilon(1e-3));
    CHECK(20.0 * std::log10(amplitude(values, line) / (2.0 / pi)) == Approx(0.0).margin(0.1));
    CHECK(spurious_db(values, line, false) <= -40.0);
}

TEST_CASE("waveform: Hoshi's 32 frequencies", "[waveform]") {
    const std::array<double, 32> hertz = hoshi_frequencies_hz();
    CHECK(hertz.front() == 1.0);
    CHECK(hertz[10] == Approx(9.284).margin(5e-4));
    CHECK(hertz[24] == Approx(210.175).margin(5e-4));
    CHECK(hertz[29] == Approx(640.400).margin(5e-4));
    CHECK(hertz.back() == Approx(1000.0));
    CHECK(hertz[1] / hertz[0] == Approx(1.249609).margin(1e-6));
}

TEST_CASE("waveform: a sum has both lines at half their height", "[waveform]") {
    const MadeModulation m = made("sine:200+sine:50");
    const std::vector<double> values = over_time(m.modulation);
    REQUIRE(values.size() == 800);
    CHECK(amplitude(values, 4) == Approx(0.25).epsilon(1e-3));
    CHECK(amplitude(values, 1) == Approx(0.25).epsilon(1e-3));
    CHECK(*std::min_element(values.begin(), values.end()) >= 0.0);
    CHECK(*std::max_element(values.begin(), values.end()) <= 1.0);
}

TEST_CASE("waveform: the pulses of an image have the sine's spectrum", "[waveform]") {
    const double hertz = GENERATE(100.0, 200.0, 500.0, 1000.0);
    const AmplitudeLaw law = GENERATE(AmplitudeLaw::pressure, AmplitudeLaw::radiation);
    Project project;
    project.shapes.resize(1);
    project.shapes[0].primitive = {.kind = "point"};
    project.am = "sine:" + std::to_string(hertz);
    project.am_law = law;
    const Compiled compiled = compile(project);
    REQUIRE(compiled.am_hz == std::vector<double>{hertz});
    const Image& image = compiled.bundle.image;
    const Timer& timer = compiled.bundle.manifest.timer;
    std::vector<double> values;  // the carrier's amplitude in each period: sin(π·pulse/cycle), Hoshi eq. 7
    for (const SequenceEntry& entry : image.sequence) {
        const double ticks = entry.index == 0 ? 0.0 : image.records.at(entry.index - 1U).pulse_length;
        values.insert(values.end(), entry.dwell, std::sin(pi * ticks / timer.cycle_ticks));
    }
    REQUIRE(values.size() == static_cast<std::size_t>(carrier_hz / hertz));
    if (law == AmplitudeLaw::radiation) values = squared(values);
    CAPTURE(hertz);
    CHECK(20.0 * std::log10(amplitude(values, 1) / 0.5) == Approx(0.0).margin(0.1));
    CHECK(spurious_db(values, 1, true) <= -40.0);
}

TEST_CASE("waveform: a WAV file of a tone becomes that tone", "[waveform]") {
    const unsigned bits = GENERATE(8U, 16U, 24U, 32U, 132U);
    const std::uint32_t rate = GENERATE(8000U, 44100U);
    std::vector<double> samples(rate / 5);  // 200 ms, 50 periods
    for (std::size_t i = 0; i < samples.size(); ++i)
        samples[i] = 0.8 * std::sin(2.0 * pi * 250.0 * static_cast<double>(i) / rate);
    const std::string file = in_temporary_file(std::to_string(bits) + ".wav", wav(samples, rate, bits));
    const MadeModulation m = made("wav:" + file);
    std::filesystem::remove(file);
    REQUIRE(m.modulation.samples.size() == 800);
    REQUIRE(m.modulation.periods_a_sample == 10);
    const std::vector<double> values = m.modulation.samples;
    CAPTURE(bits, rate);
    CHECK(amplitude(values, 50) == Approx(0.4).epsilon(0.01));
    CHECK(mean_of(m.modulation) == Approx(0.5).margin(0.005));
    double rest = 0.0;
    for (std::size_t k = 1; k < 200; ++k)
        if (k != 50) rest = std::max(rest, amplitude(values, k));
    CHECK(20.0 * std::log10(rest / 0.4) <= -40.0);
}

TEST_CASE("waveform: a tone that the new rate cannot hold is filtered out", "[waveform]") {
    std::vector<double> samples(4410);
    for (std::size_t i = 0; i < samples.size(); ++i)
        samples[i] = std::sin(2.0 * pi * 5000.0 * static_cast<double>(i) / 44100.0);
    for (const double value : resampled(samples, 44100.0, 4000.0, 400)) CHECK(std::abs(value) < 0.01);
}

TEST_CASE("waveform: a CSV file has straight lines between its rows", "[waveform]") {
    const std::string file = in_temporary_file("ramp.csv", "time_ms,amplitude\n10,0\n20,1\n30,0\n");
    const MadeModulation m = made("csv:" + file);
    std::filesystem::remove(file);
    REQUIRE(m.modulation.samples.size() == 80);
    CHECK(m.frequencies_hz.front() == Approx(50.0));
    for (std::size_t i = 0; i < 80; ++i)
        CHECK(m.modulation.samples[i] ==
              Approx(1.0 - std::abs((static_cast<double>(i) + 0.5) / 40.0 - 1.0)).margin(1e-9));
}

TEST_CASE("waveform: mistakes are named", "[waveform]") {
    const auto refuses = [](const std::string& text) {
        CAPTURE(text);
        REQUIRE_REFUSED(made(text));
    };
    refuses("sinus:200");
    refuses("");
    refuses("sine");
    refuses("sine:fast");
    refuses("sine:0");
    refuses("sine:20001");
    refuses("sine:200:0.5");
    refuses("square:200:1");
    refuses("sine:200+");
    refuses("wav:/no/such.wav");
    const auto refuses_wav = [](const std::string& bytes) { REQUIRE_REFUSED(wave_from_wav(bytes, "x.wav")); };
    const std::string good = wav({0.0, 0.5, -0.5}, 8000, 16);
    CHECK(wave_from_wav(good, "x.wav").samples.size() == 3);
    refuses_wav("RIFX");
    refuses_wav(good.substr(0, good.size() - 1));
    refuses_wav(good.substr(0, 36));
    refuses_wav(wav({0.0}, 8000, 16, 2));
    refuses_wav(wav({}, 8000, 16));
    refuses_wav(wav({1.5}, 8000, 132));
}

TEST_CASE("waveform: a sound that came through a pipe ends with the file", "[waveform]") {
    const std::string good = wav({0.0, 0.5, -0.5}, 8000, 16);
    const std::size_t at = good.find("data") + 4;
    for (const std::string& length : {std::string(4, '\xff'), std::string(4, '\0')}) {
        std::string piped = good;
        piped.replace(4, 4, length).replace(at, 4, length);
        CHECK(wave_from_wav(piped, "x.wav").samples == wave_from_wav(good, "x.wav").samples);
    }
}

TEST_CASE("waveform: foci that a modulation always silences are warned of", "[waveform]") {
    Project project;
    project.shapes.resize(1);
    project.shapes[0].primitive = {.kind = "circle"};
    project.points = 40;
    project.pace.frequency_hz = 20.0;
    project.am = "square:200";
    REQUIRE_SAID(compile(project).warnings.front());
    project.pace.frequency_hz = 25.0;
    REQUIRE(compile(project).warnings.empty() == false);
    project.am.clear();
    for (const std::string& warning : compile(project).warnings) REQUIRE_THAT(warning, !Contains("never heard"));
}
