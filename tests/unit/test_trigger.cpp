// SPDX-License-Identifier: Apache-2.0
// Marks of entries from a path file to a board's memory, and a board's clock as time of the host.
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <vector>

#include "haptogram/base/error.hpp"
#include "haptogram/format/image.hpp"
#include "haptogram/link/clock_fit.hpp"
#include "haptogram/shape/path_file.hpp"

using namespace haptogram;

namespace {

Image marked_image() {
    Image image;
    image.channels = 16;
    image.clock_hz = 50'000'000;
    image.timing_bits = 12;
    image.records = {Record{250, 5, 100, std::vector<std::uint16_t>(16, 7)}};
    image.sequence = {{1, 3}, {0, 2, true}, {1, 9, true}};
    return image;
}

}  // namespace

TEST_CASE("marks: an image keeps them in the uppermost bit of an entry's index, and reads them back") {
    const Image image = marked_image();
    REQUIRE(sequence_words(image) == std::vector<std::uint32_t>{3, 0x0003'0001, 0x0002'8000, 0x0009'8001});
    REQUIRE(from_intel_hex(to_intel_hex(image), "image").sequence == image.sequence);
}

TEST_CASE("marks: a board without a trigger output refuses them, by name") {
    interface::CoreParameters core = interface::find_configuration("small-16")->parameters;
    REQUIRE_NOTHROW(require_fits(marked_image(), core, "image"));
    core.trigger = 0;
    REQUIRE_THROWS_WITH(require_fits(marked_image(), core, "image"), Catch::Contains("marks entries"));
}

TEST_CASE("marks: a path file says them by step, and anything but true and false is an error") {
    const std::string text =
        R"({"format": "haptogram-path-1", "carrier_hz": 40000, "steps": [{"periods": 4, "foci": []},
            {"periods": 5, "mark": true, "foci": []}, {"periods": 5, "mark": false, "foci": []}]})";
    const Path path = path_from_json(text, "path.json", 40'000.0);
    REQUIRE((!path.steps[0].mark && path.steps[1].mark && !path.steps[2].mark));
    REQUIRE(path_from_json(to_json_text(path, 40'000.0), "again", 40'000.0) == path);
    std::string wrong = text;
    wrong.replace(wrong.find("true"), 4, "1");
    REQUIRE_THROWS_WITH(path_from_json(wrong, "path.json", 40'000.0), Catch::Contains("true or false"));
}

TEST_CASE("clocks: a crystal that is off, and a line of random delays, are fitted within the stated error") {
    std::mt19937 g(Catch::rngSeed());
    for (int round = 0; round < 50; ++round) {
        const auto uniform = [&g](double low, double high) {
            return std::uniform_real_distribution<double>(low, high)(g);
        };
        const double hz = 50e6 * (1 + uniform(-1e-4, 1e-4)), begun_s = uniform(0, 1e5);
        const std::uint64_t first = g() * std::uint64_t{1000};
        const auto clock_at = [&](double s) { return first + static_cast<std::uint64_t>(hz * (s - begun_s)); };
        std::vector<link::ClockSample> samples;
        for (int i = 0; i < 200; ++i) {
            const double asked = begun_s + 0.05 * i, out = uniform(50e-6, i % 9 == 0 ? 20e-3 : 400e-6),
                         back = uniform(50e-6, 400e-6);
            samples.push_back({asked, asked + out + back, clock_at(asked + out)});
        }
        const link::ClockFit fit = link::fit_clocks(samples);
        for (double s : {0.0, 3.0, 7.5, 10.0}) {
            INFO("error " << fit.error_s << " spread " << fit.spread_s);
            REQUIRE(std::abs(fit.host_s(clock_at(begun_s + s)) - begun_s - s) < fit.error_s);
        }
        REQUIRE(fit.error_s < 400e-6);
        REQUIRE(std::abs(fit.s_per_clock * hz - 1) < 2e-5);
    }
}

TEST_CASE("clocks: what cannot be one is refused") {
    using Samples = std::vector<link::ClockSample>;
    REQUIRE_THROWS_WITH(link::fit_clocks(Samples{}), Catch::Contains("expected at least two"));
    REQUIRE_THROWS_WITH(link::fit_clocks(Samples{{0, 1, 5}, {2, 3, 5}}), Catch::Contains("no two different clocks"));
    REQUIRE_THROWS_WITH(link::fit_clocks(Samples{{1, 0, 5}, {2, 3, 9}}), Catch::Contains("before its question"));
    REQUIRE_THROWS_WITH(link::fit_clocks(Samples{{0, 1, 50}, {2, 3, 9}}), Catch::Contains("goes back"));
}
