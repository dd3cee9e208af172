// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/live_feed.hpp"

#include <algorithm>
#include <utility>

namespace haptogram::link {

// A frame fills a quarter of the FIFO: while two quarters play, one frame can be on the line and another be answered.
// No frame may carry more indices than there are channels, because a record is the longest that a device must take.
LiveFeed::LiveFeed(Commands& device, const Identity& identity)
    : device_(device), depth_(identity.live_depth), frame_(std::min(identity.live_depth / 4, identity.channels)) {
    refresh();
}

std::size_t LiveFeed::room() const { return std::min(frame_, depth_ - std::min(depth_, level())); }

void LiveFeed::push(const std::vector<std::uint16_t>& indices, std::uint16_t dwell) {
    Bytes payload = {static_cast<std::uint8_t>(dwell), static_cast<std::uint8_t>(dwell >> 8)};
    for (const std::uint16_t index : indices)
        for (const unsigned shift : {0U, 8U}) payload.push_back(static_cast<std::uint8_t>(index >> shift));
    fifo_->under_way += indices.size();
    device_.submit({interface::Command::push, std::move(payload)},
                   [fifo = fifo_, count = indices.size()](const Reply& reply) {
                       fifo->under_way -= count;
                       fifo->level = reply.live_level;
                   });
    device_.flush();
}

void LiveFeed::refresh() {
    if (device_.unanswered() > 0)
        device_.wait(device_.unanswered() - 1);
    else
        fifo_->level = device_.status().live_level;
}

}  // namespace haptogram::link
