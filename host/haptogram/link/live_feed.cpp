// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/live_feed.hpp"

#include <algorithm>
#include <utility>

namespace haptogram::link {

// A frame fills a quarter of the FIFO: while two quarters play, one frame can be on the line and another be answered.
// No frame may carry more indices than there are channels, because a record is the longest that a device must take.
// A frame of foci is as long as the device takes it, for they fill the line.
LiveFeed::LiveFeed(Commands& device, const Identity& identity, std::size_t foci_each)
    : device_(device),
      foci_each_(foci_each),
      depth_(identity.live_depth),
      frame_(std::min<std::size_t>(identity.live_depth / 4,
                                   foci_each == 0 ? identity.channels : (identity.frame_bytes - 4) / (8 * foci_each))) {
    refresh();
}

std::size_t LiveFeed::room() const { return std::min(frame_, depth_ - std::min(depth_, level())); }

void LiveFeed::push(const std::vector<std::uint16_t>& indices, std::uint16_t dwell) {
    send(push_request(indices, dwell), indices.size());
}

void LiveFeed::push_foci(std::span<const std::uint16_t> words, std::uint16_t dwell) {
    send(push_foci_request(words, dwell), words.size() / (4 * foci_each_));
}

void LiveFeed::send(Request request, std::size_t count) {
    fifo_->under_way += count;
    device_.submit(std::move(request), [fifo = fifo_, count](const Reply& reply) {
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
