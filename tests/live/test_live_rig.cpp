// SPDX-License-Identifier: Apache-2.0
// Two boards of a rig that a live path is played on: at the pins they are one array.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <deque>
#include <map>
#include <memory>
#include <numbers>
#include <optional>

#include "../refusal.hpp"
#include "haptogram/array/rig.hpp"
#include "haptogram/link/outputs.hpp"
#include "haptogram/link/rig_commands.hpp"
#include "haptogram/live/players.hpp"
#include "rig_simulation.hpp"
#include "tiles.hpp"

using namespace haptogram;
using namespace std::chrono_literals;

namespace {

constexpr double fs = 1e-15, carrier_s = 25e-6;

/// A tile on either side, which lean towards each other.
Rig leaning_pair() {
    const Array tile = find_array("tile-10x10");
    const double c = std::cos(0.2), s = std::sin(0.2);
    Rig rig{.name = "pair", .arrays = {}};
    rig.arrays.push_back({tile, {{-60e-3, 0, 0}, {c, 0, -s}, {0, 1, 0}, {s, 0, c}}});
    rig.arrays.push_back({tile, {{60e-3, 0, 0}, {c, 0, s}, {0, 1, 0}, {-s, 0, c}}});
    return rig;
}

/// Reference boards, as one device, and what their pins do.
struct RigBench {
    Rig rig = leaning_pair();
    Array array = joined(rig);
    sim::ReferenceTiles boards{"tile-100-wide", sim::random_oscillators(2, 50.0, 3), 3};
    std::vector<std::unique_ptr<sim::TileTransport>> lines;
    std::vector<std::unique_ptr<link::Client>> clients;
    Image no_image;
    std::vector<link::Tile> tiles;
    std::vector<live::DevicePart> parts;
    std::optional<link::RigCommands> device;
    std::vector<std::vector<std::pair<double, std::uint16_t>>> changes{2};  ///< of the record at the pins
    std::deque<double> periods;                                             ///< when the master's last ones began
    std::map<std::pair<std::size_t, std::uint32_t>, double> rises;          ///< the last of each channel
    std::complex<double> at_focus;  ///< sum of the pulses' phases there, and how many they are
    double pulses = 0.0;
    std::optional<Vec3> focus;  ///< while it is looked at

    RigBench() {
        for (std::size_t i = 0; i < 2; ++i) {
            lines.push_back(std::make_unique<sim::TileTransport>(boards, i));
            clients.push_back(std::make_unique<link::Client>(*lines.back()));
            clients.back()->identify();
            tiles.push_back({*clients.back(), no_image, "tile " + std::to_string(i + 1)});
            parts.push_back({*clients.back(), 100});
            boards.board(i).on_cycle_start([this, i](const sim::CycleStart& c) {
                if (i == 0) {
                    periods.push_back(seconds(0, c.clock));
                    if (periods.size() > 4) periods.pop_front();
                }
                if (c.enabled && (changes[i].empty() || changes[i].back().second != c.index))
                    changes[i].emplace_back(seconds(i, c.clock), c.index);
            });
            boards.board(i).on_edge([this, i](const sim::Edge& edge) { look(i, edge); });
        }
        device.emplace(tiles, link::RigSettings{});
    }

