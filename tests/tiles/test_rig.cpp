// SPDX-License-Identifier: Apache-2.0
// Rigs through the whole chain: compiled, uploaded, begun in one carrier period, and measured at the pins of as many
// Verilated boards as tiles, each with a crystal of its own. And what a host does when a tile is not as it must be.
#include <fmt/format.h>

#include <functional>
#include <set>

#include "bench.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/instrument/rig.hpp"
#include "haptogram/link/frame.hpp"
#include "haptogram/link/rig.hpp"
#include "haptogram/link/transfer.hpp"
#include "rig_simulation.hpp"
#include "serve_tiles.hpp"

using namespace haptogram;
using namespace haptogram::test;
using Catch::Contains;

namespace {

Project circle(std::mt19937& g, std::size_t points, double rate_hz, ImageKind kind) {
    std::uniform_real_distribution<double> sideways(-20, 20), up(150, 220);
    Project project;
    project.shapes.push_back({});
    project.shapes.back().primitive.kind = "circle";
    project.placement.center = from_mm(sideways(g), sideways(g), up(g));
    project.points = points;
    project.rate_hz = rate_hz;
    project.seed = g();
    project.image = kind;
    return project;
}

/// A line that can be cut, and that tells which command it carries.
class TroubledLine final : public link::Transport {
public:
    explicit TroubledLine(link::Transport& line) : line_(line) {}
    void write(std::span<const std::uint8_t> bytes) override {
        const auto frame = link::cobs_decode(bytes.first(bytes.empty() ? 0 : bytes.size() - 1));
        if (on_command && frame && frame->size() > 1) on_command(static_cast<interface::Command>((*frame)[1]));
        if (!cut) line_.write(bytes);
    }
    [[nodiscard]] std::vector<std::uint8_t> read(std::chrono::microseconds patience) override {
        auto bytes = line_.read(patience);
        if (cut) bytes.clear();
        return bytes;
    }
    [[nodiscard]] std::chrono::microseconds patience() const override { return line_.patience(); }

    bool cut = false;
    std::function<void(interface::Command)> on_command;  ///< before it goes out

private:
    link::Transport& line_;
};

/// Two tiles in one time, with their images in their memories.
struct Pair {
    CompiledRig compiled;
    sim::Tiles tiles;
    std::vector<std::unique_ptr<sim::TileTransport>> wires;
    std::vector<std::unique_ptr<TroubledLine>> lines;
    std::vector<std::unique_ptr<link::Client>> hosts;
    std::vector<link::Tile> rig;
    std::vector<std::string> warnings;
    std::vector<std::vector<std::pair<Femtoseconds, std::uint16_t>>> played;  // of each tile: changes of index

    Pair(std::mt19937& g, ImageKind kind)
        : compiled(compile_rig(circle(g, 5, 200.0, kind), "2x2", "wall.json")),
          tiles("tile-100-wide", sim::random_oscillators(2, 50.0, static_cast<std::uint32_t>(g())),
                static_cast<std::uint32_t>(g())),
          played(2) {
        for (std::size_t i = 0; i < 2; ++i) {
            wires.push_back(std::make_unique<sim::TileTransport>(tiles, i));
            lines.push_back(std::make_unique<TroubledLine>(*wires.back()));
            hosts.push_back(std::make_unique<link::Client>(*lines.back()));
            hosts.back()->identify();
            rig.push_back({*hosts.back(), compiled.bundle.tiles[i].image, fmt::format("tile {}", i + 1)});
            link::upload(*hosts.back(), rig.back().image);
            tiles.board(i).on_cycle_start([this, i](const sim::CycleStart& start) {
                if (start.enabled && (played[i].empty() || played[i].back().second != start.index))
                    played[i].push_back({tiles.now(), start.index});
            });
        }
    }

    link::RigSettings settings(link::OnLoss on_loss = link::OnLoss::off) {
        return {.loops = 0, .watchdog_ms = 40, .on_loss = on_loss, .warn = [this](const std::string& message) {
                    warnings.push_back(message);
                }};
    }
    bool any_enabled() { return tiles.board(0).outputs().enabled || tiles.board(1).outputs().enabled; }
    void run_ms(double milliseconds) { tiles.run(static_cast<Femtoseconds>(milliseconds * 1000.0) * microsecond); }

