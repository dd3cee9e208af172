// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "board.hpp"
#include "haptogram/format/image.hpp"
#include "haptogram/format/pulses.hpp"

namespace haptogram::sim {

/// A stretch of whole cycles of one record, as seen at the pins.
struct Dwell {
    std::uint16_t index;
    std::uint64_t begin;
    std::uint64_t end;
    std::uint32_t cycles;
};

/// The record that a pulse of a board with amplitudes belongs to: the one in which its middle lies, although it may
/// rise before that one begins. Times are of any one kind.
/// @param at_rise        the record at the pins when it rises
/// @param begun, record  the last one that began before it fell, and when
template <class Time>
[[nodiscard]] std::uint16_t record_of_pulse(Time rise, Time fall, std::uint16_t at_rise, Time begun,
                                            std::uint16_t record) {
    return record != 0 && begun > rise && begun - rise <= fall - begun ? record : at_rise;
}

/// Gathers pulses and dwells from a board's callbacks.
class PulseRecorder {
public:
    /// Takes over the board's edge and cycle callbacks; the board must not outlive the recorder.
    explicit PulseRecorder(Board& board);

    [[nodiscard]] const std::vector<Pulse>& pulses() const { return pulses_; }
    /// The pulses so far, which are forgotten, as are the cycles.
    [[nodiscard]] std::vector<Pulse> take();
    [[nodiscard]] const std::vector<CycleStart>& cycles() const { return cycles_; }
    /// Whole cycles only: the one still under way is left out.
    [[nodiscard]] std::vector<Dwell> dwells() const;

private:
    std::vector<Pulse> pulses_;
    std::vector<CycleStart> cycles_;
    std::vector<std::uint64_t> rise_;
    std::vector<std::uint16_t> rise_index_;
};

struct PulseReport {
    std::uint64_t checked = 0;       ///< pulses compared
    std::uint64_t violations = 0;    ///< pulses missing, unexpected, or at another clock
    std::vector<std::string> first;  ///< the first few, in words
};

/// Compares measured pulses with what the image says, exact to the clock: in every cycle from `begin` to `end`, each
/// channel whose timing lies within the cycle starts one pulse at its tick, of exactly the record's length (contracts 1
/// and 2). Of a record with amplitudes, the pulses are those that the host's models of the arithmetic give
/// (format/focus_engine.hpp, format/emission.hpp; contracts 8 and 9), and silence after it has none. Pulses that
/// overlap merge. The expectation is built from the image's numbers and the measured cycle starts alone.
/// @param modulation_start  clock of the cycle with the modulation's first sample; without, nothing is modulated
[[nodiscard]] PulseReport check_pulses(const Image& image, const std::vector<CycleStart>& cycles,
                                       const std::vector<Pulse>& pulses, std::uint64_t begin, std::uint64_t end,
                                       std::uint32_t channels, std::optional<std::uint64_t> modulation_start = {});

}  // namespace haptogram::sim
