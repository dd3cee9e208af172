// SPDX-License-Identifier: Apache-2.0
// Streams to all tiles of a rig, measured at the pins of Verilated boards with crystals of their own.
#include <algorithm>
#include <cmath>
#include <optional>

#include "../refusal.hpp"
#include "haptogram/link/rig_stream.hpp"
#include "pair.hpp"

using namespace haptogram;
using namespace haptogram::test;

namespace {

constexpr double clock_fs = 20e6;  // of 50 MHz

using Entries = std::vector<SequenceEntry>;

/// Entries that follow each other, with different records side by side.
Entries random_entries(std::mt19937& g, std::size_t count, const std::vector<std::uint16_t>& dwells) {
    Entries entries;
    while (entries.size() < count) {
        const auto index = static_cast<std::uint16_t>(g() % 6);
        if (entries.empty() ? index != 0 : index != entries.back().index)
            entries.push_back({index, dwells[g() % dwells.size()]});
    }
    return entries;
}

/// Gives entries in groups, and nothing in between for some time.
class Halting final : public link::StreamSource {
public:
    Halting(Entries entries, std::size_t group, unsigned halt)
        : entries_(std::move(entries)), group_(group), halt_(halt) {}
    std::optional<SequenceEntry> next(std::chrono::milliseconds) override {
        if (taken_ % group_ == 0 && taken_ != 0 && waited_++ < halt_) return {};
        if (ended()) return {};
        waited_ = 0;
        return entries_[taken_++];
    }
    [[nodiscard]] bool ended() const override { return taken_ == entries_.size(); }

private:
    Entries entries_;
    std::size_t group_, taken_ = 0;
    unsigned halt_, waited_ = 0;
};

/// When the channels of each tile began to pulse, in order.
struct Rises {
    struct Rise {
        Femtoseconds at;
        std::uint32_t channel;
        std::uint16_t index;  ///< at the pins
    };
    std::vector<std::vector<Rise>> of;  // by tile

    explicit Rises(Pair& pair) : of(2) {
        for (std::size_t i = 0; i < 2; ++i)
            pair.tiles.board(i).on_edge([this, &pair, i](const sim::Edge& edge) {
                if (edge.rises) of[i].push_back({pair.tiles.time_of(i, edge.clock), edge.channel, edge.index});
            });
    }
};

/// Judges every pulse of every tile by the carrier period of the master in which it begins, from the one on in which
/// the first entry plays: it is one of the record that the entries say, and begins when that tile's record says.
/// @return the pulses
std::size_t require_played(const Pair& pair, const Rises& rises, const Entries& entries) {
    constexpr double most_clocks = 6.0;  // two between tiles, and what lies between a period's begin and the pins
    constexpr Femtoseconds early = 60'000'000;  // three clocks
    REQUIRE_FALSE(pair.played[0].empty());
    const auto begin = std::ranges::find_if(pair.played[0], [](const auto& change) { return change.second != 0; });
    REQUIRE(begin != pair.played[0].end());
    auto period = std::ranges::find(pair.periods, begin->first);
    std::size_t pulses = 0;
    std::vector<std::size_t> next(2, 0);  // rise of each tile
    std::uint16_t before = 0;
    for (const SequenceEntry& entry : entries)
        for (unsigned n = 0; n < entry.dwell; ++n, ++period, before = entry.index) {
            REQUIRE(pair.periods.end() - period > 1);
            for (std::size_t tile = 0; tile < 2; ++tile) {
                const Image& image = pair.rig[tile].image;
                const Record* record = entry.index == 0 ? nullptr : &image.records[entry.index - 1U];
                std::size_t here = 0, firing = 0;
                for (; next[tile] < rises.of[tile].size(); ++next[tile], ++here) {
                    const Rises::Rise& rise = rises.of[tile][next[tile]];
                    if (rise.at >= period[1] - early) break;
                    const double clocks = static_cast<double>(rise.at - period[0]) / clock_fs;
                    if (rise.at < period[0] - early || rise.index != entry.index || !record ||
                        (record->kind == interface::Kind::timings &&
                         std::abs(clocks - static_cast<double>(record->timings[rise.channel] * record->prescaler)) >
                             most_clocks))
                        FAIL(
                            fmt::format("tile {}, channel {}: a pulse of record {}, {:.1f} clocks after the begin of "
                                        "a period in which record {} plays",
                                        tile + 1, rise.channel, rise.index, clocks, entry.index));
                }
                for (std::uint32_t channel = 0; record && channel < image.channels; ++channel)
                    firing += record->fires(channel) ? 1U : 0U;
                // A pulse of the record before can reach into that of the next.
                const bool steady = entry.index == before;
                if (steady ? here != firing : here < firing / 4)
                    FAIL(fmt::format("tile {}: {} pulses of {} in a period in which record {} plays", tile + 1, here,
                                     firing, entry.index));
                pulses += here;
            }
        }
    for (std::size_t tile = 0; tile < 2; ++tile) CHECK(next[tile] == rises.of[tile].size());
    return pulses;
}

}  // namespace

