// SPDX-License-Identifier: Apache-2.0
// Two tiles of a rig with a host each, whose lines can be cut.
#pragma once
#include <fmt/format.h>

#include <cstdlib>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "bench.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/link/chain.hpp"
#include "haptogram/link/frame.hpp"
#include "haptogram/link/rig.hpp"
#include "haptogram/link/transfer.hpp"
#include "haptogram/verbs/rig.hpp"
#include "rig_simulation.hpp"

namespace haptogram::test {

inline Project circle(std::mt19937& g, std::size_t points, double rate_hz, ImageKind kind) {
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
    [[nodiscard]] haptogram::link::Clock& clock() override { return line_.clock(); }
    [[nodiscard]] std::chrono::microseconds patience() const override { return line_.patience(); }

    bool cut = false;
    std::function<void(interface::Command)> on_command;  ///< before it goes out

private:
    link::Transport& line_;
};

/// Two boards. Most cases are about the host, so these are reference boards, which are equal to Verilated ones at every
/// clock (tests/reference, test_reference_tiles.cpp); HAPTOGRAM_MODEL=rtl takes those. Only they can be chained.
inline std::unique_ptr<sim::Tiles> two_boards(std::mt19937& g, bool chained) {
    const auto oscillators = sim::random_oscillators(2, 50.0, static_cast<std::uint32_t>(g()));
    const auto seed = static_cast<std::uint32_t>(g());
    const char* model = std::getenv("HAPTOGRAM_MODEL");
    if (chained || (model != nullptr && std::string_view(model) == "rtl"))
        return std::make_unique<sim::SimulatedTiles>("tile-100-wide", oscillators, seed);
    return std::make_unique<sim::ReferenceTiles>("tile-100-wide", oscillators, seed);
}

/// Two tiles in one time, with their images in their memories.
struct Pair {
    CompiledRig compiled;
    std::unique_ptr<sim::Tiles> boards;
    sim::Tiles& tiles;
    std::vector<std::unique_ptr<link::Transport>> wires;
    std::vector<std::unique_ptr<TroubledLine>> lines;
    std::vector<std::unique_ptr<link::Client>> hosts;
    std::vector<link::Tile> rig;
    std::vector<std::string> warnings;
    std::vector<Femtoseconds> periods;                                        // of the master: when each began
    std::vector<std::vector<std::pair<Femtoseconds, std::uint16_t>>> played;  // of each tile: changes of index

    /// @param chained  the second's serial line is behind the first's
    Pair(std::mt19937& g, ImageKind kind, bool chained = false)
        : compiled(compile_rig(circle(g, 5, 200.0, kind), "2x2", "wall.json")),
          boards(two_boards(g, chained)),
          tiles(*boards),
          played(2) {
        if (chained) tiles.chain();
        const auto chain = std::make_shared<link::Chain>(std::make_unique<sim::TileTransport>(tiles, 0));
        for (std::size_t i = 0; i < 2; ++i) {
            if (chained)
                wires.push_back(chain->tile(static_cast<unsigned>(i + 1)));
            else
                wires.push_back(std::make_unique<sim::TileTransport>(tiles, i));
            lines.push_back(std::make_unique<TroubledLine>(*wires.back()));
            hosts.push_back(std::make_unique<link::Client>(*lines.back()));
            hosts.back()->identify();
            rig.push_back({*hosts.back(), compiled.bundle.tiles[i].image, fmt::format("tile {}", i + 1)});
            link::upload(*hosts.back(), rig.back().image);
            tiles.board(i).on_cycle_start([this, i](const sim::CycleStart& start) {
                const Femtoseconds at = tiles.time_of(i, start.clock);
                if (i == 0) periods.push_back(at);
                if (start.enabled && (played[i].empty() || played[i].back().second != start.index))
                    played[i].push_back({at, start.index});
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

}  // namespace haptogram::test
