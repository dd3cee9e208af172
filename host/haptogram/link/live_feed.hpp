// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "haptogram/link/client.hpp"

namespace haptogram::link {

/// Feeds a board's live FIFO through a client: several frames are under way at once, and never more indices than the
/// FIFO can take, so that the board refuses none.
class LiveFeed {
public:
    LiveFeed(Client& client, const Identity& board);

    /// How many indices can be pushed now; no more than a frame holds.
    [[nodiscard]] std::size_t room() const;
    /// A frame's worth: with so much room it pays to push.
    [[nodiscard]] std::size_t frame() const { return frame_; }
    /// Pushes up to room() indices, each for `dwell` cycles, without waiting for the answer.
    void push(const std::vector<std::uint16_t>& indices, std::uint16_t dwell);
    /// Learns how far the FIFO has drained: waits for an answer that is under way, or else asks. Each is a sign of
    /// life.
    void refresh();
    /// The FIFO's entries as the board said last, and those that are on their way to it.
    [[nodiscard]] std::size_t level() const { return fifo_->level + fifo_->under_way; }

private:
    struct Fifo {
        std::size_t level = 0;      // as the last answer had it; since then it has only drained
        std::size_t under_way = 0;  // indices in frames without an answer
    };

    Client& client_;
    std::size_t depth_, frame_;
    std::shared_ptr<Fifo> fifo_ = std::make_shared<Fifo>();  // answers may still come when this is gone
};

}  // namespace haptogram::link