TEST_CASE("rig, stream: every pulse of both tiles is in the carrier period of its entry") {
    std::mt19937 g(Catch::rngSeed());
    Pair pair(g, ImageKind::records);
    link::keep_together(pair.rig);  // now, so that what is recorded is not reset any more
    Rises rises(pair);
    const Entries entries = random_entries(g, 150, {1, 2, 5, 10});
    link::RepeatedEntries source(entries, 1);
    const link::RigPlayed played = link::stream(pair.rig, pair.settings(), source);
    pair.run_ms(0.2);
    CHECK(played.sent == entries.size());
    CHECK(played.underruns == 0);
    CHECK(played.refused_records == 0);
    CHECK(played.lost.empty());
    CHECK_FALSE(played.interrupted);
    CHECK_FALSE(pair.any_enabled());
    const std::uint64_t pulses = require_played(pair, rises, entries);
    fmt::print("rig, stream: seed {}, {} entries, {} pulses, each in its period on both tiles\n", Catch::rngSeed(),
               entries.size(), pulses);
    CHECK(pulses > 30'000);
}

TEST_CASE("rig, stream: a path goes into the tiles and plays pass after pass") {
    std::mt19937 g(Catch::rngSeed());
    Pair pair(g, ImageKind::records);
    link::keep_together(pair.rig);
    Rises rises(pair);
    const link::RigPlayed played = link::stream(pair.rig, pair.settings(), 2);
    pair.run_ms(0.2);
    const Entries& pass = pair.rig[0].image.sequence;
    Entries entries = pass;
    entries.insert(entries.end(), pass.begin(), pass.end());
    CHECK(played.sent == entries.size());
    CHECK(played.underruns == 0);
    CHECK(require_played(pair, rises, entries) > 10'000);
    // Their sequences are gone, so nobody plays them with records that are no longer theirs.
    CHECK_REFUSAL(heard::refusal_of([&] { static_cast<void>(link::play(pair.rig, pair.settings())); }));
}

TEST_CASE("rig, stream: tiles change together behind entries of dwell 0, and after they have run out of entries") {
    std::mt19937 g(Catch::rngSeed());
    Pair pair(g, ImageKind::records);
    const bool until_the_next = GENERATE(true, false);
    const Entries entries =
        random_entries(g, 20, until_the_next ? std::vector<std::uint16_t>{0, 3} : std::vector<std::uint16_t>{5});
    Halting source(entries, until_the_next ? 1 : 3, until_the_next ? 1 : 6);
    const link::RigPlayed played = link::stream(pair.rig, pair.settings(), source);
    pair.run_ms(0.2);
    CHECK(played.sent == entries.size());
    if (!until_the_next) CHECK(played.underruns >= 2);
    // Each change of both, in order, at the same time.
    std::vector<std::uint16_t> wanted;
    for (const SequenceEntry& entry : entries) wanted.push_back(entry.index);
    if (wanted.back() != 0) wanted.push_back(0);
    for (auto& one : pair.played) {
        while (!one.empty() && one.front().second == 0) one.erase(one.begin());
        std::vector<std::uint16_t> found;
        for (const auto& change : one) found.push_back(change.second);
        CHECK(found == wanted);
    }
    pair.require_alike(entries.size());
}

TEST_CASE("rig, stream: a tile that falls silent ends it, or the others go on") {
    std::mt19937 g(Catch::rngSeed());
    Pair pair(g, ImageKind::records);
    link::keep_together(pair.rig);
    const Entries entries = random_entries(g, 200, {20, 40});
    const auto with_a_cut = [&](link::OnLoss on_loss, const link::RigWatch& watch) {
        link::RepeatedEntries source(entries, 1);
        pair.lines[1]->cut = false;
        return link::stream(pair.rig, pair.settings(on_loss), source, [&](const link::RigPlaying& now) {
            if (now.sent > 40) pair.lines[1]->cut = true;
            return watch(now);
        });
    };
    SECTION("off") {
        CHECK_REFUSAL(heard::refusal_of(
            [&] { static_cast<void>(with_a_cut(link::OnLoss::off, [](const link::RigPlaying&) { return true; })); }));
        CHECK_FALSE(pair.tiles.board(0).outputs().enabled);
        pair.run_ms(45);  // its watchdog
        CHECK_FALSE(pair.any_enabled());
    }
    SECTION("rest") {
        bool went_off = false;
        const link::RigPlayed played = with_a_cut(link::OnLoss::rest, [&](const link::RigPlaying& now) {
            if (now.sent > 0 && !pair.tiles.board(0).outputs().enabled) went_off = true;
            return true;
        });
        CHECK(played.lost == std::vector<std::string>{"tile 2"});
        CHECK(played.sent == entries.size());
        CHECK(played.watchdog_trips == 0);
        CHECK_FALSE(went_off);
        REQUIRE(pair.warnings.size() >= 1);
        CHECK_SAID(pair.warnings[0]);
        // The first has played every entry.
        std::vector<std::uint16_t> wanted, found;
        for (const SequenceEntry& entry : entries) wanted.push_back(entry.index);
        auto& one = pair.played[0];
        while (!one.empty() && one.front().second == 0) one.erase(one.begin());
        for (const auto& change : one) found.push_back(change.second);
        if (wanted.back() == 0 && found.size() + 1 == wanted.size()) found.push_back(0);
        if (wanted.back() != 0) wanted.push_back(0);
        CHECK(found == wanted);
        CHECK_FALSE(pair.tiles.board(0).outputs().enabled);
    }
}

TEST_CASE("rig, stream: what cannot be streamed is told, and the outputs go off") {
    std::mt19937 g(Catch::rngSeed());
    Pair pair(g, ImageKind::records);
    link::keep_together(pair.rig);
    const auto stream = [&](link::StreamSource& source) {
        return heard::refusal_of([&] { static_cast<void>(link::stream(pair.rig, pair.settings(), source)); });
    };
    // A first entry that no tile has: nothing is heard at all.
    link::RepeatedEntries unknown({{6, 1}}, 1);
    CHECK_REFUSAL(stream(unknown));
    CHECK(pair.played[0].empty());
    // One in the midst.
    Entries entries = random_entries(g, 300, {3});
    entries.back().index = 6;
    link::RepeatedEntries later(entries, 1);
    CHECK_REFUSAL(stream(later));
    CHECK_FALSE(pair.any_enabled());
    // The watch ends it.
    link::RepeatedEntries endless({{1, 10}, {2, 10}}, 0);
    const link::RigPlayed played =
        link::stream(pair.rig, pair.settings(), endless, [](const link::RigPlaying& now) { return now.sent < 200; });
    CHECK(played.interrupted);
    CHECK(played.sent >= 200);
    CHECK_FALSE(pair.any_enabled());
    // Tiles that hold other images.
    std::vector<link::Tile> swapped = {{*pair.hosts[1], pair.rig[0].image, "tile 1"},
                                       {*pair.hosts[0], pair.rig[1].image, "tile 2"}};
    link::RepeatedEntries good({{1, 10}}, 1);
    CHECK_REFUSAL(heard::refusal_of([&] { static_cast<void>(link::stream(swapped, pair.settings(), good)); }));
}
