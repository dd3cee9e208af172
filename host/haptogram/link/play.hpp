// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>

#include "haptogram/format/path.hpp"
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

/// How many entries the sequence in a device's memory has. @throws Error{device} when there is none
[[nodiscard]] std::uint16_t sequence_length(Commands& device);

/// What became of it: how much the device's counters went up, and the indices that went over the link.
struct Played {
    std::uint64_t sent = 0;
    std::uint16_t underruns = 0, refused_records = 0, watchdog_trips = 0, guard_trips = 0;
    bool interrupted = false;  ///< the watch ended it
};

/// How far the counters have gone on from one status to a later one.
[[nodiscard]] inline Played counted(const Status& before, const Status& now) {
    const auto since = [&](std::uint16_t Status::*counter) {
        return static_cast<std::uint16_t>(now.*counter - before.*counter);
    };
    return {.underruns = since(&Status::underruns),
            .refused_records = since(&Status::refused_records),
            .watchdog_trips = since(&Status::watchdog_trips),
            .guard_trips = since(&Status::guard_trips)};
}

/// Turns the outputs on, plays what is in the device's memories until its end, and turns them off again. At a rate of
/// its own, and under a waveform that the device itself cannot play, the sequence goes through the live FIFO with other
/// dwells, and the memory stays as it is.
/// @throws what modulate.hpp says, for a waveform,
///         Error{device} when there is nothing to play, or the device turns its outputs off or does not confirm that
///         they are off in the end, Error{bad_argument} for a "rate" that no whole number of carrier cycles makes, and
///         for what goes over the link "on_trigger", which has effect on the memory's sequence alone
Played play(Commands& device, const PlaySettings& settings, const Watch& watch = {});

/// What starts parts and is no pin.
class TriggerSource {
public:
    TriggerSource() = default;
    TriggerSource(const TriggerSource&) = delete;
    TriggerSource& operator=(const TriggerSource&) = delete;
    virtual ~TriggerSource() = default;

    /// The number of the part that is to start, after waiting for it at most so long.
    [[nodiscard]] virtual std::optional<std::size_t> next(std::chrono::milliseconds patience) = 0;
    /// Whether nothing more will come.
    [[nodiscard]] virtual bool ended() const = 0;
};

/// @param length  of the sequence
/// @throws Error{bad_argument} naming the "trigger" of a part that the sequence does not have, and a second one of the
/// pin; Error{device} for a device without the pin
void require_parts(std::span<const TriggeredPart> parts, std::size_t length, const Identity& identity);

/// That of the pin, if there is one.
[[nodiscard]] const TriggeredPart* part_of_pin(std::span<const TriggeredPart> parts);

/// Turns the outputs on, and plays nothing until a part is started, which ends what plays. It is over when the source
/// has ended, no pin is waited for and nothing plays, or after `seconds`. Of what starts at the pin while a part of it
/// was started less than 20 ms ago, nothing is played.
/// @param settings  of which index, loops, rate and on_trigger have no effect
/// @throws as require_parts(), and as play() does; Error{bad_argument} for a waveform that only the host could play
Played play(Commands& device, const PlaySettings& settings, std::span<const TriggeredPart> parts, TriggerSource& source,
            const Watch& watch = {});

}  // namespace haptogram::link
