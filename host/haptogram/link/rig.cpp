// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/rig.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/link/rig_stream.hpp"
#include "haptogram/link/rig_tiles.hpp"
#include "haptogram/link/transfer.hpp"

namespace haptogram::link {
namespace {

using namespace std::chrono_literals;

Error tile_error(const Tile& tile, const std::string& message) { return {ErrorCode::device, tile.name, message}; }

constexpr const char* another_image = "it holds another image than its own; upload the rig to it";

/// In words, which tile's image a tile holds that does not hold its own.
std::string found_instead(std::span<const Tile> tiles, const Tile& tile) {
    for (const Tile& other : tiles)
        if (&other != &tile && other.image.channels == tile.image.channels &&
            with(tile, [&](Client& device) { return holds_records(device, other.image); }))
            return fmt::format("it holds the image of {}: the two ports are swapped, or the images are", other.name);
    return another_image;
}

Role role_of(std::size_t tile) { return tile == 0 ? Role::master : Role::slave; }

bool follows(const Status& status) { return status.in_step && status.numbered; }

std::uint64_t period_of(const Tile& tile) {
    return with(tile, [](Client& device) { return device.status().period.value_or(0); });
}

/// Waits for the slaves as long as the master counts: simulated boards may take a while for a carrier period.
void wait_for_step(std::span<const Tile> tiles) {
    constexpr std::uint64_t most_periods = 4000;  // 100 ms, four times what it takes
    const std::uint64_t begin = period_of(tiles[0]);
    PeriodCount count;
    for (const Tile& tile : tiles.subspan(1))
        while (!with(tile, [](Client& device) { return follows(device.status()); })) {
            const std::uint64_t period = period_of(tiles[0]);
            if (!count.goes_on(period, tiles[0].device.clock().now())) throw tile_error(tiles[0], stands_still(period));
            if (period - begin > most_periods)
                throw tile_error(tile, fmt::format("it is a slave and does not come into step with {}; check the wire "
                                                   "from there to its sync_in, and the ground",
                                                   tiles[0].name));
            with(tile, [](Client& device) { device.exchange(5ms); });
        }
}

/// A slave could follow another master, or have its number from one.
void require_same_numbers(std::span<const Tile> tiles) {
    for (std::size_t i = 1; i < tiles.size(); ++i) {
        const std::uint64_t from = period_of(tiles[0]), here = period_of(tiles[i]), to = period_of(tiles[0]);
        if (here + 1 < from || here > to + 1)
            throw tile_error(tiles[i], fmt::format("it is in carrier period {}, while {} went from {} to {}; is it "
                                                   "wired to another master?",
                                                   here, tiles[0].name, from, to));
    }
}

}  // namespace

void require_images(std::span<const Tile> tiles) {
    for (const Tile& tile : tiles) {
        require_fits(tile.image, tile.device.identity(), tile.name);
        if (!with(tile, [&](Client& device) { return holds_records(device, tile.image); }))
            throw tile_error(tile, found_instead(tiles, tile));
        with(tile, [&](Client& device) {
            if (tile.image.foci) write_settings(device, tile.image);
        });
        if (!with(tile, [&](Client& device) { return holds(device, tile.image); }))
            throw tile_error(tile, another_image);
    }
}

void keep_together(std::span<const Tile> tiles) {
    if (tiles.size() < 2) return;
    std::vector<Status> statuses;
    for (const Tile& tile : tiles) {
        const interface::CoreParameters core = tile.device.identity().core();
        if (core.sync == 0 || core.schedule == 0)
            throw tile_error(tile, fmt::format("this board has no {}, so it cannot play together with others",
                                               core.sync == 0 ? "SYNC" : "SCHEDULE"));
        statuses.push_back(with(tile, [](Client& device) { return device.status(); }));
    }
    // A new master numbers anew, and the others must learn that; a slave is told its role only when it has another.
    const bool new_master = statuses[0].role != Role::master;
    for (std::size_t i = 0; i < tiles.size(); ++i)
        if (new_master || statuses[i].role != role_of(i))
            with(tiles[i], [&](Client& device) { device.set_role(role_of(i)); });
    wait_for_step(tiles);
    require_same_numbers(tiles);
}

RigPlayed play(std::span<const Tile> tiles, const RigSettings& settings, const RigWatch& watch) {
    if (const Image& image = tiles.front().image; settings.index != 0 && !place_of(image, settings.index))
        throw bad_argument("index", fmt::format("{}: expected {}", settings.index, records_in_words(image)));
    prepare(tiles);
    PlayingTiles playing(tiles, settings);
    const auto arm = [&](const Tile& tile, When when) {
        begin_modulation(tile, when);
        if (settings.index != 0)
            tile.device.push({settings.index}, 0, when);
        else
            tile.device.start(1, settings.loops ? static_cast<std::uint16_t>(tile.image.sequence.size()) : 0,
                              settings.loops.value_or(0), when);
    };
    RigTeller tell(watch, tiles.front().device.clock());
    const auto play_on = [&] {
        const std::uint64_t begins = playing.begin_together(arm, 0, false);
        tell.begin();
        const std::chrono::milliseconds pause = keep_alive_pause(settings.watchdog_ms);
        // Asking for the status also keeps the watchdogs quiet.
        do {
            playing.wait(pause);
            playing.ask();
            if (playing.all(is_over)) playing.ask();  // as sure_status() does
        } while (tell(playing) && (playing.period() < begins || !playing.all(is_over)) &&
                 (settings.seconds == 0.0 || tell.seconds() < settings.seconds));
    };
    if (then_off(play_on, [&] { return playing.off(); })) tell.interrupt();
    return tell.outcome(playing);
}

}  // namespace haptogram::link
