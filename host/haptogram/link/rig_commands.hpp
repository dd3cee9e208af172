// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <memory>
#include <span>

#include "haptogram/link/commands.hpp"
#include "haptogram/link/rig.hpp"

namespace haptogram::link {

class PlayingTiles;

/// A rig's tiles as one device that has all their channels: what it is asked goes to all of them, and its answers are
/// those of the first, with the fullest of the FIFOs. Memory differs from tile to tile, and is written by their own
/// Commands.
///
/// What is pushed plays in the same carrier periods on all. The first push, one after an entry of dwell 0, and one
/// after a tile has run out of entries wait until all FIFOs are empty, and begin in a period that the tiles agree on.
/// Others follow without a gap, because an entry lasts as many periods on each.
class RigCommands final : public Commands {
public:
    /// Puts the tiles in step, which may reset them.
    /// @throws as keep_together(), and Error{device} naming a tile that is of another kind than the first
    RigCommands(std::span<const Tile> tiles, const RigSettings& settings);
    ~RigCommands() override;

    [[nodiscard]] const Identity& identity() const override { return identity_; }
    /// @throws Error{device} naming a tile that has turned its outputs off, or does not answer
    void submit(Request request, std::function<void(const Reply&)> done = {}) override;
    void tell(Request request) override;
    void flush() override;
    void wait(std::size_t most_unanswered = 0) override;
    [[nodiscard]] std::size_t unanswered() const override;
    void drop() override;
    [[nodiscard]] std::uint64_t retransmissions() const override;
    [[nodiscard]] Clock& clock() override { return tiles_.front().device.clock(); }
    bool turn_off() override;
    void keep_alive_every(std::chrono::milliseconds pause) override;
    /// How often all have begun together.
    [[nodiscard]] unsigned beginnings() const { return beginnings_; }

private:
    struct Heard;
    struct Asked;

    void begin(const Request& request);
    void require_on();

    std::span<const Tile> tiles_;
    RigSettings settings_;
    Identity identity_;
    std::unique_ptr<PlayingTiles> playing_;
    std::shared_ptr<Heard> heard_;  ///< shared, because answers may come after this object is gone
    Reply begun_;                   ///< of a tile, to the push with which all began
    std::uint64_t last_dwell_ = 0;  ///< of the last entry that was pushed
    unsigned beginnings_ = 0;
};

}  // namespace haptogram::link
