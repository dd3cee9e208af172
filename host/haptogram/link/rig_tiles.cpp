// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/rig_tiles.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "haptogram/base/error.hpp"
#include "haptogram/link/play.hpp"

namespace haptogram::link {
namespace {

using namespace std::chrono_literals;

/// For so long a tile's watchdog waits for the host; then its outputs are off. Counted in looks, in its line's own
/// time: each lasts a millisecond, or until something arrives. A slow line brings the bytes of its answers one by one,
/// so there are as many looks more.
unsigned most_looks(std::uint16_t watchdog_ms) {
    constexpr unsigned bytes_of_answers = 128, without_watchdog = 1000;
    return bytes_of_answers + (watchdog_ms == 0 ? without_watchdog : watchdog_ms);
}

constexpr std::uint64_t least_start_lead = 200;  // carrier periods, 5 ms
constexpr std::uint64_t lead_of_a_tile = 8;      // exchanges with all tiles: what one needs to be armed and turned on
constexpr unsigned most_attempts = 5;

/// Why a tile cannot play on; empty when it can.
std::string unfit(const Status& status, const Status& before, bool on) {
    if (status.role != before.role) return "it was reset while it played";
    if (!on || status.enabled) return {};
    if (status.stopped) return "its outputs are off, because its stop input is active";
    if (status.role == Role::slave && !status.in_step)
        return "its outputs are off, because it is out of step; check its wire SYNC";
    return "it has turned its outputs off: its watchdog or guard tripped";
}

}  // namespace

PlayingTiles::PlayingTiles(std::span<const Tile> tiles, const RigSettings& settings)
    : tiles_(tiles), settings_(settings), statuses_(tiles.size()), counts_(tiles.size()) {
    for (std::size_t i = 0; i < tiles.size(); ++i)
        with(tiles[i], [&](Client& device) {
            device.set_watchdog(settings.watchdog_ms);
            before_.push_back(device.status());
            statuses_[i] = before_.back();
        });
}

std::string PlayingTiles::off() {
    std::vector<Client*> devices;
    for (const Tile& tile : tiles_) devices.push_back(&tile.device);
    const std::vector<bool> off = shut_off(devices);
    std::vector<std::string> trouble;
    for (std::size_t i = 0; i < tiles_.size(); ++i) {
        if (off[i]) continue;
        std::string found = fmt::format("{}: {}", tiles_[i].name, not_confirmed(settings_.watchdog_ms));
        if (is_lost(i) && settings_.on_loss == OnLoss::rest && settings_.watchdog_ms != 0 && settings_.warn)
            settings_.warn(found);
        else
            trouble.push_back(std::move(found));
    }
    return fmt::format("{}", fmt::join(trouble, "; "));
}

bool PeriodCount::goes_on(std::optional<std::uint64_t> period, Clock::Time now) {
    constexpr std::chrono::seconds most{3};
    if (!period || period != last_) since_ = now;
    last_ = period;
    return now - since_ < most;
}

std::string stands_still(std::uint64_t period) {
    return fmt::format("its count of carrier periods stands still at {}; switch it off and on", period);
}

void PlayingTiles::lose(std::size_t tile, const std::string& why) {
    statuses_[tile].reset();
    if (!on_ || settings_.on_loss == OnLoss::off)
        throw Error(ErrorCode::device, tiles_[tile].name,
                    why + (tiles_.size() > 1 ? "; all tiles are switched off" : ""));
    lost_.push_back(tiles_[tile].name);
    try {
        tiles_[tile].device.shut_off();
    } catch (const Error&) {
        // Its port is gone. What can be done was done, and the warning says that it is lost.
    }
    if (std::ranges::none_of(statuses_, [](const auto& status) { return status.has_value(); }))
        throw Error(ErrorCode::device, tiles_[tile].name, why + "; no tile is left");
    if (settings_.warn) settings_.warn(fmt::format("{}: {}; the others go on", tiles_[tile].name, why));
}

void PlayingTiles::each(const std::function<void(const Tile&)>& work) {
    for (std::size_t i = 0; i < tiles_.size(); ++i) {
        if (is_lost(i)) continue;
        try {
            work(tiles_[i]);
        } catch (const Interrupted&) {
            throw;
        } catch (const Error& error) {
            lose(i, error.message());
        }
    }
}

/// One that nobody asks for anything is told that the host is alive. In looks, not in time: a slow simulated board
/// would have more to answer than it can.
void PlayingTiles::keep_alive(std::span<const std::optional<Status>> answered) {
    for (std::size_t i = 0; i < tiles_.size(); ++i) {
        if (is_lost(i) || !answered[i]) continue;
        try {
            tiles_[i].device.exchange(0us);
            if (tiles_[i].device.unanswered() == 0) tiles_[i].device.submit({interface::Command::keep_alive, {}});
            tiles_[i].device.flush();
        } catch (const Interrupted&) {
            throw;
        } catch (const Error&) {
            // It will not answer either when it is asked next, and is lost then.
        }
    }
}

void PlayingTiles::exchange(std::span<std::optional<Status>> answers) {
    std::vector<std::string> trouble(tiles_.size());
    /// @return whether there was any tile that has not answered yet
    const auto with_the_silent = [&](const auto& work) {
        bool any = false;
        for (std::size_t i = 0; i < tiles_.size(); ++i) {
            if (is_lost(i) || answers[i] || !trouble[i].empty()) continue;
            any = true;
            try {
                work(tiles_[i].device, i);
            } catch (const Interrupted&) {
                throw;
            } catch (const Error& error) {
                trouble[i] = error.message();
            }
        }
        return any;
    };
    with_the_silent([&](Client& device, std::size_t i) {
        device.submit({interface::Command::status, {}},
                      [answers, i](const Reply& reply) { answers[i] = to_status(reply.data); });
        device.flush();
    });
    const auto pause = static_cast<unsigned>(std::max<std::size_t>(
        1, static_cast<std::size_t>(keep_alive_pause(settings_.watchdog_ms).count()) / tiles_.size()));
    // A tile has fallen silent that has said nothing for twice as long as its watchdog waits, or longer if its line is
    // known to be slow, as that of a simulated board is.
    unsigned slowness = 1;
    for (const Tile& tile : tiles_) slowness = std::max(slowness, tile.device.slowness());
    for (unsigned look = 1; look <= 2 * slowness * most_looks(settings_.watchdog_ms); ++look) {
        bool answered = false;  // anything, such as entries of a stream that were sent before
        const auto listen = [&answered](Client& device, std::size_t) {
            const std::uint64_t before = device.answers();
            device.exchange(1ms);
            answered |= device.answers() != before;
        };
        if (!with_the_silent(listen)) break;
        if (answered) look = 0;
        if (look % pause == 0)
            keep_alive(answers);  // while some are waited for, the others' watchdogs must be kept quiet
    }
    for (std::size_t i = 0; i < tiles_.size(); ++i) {
        if (is_lost(i) || answers[i]) continue;
        tiles_[i].device.drop();  // nobody may tell of answers to variables that are gone
        lose(i, trouble[i].empty() ? "it does not answer any more; check its cable and its power" : trouble[i]);
    }
}

void PlayingTiles::ask() {
    std::vector<std::optional<Status>> answers(tiles_.size());
    try {
        exchange(answers);
    } catch (...) {
        for (const Tile& tile : tiles_) tile.device.drop();
        throw;
    }
    for (std::size_t i = 0; i < tiles_.size(); ++i) {
        if (is_lost(i) || !answers[i]) continue;
        std::string why = unfit(*answers[i], before_[i], on_);
        if (why.empty() && !counts_[i].goes_on(answers[i]->period, tiles_[i].device.clock().now()))
            why = stands_still(*answers[i]->period);
        if (why.empty())
            statuses_[i] = answers[i];
        else
            lose(i, why);
    }
}

void PlayingTiles::wait(std::chrono::milliseconds pause) {
    for (std::size_t i = 0; i < tiles_.size(); ++i) {
        if (is_lost(i)) continue;
        try {
            return tiles_[i].device.exchange(pause);
        } catch (const Interrupted&) {
            throw;
        } catch (const Error& error) {
            lose(i, error.message());
        }
    }
}

std::uint64_t PlayingTiles::begin_together(const std::function<void(const Tile&, When)>& arm, std::uint64_t before,
                                           bool outputs_on) {
    for (unsigned attempt = 1; attempt <= most_attempts; ++attempt) {
        attempts_ = std::max(attempts_, attempt);
        ask();
        const std::uint64_t from = period();
        ask();
        const std::vector<std::optional<Status>> known = statuses_;
        lead_ = std::max(least_start_lead, lead_of_a_tile * tiles_.size() * (period() - from)) << (attempt - 1);
        const std::uint64_t wanted = std::max(before, period() + lead_);
        const auto too_late = [&] {
            ask();
            for (std::size_t i = 0; i < tiles_.size(); ++i)
                if (statuses_[i] && (statuses_[i]->late_changes != known[i]->late_changes || !statuses_[i]->waiting ||
                                     statuses_[i]->period.value_or(0) >= wanted))
                    return true;
            return false;
        };
        each([&](const Tile& tile) { arm(tile, When::at_period(wanted)); });
        bool late = too_late();
        if (!late && !outputs_on) {
            each([](const Tile& tile) { tile.device.enable(); });
            late = too_late();
        }
        if (!late) {
            on_ = true;
            if (begun_ == 0) begun_ = wanted;
            return wanted;
        }
        each([&](const Tile& tile) {
            if (!outputs_on) tile.device.disable();
            tile.device.stop();
        });
    }
    throw Error(ErrorCode::device, "rig",
                fmt::format("its tiles could not be told in time in which carrier period to begin, although the last "
                            "of {} was {} periods ahead; is a line, or this machine, very busy?",
                            most_attempts, lead_));
}

std::uint64_t PlayingTiles::period() const {
    std::uint64_t latest = 0;
    for (const auto& status : statuses_)
        if (status) latest = std::max(latest, status->period.value_or(0));
    return latest;
}

bool PlayingTiles::all(const std::function<bool(const Status&)>& judge) const {
    return std::ranges::all_of(statuses_, [&](const auto& status) { return !status || judge(*status); });
}

RigPlayed PlayingTiles::played() const {
    RigPlayed played{.period = begun_, .attempts = attempts_, .lost = lost_};
    for (std::size_t i = 0; i < tiles_.size(); ++i) {
        if (is_lost(i)) continue;
        const Played one = counted(before_[i], statuses_[i].value());
        played.underruns += one.underruns;
        played.refused_records += one.refused_records;
        played.watchdog_trips += one.watchdog_trips;
        played.guard_trips += one.guard_trips;
    }
    return played;
}

void prepare(std::span<const Tile> tiles) {
    if (tiles.empty()) throw bad_argument("rig", "it has no tiles; name at least one");
    require_images(tiles);
    keep_together(tiles);
}

void begin_modulation(const Tile& tile, When when) {
    if (const auto& modulation = tile.image.modulation)
        tile.device.modulate(modulation->divider, static_cast<std::uint16_t>(modulation->samples.size()), true, 0,
                             when);
    else if (tile.device.identity().modulation_words > 0)
        tile.device.modulate(0, 0, false);
}

}  // namespace haptogram::link
