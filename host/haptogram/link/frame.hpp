// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "haptogram/format/interface.hpp"

namespace haptogram::link {

using Bytes = std::vector<std::uint8_t>;

/// CRC-16/IBM-3740: polynomial 0x1021, start 0xFFFF, most significant bit first. The CRC of data that is followed by
/// its own CRC, high byte first, is 0.
[[nodiscard]] std::uint16_t crc16(std::span<const std::uint8_t> data);

/// Consistent-overhead byte stuffing (COBS), without the delimiter: the result holds no zero byte.
[[nodiscard]] Bytes cobs_encode(std::span<const std::uint8_t> data);
/// @return empty when the bytes are no COBS code
[[nodiscard]] std::optional<Bytes> cobs_decode(std::span<const std::uint8_t> code);

/// A request as it goes on the line, with its delimiter (rtl/INTERFACE.md).
[[nodiscard]] Bytes encode_request(std::uint8_t sequence, interface::Command command,
                                   std::span<const std::uint8_t> payload);

/// A reply, decoded and checked.
struct Reply {
    std::uint8_t sequence = 0;
    interface::Command command {};
    interface::Status status {};
    std::uint8_t expected = 0;     ///< the next sequence number that the device will apply
    std::uint16_t live_level = 0;  ///< entries in the live FIFO
    Bytes data;
};

/// Takes a stream of bytes apart into replies. Damaged ones are counted and dropped, as the device does with requests.
class ReplyDecoder {
public:
    void feed(std::span<const std::uint8_t> bytes, std::vector<Reply>& replies);
    [[nodiscard]] std::uint64_t damaged() const { return damaged_; }

private:
    Bytes frame_;
    std::uint64_t damaged_ = 0;
};

}  // namespace haptogram::link
