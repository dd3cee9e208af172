// SPDX-License-Identifier: Apache-2.0
// Rigs through the whole chain: compiled, uploaded, begun in one carrier period, and measured at the pins of as many
// Verilated boards as tiles, each with a crystal of its own. And what a host does when a tile is not as it must be.
#include <fmt/format.h>

#include <set>

#include "../refusal.hpp"
#include "pair.hpp"
#include "serve_tiles.hpp"

using namespace haptogram;
using namespace haptogram::test;

TEST_CASE("rig: a shape on four tiles, from the compiler to the pins, is where one perfect array has it") {
    std::mt19937 g(Catch::rngSeed());
    const ImageKind kind = g() % 2 == 0 ? ImageKind::records : ImageKind::foci;
    const CompiledRig compiled = compile_rig(circle(g, 4, 500.0, kind), "2x2", "wall.json");
    const sim::RigSimulation s =
        sim::simulate(compiled.bundle, {.passes = 1, .drift_ppm = 50.0, .seed = Catch::rngSeed()});
    fmt::print(
        "rig: seed {}, {}, begun in period {} after {} attempt(s), {:.3f} clocks apart; {} points, {:.4f} % of the "
        "pressure of a perfect array at least, peaks {:.4f} mm off at most\n",
        Catch::rngSeed(), kind == ImageKind::foci ? "foci" : "records", s.played.period, s.played.attempts,
        s.start_spread_clocks, s.result.checked, 100.0 * s.result.least_kept, 1e3 * s.result.worst_offset_m);
    for (const std::string& violation : s.result.playback.violations) UNSCOPED_INFO(violation);
    CHECK(s.result.playback.violation_count == 0);
    CHECK(s.result.checked == 4);
    CHECK(s.result.least_kept >= 0.995);
    CHECK(s.result.worst_offset_m <= 0.2e-3);
    CHECK(s.start_spread_clocks <= 2.0);
    CHECK(s.result.good());
}

TEST_CASE("rig: no output is enabled before every tile is as it must be") {
    std::mt19937 g(Catch::rngSeed());
    // Images of foci are alike but for their geometry, which boards do not give back.
    const auto kind = GENERATE(ImageKind::records, ImageKind::foci);
    Pair pair(g, kind);
    std::set<std::size_t> enabled;
    for (std::size_t i = 0; i < 2; ++i)
        pair.tiles.board(i).on_cycle_start([&enabled, i](const sim::CycleStart& start) {
            if (start.enabled) enabled.insert(i);
        });
    const auto play = [&](std::vector<link::Tile> rig) {
        return heard::refusal_of([&] { static_cast<void>(link::play(rig, pair.settings())); });
    };
    // Ports swapped: each holds the other's image.
    CHECK_REFUSAL(play({{*pair.hosts[1], pair.rig[0].image, "tile 1"}, {*pair.hosts[0], pair.rig[1].image, "tile 2"}}));
    // The second holds neither.
    CHECK_REFUSAL(play({pair.rig[0], {*pair.hosts[1], pair.compiled.bundle.tiles[2].image, "tile 2"}}));
    // Its records are those of the second, its modulation is not; of foci all that is no record is written before they
    // play.
    Image modulated = pair.compiled.bundle.tiles[1].image;
    modulated.modulation = SampledModulation{1, {255, 128}};
    if (kind == ImageKind::records) CHECK_REFUSAL(play({pair.rig[0], {*pair.hosts[1], modulated, "tile 2"}}));
    // The wire SYNC is not connected.
    pair.tiles.connect(1, false);
    CHECK_REFUSAL(play(pair.rig));
    pair.tiles.connect(1, true);
    // The stop switch of one is pressed: nothing of the other may be heard either.
    pair.tiles.board(0).press_stop(true);
    CHECK_REFUSAL(play(pair.rig));
    pair.tiles.board(0).press_stop(false);
    CHECK(enabled.empty());
    CHECK_FALSE(pair.any_enabled());
    // All well again.
    pair.run_ms(1);
    int looks = 0;
    const link::RigPlayed played =
        link::play(pair.rig, pair.settings(), [&](const link::RigPlaying&) { return ++looks < 3; });
    CHECK(played.interrupted);
    CHECK(enabled == std::set<std::size_t>{0, 1});
    CHECK_FALSE(pair.any_enabled());
}

TEST_CASE("rig: a slave out of step, and one that was reset, are named") {
    std::mt19937 g(Catch::rngSeed());
    Pair pair(g, ImageKind::records);
    int looks = 0;
    CHECK_REFUSAL(heard::refusal_of([&] {
        static_cast<void>(link::play(pair.rig, pair.settings(), [&](const link::RigPlaying&) {
            if (++looks == 2) pair.tiles.connect(1, false);
            return true;
        }));
    }));
    CHECK_FALSE(pair.any_enabled());
    pair.tiles.connect(1, true);
    looks = 0;
    CHECK_REFUSAL(heard::refusal_of([&] {
        static_cast<void>(link::play(pair.rig, pair.settings(), [&](const link::RigPlaying&) {
            if (++looks == 2) pair.hosts[1]->reset();
            return true;
        }));
    }));
    CHECK_FALSE(pair.any_enabled());
}

