// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>

#include "haptogram/link/outputs.hpp"

namespace haptogram::link {

struct PatternSettings {
    bool foci = false;  ///< patterns are focus records, which the device computes, instead of records of amplitudes
    std::uint32_t slots =
        0;  ///< how many periods ahead the host can be, a power of two from 16 on; 0: as many as the device has
    std::uint16_t hold = 40;          ///< periods without a pattern through which the last pattern plays on
    std::uint16_t fade = 1024;        ///< then amplitudes lose so much a period, of 65,535
    std::uint16_t watchdog_ms = 500;  ///< outputs go off when this host is silent for so long; 0: never
};

/// The slots in a device for a pattern of each carrier period, and what is sent to them: "A stream of patterns" in
/// rtl/INTERFACE.md. They are its last records, whatever was in them; of foci, its ring.
class PatternStream {
public:
    /// @throws Error{device} when the device takes no streams, has not so many slots, or is stopped by its input; of
    ///         foci also as make_ring() does
    PatternStream(Commands& device, const PatternSettings& settings);

    /// Words of 16 bits of a pattern: of amplitudes phase and amplitude of each channel, of foci four a focus.
    [[nodiscard]] std::size_t words() const { return words_; }
    [[nodiscard]] std::uint32_t slots() const { return slots_; }
    /// Sends patterns for this carrier period and those after it. No answer says what became of them.
    /// @param patterns  whole ones
    void send(std::uint64_t period, std::span<const std::uint16_t> patterns);

private:
    [[nodiscard]] bool takes(std::uint32_t slots, const PatternSettings& settings);

    Commands& device_;
    std::size_t words_, most_;  // of a pattern; patterns of a frame
    std::uint32_t slots_ = 0;
};

inline constexpr double pattern_period_s = 1.0 / 40'000;

/// Asked for the patterns of the periods from `period` on, room for which is in `patterns`. How many it has filled in;
/// where they are fewer, the periods behind them come again. Nothing: there are no more.
using PatternSource =
    std::function<std::optional<std::size_t>(std::uint64_t period, std::span<std::uint16_t> patterns)>;

/// What became of the patterns that were sent, as the device counted.
struct PlayedPatterns {
    std::uint64_t sent = 0, late = 0, lost = 0, early = 0, repeated = 0;
    std::uint32_t lead = 0;    ///< carrier periods that the host was ahead last
    bool interrupted = false;  ///< the watch ended it
};
struct PatternsPlaying {
    Status status;
    PlayedPatterns played;  ///< until now
};

/// Turns the outputs on, plays a source's patterns, each in its own carrier period, until there are no more; then off
/// again. The lead over the device's clock grows while patterns come too late, and shrinks while they come too early.
/// @param watch  told some 200 times a second; false ends it
/// @throws as PatternStream; Error{device} when the device turns its outputs off by itself
PlayedPatterns play_patterns(Commands& device, const PatternSettings& settings, const PatternSource& source,
                             const std::function<bool(const PatternsPlaying&)>& watch = {});

}  // namespace haptogram::link
