// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <functional>
#include <optional>

#include "haptogram/link/modulate.hpp"
#include "haptogram/link/outputs.hpp"

namespace haptogram::link {

/// What goes on while a device plays.
struct Playing {
    double seconds = 0.0;    ///< since the outputs came on; 0 while a trigger is waited for
    Status status;           ///< as the device said last
    std::uint64_t sent = 0;  ///< indices that went over the link
    std::uint16_t underruns = 0;
};

/// Told what goes on at least every keep_alive_pause(); false ends the playing in good order. That is no failure:
/// endless playing has no other end.
using Watch = std::function<bool(const Playing&)>;

struct PlaySettings {
    std::uint16_t index = 0;               ///< one record, until it is ended; 0: the sequence
    std::optional<std::uint16_t> loops{};  ///< passes over the sequence, 0 for ever; without: as the image says
    double rate = 0.0;                     ///< passes a second; 0: as the image says
    double seconds = 0.0;                  ///< not longer than this, from a trigger on; 0: no limit
    bool on_trigger = false;               ///< the sequence begins when the board's trigger input says so
    std::uint16_t watchdog_ms = 500;       ///< outputs go off when this host is silent for so long; 0: never
    Warning warn{};
    Am am{};  ///< by which all amplitudes are multiplied meanwhile
};

/// What became of it: how much the device's counters went up, and the indices that went over the link.
struct Played {
    std::uint64_t sent = 0;
    std::uint16_t underruns = 0, refused_records = 0, watchdog_trips = 0, guard_trips = 0;
    bool interrupted = false;  ///< the watch ended it
};

/// Turns the outputs on, plays what is in the device's memories until its end, and turns them off again. At a rate of
/// its own, and under a waveform that the device itself cannot play, the sequence goes through the live FIFO with other
/// dwells, and the memory stays as it is.
/// @throws what modulate.hpp says, for a waveform,
///         Error{device} when there is nothing to play, or the device turns its outputs off or does not confirm that
///         they are off in the end, Error{bad_argument} for a "rate" that no whole number of carrier cycles makes, and
///         for what goes over the link "on_trigger", which has effect on the memory's sequence alone
Played play(Commands& device, const PlaySettings& settings, const Watch& watch = {});

}  // namespace haptogram::link
