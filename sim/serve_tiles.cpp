// SPDX-License-Identifier: Apache-2.0
#include "serve_tiles.hpp"

#include <fmt/format.h>

#include <charconv>
#include <chrono>
#include <cmath>
#include <utility>

#include "haptogram/base/error.hpp"

namespace haptogram::sim {
namespace {

double seconds_of(Femtoseconds time) { return 1e-15 * static_cast<double>(time); }

bool is_cut(std::span<const TileFault> faults, std::size_t tile, double now_s) {
    for (const TileFault& fault : faults)
        if (fault.kind == TileFault::Kind::silent && fault.tile == tile && now_s >= fault.at_s) return true;
    return false;
}

}  // namespace

TileFault parse_fault(const std::string& text, std::size_t tiles) {
    const auto fail = [&](const std::string& what) {
        return bad_argument("fault", fmt::format("found '{}', expected {}", text, what));
    };
    const std::size_t colon = text.find(':'), at = text.find('@');
    const std::string kind = text.substr(0, colon);
    if (colon == std::string::npos || at == std::string::npos || at < colon || (kind != "silent" && kind != "sync"))
        throw fail("silent:TILE@SECONDS or sync:TILE@SECONDS, such as silent:2@1.5");
    TileFault fault{kind == "sync" ? TileFault::Kind::sync : TileFault::Kind::silent, 0, 0.0};
    const char* const end = text.data() + text.size();
    const auto tile = std::from_chars(text.data() + colon + 1, text.data() + at, fault.tile);
    if (tile.ec != std::errc() || tile.ptr != text.data() + at || fault.tile < 1 || fault.tile > tiles)
        throw fail(fmt::format("a tile from 1 to {} behind the colon", tiles));
    --fault.tile;
    const auto time = std::from_chars(text.data() + at + 1, end, fault.at_s);
    if (time.ec != std::errc() || time.ptr != end || !std::isfinite(fault.at_s) || fault.at_s < 0.0)
        throw fail("a number of seconds, not negative, behind the @");
    if (fault.kind == TileFault::Kind::sync && fault.tile == 0)
        throw fail("a tile from 2 on: tile 1 drives the wire SYNC and does not listen to it");
    return fault;
}

std::string_view tile_model_with_channels(std::uint32_t channels,
                                          std::span<const interface::CoreConfiguration> models) {
    std::vector<interface::CoreConfiguration> able;
    for (const interface::CoreConfiguration& model : models)
        if (model.parameters.sync != 0 && model.parameters.schedule != 0) able.push_back(model);
    return model_with_channels(channels, able);
}

ServedTiles serve(Tiles& tiles, std::span<const std::unique_ptr<PseudoTerminal>> terminals, const ServeOptions& options,
                  std::span<const TileFault> faults, const std::function<bool(const ServedTiles&)>& watch) {
    constexpr Femtoseconds slice = 40 * microsecond;  // less than one byte at 115,200 baud
    Pace pace(most_behind_s);
    ServedTiles served;
    served.enabled.resize(tiles.size());
    std::vector<LinkCounters> links(terminals.size(), LinkCounters(tiles.chained() ? 2 : 0));
    const auto go_on = [&] {
        served.simulated_s = seconds_of(tiles.now());
        served.wall_s = pace.wall_s();
        served.frames = served.applied = 0;
        for (const LinkCounters& link : links) {
            served.frames += link.frames;
            served.applied += link.applied;
        }
        return watch(served) && (options.seconds == 0.0 || served.simulated_s < options.seconds);
    };
    while (go_on()) {
        pace.give_up(served.simulated_s);
        const double ahead_s = pace.ahead_s(served.simulated_s);
        int patience_ms = options.real_time && ahead_s > 1e-3 ? static_cast<int>(1e3 * ahead_s) : 0;
        for (const TileFault& fault : faults) {
            if (served.simulated_s < fault.at_s) continue;
            if (fault.kind == TileFault::Kind::sync)
                tiles.connect(fault.tile, false);
            else if (tiles.chained() && fault.tile > 0)
                tiles.cut_chain(fault.tile, true);
        }
        for (std::size_t i = 0; i < terminals.size(); ++i) {
            const auto arrived = terminals[i]->read(std::chrono::milliseconds(std::exchange(patience_ms, 0)));
            links[i].in(arrived);
            if (!is_cut(faults, i, served.simulated_s)) tiles.board(i).send(arrived);
        }
        tiles.run(slice);
        for (std::size_t i = 0; i < terminals.size(); ++i) {
            const auto answer = tiles.board(i).receive();
            if (is_cut(faults, i, served.simulated_s)) continue;
            terminals[i]->write(answer);
            links[i].out(answer);
        }
    }
    for (std::size_t i = 0; i < tiles.size(); ++i) served.enabled[i] = tiles.board(i).present().enabled;
    return served;
}

}  // namespace haptogram::sim
