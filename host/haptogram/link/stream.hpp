// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string>

#include "haptogram/base/progress.hpp"
#include "haptogram/format/image.hpp"
#include "haptogram/link/modulate.hpp"
#include "haptogram/link/play.hpp"
#include "haptogram/link/source.hpp"

namespace haptogram::link {

struct StreamSettings {
    std::uint16_t watchdog_ms = 500;  ///< outputs go off when this host is silent for so long; 0: never
    Warning warn{};
    Am am{};  ///< by which all amplitudes are multiplied meanwhile
};

/// Turns the outputs on and plays entries through the live FIFO, no faster than the device takes them, until they end;
/// then off again.
/// @throws what modulate.hpp says, for a waveform that the device cannot play
Played stream(Commands& device, const StreamSettings& settings, StreamSource& source, const Watch& watch = {});
/// The same with foci, which go into the device's ring; each is a record of its own.
/// @throws Error{device} also as make_ring() does
Played stream(Commands& device, const StreamSettings& settings, FocusSource& source, const Watch& watch = {});

/// Writes an image's records, foci and modulation into a device, and streams its sequence, which may be longer than the
/// device's memory. The sequence in that memory is emptied, as its records are no longer there.
/// @param loops     passes; 0: until the watch ends it
/// @param where     names the image in messages
/// @param progress  of the writing
/// @throws Error{bad_input} when the records do not fit the device
Played stream(Commands& device, const StreamSettings& settings, Image image, std::uint64_t loops,
              const std::string& where, const Progress& progress = {}, const Watch& watch = {});

/// How many carrier cycles an entry must last for this many entries a second.
/// @throws Error{bad_argument} for a "rate" that no number of cycles from 1 to 65535 makes within 5 %
[[nodiscard]] std::uint16_t dwell_of(double rate, double carrier_hz);

}  // namespace haptogram::link
