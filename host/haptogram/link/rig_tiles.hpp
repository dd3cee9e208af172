// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "haptogram/link/rig.hpp"

namespace haptogram::link {

/// Does something with one tile; what it throws names the tile.
template <class Work>
auto with(const Tile& tile, const Work& work) {
    try {
        return work(tile.device);
    } catch (const LinkLost& lost) {
        throw LinkLost(tile.name, lost.message());
    } catch (const Interrupted&) {
        throw;
    } catch (const Error& error) {
        throw Error(error.code() == ErrorCode::bad_input ? ErrorCode::bad_input : ErrorCode::device, tile.name,
                    error.message());
    }
}

/// A device's count of carrier periods, which must go on: a rig waits for numbers of it.
class PeriodCount {
public:
    /// @return whether it has gone on lately
    bool goes_on(std::optional<std::uint64_t> period, Clock::Time now);

private:
    std::optional<std::uint64_t> last_;
    Clock::Time since_{};
};
[[nodiscard]] std::string stands_still(std::uint64_t period);

/// The tiles of a rig that plays. Who has them turned on calls off() in the end, by then_off().
class PlayingTiles {
public:
    PlayingTiles(std::span<const Tile> tiles, const RigSettings& settings);

    /// Shuts all tiles off, also those that are lost. Of these only a warning says that they have not confirmed it, if
    /// their watchdogs do it and the others were to go on. @return which have not confirmed it, in words
    std::string off();

    /// Calls `work` with each tile that is not lost, one after the other. A tile at which `work` fails is lost.
    void each(const std::function<void(const Tile&)>& work);
    /// Asks all for their status at the same time. A tile is lost that does not answer, or is not fit to play on.
    /// @throws Error{device} when a tile is lost and the others are not to go on, or when none is left
    void ask();
    /// Waits in the lines' own time, which need not be the machine's.
    void wait(std::chrono::milliseconds pause);
    /// Has all tiles begin something in one carrier period: `arm` is to do it behind a gate for that period. Should one
    /// tile hear of it too late, all stop, and a later period is tried.
    /// @param before     the first period that may be taken
    /// @param outputs_on whether the outputs are on already; if not, they are turned on once all tiles wait
    /// @return the period
    std::uint64_t begin_together(const std::function<void(const Tile&, When)>& arm, std::uint64_t before,
                                 bool outputs_on);

    [[nodiscard]] bool is_lost(std::size_t tile) const { return !statuses_[tile].has_value(); }
    [[nodiscard]] const std::vector<std::optional<Status>>& statuses() const { return statuses_; }
    /// The latest carrier period that any tile has told.
    [[nodiscard]] std::uint64_t period() const;
    /// How many periods ahead an agreed one must be, as the last exchange with all tiles showed.
    [[nodiscard]] std::uint64_t lead() const { return lead_; }
    /// Whether all that are left satisfy something.
    [[nodiscard]] bool all(const std::function<bool(const Status&)>& judge) const;
    /// What all tiles have counted since this began, and the tiles that were lost.
    [[nodiscard]] RigPlayed played() const;

private:
    void lose(std::size_t tile, const std::string& why);
    void exchange(std::span<std::optional<Status>> answers);
    void keep_alive(std::span<const std::optional<Status>> answered);

    std::span<const Tile> tiles_;
    const RigSettings& settings_;
    std::vector<std::optional<Status>> statuses_;
    std::vector<Status> before_;
    std::vector<PeriodCount> counts_;
    std::vector<std::string> lost_;
    bool on_ = false;
    std::uint64_t lead_ = 0, begun_ = 0;
    unsigned attempts_ = 0;
};

/// That there are tiles, that they hold their images, and that they are in step.
void prepare(std::span<const Tile> tiles);

/// What an image says of modulation.
void begin_modulation(const Tile& tile, When when);

/// Tells the watch what goes on, and remembers what it said.
class RigTeller {
public:
    RigTeller(const RigWatch& watch, const Clock& clock) : watch_(watch), clock_(clock) {}

    /// The seconds are counted from here on.
    void begin() { begun_ = clock_.now(); }
    void interrupt() { interrupted_ = true; }
    [[nodiscard]] double seconds() const { return clock_.seconds_since(begun_); }
    /// @return whether to go on
    bool operator()(const PlayingTiles& tiles) {
        if (watch_ && !watch_({seconds(), sent, tiles.statuses()})) interrupted_ = true;
        return !interrupted_;
    }
    [[nodiscard]] RigPlayed outcome(const PlayingTiles& tiles) const {
        RigPlayed played = tiles.played();
        played.sent = sent;
        played.interrupted = interrupted_;
        return played;
    }

    std::uint64_t sent = 0;  ///< entries that went over the lines

private:
    const RigWatch& watch_;
    const Clock& clock_;
    bool interrupted_ = false;
    Clock::Time begun_ = clock_.now();
};

}  // namespace haptogram::link
