// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>

namespace haptogram::sim {

/// Bytes that wait in a network port, and which of them were sent before something happened (rtl/net/datagram_mark.v).
class PortBytes {
public:
    enum Event : std::size_t { off, stop, end };  ///< as the bits of i_net_old

    void add(std::span<const std::uint8_t> bytes) { bytes_.insert(bytes_.end(), bytes.begin(), bytes.end()); }
    /// All that waits now is old.
    void mark(Event event) { old_[event] = bytes_.size(); }
    void clear() {
        bytes_.clear();
        old_ = {};
    }
    [[nodiscard]] bool empty() const { return bytes_.empty(); }
    /// A bit for each event since which nothing new has come.
    [[nodiscard]] std::uint8_t old() const {
        return static_cast<std::uint8_t>((old_[off] != 0 ? 1 : 0) | (old_[stop] != 0 ? 2 : 0) |
                                         (old_[end] != 0 ? 4 : 0));
    }
    [[nodiscard]] std::uint8_t take() {
        const std::uint8_t byte = bytes_.front();
        bytes_.pop_front();
        for (std::size_t& left : old_) left -= left != 0 ? 1 : 0;
        return byte;
    }

private:
    std::deque<std::uint8_t> bytes_;
    std::array<std::size_t, 3> old_{};  // so many of the first ones
};

}  // namespace haptogram::sim