    /// Both play the same indices, each change at the same time to two clocks.
    void require_alike(std::size_t least) {
        for (auto& one : played)
            while (!one.empty() && one.front().second == 0) one.erase(one.begin());
        const std::size_t both = std::min(played[0].size(), played[1].size());
        REQUIRE(both >= least);
        for (std::size_t i = 0; i < both; ++i) {
            REQUIRE(played[0][i].second == played[1][i].second);
            REQUIRE(std::abs(played[0][i].first - played[1][i].first) <= 2 * 20'000'000);
        }
    }
};

std::string error_of(const std::function<void()>& work) {
    try {
        work();
    } catch (const Error& error) {
        return error.what();
    }
    return "no error";
}

}  // namespace

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
    Pair pair(g, ImageKind::records);
    std::set<std::size_t> enabled;
    for (std::size_t i = 0; i < 2; ++i)
        pair.tiles.board(i).on_cycle_start([&enabled, i](const sim::CycleStart& start) {
            if (start.enabled) enabled.insert(i);
        });
    const auto play = [&](std::vector<link::Tile> rig) {
        return error_of([&] { static_cast<void>(link::play(rig, pair.settings())); });
    };
    // Ports swapped: each holds the other's image.
    CHECK_THAT(play({{*pair.hosts[1], pair.rig[0].image, "tile 1"}, {*pair.hosts[0], pair.rig[1].image, "tile 2"}}),
               Contains("tile 1") && Contains("the image of tile 2") && Contains("swapped"));
    // The second holds neither.
    CHECK_THAT(play({pair.rig[0], {*pair.hosts[1], pair.compiled.bundle.tiles[2].image, "tile 2"}}),
               Contains("tile 2") && Contains("another image"));
    // The wire SYNC is not connected.
    pair.tiles.connect(1, false);
    CHECK_THAT(play(pair.rig), Contains("tile 2") && Contains("does not come into step with tile 1"));
    pair.tiles.connect(1, true);
    // The stop switch of one is pressed: nothing of the other may be heard either.
    pair.tiles.board(0).press_stop(true);
    CHECK_THAT(play(pair.rig), Contains("tile 1") && Contains("stopped"));
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
    CHECK_THAT(error_of([&] {
                   static_cast<void>(link::play(pair.rig, pair.settings(), [&](const link::RigPlaying&) {
                       if (++looks == 2) pair.tiles.connect(1, false);
                       return true;
                   }));
               }),
               Contains("tile 2") && Contains("out of step"));
    CHECK_FALSE(pair.any_enabled());
    pair.tiles.connect(1, true);
    looks = 0;
    CHECK_THAT(error_of([&] {
                   static_cast<void>(link::play(pair.rig, pair.settings(), [&](const link::RigPlaying&) {
                       if (++looks == 2) pair.hosts[1]->reset();
                       return true;
                   }));
               }),
               Contains("tile 2") && Contains("reset"));
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
    const link::RigPlayed played =
        link::play(pair.rig, pair.settings(), [&](const link::RigPlaying&) { return ++looks < 4; });
    CHECK(played.attempts == 2);
    CHECK(stalls >= 2);
    pair.require_alike(2);
}

TEST_CASE("rig: faults as a text") {
    const sim::TileFault fault = sim::parse_fault("sync:3@0.25", 4);
    CHECK((fault.kind == sim::TileFault::Kind::sync && fault.tile == 2 && fault.at_s == 0.25));
    CHECK(sim::parse_fault("silent:1@2", 4).kind == sim::TileFault::Kind::silent);
    for (const char* const bad : {"", "silent", "silent:0@1", "silent:5@1", "silent:1@-1", "silent:1@x", "silent:1@1s",
                                  "sync:1@1", "broken:1@1", "silent@1:2", "silent:1"})
        CHECK_THAT(error_of([&] { static_cast<void>(sim::parse_fault(bad, 4)); }),
                   Contains("fault") && Contains("expected"));
}