TEST_CASE("rig: a tile that hears of the agreed period too late makes all agree on another") {
    std::mt19937 g(Catch::rngSeed());
    Pair pair(g, ImageKind::records);
    link::keep_together(pair.rig);
    const std::size_t slow = g() % 2;
    int looks = 0, stalls = 0;
    pair.lines[slow]->on_command = [&](interface::Command command) {
        if (command == interface::Command::start && stalls++ == 0) pair.run_ms(60);
    };
    const link::RigPlayed played = link::play(pair.rig, pair.settings(), [&](const link::RigPlaying&) {
        return ++looks < 1000 && std::min(pair.played[0].size(), pair.played[1].size()) < 6;
    });
    CHECK(played.attempts == 2);
    CHECK(stalls >= 2);
    pair.require_alike(2);
}

TEST_CASE("rig: when a tile falls silent while it plays, all go off, or the others go on") {
    std::mt19937 g(Catch::rngSeed());
    Pair pair(g, ImageKind::records);
    int looks = 0, looks_after = 0;
    bool went_off = false;
    const auto play = [&](link::OnLoss on_loss) {
        looks = looks_after = 0;
        return link::play(pair.rig, pair.settings(on_loss), [&](const link::RigPlaying& now) {
            if (++looks == 2) pair.lines[1]->cut = true;
            if (!pair.tiles.board(0).outputs().enabled) went_off = true;
            return now.statuses[1].has_value() || ++looks_after < 5;
        });
    };
    SECTION("all go off") {
        CHECK_REFUSAL(heard::refusal_of([&] { static_cast<void>(play(link::OnLoss::off)); }));
        CHECK(looks == 2);
        CHECK_FALSE(pair.tiles.board(0).outputs().enabled);
        pair.run_ms(45);  // the silent one's watchdog
        CHECK_FALSE(pair.any_enabled());
    }
    SECTION("the others go on") {
        const link::RigPlayed played = play(link::OnLoss::rest);
        CHECK(played.lost == std::vector<std::string>{"tile 2"});
        CHECK(looks_after == 5);
        CHECK(played.interrupted);
        // Nobody heard the first one pause while the host waited for the other.
        CHECK_FALSE(went_off);
        CHECK(played.watchdog_trips == 0);
        REQUIRE_FALSE(pair.warnings.empty());
        CHECK_SAID(pair.warnings[0]);
        CHECK_FALSE(pair.any_enabled());
    }
}

TEST_CASE("rig: tiles behind one line play together, and one that is cut off is named", "[deep]") {
    std::mt19937 g(Catch::rngSeed());
    const bool go_on = g() % 2 == 0;
    Pair pair(g, ImageKind::records, true);
    int looks = 0, looks_after = 0;
    const auto play = [&] {
        return link::play(pair.rig, pair.settings(go_on ? link::OnLoss::rest : link::OnLoss::off),
                          [&](const link::RigPlaying& now) {
                              if (++looks == 3) pair.tiles.cut_chain(1, true);
                              return now.statuses[1].has_value() || ++looks_after < 3;
                          });
    };
    if (go_on) {
        const link::RigPlayed played = play();
        CHECK(played.lost == std::vector<std::string>{"tile 2"});
        CHECK(played.watchdog_trips == 0);
    } else {
        CHECK_REFUSAL(heard::refusal_of([&] { static_cast<void>(play()); }));
    }
    pair.require_alike(4);
    CHECK_FALSE(pair.tiles.board(0).outputs().enabled);
    pair.run_ms(45);  // the watchdog of the one that is cut off
    CHECK_FALSE(pair.any_enabled());
}

TEST_CASE("rig: a tile that is reset or out of step leaves the others playing, if that is wanted") {
    std::mt19937 g(Catch::rngSeed());
    Pair pair(g, ImageKind::records);
    const bool reset = GENERATE(false, true);
    int looks = 0, looks_after = 0;
    const link::RigPlayed played =
        link::play(pair.rig, pair.settings(link::OnLoss::rest), [&](const link::RigPlaying& now) {
            if (++looks == 2) {
                if (reset)
                    pair.hosts[1]->reset();
                else
                    pair.tiles.connect(1, false);
            }
            if (!now.statuses[1]) CHECK(pair.tiles.board(0).outputs().enabled);
            return now.statuses[1].has_value() || ++looks_after < 3;
        });
    CHECK(played.lost == std::vector<std::string>{"tile 2"});
    REQUIRE_FALSE(pair.warnings.empty());
    CHECK_SAID(pair.warnings[0]);
    CHECK_FALSE(pair.any_enabled());
}

TEST_CASE("rig: the loss of the first tile, which gives the time, ends it for all") {
    std::mt19937 g(Catch::rngSeed());
    Pair pair(g, ImageKind::records);
    int looks = 0;
    CHECK_REFUSAL(heard::refusal_of([&] {
        static_cast<void>(link::play(pair.rig, pair.settings(link::OnLoss::rest), [&](const link::RigPlaying&) {
            if (++looks == 2) pair.hosts[0]->reset();
            return true;
        }));
    }));
    CHECK_FALSE(pair.any_enabled());
}

TEST_CASE("rig: faults as a text") {
    const sim::TileFault fault = sim::parse_fault("sync:3@0.25", 4);
    CHECK((fault.kind == sim::TileFault::Kind::sync && fault.tile == 2 && fault.at_s == 0.25));
    CHECK(sim::parse_fault("silent:1@2", 4).kind == sim::TileFault::Kind::silent);
    for (const char* const bad : {"", "silent", "silent:0@1", "silent:5@1", "silent:1@-1", "silent:1@x", "silent:1@1s",
                                  "sync:1@1", "broken:1@1", "silent@1:2", "silent:1"})
        CHECK_REFUSAL(heard::refusal_of([&] { static_cast<void>(sim::parse_fault(bad, 4)); }));
}
