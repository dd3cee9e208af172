// SPDX-License-Identifier: Apache-2.0
// Amplitudes, modulation, slew limit and foci, through the serial link and at the pins, on the configurations
// small-16-wide and, at their full number, tile-100-wide. What each channel must do is computed from the host's models
// of the arithmetic (format/emission.hpp, format/focus_engine.hpp) and from the measured starts of the cycles; every
// pulse is compared to the clock.
#include <cmath>
#include <complex>
#include <cstdlib>
#include <map>
#include <numbers>

#include "../refusal.hpp"
#include "../soak.hpp"
#include "haptogram/link/focus_ring.hpp"
#include "haptogram/link/live_feed.hpp"
#include "wide_bench.hpp"

using namespace haptogram;
using namespace haptogram::test;
using namespace haptogram::test::wide;

namespace {

/// A payload's first words: the address of a word in a region.
Bytes address(std::uint32_t base, std::uint32_t offset) {
    return words({static_cast<std::uint16_t>(offset), static_cast<std::uint16_t>(base >> 16)});
}
Bytes with(Bytes bytes, std::initializer_list<std::uint16_t> more) {
    for (const std::uint8_t b : words(more)) bytes.push_back(b);
    return bytes;
}

/// Whether figures for the documentation are wanted.
bool figures() { return std::getenv("HAPTOGRAM_FIGURES") != nullptr; }

}  // namespace

TEST_CASE("second instrument: the board says what it has", "[second][wide]") {
    Wide bench;
    const link::Identity identity = bench.client.identify();
    REQUIRE(identity.features == 0x3ff);
    REQUIRE(identity.width_bits == 10);
    REQUIRE(identity.foci == 8);
    REQUIRE(identity.modulation_words == 32);
    REQUIRE(identity.core().slew == 1);
}

TEST_CASE("second instrument: a board without it says so", "[second]") {
    Bench plain;
    const link::Identity without = plain.client.identify();
    REQUIRE(without.features == 0x90f);
    REQUIRE(without.width_bits + without.foci + without.modulation_words == 0);
}

TEST_CASE("contract 8: at the pins the carrier's phase does not depend on the amplitude, to half a tick",
          "[second][wide][contract8]") {
    Wide bench;
    auto g = generator();
    bench.open();
    double worst_phase = 0, worst_amplitude = 0;
    std::size_t measured = 0;
    for (int round = 0; round < 24; ++round) {
        bench.random_record(g, 1, 1250);
        const std::vector<Emission>& asked = bench.book[1].emissions;
        bench.client.select(1);
        bench.wait_for_index(1);
        bench.board.run(8 * 1250);
        const std::size_t last = bench.recorder.cycles().size() - 3;
        const std::uint64_t from = bench.recorder.cycles()[last].clock;
        REQUIRE(bench.recorder.cycles()[last - 3].index == 1);
        require_right(bench.compare(last - 4, last + 2), 20);
        for (std::uint32_t k = 0; k < channel_count; ++k) {
            std::complex<double> sum;
            for (const Pulse& p : bench.pulses(k, from - 1250, from + 1250))
                for (std::uint64_t t = std::max(p.rise, from); t < std::min(p.fall, from + 1250); ++t)
                    sum += std::polar(1.0, 2 * std::numbers::pi * (static_cast<double>(t - from) + 0.5) / 1250);
            const double amplitude = std::abs(sum) * std::numbers::pi / 1250;
            worst_amplitude = std::max(worst_amplitude, std::abs(amplitude - asked[k].amplitude / 65535.0));
            if (std::abs(sum) < 0.5) continue;
            const double ticks = std::arg(sum) / (2 * std::numbers::pi) * 1250;
            worst_phase =
                std::max(worst_phase, std::abs(std::remainder(ticks - asked[k].phase / 65536.0 * 1250, 1250)));
            ++measured;
        }
        bench.client.stop();
        bench.wait_for_index(0);
    }
    INFO("worst phase " << worst_phase << " ticks, worst amplitude " << worst_amplitude << " of full");
    if (figures()) WARN("worst phase " << worst_phase << " ticks, worst amplitude " << worst_amplitude << " of full");
    REQUIRE(measured > 300);
    REQUIRE(worst_phase <= 0.501);
    REQUIRE(worst_amplitude <= 0.0025);
    REQUIRE(bench.client.status().underruns == 0);
}

namespace {

/// A record of full amplitude at these phases, 256ths of the cycle, channel by channel.
void full_record(Wide& bench, std::uint16_t index, const std::vector<std::uint32_t>& phases) {
    Words words;
    for (std::uint32_t k = 0; k < bench.channels(); ++k)
        words.push_back(static_cast<std::uint16_t>(0xff00U | phases[k % phases.size()]));
    bench.write_record(index, amplitude_record(1250, words));
    bench.book[index] = played(1250, words);
}

/// A record of timings, all at tick 400.
void record_at_400(Wide& bench, std::uint16_t index) {
    Words words(interface::record_header_words + bench.channels(), 400);
    interface::record_field::cycle_length.set(words, 1250);
    interface::record_field::pulse_length.set(words, 125);
    interface::record_field::prescaler.set(words, 1);
    interface::record_field::kind.set(words, static_cast<unsigned>(interface::Kind::timings));
    bench.write_record(index, words);
    bench.book[index] = Played{{}, 1250, true, 125};
    bench.book[index].emissions.assign(bench.channels(), {65535, 400});
}

void write_samples(Wide& bench, const std::vector<std::uint8_t>& samples) {
    Words words;
    for (std::size_t i = 0; i < samples.size(); i += 2)
        words.push_back(static_cast<std::uint16_t>(samples[i + 1] << 8 | samples[i]));
    bench.write(interface::modulation_base, words);
}

const std::vector<std::uint32_t> phases_about_zero = {0,  1,   2,   16,  31,  32,  63,  64,
                                                      65, 128, 191, 192, 193, 224, 250, 255};

}  // namespace

