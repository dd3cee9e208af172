// SPDX-License-Identifier: Apache-2.0
// What a host makes weaker while it plays, at the pins.
#include <cmath>
#include <map>

#include "../refusal.hpp"
#include "haptogram/link/intensity.hpp"
#include "haptogram/link/transfer.hpp"
#include "haptogram/solve/drives.hpp"
#include "wide_bench.hpp"

using namespace haptogram;
using namespace haptogram::test;

TEST_CASE("intensity: pulses of a sequence become shorter and longer while it plays, and nothing else happens") {
    auto g = generator();
    Bench bench;
    const std::uint32_t channels = bench.channels();
    std::vector<Record> records;
    for (int i = 0; i < 5; ++i) {
        // Of all channels alike, so that the pulses of two records never meet.
        Record one = random_record(g, channels, 250, 5, 100);
        for (auto& timing : one.timings) timing = static_cast<std::uint16_t>(timing % 100);
        records.push_back(one);
    }
    const Image image = image_of(channels, records);
    bench.client.identify();
    link::upload(bench.client, image);
    link::Intensity intensity(image);
    bench.client.set_watchdog(0);
    bench.client.enable();
    bench.client.start(1, 5, 0);
    const Timer timer{50e6, 5, 250, 100, 1};
    std::size_t before = 0;
    for (const double factor : {1.0, 0.5, 0.03, 0.8, 0.0, 1.0}) {
        intensity.set(bench.client, factor);
        bench.board.run(3 * 5 * 1250);  // what was loaded before has been played
        before = bench.recorder.pulses().size();
        bench.board.run(20 * 5 * 1250);
        std::map<std::uint64_t, std::size_t> lengths;
        const auto& pulses = bench.recorder.pulses();
        for (std::size_t i = before; i < pulses.size(); ++i) ++lengths[pulses[i].fall - pulses[i].rise];
        const std::uint32_t wanted = pulse_ticks(timer, factor);
        INFO("factor " << factor << ", " << lengths.size() << " lengths, wanted " << wanted);
        if (wanted == 0) {
            REQUIRE(lengths.empty());
            continue;
        }
        REQUIRE(lengths.size() == 1);
        REQUIRE(lengths.begin()->first == 5 * wanted);
        REQUIRE(lengths.begin()->second + 2 * channels >= 100 * channels);
    }
    // What is left is the image, word by word.
    REQUIRE(link::holds(bench.client, image));
    const link::Status status = bench.client.status();
    REQUIRE(status.refused_records == 0);
    REQUIRE(status.underruns == 0);
    REQUIRE_REFUSED(intensity.set(bench.client, 1.1));
}

TEST_CASE("intensity: amplitudes are multiplied by the board's modulation", "[wide]") {
    auto g = generator();
    wide::Wide bench;
    Record record{1250, 1, 0, {}, interface::Kind::amplitudes};
    for (std::uint32_t k = 0; k < bench.channels(); ++k)
        record.timings.push_back(static_cast<std::uint16_t>(0xff00U | random(g, 0, 255)));
    Image image = image_of(bench.channels(), {record});
    const bool modulated = GENERATE(false, true);
    if (modulated) image.modulation = SampledModulation{4, {255, 128}};
    bench.client.identify();
    link::upload(bench.client, image);
    link::Intensity intensity(image);
    bench.client.set_watchdog(0);
    bench.client.enable();
    bench.client.select(1);
    for (const double factor : {0.5, 0.25, 1.0}) {
        intensity.set(bench.client, factor);
        bench.board.run(4 * 1250);
        const std::size_t before = bench.recorder.pulses().size();
        bench.board.run(40 * 1250);
        const auto& pulses = bench.recorder.pulses();
        REQUIRE(pulses.size() > before + 30 * bench.channels());
        const auto wanted = [factor](int sample) {
            const auto amplitude = static_cast<std::uint16_t>(std::lround(factor * sample) * 257);
            return emission_ticks(amplitude, 1250, 1);
        };
        const std::uint32_t longest = wanted(255), shortest = wanted(modulated ? 128 : 255);
        std::size_t right = 0;
        for (std::size_t i = before; i < pulses.size(); ++i) {
            const auto length = static_cast<std::uint32_t>(pulses[i].fall - pulses[i].rise);
            // Products are cut to 16 bits, and both ends of a pulse are rounded.
            const auto is = [length](std::uint32_t ticks) { return length + 2 >= ticks && length <= ticks + 2; };
            right += is(longest) || is(shortest) ? 1 : 0;
            INFO("factor " << factor << ", a pulse of " << length << " clocks");
            REQUIRE(length + 2 >= shortest);
            REQUIRE(length <= longest + 2);
        }
        // A pulse over the end of a period has one half of either sample's.
        REQUIRE(10 * right >= (modulated ? 7U : 10U) * (pulses.size() - before));
    }
}

TEST_CASE("intensity: another modulation, or none, while it plays, as strong as before", "[wide]") {
    auto g = generator();
    wide::Wide bench;
    Record record{1250, 1, 0, {}, interface::Kind::amplitudes};
    for (std::uint32_t k = 0; k < bench.channels(); ++k)
        record.timings.push_back(static_cast<std::uint16_t>(0xff00U | random(g, 0, 255)));
    const Image image = image_of(bench.channels(), {record});
    bench.client.identify();
    link::upload(bench.client, image);
    link::Intensity intensity(image);
    bench.client.set_watchdog(0);
    bench.client.enable();
    bench.client.select(1);
    intensity.set(bench.client, 0.5);
    using Samples = std::optional<SampledModulation>;
    for (const Samples& modulation :
         {Samples(SampledModulation{3, {255, 0}}), Samples(SampledModulation{2, {64, 64, 255, 0}}), Samples()}) {
        intensity.modulate(bench.client, modulation);
        bench.board.run(4 * 1250);
        const std::size_t before = bench.recorder.pulses().size();
        const std::size_t periods = 48;  // of all samples, whole rounds
        bench.board.run(periods * 1250);
        const auto& pulses = bench.recorder.pulses();
        const std::uint32_t whole = emission_ticks(static_cast<std::uint16_t>(128 * 257), 1250, 1);
        std::size_t strong = 0;
        for (std::size_t i = before; i < pulses.size(); ++i)
            strong += pulses[i].fall - pulses[i].rise + 2 >= whole ? 1 : 0;
        const std::size_t parts = !modulation ? 1 : modulation->samples.size();
        const std::size_t expected = periods * bench.channels() / parts;
        INFO(parts << " samples: " << strong << " strong pulses, expected " << expected);
        REQUIRE(strong + 2 * bench.channels() >= expected);
        REQUIRE(strong <= expected + 2 * bench.channels());
    }
    const std::uint32_t most = bench.board.parameters().modulation_depth;
    REQUIRE_REFUSED(intensity.modulate(bench.client, SampledModulation{1, std::vector<std::uint8_t>(most + 1)}));
}

TEST_CASE("intensity: neither timings nor a board without modulation can be modulated") {
    auto g = generator();
    Bench bench;
    bench.client.identify();
    link::Intensity timings(image_of(bench.channels(), {random_record(g, bench.channels(), 250, 5, 100)}));
    REQUIRE_REFUSED(timings.modulate(bench.client, {}));
    const Record record{1250, 1, 0, std::vector<std::uint16_t>(bench.channels(), 0xff80), interface::Kind::amplitudes};
    link::Intensity amplitudes(image_of(bench.channels(), {record}));
    REQUIRE_REFUSED(amplitudes.set(bench.client, 0.5));
}
