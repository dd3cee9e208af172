// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/live_feed.hpp"

#include <algorithm>
#include <utility>

namespace haptogram::link {

// A quarter of the FIFO a frame, so that one can be on the line and one be answered while two are played; and a frame
// holds at most as many indices as a record has words.
LiveFeed::LiveFeed(Client& client, const Identity& board)
    : client_(client), depth_(board.live_depth), frame_(std::min(board.live_depth / 4, board.channels)) {
    refresh();
}

std::size_t LiveFeed::room() const { return std::min(frame_, depth_ - std::min(depth_, level())); }

void LiveFeed::push(const std::vector<std::uint16_t>& indices, std::uint16_t dwell) {
    Bytes payload = {static_cast<std::uint8_t>(dwell), static_cast<std::uint8_t>(dwell >> 8)};
    for (const std::uint16_t index : indices)
        for (const unsigned shift : {0U, 8U}) payload.push_back(static_cast<std::uint8_t>(index >> shift));
    fifo_->under_way += indices.size();
    client_.submit({interface::Command::push, std::move(payload)},
                   [fifo = fifo_, count = indices.size()](const Reply& reply) {
                       fifo->under_way -= count;
                       fifo->level = reply.live_level;
                   });
    client_.flush();
}

void LiveFeed::refresh() {
    if (client_.unanswered() > 0)
        client_.wait(client_.unanswered() - 1);
    else
        fifo_->level = client_.status().live_level;
}

}  // namespace haptogram::link