TEST_CASE("contract 8: with samples of full and nothing in turn each pulse is whole, in its own carrier period",
          "[second][wide][contract8][phase]") {
    Wide bench;
    bench.open();
    full_record(bench, 1, phases_about_zero);
    write_samples(bench, {255, 0});
    bench.client.modulate(1, 2, true);
    bench.client.select(1);
    bench.wait_for_index(1);
    bench.board.run(10'000);
    const auto& cycles = bench.recorder.cycles();
    const std::size_t from = cycles.size();
    bench.board.run(1250ULL * 200);
    for (std::uint32_t k = 0; k < channel_count; ++k) {
        const auto found = bench.pulses(k, cycles[from].clock - 625, cycles[from + 180].clock - 625);
        REQUIRE(found.size() >= 89);
        REQUIRE(found.size() <= 91);
        for (std::size_t i = 0; i < found.size(); ++i) {
            CAPTURE(k, i);
            REQUIRE(found[i].fall - found[i].rise == 625);
            const double phase = phases_about_zero[k] / 256.0 * 1250;
            const double middle = static_cast<double>(found[i].rise + found[i].fall) / 2;
            REQUIRE(std::abs(std::remainder(middle - static_cast<double>(cycles[from].clock) - phase, 1250)) <= 0.5);
        }
    }
    REQUIRE(bench.client.status().underruns == 0);
}

TEST_CASE("contract 8: a sine of full depth moves no pulse's middle and makes no second harmonic, at any phase",
          "[second][wide][contract8][phase]") {
    Wide bench;
    bench.open();
    full_record(bench, 1, phases_about_zero);
    constexpr int count = 40;  // 1 kHz
    std::vector<std::uint8_t> samples;
    for (int i = 0; i < count; ++i)
        samples.push_back(
            static_cast<std::uint8_t>(std::lround(127.5 + 127.5 * std::sin(2 * std::numbers::pi * (i + 0.5) / count))));
    write_samples(bench, samples);
    bench.client.modulate(1, count, true);
    bench.client.select(1);
    bench.wait_for_index(1);
    bench.board.run(10'000);
    const auto& cycles = bench.recorder.cycles();
    const std::size_t from = cycles.size();
    constexpr std::size_t periods = 20 * count;
    bench.board.run(1250ULL * (periods + 4));
    double worst_middle = 0, worst_harmonic = -1000;
    for (std::uint32_t k = 0; k < channel_count; ++k) {
        const double first = static_cast<double>(cycles[from].clock) + phases_about_zero[k] / 256.0 * 1250;
        std::vector<double> amplitude(periods);  // of the carrier, by the period of the pulse's middle
        for (const Pulse& p : bench.pulses(k, cycles[from].clock - 1250, cycles[from + periods + 2].clock)) {
            const double middle = static_cast<double>(p.rise + p.fall) / 2 - first;
            worst_middle = std::max(worst_middle, std::abs(std::remainder(middle, 1250)));
            const auto n = static_cast<std::ptrdiff_t>(std::lround(middle / 1250));
            if (n >= 0 && n < static_cast<std::ptrdiff_t>(periods))
                amplitude[static_cast<std::size_t>(n)] +=
                    std::sin(std::numbers::pi * static_cast<double>(p.fall - p.rise) / 1250);
        }
        const auto harmonic = [&](int number) {
            std::complex<double> sum;
            for (std::size_t n = 0; n < periods; ++n)
                sum += std::polar(amplitude[n], 2 * std::numbers::pi * number * static_cast<double>(n) / count);
            return std::abs(sum);
        };
        worst_harmonic = std::max(worst_harmonic, 20 * std::log10(harmonic(2) / harmonic(1)));
    }
    INFO("worst middle off by " << worst_middle << " ticks, second harmonic " << worst_harmonic << " dBc");
    if (figures())
        WARN("worst middle off by " << worst_middle << " ticks, second harmonic " << worst_harmonic << " dBc");
    REQUIRE(worst_middle <= 0.501);
    REQUIRE(worst_harmonic <= -60);
}

TEST_CASE("contract 8: behind any other record the first pulse is whole, on either side of the cycle's start",
          "[second][wide][contract8][phase]") {
    Wide bench;
    bench.open();
    full_record(bench, 1, {96});
    full_record(bench, 2, {0, 5, 250, 32, 64});
    record_at_400(bench, 3);
    for (const std::uint16_t before : {std::uint16_t{1}, std::uint16_t{3}, std::uint16_t{0}}) {
        CAPTURE(before);
        const std::size_t first = bench.play({{1, 4}, {before, 4}, {2, 4}, {1, 4}});
        require_right(bench.compare(first - 4, first + 18), 150);
        const std::uint64_t begins = bench.recorder.cycles()[first + 8].clock;
        const auto found = bench.pulses(0, begins - 400, begins + 400);
        REQUIRE(found.size() == 1);
        REQUIRE(found[0].fall - found[0].rise == 625);
        REQUIRE(found[0].rise == begins - 312);
    }
    REQUIRE(bench.client.status().underruns == 0);
}

TEST_CASE("second instrument: a record of amplitudes in every carrier period, and every pulse where the model says",
          "[second][wide]") {
    Wide bench;
    auto g = generator();
    bench.open();
    const std::uint32_t cycle = GENERATE(1250U, 2U * lead, 2046U);
    std::vector<SequenceEntry> sequence;
    for (std::uint16_t i = 1; i <= 200; ++i) {
        bench.random_record(g, i, cycle);
        sequence.push_back({i, 1});
    }
    const std::size_t first = bench.play(sequence);
    require_right(bench.compare(first - 4, first + 203), 3000);
    const link::Status status = bench.client.status();
    REQUIRE(status.underruns == 0);
    REQUIRE(status.refused_records == 0);
    REQUIRE(status.guard_trips == 0);
}

TEST_CASE("second instrument: one to eight foci a record, a record in every carrier period, equal to the host's model",
          "[second][wide][foci]") {
    Wide bench;
    auto g = generator();
    bench.open();
    constexpr std::uint16_t base = 600;  // beside records, in words of four
    const FocusEngine engine = square_engine(4, 2.5);
    for (std::size_t foci = 1; foci <= most_record_foci; ++foci) {
        const bool whole = random(g, 0, 3) == 0;
        bench.write_engine(engine, base, 20, foci, whole);
        std::vector<SequenceEntry> sequence;
        for (std::uint16_t n = 1; n <= 20; ++n) {
            std::vector<FocusWords> words;
            for (std::size_t f = 0; f < foci; ++f) words.push_back(random_focus(g));
            if (n % 4 == 0)  // as far away as a focus may be
                words[0] =
                    pack_focus({{random(g, 0, 1) == 0 ? -0.95 : 0.95, random(g, 0, 1) == 0 ? -0.95 : 0.95, 0.95}, 1.0});
            bench.write_foci(engine, base, n, words, whole);
            sequence.push_back({static_cast<std::uint16_t>(records + n), 1});
        }
        const std::size_t first = bench.play(sequence);
        require_right(bench.compare(first - 4, first + 23), 200);
    }
    const link::Status status = bench.client.status();
    REQUIRE(status.underruns == 0);
    REQUIRE(status.refused_records == 0);
    REQUIRE(status.far_foci == 0);
    // A focus more than a metre away counts for no channel and is told, also as the first of two; those without one are
    // not.
    const FocusWords far = pack_focus({{-1.02, 0.0, 0.1}, 1.0}), near = pack_focus({{0.0, 0.0, 0.1}, 1.0});
    const std::vector<std::vector<FocusWords>> written = {{far}, {far, near}, {near, near}};
    for (std::size_t i = 0; i < written.size(); ++i) {
        bench.write_engine(engine, base, 1, written[i].size(), false);
        bench.write_foci(engine, base, 1, written[i], false);
        bench.client.select(records + 1, 3);
        bench.wait_for_index(records + 1);
        REQUIRE(bench.client.status().far_foci == std::min<std::size_t>(i + 1, 2));
        bench.client.select(0, 0);
        bench.wait_for_index(0);
    }
}

TEST_CASE("second instrument: eight foci for 100 channels in every carrier period, and no pulse too short",
          "[second][wide][tile100]") {
    Wide bench("tile-100-wide");
    auto g = generator();
    bench.open();
    REQUIRE(bench.channels() == 100);
    const std::uint32_t records = bench.board.parameters().records;
    const std::uint64_t shortest = bench.board.parameters().min_pulse_clocks;
    constexpr std::uint16_t base = 2600;
    constexpr std::uint16_t count = 40;
    const FocusEngine engine = square_engine(10, 2.5);
    bench.write_engine(engine, base, count, most_record_foci, false);
    std::vector<SequenceEntry> sequence;
    for (std::uint16_t n = 1; n <= count; ++n) {
        std::vector<FocusWords> words;
        for (std::size_t f = 0; f < most_record_foci; ++f) words.push_back(random_focus(g));
        bench.write_foci(engine, base, n, words, false);
        sequence.push_back({static_cast<std::uint16_t>(records + n), 1});
    }
    bench.random_record(g, 1, 1250);
    Words weak;  // amplitudes whose pulses are 0 to 12 clocks long
    for (std::uint32_t k = 0; k < 100; ++k) weak.push_back(static_cast<std::uint16_t>(random(g, 0, 7) << 8 | 2 * k));
    bench.write_record(2, amplitude_record(1250, weak));
    bench.book[2] = played(1250, weak);
    sequence.insert(sequence.end(), {{1, 2}, {2, 3}});
    const std::size_t first = bench.play(sequence);
    require_right(bench.compare(first - 4, first + count + 8), 3500);
    // In the steady weak cycles, where a pulse is whole and alone, the shortest ones are as short as the board says.
    std::uint64_t least = 1250;
    const auto& cycles = bench.recorder.cycles();
    for (std::uint32_t k = 0; k < 100; ++k)
        for (const Pulse& p : bench.pulses(k, cycles[first + count + 3].clock, cycles[first + count + 5].clock))
            least = std::min(least, p.fall - p.rise);
    REQUIRE(least == shortest);
    const link::Status status = bench.client.status();
    REQUIRE(status.underruns == 0);
    REQUIRE(status.refused_records == 0);
}

TEST_CASE("second instrument: timings, amplitudes and foci follow each other in any order", "[second][wide][order]") {
    Wide bench;
    auto g = generator();
    bench.open();
    constexpr std::uint16_t base = 600;
    const FocusEngine engine = square_engine(4, 1.5);
    bench.write_engine(engine, base, 20, 2, false);
    for (std::uint16_t i = 1; i <= 20; ++i) {
        bench.raw_record(g, i, random(g, 800, 1400), static_cast<std::uint8_t>(random(g, 1, 255)));
        bench.random_record(g, static_cast<std::uint16_t>(20 + i), random(g, 800, 1400));
        bench.write_foci(engine, base, i, {random_focus(g), random_focus(g)}, false);
    }
    std::vector<SequenceEntry> sequence;
    for (int i = 0; i < 200; ++i) {
        const std::uint32_t kind = random(g, 0, 9);
        const std::uint32_t index = kind == 0 && i > 0 ? 0
                                    : kind < 4         ? random(g, records + 1, records + 20)
                                                       : random(g, 1, 40);
        sequence.push_back({static_cast<std::uint16_t>(index), static_cast<std::uint16_t>(random(g, 1, 2))});
    }
    const std::size_t first = bench.play(sequence);
    require_right(bench.compare(first - 3, bench.recorder.cycles().size() - 2), 3000);
    const link::Status status = bench.client.status();
    REQUIRE(status.underruns == 0);
    REQUIRE(status.refused_records == 0);
    // The live FIFO takes foci, too.
    std::vector<std::uint16_t> indices;
    for (std::uint16_t i = 1; i <= 10; ++i) indices.push_back(static_cast<std::uint16_t>(records + i));
    const std::size_t before = bench.recorder.cycles().size();
    bench.client.push(indices, 1);
    bench.wait_for_index(records + 10);
    bench.board.run(10'000);
    require_right(bench.compare(before - 2, bench.recorder.cycles().size() - 2), 100);
}

TEST_CASE("second instrument: a host that is sure that all is over has heard the last entry", "[second][wide]") {
    Wide bench;
    auto g = generator();
    bench.open();
    for (std::uint16_t i = 1; i <= 2; ++i) bench.random_record(g, i, 2046);
    bench.write_sequence({{1, 1}, {0, 4}, {2, 3}});
    const auto periods = [&](std::uint16_t index) {
        return std::ranges::count_if(bench.recorder.cycles(),
                                     [&](const sim::CycleStart& c) { return c.index == index; });
    };
    int silent = 0;
    for (int repeat = 1; repeat <= 150; ++repeat) {
        bench.client.start(1, 3, 1);
        bench.board.run(random(g, 0, 10'000));
        for (link::Status status = link::sure_status(bench.client); !link::is_over(status);
             status = link::sure_status(bench.client))
            if (status.present_index == 0) ++silent;
        REQUIRE(periods(2) == 3 * repeat);
    }
    REQUIRE(silent > 20);
}

TEST_CASE("contract 9: sample i is on the pins in carrier periods i · N to (i + 1) · N − 1",
          "[second][wide][contract9]") {
    Wide bench;
    auto g = generator();
    bench.open();
    const std::uint16_t divider = GENERATE(std::uint16_t{1}, std::uint16_t{3});
    const bool loop = GENERATE(false, true);
    const std::uint16_t length = loop ? 7 : 64;
    std::vector<std::uint8_t> samples;
    for (int i = 0; i < 64; ++i)
        samples.push_back(static_cast<std::uint8_t>(random(g, 60, 110) + (i % 2 == 0 ? 80U : 0U)));
    Words words;
    for (std::size_t i = 0; i < 64; i += 2)
        words.push_back(static_cast<std::uint16_t>(samples[i + 1] << 8 | samples[i]));
    bench.write(interface::modulation_base, words);
    bench.random_record(g, 1, 1250);
    bench.random_record(g, 2, 1250);
    bench.raw_record(g, 3, 900, 200);
    bench.write_sequence({{2, 3}, {3, 4}, {0, 2}, {2, 5}, {0, 1}});
    bench.client.select(1);
    bench.wait_for_index(1);
    bench.board.run(10'000);
    const std::size_t sent = bench.recorder.cycles().size();
    bench.client.modulate(divider, loop ? length : 0, loop);
    const std::size_t told = bench.recorder.cycles().size();
    bench.board.run(20'000);
    REQUIRE(bench.client.status().modulated);
    bench.client.start(1, 5,
                       0);  // the modulation does not care for records, and cycles of timings and of silence count
    bench.board.run(1250ULL * 64 * divider + 20'000);
    const std::size_t end = bench.recorder.cycles().size() - 2;
    // The start is seen at the pins; there is one period that it can have been.
    std::size_t starts = 0, start = 0;
    for (std::size_t s = sent - 1; s <= told + 2; ++s) {
        const auto setting = [&](std::size_t i) {
            std::size_t n = i < s ? 0 : (i - s) / divider;
            n = loop ? n % length : std::min<std::size_t>(n, 63);
            return Setting{.modulation = i < s ? std::uint8_t{255} : samples[n]};
        };
        EmissionModel model(channel_count);
        const Comparison comparison = bench.compare(sent - 4, end, setting, model);
        if (comparison.wrong != 0) continue;
        ++starts;
        start = s;
        REQUIRE(comparison.pulses > 800);
    }
    REQUIRE(starts == 1);
    REQUIRE(start <= told + 1);  // from the next period on whose words are not begun yet
    REQUIRE(bench.client.status().modulated == loop);
    // A stop is a commit: from one period on there is no modulation. It is seen on a record that has amplitudes
    // throughout.
    bench.client.select(1);
    bench.wait_for_index(1);
    bench.board.run(10'000);
    const std::size_t before = bench.recorder.cycles().size();
    bench.client.modulate(0, 0, false);
    bench.board.run(20'000);
    REQUIRE_FALSE(bench.client.status().modulated);
    std::size_t stops = 0;
    for (std::size_t s = before - 1; s <= before + 6; ++s) {
        const auto setting = [&](std::size_t i) {
            const std::size_t n = (i - start) / divider;
            return Setting{.modulation =
                               i >= s ? std::uint8_t{255} : samples[loop ? n % length : std::min<std::size_t>(n, 63)]};
        };
        EmissionModel model(channel_count);
        stops += bench.compare(before - 5, bench.recorder.cycles().size() - 2, setting, model).wrong == 0;
    }
    REQUIRE(stops == 1);
    REQUIRE(bench.client.status().underruns == 0);
}

TEST_CASE("second instrument: amplitude modulation of full depth at 200 Hz loses no pulse", "[second][wide]") {
    Wide bench;
    bench.open();
    // 50 samples of four periods each are 200 periods, a 200th of a second.
    std::vector<std::uint8_t> samples;
    for (int i = 0; i < 50; ++i)
        samples.push_back(
            static_cast<std::uint8_t>(std::lround(127.5 - 127.5 * std::cos(2 * std::numbers::pi * i / 50))));
    Words words;
    for (std::size_t i = 0; i < 50; i += 2)
        words.push_back(static_cast<std::uint16_t>(samples[i + 1] << 8 | samples[i]));
    bench.write(interface::modulation_base, words);
    Words record;  // most of the phases around the cycle's start, where a pulse can be lost when it grows
    for (std::uint32_t k = 0; k < channel_count; ++k)
        record.push_back(static_cast<std::uint16_t>(0xff00 | ((256 - 20 + 3 * k) & 0xff)));
    bench.write_record(1, amplitude_record(1250, record));
    bench.book[1] = played(1250, record);
    bench.client.select(1);
    bench.wait_for_index(1);
    bench.client.modulate(4, 50, true);
    bench.board.run(10'000);
    const std::size_t from = bench.recorder.cycles().size();
    bench.board.run(1250ULL * 1000);
    const std::size_t to = bench.recorder.cycles().size() - 2;
    std::size_t matches = 0, pulses = 0;
    for (std::size_t shift = 0; shift < 200; ++shift) {
        EmissionModel model(channel_count);
        const auto setting = [&](std::size_t i) { return Setting{.modulation = samples[(i + shift) / 4 % 50]}; };
        if (bench.compare(from, from + 20, setting, model).wrong != 0) continue;
        const Comparison all = bench.compare(from, to, setting, model);
        matches += all.wrong == 0;
        pulses = all.pulses;
    }
    REQUIRE(matches == 1);
    REQUIRE(pulses > 15'000);
    // And by themselves: whenever a channel's amplitude is not near zero, its pin is high at the middle of its pulse.
    std::size_t lost = 0, wanted = 0;
    const auto& cycles = bench.recorder.cycles();
    for (std::uint32_t k = 0; k < channel_count; ++k) {
        const auto found = bench.pulses(k, cycles[from - 2].clock, cycles[to].clock);
        std::size_t at = 0;
        for (std::size_t i = from + 1; i + 1 < to; ++i) {
            const std::uint64_t middle = cycles[i].clock + bench.book[1].emissions[k].phase * 1250U / 65536;
            while (at < found.size() && found[at].fall <= middle) ++at;
            const bool high = at < found.size() && found[at].rise <= middle;
            // Of 50 samples one is 0; the next larger one is a pulse of two ticks.
            lost += !high;
            ++wanted;
        }
    }
    INFO(lost << " of " << wanted << " without a pulse");
    REQUIRE(wanted > 15'000);
    REQUIRE(lost * 50 <= wanted + 50 * 4 * channel_count);
    REQUIRE(bench.client.status().underruns == 0);
    if (figures())
        WARN(pulses << " pulses as the model says, " << lost << " of " << wanted
                    << " middles low, where the sample is 0");
}

TEST_CASE("second instrument: the slew limiter goes where the host's model goes, and down to silence",
          "[second][wide][slew]") {
    Wide bench;
    auto g = generator();
    SlewLimit slew;
    slew.mode = GENERATE(Slew::rate, Slew::arrive);
    slew.phase_rate = 900;
    slew.amplitude_rate = 1500;
    slew.arrival_periods = 109;
    using enum interface::ParametersWord;
    bench.open();
    bench.set(slew_mode, static_cast<std::uint32_t>(slew.mode));
    bench.set(phase_rate, slew.phase_rate);
    bench.set(amplitude_rate, slew.amplitude_rate);
    bench.set(arrival_periods, slew.arrival_periods);
    for (std::uint16_t i = 1; i <= 5; ++i) bench.random_record(g, i, 1250);
    const std::size_t before = bench.recorder.cycles().size();
    for (std::uint16_t i = 1; i <= 5; ++i) {
        bench.client.select(i);
        bench.wait_for_index(i);
        bench.board.run(1250ULL * random(g, 5, 130));
    }
    bench.client.stop();
    bench.wait_for_index(0);
    const std::size_t stopped = bench.recorder.cycles().size() - 1;
    bench.board.run(1250ULL * 120);
    const auto& cycles = bench.recorder.cycles();
    EmissionModel model(channel_count);
    const auto setting = [&](std::size_t i) {
        return Setting{.slew = slew, .new_target = cycles[i].index != cycles[i - 1].index};
    };
    const Comparison all = bench.compare(before - 3, cycles.size() - 2, setting, model);
    require_right(all, 1000);
    std::size_t falling = 0;
    for (const Pulse& p : bench.recorder.pulses()) falling += p.rise > cycles[stopped + 4].clock;
    REQUIRE(falling > 100);  // it takes its time
    REQUIRE_FALSE(bench.board.any_pin());
    for (const Emission& place : model.places()) REQUIRE(place.amplitude == 0);
    const link::Status status = bench.client.status();
    REQUIRE(status.bent_periods == all.bent);
    REQUIRE(status.underruns == 0);
}

TEST_CASE(
    "second instrument: the slew limiter starts from what the pins do, behind a reset, timings, outputs that were off, "
    "and a change of role",
    "[second][wide][slew]") {
    const auto cause = GENERATE(0, 1, 2, 3, 4);
    Wide bench(cause == 4 ? "tile-100-wide" : "small-16-wide");
    if (cause == 4 && bench.board.parameters().sync == 0) return;  // an executable with one core, which has no roles
    bench.open();
    full_record(bench, 1, phases_about_zero);
    full_record(bench, 2, {128});
    record_at_400(bench, 3);
    using enum interface::ParametersWord;
    bench.set(slew_mode, static_cast<std::uint32_t>(Slew::rate));
    bench.set(phase_rate, 10);
    bench.set(amplitude_rate, 3000);
    const auto begin = [&](std::uint16_t index) {
        bench.client.select(index);
        bench.wait_for_index(index);
        bench.board.run(1250 * 40);
    };
    begin(2);  // at full amplitude
    switch (cause) {
        case 0: bench.client.reset(); break;
        case 1: begin(3); break;
        case 2: bench.client.disable(); break;
        case 3: bench.board.reset(5); break;
        default: bench.client.set_role(interface::Role::master); break;
    }
    if (cause == 3) bench.client.identify();
    bench.client.set_watchdog(0);
    const std::size_t before = bench.recorder.cycles().size();
    if (cause != 1) bench.client.enable();
    // The record that played goes on when outputs were only off.
    const std::uint16_t index = cause == 2 ? 2 : 1;
    if (cause != 2) bench.client.select(1);
    bench.wait_for_index(index);
    bench.board.run(1250 * 40);
    const auto& cycles = bench.recorder.cycles();
    std::size_t first = before;
    while (cycles[first].index != index) ++first;
    // A master's carrier waits for a clock in every second period.
    const std::uint32_t stretch = cause == 4 ? 1 : 0;
    const double period = cause == 4 ? 1250.5 : 1250;
    for (std::uint32_t k = 0; k < bench.channels(); ++k) {
        CAPTURE(cause, k);
        const auto found = bench.pulses(k, cycles[first].clock - 312, cycles[first].clock + 1250 * 30);
        std::uint16_t amplitude = 0;
        std::size_t ramp = 0;
        const double phase = (cause == 2 ? 128 : phases_about_zero[k % phases_about_zero.size()]) / 256.0 * 1250;
        for (const Pulse& p : found) {
            // The rest of what played before is not where this channel is now.
            const double middle = static_cast<double>(p.rise + p.fall) / 2 - static_cast<double>(cycles[first].clock);
            if (ramp == 0 && std::abs(std::remainder(middle - phase, period)) > 0.5) continue;
            // The first period with outputs on may have been begun before.
            const bool again = cause == 2 && ramp == 1 && p.fall - p.rise == emission_ticks(amplitude, 1250, 1);
            if (!again) amplitude = static_cast<std::uint16_t>(std::min(65535, amplitude + 3000));
            const std::uint64_t width = p.fall - p.rise, asked = emission_ticks(amplitude, 1250, 1);
            REQUIRE(width >= asked);
            REQUIRE(width <= asked + stretch);
            REQUIRE(std::abs(std::remainder(middle - phase, period)) <= 0.5 + stretch);
            ++ramp;
        }
        REQUIRE(ramp >= 20);
    }
}

TEST_CASE("contract 4: a focus record with a reserved bit in any of its foci is refused", "[contract4][second][wide]") {
    Wide bench;
    bench.open();
    const Words geometry(64);
    bench.write(interface::geometry_base, geometry);
    constexpr std::uint16_t index = records + 1;
    std::uint32_t refused = 0;
    for (std::uint32_t foci = 1; foci <= most_record_foci; ++foci) {
        using enum interface::ParametersWord;
        bench.set(foci_count, 1);
        bench.set(foci_form, foci - 1);
        for (std::uint32_t odd = 0; odd <= foci; ++odd) {  // the last time none is
            CAPTURE(foci, odd);
            Words words;
            for (std::uint32_t i = 0; i < foci; ++i)
                words.insert(words.end(), {1000, 1000, 10000,
                                           static_cast<std::uint16_t>(0xff00U | (i == odd ? 0x40U << odd % 2 : 0))});
            bench.write(interface::primary_base, words);
            bench.client.select(index, 0);
            bench.board.run(5'000);
            if (odd < foci) ++refused;
            REQUIRE(bench.client.status().refused_records == refused);
        }
    }
}

TEST_CASE("second instrument: records of timings play as on a board without amplitudes", "[second][wide]") {
    Wide bench;
    auto g = generator();
    bench.open();
    std::vector<Record> all;
    for (int i = 0; i < 40; ++i) {
        const std::uint32_t prescaler = random(g, 1, 4), cycle = random(g, 200, 2048);
        all.push_back(test::random_record(g, channel_count, cycle, prescaler,
                                          static_cast<std::uint8_t>(random(g, 1, std::min(cycle / 2, 255U)))));
    }
    Image image = image_of(channel_count, all);
    // Of different prescalers, an old pulse's rest takes the new record's ticks, which the check does not know; silence
    // is between.
    std::vector<SequenceEntry> sequence;
    for (const SequenceEntry& e : image.sequence) {
        sequence.push_back({e.index, 2});
        sequence.push_back({0, 2});
    }
    image.sequence = sequence;
    bench.load(image);
    bench.client.start(1, 80, 1);
    bench.wait_for_index(40, 4'000'000);
    bench.wait_for_index(0);
    bench.board.run(20'000);
    require_equal(bench.check(image), 40 * 16);
    const link::Status status = bench.client.status();
    REQUIRE(status.underruns == 0);
    REQUIRE(status.refused_records == 0);
    // Two records in turn, in the shortest cycle that the contract names: (pulse - 1) · prescaler + CHANNELS + 16.
    const std::uint32_t shortest = 20 - 1 + channel_count + 16;
    const Image quick = image_of(channel_count, {test::random_record(g, channel_count, shortest, 1, 20),
                                                 test::random_record(g, channel_count, shortest, 1, 20)});
    bench.load(quick);
    bench.client.start(1, 2, 100);
    bench.wait_for_index(2);
    bench.wait_for_index(0);
    bench.board.run(1000);
    REQUIRE(bench.client.status().underruns == 0);
}

TEST_CASE("second instrument: SELECT reaches the pins within a cycle, a load and a sweep", "[second][wide]") {
    Wide bench;
    auto g = generator();
    bench.open();
    std::vector<std::uint32_t> cycle(41, 1250);
    for (std::uint16_t i = 1; i <= 40; ++i) {
        cycle[i] = random(g, 600, 1400);
        if (i % 2 == 0)
            bench.random_record(g, i, cycle[i]);
        else
            bench.raw_record(g, i, cycle[i], static_cast<std::uint8_t>(random(g, 1, 255)));
    }
    std::uint64_t worst = 0;
    std::uint16_t present = 0;
    int measured = 0;
    std::uint8_t number = 0;
    {
        const auto reply = bench.talk(link::encode_request(0, interface::Command::identify, {}));
        REQUIRE(reply.size() == 1);
        number = reply[0].expected;
    }
    for (int i = 0; i < 1000; ++i) {
        const auto index = static_cast<std::uint16_t>(random(g, 1, 40));
        if (index == present) continue;
        bench.board.run(random(g, 0, 1500));
        bench.board.send(link::encode_request(number++, interface::Command::select, words({index, 0})));
        while (!bench.board.line_idle()) bench.board.run(1);
        const std::uint64_t sent = bench.board.now();
        const std::size_t seen = bench.recorder.cycles().size();
        REQUIRE(bench.board.run_until([&] { return bench.board.outputs().index == index; }, 5000));
        std::uint64_t begins = bench.recorder.cycles().back().clock;
        for (std::size_t c = seen; c < bench.recorder.cycles().size(); ++c)
            if (bench.recorder.cycles()[c].index == index) begins = std::min(begins, bench.recorder.cycles()[c].clock);
        const std::uint64_t took = begins - std::min(begins, sent);
        // Up to 40 clocks for the command itself, a cycle of what played and a quarter of it, a load of 33 and what the
        // drive memory adds, a sweep.
        const std::uint64_t bound = 40 + cycle[present] * 5 / 4 + 45 + lead;
        INFO(took << " clocks after the frame, record " << present << " to " << index << ", at most " << bound);
        REQUIRE(took <= bound);
        worst = std::max(worst, took);
        present = index;
        ++measured;
    }
    REQUIRE(measured > 900);
    if (figures()) WARN("SELECT: worst " << worst << " clocks after its frame, of " << measured);
    static_cast<void>(bench.board.receive());
}

TEST_CASE("second instrument: after any commands at any time a record plays exactly", "[second][wide]") {
    auto g = generator();
    for (std::size_t round = 0; round < soaked(6, 2); ++round) {
        Wide bench;
        bench.open();
        constexpr std::uint16_t base = 600;
        const FocusEngine engine = square_engine(4, 1.5);
        // A ring of records of three foci has no room beside these, so with three PUSH_FOCI is refused.
        const std::size_t each = round % 2 == 0 ? 1 : 3;
        const auto random_foci = [&] {
            std::vector<FocusWords> foci;
            for (std::size_t f = 0; f < each; ++f) foci.push_back(random_focus(g));
            return foci;
        };
        bench.write_engine(engine, base, 10, each, false);
        for (std::uint16_t i = 1; i <= 10; ++i) {
            bench.raw_record(g, i, random(g, 300, 1400), static_cast<std::uint8_t>(random(g, 1, 150)));
            bench.random_record(g, static_cast<std::uint16_t>(10 + i), random(g, 2 * lead, 2046));
            bench.write_foci(engine, base, i, random_foci(), false);
        }
        if (each == 1) static_cast<void>(link::make_ring(bench.client));
        std::vector<SequenceEntry> sequence;
        for (std::uint16_t i = 1; i <= 20; ++i) sequence.push_back({i, 1});
        bench.write_sequence(sequence);
        std::uint8_t number = bench.talk(link::encode_request(0, interface::Command::identify, {})).at(0).expected;
        const auto send = [&](interface::Command command, const Bytes& payload) {
            bench.board.send(link::encode_request(number++, command, payload));
        };
        link::ReplyDecoder decoder;
        std::vector<link::Reply> replies;
        std::size_t seen = 0, applied = 0;
        std::map<interface::Command, std::size_t> of;  // how often each was applied
        const auto look = [&] {                        // at the replies that have come; whether a command was refused
            decoder.feed(bench.board.receive(), replies);
            bool refused = false;
            for (; seen < replies.size(); ++seen) {
                const bool ok = replies[seen].status == interface::Status::ok;
                refused = refused || !ok;
                applied += ok ? 1 : 0;
                of[replies[seen].command] += ok ? 1 : 0;
            }
            return refused;
        };
        const auto wait = [&] {
            REQUIRE(bench.board.run_until([&] { return bench.board.line_idle(); }, 10'000'000));
            bench.board.run(50'000);
        };
        for (int i = 0; i < 350; ++i) {
            const auto index = static_cast<std::uint16_t>(random(g, 0, 2) == 0 ? random(g, records + 1, records + 10)
                                                                               : random(g, 0, 20));
            switch (random(g, 0, 13)) {
                case 0: send(interface::Command::start, words({1, 20, 0})); break;
                case 1: send(interface::Command::stop, {}); break;
                case 2: send(interface::Command::disable, {}); break;
                case 3: send(interface::Command::reset, {}); break;
                case 4:
                    send(interface::Command::modulate, words({static_cast<std::uint16_t>(random(g, 0, 2)), 0, 1}));
                    break;
                case 5: send(interface::Command::push, words({1, index, 3, 12})); break;
                case 6: send(interface::Command::enable, {}); break;
                case 7: send(interface::Command::keep_alive, {}); break;
                case 8: {  // soon, past, at the end of what plays, or not at all
                    const auto soon = static_cast<std::uint16_t>(bench.board.now() / 1250 + random(g, 0, 20));
                    const std::uint16_t period[] = {soon, 1, 0xffff, 0};
                    const std::uint32_t which = random(g, 0, 3);
                    const auto above = static_cast<std::uint16_t>(which == 2 ? 0xffff : 0);
                    send(interface::Command::gate, words({period[which], above, above}));
                    break;
                }
                case 9:
                case 10: {
                    Words payload{static_cast<std::uint16_t>(random(g, 0, 3))};
                    for (std::uint32_t n = random(g, 1, 4); n > 0; --n)
                        for (const FocusWords& focus : random_foci())
                            payload.insert(payload.end(), focus.begin(), focus.end());
                    send(interface::Command::push_foci, words(payload));
                    break;
                }
                default:
                    send(interface::Command::select, words({index, static_cast<std::uint16_t>(random(g, 0, 3))}));
                    break;
            }
            bench.board.run(random(g, 0, 1) == 0 ? random(g, 0, 300) : random(g, 0, 4000));
            if (!look()) continue;
            // A command that was refused takes no number: all behind it on the line are out of order.
            wait();
            static_cast<void>(look());
            number = replies.back().expected;
        }
        wait();
        static_cast<void>(look());
        REQUIRE(applied >= 30);  // a refused one takes those with it that are on the line already
        REQUIRE(of[interface::Command::gate] > 0);
        REQUIRE((of[interface::Command::push_foci] > 0) == (each == 1));
        link::Client client(bench.line);
        client.identify();
        client.reset();
        client.set_watchdog(0);
        client.enable();
        for (const std::uint16_t index : {std::uint16_t{15}, std::uint16_t{records + 4}, std::uint16_t{3}}) {
            client.select(index);
            bench.wait_for_index(index);
            bench.board.run(20'000);
            const std::size_t end = bench.recorder.cycles().size() - 2;
            require_right(bench.compare(end - 7, end), 16);
        }
        REQUIRE(client.status().guard_trips == 0);
        REQUIRE(client.status().refused_records == 0);
    }
}

TEST_CASE("second instrument: what cannot be played is refused, and silence takes its place", "[second][wide]") {
    Wide bench;
    bench.open();
    const Words channel(channel_count, 0x80ff);
    const auto refused = [&](std::uint16_t index) {
        const std::uint16_t before = bench.client.status().refused_records;
        bench.client.select(index, 2);
        bench.board.run(20'000);
        return bench.client.status().refused_records - before;
    };
    const auto record = [&](std::uint32_t cycle, std::uint16_t pulse, std::uint32_t prescaler, std::uint16_t kind) {
        Words words = {static_cast<std::uint16_t>(cycle), static_cast<std::uint16_t>(pulse << 8 | cycle >> 16),
                       static_cast<std::uint16_t>(prescaler), static_cast<std::uint16_t>(kind << 8 | prescaler >> 16)};
        words.insert(words.end(), channel.begin(), channel.end());
        bench.write_record(1, words);
        return refused(1);
    };
    REQUIRE(record(1250, 0, 1, 1) == 0);
    REQUIRE(record(1250, 1, 1, 1) == 1);
    REQUIRE(record(1250, 0, 2, 1) == 1);
    REQUIRE(record(1250, 0, 0x10001, 1) == 1);
    REQUIRE(record(2 * lead, 0, 1, 1) == 0);
    REQUIRE(record(2 * lead - 1, 0, 1, 1) == 1);
    REQUIRE(record(2046, 0, 1, 1) == 0);
    REQUIRE(record(2047, 0, 1, 1) == 1);
    REQUIRE(record(0x10000 + 1250, 0, 1, 1) == 1);
    REQUIRE(record(1250, 0, 1, 2) == 1);
    REQUIRE(record(1250, 0, 1, 0x81) == 1);
    // Timings: cycles over whose end no pulse could be carried.
    REQUIRE(record(2048, 20, 1, 0) == 0);
    REQUIRE(record(2049, 20, 1, 0) == 1);
    REQUIRE(record(2048 + 1023, 20, 1, 0) == 1);
    REQUIRE(record(2048 + 1024, 20, 1, 0) == 0);
    REQUIRE(record(2048, 0, 0, 0) == 1);
    // Cycles in which one carrier period cannot be told from the next.
    for (const std::uint16_t pulse : {std::uint16_t{0}, std::uint16_t{1}}) {
        REQUIRE(record(1, 0, 1, 0) == 1);
        REQUIRE(record(2, pulse, 1, 0) == 1);
        REQUIRE(record(3, pulse, 1, 0) == 1);
        REQUIRE(record(7, pulse, 1, 0) == 1);
        REQUIRE(record(1, 0, 7, 0) == 1);
        REQUIRE(record(8, pulse, 1, 0) == 0);
        REQUIRE(record(2, pulse, 4, 0) == 0);
        REQUIRE(record(1, 0, 8, 0) == 0);
        bench.client.select(1);  // that one goes on, until another record is asked for
        bench.board.run(5'000);
        REQUIRE(record(1250, 0, 1, 1) == 0);
        bench.client.select(1);
        bench.wait_for_index(1, 10'000);
        bench.client.stop();
        bench.wait_for_index(0, 10'000);
    }

    using enum interface::ParametersWord;
    const FocusEngine engine = square_engine(4, 1.0);
    bench.write_engine(engine, 600, 5, 2, false);
    const FocusWords near = pack_focus({{0.0, 0.0, 0.1}, 1.0});
    for (std::uint16_t n = 1; n <= 5; ++n) bench.write_foci(engine, 600, n, {near, near}, false);
    REQUIRE(refused(records + 1) == 0);
    REQUIRE(refused(records + 5) == 0);
    FocusWords wrong = near;
    wrong[3] |= 0x40;
    bench.write(8 * 602 + 8, Words(wrong.begin(), wrong.end()));
    REQUIRE(refused(records + 2) == 1);
    bench.set(foci_cycle, 2 * lead - 1);
    REQUIRE(refused(records + 1) == 1);
    bench.set(foci_cycle, 2047);
    REQUIRE(refused(records + 1) == 1);
    bench.set(foci_cycle, 1250);
    // The last focus ends with primary memory, of 256 · 20 words; the next one is beyond it.
    bench.set(foci_base, 1280 - 2 * 4);
    for (std::uint32_t n = 0; n < 8; ++n) bench.write(2 * (5120 - 32) + 8 * n, Words(near.begin(), near.end()));
    REQUIRE(refused(records + 4) == 0);
    REQUIRE(refused(records + 5) == 1);

    // Arguments.
    const auto status_of = [&](interface::Command command, const Bytes& payload) {
        const auto hello = bench.talk(link::encode_request(0, interface::Command::identify, {}));
        return bench.talk(link::encode_request(hello.at(0).expected, command, payload)).at(0).status;
    };
    using interface::Command;
    using interface::Status;
    REQUIRE(status_of(Command::select, words({records + 5, 0})) == Status::ok);
    REQUIRE(status_of(Command::select, words({records + 6, 0})) == Status::bad_index);
    REQUIRE(status_of(Command::push, words({1, records + 5})) == Status::ok);
    REQUIRE(status_of(Command::push, words({1, records + 5, records + 6})) == Status::bad_index);
    REQUIRE(status_of(Command::modulate, words({1, 64, 1})) == Status::ok);
    REQUIRE(status_of(Command::modulate, words({1, 65, 1})) == Status::bad_range);
    REQUIRE(status_of(Command::modulate, words({1, 64, 2})) == Status::bad_range);
    REQUIRE(status_of(Command::modulate, words({0, 65, 2})) == Status::ok);
    REQUIRE(status_of(Command::modulate, words({1, 64})) == Status::bad_length);
    REQUIRE(status_of(Command::write, with(address(interface::parameters_base, 2 * 10), {1})) == Status::ok);
    REQUIRE(status_of(Command::write, with(address(interface::parameters_base, 2 * 11), {1})) == Status::bad_address);
    REQUIRE(status_of(Command::write, with(address(interface::geometry_base, 2 * 63), {1})) == Status::ok);
    REQUIRE(status_of(Command::write, with(address(interface::geometry_base, 2 * 64), {1})) == Status::bad_address);
    REQUIRE(status_of(Command::read, with(address(interface::geometry_base, 0), {2})) == Status::bad_address);
    REQUIRE(status_of(Command::write, with(address(interface::modulation_base, 2 * 31), {1})) == Status::ok);
    REQUIRE(status_of(Command::write, with(address(interface::modulation_base, 2 * 32), {1})) == Status::bad_address);
}

TEST_CASE("second instrument: a board without it refuses its commands and has none of its regions", "[second]") {
    using interface::Command;
    using interface::Status;
    Bench plain;
    const auto hello = plain.talk(link::encode_request(0, Command::identify, {}));
    std::uint8_t number = hello.at(0).expected;
    REQUIRE(plain.talk(link::encode_request(number, Command::modulate, words({1, 0, 1}))).at(0).status ==
            Status::unknown_command);
    REQUIRE(plain.talk(link::encode_request(number, Command::push_foci, words({1, 0, 0, 0, 0}))).at(0).status ==
            Status::unknown_command);
    REQUIRE(plain.talk(link::encode_request(number, Command::write, with(address(interface::parameters_base, 0), {1})))
                .at(0)
                .status == Status::bad_address);
    REQUIRE(plain.talk(link::encode_request(number, Command::read, with(address(interface::modulation_base, 0), {2})))
                .at(0)
                .status == Status::bad_address);
}

TEST_CASE("second instrument: settings and samples have a value at power-up, are read back, and outlast a reset",
          "[second][wide][settings]") {
    sim::SimulatedBoardOptions options;
    options.power_up_seed = generator()();
    Bench bench("small-16-wide", options);
    bench.client.identify();
    const auto read = [&](std::uint32_t address, std::uint16_t count) {
        const Bytes bytes = bench.client.read(address, static_cast<std::uint16_t>(2 * count));
        Words words;
        for (std::size_t i = 0; i < bytes.size(); i += 2)
            words.push_back(static_cast<std::uint16_t>(bytes[i] | bytes[i + 1] << 8));
        return words;
    };
    REQUIRE(read(interface::parameters_base, 11) == Words{0, 0, 0, 1250, 0, 0, 0, 0, 65535, 65535, 1});
    REQUIRE(read(interface::modulation_base, 16) == Words(16, 0xffff));
    const Words settings = {1, 2, 0xf, 4, 0x8005, 0x3, 7, 2, 9, 10, 0xfff};
    Bytes bytes;
    for (const std::uint16_t word : settings) {
        bytes.push_back(static_cast<std::uint8_t>(word));
        bytes.push_back(static_cast<std::uint8_t>(word >> 8));
    }
    bench.client.write(interface::parameters_base, bytes);
    bench.client.write(interface::modulation_base + 62, words({0x1234}));
    REQUIRE(read(interface::parameters_base, 11) == settings);
    bench.client.reset();
    REQUIRE(read(interface::parameters_base, 11) == settings);
    REQUIRE(read(interface::modulation_base + 62, 1) == Words{0x1234});
    // While samples are played, they are still read and written rightly.
    bench.client.modulate(1, 0, true);
    for (std::uint16_t i = 0; i < 32; ++i)
        bench.client.write(interface::modulation_base + 2U * i, words({static_cast<std::uint16_t>(i * 257 + 3)}));
    for (std::uint16_t i = 0; i < 32; ++i)
        REQUIRE(read(interface::modulation_base + 2U * i, 1) == Words{static_cast<std::uint16_t>(i * 257 + 3)});
}

TEST_CASE("second instrument: while outputs are off a command does not wait for the end of a long cycle",
          "[second][wide]") {
    Wide bench;
    auto g = generator();
    bench.open();
    const std::uint32_t ticks = 5'000'000;  // a tenth of a second
    Words slow = {static_cast<std::uint16_t>(ticks & 0xffff), static_cast<std::uint16_t>(20 << 8 | ticks >> 16), 1, 0};
    slow.insert(slow.end(), channel_count, 0);
    bench.write_record(1, slow);
    bench.random_record(g, 2, 1250);
    bench.raw_record(g, 3, 1250, 100);
    for (const std::uint16_t index : {std::uint16_t{2}, std::uint16_t{3}, std::uint16_t{0}}) {
        bench.client.select(1);
        bench.wait_for_index(1);
        bench.board.run(20'000);
        bench.client.disable();
        bench.client.select(index);
        bench.wait_for_index(index, 1000);
        bench.client.enable();
        bench.board.run(20'000);
        const std::size_t end = bench.recorder.cycles().size() - 2;
        if (index != 0) require_right(bench.compare(end - 7, end), 32);
    }
    REQUIRE(bench.client.status().guard_trips == 0);
}

namespace {

/// Streams random foci at so many a second, through the line that the board has, and compares every pulse. The dwells
/// of whole carrier periods are mixed so that their mean makes the rate.
void stream_foci(std::string_view model, std::uint32_t side, std::uint16_t base, double rate, std::size_t count) {
    Wide bench(model);
    auto g = generator();
    bench.open();
    const FocusEngine engine = square_engine(side, 1.0);
    bench.write_engine(engine, base, 1, 1, false);
    const link::FocusRing ring = link::make_ring(bench.client);
    REQUIRE(link::make_ring(bench.client) == ring);  // as often as asked
    link::LiveFeed fifo(bench.client, bench.client.identity(), 1);
    const double periods = 40e3 / rate;
    Book book;
    std::vector<std::uint32_t> dwells;
    std::uint64_t promised = 0;
    while (dwells.size() < count) {
        if (fifo.room() < fifo.frame()) {
            fifo.refresh();
            continue;
        }
        const bool longer = static_cast<double>(promised) <= periods * static_cast<double>(dwells.size());
        const auto dwell = static_cast<std::uint16_t>(longer ? std::ceil(periods) : std::floor(periods));
        Words words;
        for (std::size_t i = 0; i < fifo.frame(); ++i) {
            const FocusWords focus = random_focus(g);
            words.insert(words.end(), focus.begin(), focus.end());
            dwells.push_back(dwell);
            promised += dwell;
            Played one{{}, 1250};
            for (const ChannelDrive& drive : engine_drives(engine, std::vector{focus}, false))
                one.emissions.push_back({drive.amplitude, drive.phase});
            book[static_cast<std::uint16_t>(dwells.size())] = one;
        }
        fifo.push_foci(words, dwell);
    }
    fifo.push({0}, 0);
    REQUIRE(bench.board.run_until([&] { return bench.board.outputs().index != 0; }, 2'000'000));
    REQUIRE(bench.board.run_until([&] { return bench.board.outputs().index == 0; }, 2000 * promised));
    bench.board.run(5000);
    const link::Status status = bench.client.status();
    REQUIRE(status.underruns == 0);
    REQUIRE(status.refused_records == 0);
    REQUIRE(status.frames_refused == 0);

    // The ring's indices come again; a number of its own for each focus says which one it is.
    std::vector<MeasuredCycle> cycles;
    std::size_t first = 0, number = 0;
    std::uint16_t before = 0;
    std::vector<std::uint32_t> measured;
    for (const sim::CycleStart& start : bench.recorder.cycles()) {
        if (start.index != 0 && start.index != before) {
            if (number == 0) first = cycles.size();
            ++number;
            measured.push_back(0);
        }
        if (start.index != 0) ++measured.back();
        before = start.index;
        cycles.push_back({start.clock, start.index == 0 ? std::uint16_t{0} : static_cast<std::uint16_t>(number)});
    }
    REQUIRE(measured == dwells);
    const std::size_t end = first + promised;
    const double seconds = static_cast<double>(cycles[end].clock - cycles[first].clock) / 50e6;
    const double made = static_cast<double>(dwells.size()) / seconds;
    INFO(made << " foci a second");
    if (figures()) WARN(made << " foci a second, " << dwells.size() << " foci, " << status.underruns << " underruns");
    REQUIRE(made >= 0.999 * rate);
    const interface::CoreParameters& p = bench.board.parameters();
    EmissionModel emission(p.channels, p.timing_bits, p.width_bits, p.min_pulse_clocks);
    require_right(
        compare_periods(
            cycles, bench.recorder.pulses(), book, first - 4, end + 2, [](std::size_t) { return Setting{}; }, emission),
        dwells.size() * bench.channels() / 2);
}

}  // namespace

TEST_CASE("live foci: 36,000 a second at 3 Mbaud without an underrun, and every pulse where the model says",
          "[second][wide][live]") {
    stream_foci("small-16-wide", 4, 600, 36e3, 1080);
}

TEST_CASE("live foci: 12,000 a second at 1 Mbaud without an underrun, for 100 channels",
          "[second][wide][tile100][live]") {
    stream_foci("tile-100-wide", 10, 2600, 12e3, 180);
}

TEST_CASE("live foci: what is refused is not played, and the ring goes on where it was", "[second][wide][live]") {
    Wide bench;
    auto g = generator();
    bench.open();
    const FocusEngine engine = square_engine(4, 1.0);
    const std::size_t each = GENERATE(3U, 5U);
    const auto push = [&](std::size_t count, std::uint16_t dwell) {
        Words words;
        for (std::size_t i = 0; i < count * each; ++i) {
            const FocusWords focus = random_focus(g);
            words.insert(words.end(), focus.begin(), focus.end());
        }
        return bench.client.push_foci(words, dwell);
    };
    REQUIRE_REFUSED(push(1, 1));  // no ring
    REQUIRE_REFUSED(link::make_ring(bench.client));
    bench.write_engine(engine, 10, 1, each, false);
    if (each > 4) {  // 257 records of so many foci are more than the memory holds
        REQUIRE_REFUSED(link::make_ring(bench.client));
        return;
    }
    const link::FocusRing ring = link::make_ring(bench.client);
    REQUIRE(ring.count == 257);
    REQUIRE(ring.each == each);
    const auto wrong = GENERATE(0, 1, 2, 3);
    Words block = {ring.base, ring.first, ring.count};
    if (wrong == 1) block[2] = 256;                                         // no more records than the FIFO has places
    if (wrong == 2) block[1] = static_cast<std::uint16_t>(ring.first + 1);  // its last index is beyond the foci
    if (wrong == 3) block[0] = 1279;                                        // beyond primary memory
    bench.write(interface::ring_base, block);
    if (wrong != 0) {
        REQUIRE_REFUSED(push(1, 1));
        return;
    }
    REQUIRE(bench.client.read(interface::ring_base, 6) == words({ring.base, ring.first, ring.count}));
    REQUIRE(push(5, 1) > 0);
    bench.wait_for_index(static_cast<std::uint16_t>(ring.first + 4));
    if (each > 1) REQUIRE_REFUSED(bench.client.push_foci(Words(4 * each + 4), 1));
    REQUIRE_REFUSED(bench.client.push_foci(Words(4 * each + 1), 1));
    REQUIRE(bench.client.status().live_level == 0);
    // 18 rounds of 15: the ring's end passes its beginning; then what does not fit into the FIFO.
    for (int round = 0; round < 18; ++round) {
        while (bench.client.status().live_level > 200) bench.board.run(20'000);
        push(15, 1);
    }
    bench.wait_for_index(static_cast<std::uint16_t>(ring.first + (5 + 18 * 15 - 1) % ring.count));
    push(1, 60'000);
    bench.wait_for_index(static_cast<std::uint16_t>(ring.first + (5 + 18 * 15) % ring.count));
    const std::size_t frame = 60 / each;
    std::size_t level = 0;
    while (level + frame <= 256) level = push(frame, 1);
    REQUIRE_REFUSED(push(frame, 1));
    REQUIRE(bench.client.status().live_level == level);
    REQUIRE(push(256 - level, 1) == 256);
}
