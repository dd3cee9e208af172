// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/frame.hpp"

#include <algorithm>
#include <boost/crc.hpp>
#include <cstddef>

namespace haptogram::link {
namespace {

constexpr std::size_t longest_run = 254;
constexpr std::size_t reply_header = 6;
constexpr std::size_t longest_reply = 1 << 13;  // a line that never sends a zero must not fill the memory

std::optional<Reply> decode_reply(std::span<const std::uint8_t> code) {
    const auto bytes = cobs_decode(code);
    if (!bytes || bytes->size() < reply_header + 2 || crc16(*bytes) != 0 || ((*bytes)[1] & 0x80U) == 0) return {};
    const Bytes& b = *bytes;
    return Reply{b[0], static_cast<interface::Command>(b[1] & 0x7fU), static_cast<interface::Status>(b[2]),
                 b[3], static_cast<std::uint16_t>(b[4] | b[5] << 8),  Bytes(b.begin() + reply_header, b.end() - 2)};
}

}  // namespace

std::uint16_t crc16(std::span<const std::uint8_t> data) {
    boost::crc_optimal<16, 0x1021, 0xffff> crc;  // a table's: a stream of patterns has 9 MB a second
    crc.process_bytes(data.data(), data.size());
    return crc.checksum();
}

Bytes cobs_encode(std::span<const std::uint8_t> data) {
    Bytes code;
    code.reserve(data.size() + data.size() / longest_run + 2);
    const auto end = data.end();
    for (auto at = data.begin();;) {
        const auto most = at + std::min<std::ptrdiff_t>(longest_run, end - at);
        const auto run = std::find(at, most, 0);
        code.push_back(static_cast<std::uint8_t>(run - at + 1));
        code.insert(code.end(), at, run);
        if (run == end) return code;
        at = run == most ? run : run + 1;  // a full run stands for no zero
        if (run != most && at == end) {
            code.push_back(1);
            return code;
        }
    }
}

std::optional<Bytes> cobs_decode(std::span<const std::uint8_t> code) {
    Bytes data;
    while (!code.empty()) {
        const std::size_t run = code.front();
        if (run == 0 || run > code.size()) return {};
        for (const std::uint8_t byte : code.subspan(1, run - 1)) {
            if (byte == 0) return {};
            data.push_back(byte);
        }
        code = code.subspan(run);
        if (run != longest_run + 1 && !code.empty()) data.push_back(0);
    }
    return data;
}

Bytes encode_request(std::uint8_t sequence, interface::Command command, std::span<const std::uint8_t> payload) {
    Bytes frame = {sequence, static_cast<std::uint8_t>(command)};
    frame.insert(frame.end(), payload.begin(), payload.end());
    const std::uint16_t crc = crc16(frame);
    frame.push_back(static_cast<std::uint8_t>(crc >> 8));
    frame.push_back(static_cast<std::uint8_t>(crc));
    Bytes code = cobs_encode(frame);
    code.push_back(0);
    return code;
}

void ReplyDecoder::feed(std::span<const std::uint8_t> bytes, std::vector<Reply>& replies) {
    for (const std::uint8_t byte : bytes) {
        if (byte != 0) {
            if (frame_.size() < longest_reply) frame_.push_back(byte);
            continue;
        }
        if (frame_.empty()) continue;
        if (auto reply = decode_reply(frame_))
            replies.push_back(std::move(*reply));
        else
            ++damaged_;
        frame_.clear();
    }
}

}  // namespace haptogram::link