    [[nodiscard]] double seconds(std::size_t board, std::uint64_t clock) const {
        return fs * static_cast<double>(boards.time_of(board, clock));
    }
    void look(std::size_t board, const sim::Edge& edge) {
        const double at = seconds(board, edge.clock);
        if (edge.rises) {
            rises[{board, edge.channel}] = at;
            return;
        }
        const auto rise = rises.find({board, edge.channel});
        if (!focus || rise == rises.end()) return;
        const Vec3 from = array.elements[100 * board + edge.channel].position;
        const double arrives = 0.5 * (rise->second + at) + norm(*focus - from) / array.medium.speed_m_s;
        // Periods of boards in step are a clock longer or not; all are those of the master.
        const auto begins = std::find_if(periods.rbegin(), periods.rend(), [&](double s) { return s <= at; });
        if (begins == periods.rend()) return;
        at_focus += std::polar(1.0, 2.0 * std::numbers::pi * (arrives - *begins) / carrier_s);
        pulses += 1.0;
    }
    [[nodiscard]] link::Clock& clock() { return lines.front()->clock(); }
    void serve(live::Player& player, double for_s) {
        link::Clock& time = clock();
        const double until_s = time.now_s() + for_s;
        while (time.now_s() < until_s)
            if (!player.service()) time.rest(500us);
    }
    /// How well pulses of both boards meet at a place that is played: 1 when all come at the same time.
    [[nodiscard]] double coherence(live::Player& player, Vec3 place) {
        focus = place;
        at_focus = 0.0;
        pulses = 0.0;
        serve(player, 5e-3);
        focus.reset();
        return std::abs(at_focus) / pulses;
    }
    /// Whether both boards played the same records in the same carrier periods.
    void require_together() const {
        // They are not turned off in the same period.
        const std::size_t both = std::min(changes[0].size(), changes[1].size());
        REQUIRE(both > 50);
        REQUIRE(std::max(changes[0].size(), changes[1].size()) <= both + 10);
        for (std::size_t i = 0; i < both; ++i) {
            INFO("change " << i << " at " << changes[0][i].first << " and " << changes[1][i].first);
            REQUIRE(changes[0][i].second == changes[1][i].second);
            REQUIRE(std::abs(changes[0][i].first - changes[1][i].first) < 0.1 * carrier_s);
        }
    }
};

Path circle_at(Vec3 centre, std::size_t points) {
    Path path;
    for (std::size_t i = 0; i < points; ++i) {
        const double angle = 2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(points);
        path.steps.push_back({{{centre + Vec3{10e-3 * std::cos(angle), 10e-3 * std::sin(angle), 0.0}, 1.0}}, 40});
    }
    return path;
}

Path still_at(Vec3 place) { return {{{{{place, 1.0}}, 400}}, {}}; }

/// Plays, is silent, plays again, is left alone until it has run dry, and goes on.
void play_on_both(RigBench& bench, live::Player& player, bool still) {
    const Vec3 place{8e-3, -5e-3, 0.17};
    const auto off = [&] {
        player.replace(circle_at({0, 0, 0.18}, 10), 1, 0.0);
        bench.serve(player, 0.1);
        if (still) {
            player.replace(still_at(place), 2, 0.1);
            bench.serve(player, 0.1);
            CHECK(bench.coherence(player, place) > 0.99);
            CHECK(bench.coherence(player, place + Vec3{12e-3, 0, 0}) < 0.5);
        }
        player.silence();
        bench.serve(player, 0.05);
        const unsigned begun = bench.device->beginnings();
        CHECK(begun == 1);
        player.replace(circle_at({0, 0, 0.18}, 10), 3, 0.2);
        bench.serve(player, 0.1);
        CHECK(bench.device->beginnings() == begun + 1);
        bench.clock().rest(100ms);  // nobody sends anything
        bench.serve(player, 0.2);
        CHECK(bench.device->beginnings() > begun + 1);
        // Whichever board ran dry, the rig has.
        unsigned all = 0;
        for (auto& client : bench.clients) all += client->status().underruns;
        CHECK(all > 0);
        CHECK(bench.device->status().underruns == all);
        bench.changes = {{}, {}};  // from here on
        bench.serve(player, 0.2);
    };
    link::while_on(*bench.device, 500, off);
    bench.require_together();
    for (std::size_t i = 0; i < 2; ++i) CHECK(!bench.boards.board(i).present().enabled);
}

}  // namespace

TEST_CASE("live rig: two boards that compute foci are one array", "[rig]") {
    RigBench bench;
    const live::ChosenPlayer chosen = live::choose_player(*bench.device, bench.clock(), bench.array,
                                                          {.pace = {.foci = 1, .periods = 40}, .parts = bench.parts});
    CHECK(chosen.about.starts_with("the board computes foci"));
    play_on_both(bench, *chosen.player, true);
}

TEST_CASE("live rig: records, of which each board gets its part", "[rig]") {
    RigBench bench;
    live::RingPlayer player(*bench.device, bench.clock(), bench.array, 10, Method::distance_weighted, 500, bench.parts);
    play_on_both(bench, player, false);
    // One place of all steps: pulses of both boards meet there.
    RigBench other;
    live::RingPlayer still(*other.device, other.clock(), other.array, 10, Method::distance_weighted, 500, other.parts);
    const Vec3 place{0, 5e-3, 0.16};
    link::while_on(*other.device, 500, [&] {
        still.replace(still_at(place), 1, 0.0);
        other.serve(still, 0.1);
        CHECK(other.coherence(still, place) > 0.99);
    });
}

TEST_CASE("live rig: one board that goes off turns all off and is named", "[rig]") {
    RigBench bench;
    const live::ChosenPlayer chosen = live::choose_player(*bench.device, bench.clock(), bench.array,
                                                          {.pace = {.foci = 1, .periods = 40}, .parts = bench.parts});
    const auto work = [&] {
        chosen.player->replace(circle_at({0, 0, 0.18}, 10), 1, 0.0);
        bench.serve(*chosen.player, 0.1);
        bench.boards.board(1).press_stop(true);
        bench.serve(*chosen.player, 0.2);
    };
    CHECK_REFUSED(link::while_on(*bench.device, 500, work));
    for (std::size_t i = 0; i < 2; ++i) CHECK(!bench.boards.board(i).present().enabled);
}
