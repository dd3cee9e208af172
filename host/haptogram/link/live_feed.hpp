// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "haptogram/link/commands.hpp"

namespace haptogram::link {

/// Feeds a device's live FIFO with indices, or with foci for its ring: several frames are under way at once, but never
/// more than the FIFO has room for, so that the device refuses none.
class LiveFeed {
public:
    /// @param foci_each  foci of a focus record, for push_foci()
    LiveFeed(Commands& device, const Identity& identity, std::size_t foci_each = 0);

    /// How many indices can be pushed now; no more than a frame holds.
    [[nodiscard]] std::size_t room() const;
    /// How many indices one frame carries; pushing pays when there is room for as many.
    [[nodiscard]] std::size_t frame() const { return frame_; }
    /// Pushes up to room() indices, each for `dwell` cycles, without waiting for the answer.
    void push(const std::vector<std::uint16_t>& indices, std::uint16_t dwell);
    /// The same with up to room() focus records, of four words a focus.
    void push_foci(std::span<const std::uint16_t> words, std::uint16_t dwell);
    /// Learns how far the FIFO has drained: waits for an answer that is under way, or else asks for the status. Either
    /// keeps the watchdog quiet.
    void refresh();
    /// The same from a status that was asked for behind all that was pushed.
    void learn(const Status& status) { fifo_->level = status.live_level; }
    /// Entries in the FIFO as the device said last, and those that are on their way to it.
    [[nodiscard]] std::size_t level() const { return fifo_->level + fifo_->under_way; }

private:
    struct Fifo {
        std::size_t level = 0;      // as the last answer said; since then the FIFO has only drained
        std::size_t under_way = 0;  // indices in frames that are not answered yet
    };

    void send(Request request, std::size_t count);

    Commands& device_;
    std::size_t foci_each_, depth_, frame_;
    std::shared_ptr<Fifo> fifo_ =
        std::make_shared<Fifo>();  // shared, because answers may come after this object is gone
};

}  // namespace haptogram::link
