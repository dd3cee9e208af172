// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>
#include <random>
#include <vector>

#include "../refusal.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/link/modulate.hpp"
#include "haptogram/link/source.hpp"

using namespace haptogram;
using namespace haptogram::link;

namespace {

constexpr double carrier_hz = 40e3;

/// The index in each carrier period, until the source ends or so many are there.
std::vector<std::uint16_t> played(StreamSource& source, std::size_t most = 1'000'000) {
    std::vector<std::uint16_t> found;
    while (found.size() < most && !source.ended())
        if (const auto entry = source.next(std::chrono::milliseconds(0)))
            found.insert(found.end(), entry->dwell, entry->index);
    return found;
}

Modulation made(const char* waveform) { return modulation_of(waveform, AmplitudeLaw::pressure, carrier_hz).modulation; }

}  // namespace

TEST_CASE("stream source: a sequence is repeated, and cut where its time ends", "[link]") {
    const std::vector<SequenceEntry> pass{{1, 3}, {0, 2}, {2, 1}};
    RepeatedEntries twice(pass, 2);
    CHECK(played(twice) == std::vector<std::uint16_t>{1, 1, 1, 0, 0, 2, 1, 1, 1, 0, 0, 2});
    RepeatedEntries cut(pass, 0, 8);
    CHECK(played(cut) == std::vector<std::uint16_t>{1, 1, 1, 0, 0, 2, 1, 1});
    RepeatedEntries endless(pass, 0);
    CHECK(played(endless, 6000).size() == 6000);
    RepeatedEntries nothing({}, 0);
    CHECK(nothing.ended());
}

TEST_CASE("stream source: a gate silences the periods in which the waveform is off", "[link]") {
    std::mt19937_64 random(Catch::rngSeed());
    const auto text =
        GENERATE(as<std::string>{}, "square:200", "square:500:0.25", "square:210.175", "square:1000:0.9", "static");
    const Modulation modulation = made(text.c_str());
    std::vector<SequenceEntry> pass;
    for (int i = 0; i < 50; ++i)
        pass.push_back({static_cast<std::uint16_t>(random() % 5), static_cast<std::uint16_t>(1 + random() % 400)});
    RepeatedEntries plain(pass, 1), source(pass, 1);
    GatedEntries gated(source, gate_of(modulation, text));
    const std::vector<std::uint16_t> all = played(plain), some = played(gated);
    CAPTURE(text);
    REQUIRE(some.size() == all.size());
    for (std::size_t i = 0; i < all.size(); ++i) {
        const double level = modulation.samples.at(i / modulation.periods_a_sample % modulation.samples.size());
        REQUIRE(some[i] == (level >= 0.5 ? all[i] : 0));
    }
}

TEST_CASE("stream source: what silence between entries cannot make is named", "[link]") {
    for (const char* const waveform : {"sine:200", "triangle:200", "abs-sine:100", "square:200+square:50"})
        CHECK_REFUSED(gate_of(made(waveform), waveform));
    CHECK_REFUSED(gate_of(made("square:1000:0.02"), "square:1000:0.02"));  // less than a period
    RepeatedEntries held({{1, 0}}, 1);
    GatedEntries gated(held, gate_of(made("square:200"), "square:200"));
    CHECK_REFUSED(gated.next(std::chrono::milliseconds(0)));
}
