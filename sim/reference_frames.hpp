// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "clock.hpp"
#include "haptogram/format/interface.hpp"

namespace haptogram::sim {

/// A good frame that waits to be carried out.
struct Frame {
    std::vector<std::uint8_t> bytes;  ///< without the CRC
    Clock readable;                   ///< in which its first word can be taken
    std::uint64_t number;             ///< of the good frames since reset, from 1
    /// Words of the board's drive memory: its length, and its bytes in pairs.
    [[nodiscard]] std::uint64_t words() const { return 1 + (bytes.size() + 1) / 2; }
};

/// Bytes of the longest frame that a board always takes, without its CRC.
[[nodiscard]] std::uint32_t longest_frame(const interface::CoreParameters& p);

/// Takes frames out of bytes, as far as the board's drive memory has room. Only whole ones leave (rtl/README.md,
/// contract 5).
class FrameInput {
public:
    explicit FrameInput(const interface::CoreParameters& p);

    enum class Outcome { nothing, good, damaged };
    /// @param taken       words of frames that have been taken out of the memory before this clock, since reset
    Outcome byte(Clock clock, std::uint8_t byte, std::uint64_t taken);
    /// Whether the frame that has just ended has a right CRC and is this command, which acts before its turn, also when
    /// there was no room for it.
    [[nodiscard]] bool urgent(interface::Command command) const;
    /// Whether bytes of a frame have come whose end has not.
    [[nodiscard]] bool arriving() const { return arriving_; }
    void reset();

    std::deque<Frame> frames;

private:
    void data(std::uint8_t byte, std::uint64_t taken);
    void clear();

    std::uint64_t room_;       // words
    std::uint64_t start_ = 0;  // words that the good frames so far have taken
    std::uint64_t number_ = 0;
    std::vector<std::uint8_t> bytes_;
    bool full_ = false;  // no room for what came
    bool arriving_ = false;
    std::size_t count_ = 0;  // bytes, those without room, too
    std::array<std::uint8_t, 4> first_{};
    std::uint8_t left_ = 0;                     // of a COBS group
    bool zero_ = false;                         // follows the group
    std::optional<std::uint8_t> last_command_;  // of the frame that ended last, if it has nothing but a command
};

}  // namespace haptogram::sim
