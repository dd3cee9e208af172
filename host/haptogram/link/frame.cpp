// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/frame.hpp"

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
    unsigned crc = 0xffff;
    for (const std::uint8_t byte : data) {
        crc ^= static_cast<unsigned>(byte) << 8;
        for (int bit = 0; bit < 8; ++bit) crc = (crc & 0x8000U) != 0 ? crc << 1 ^ 0x1021U : crc << 1;
    }
    return static_cast<std::uint16_t>(crc);
}

Bytes cobs_encode(std::span<const std::uint8_t> data) {
    Bytes code(1);
    std::size_t code_at = 0;
    const auto close_run = [&] {
        code[code_at] = static_cast<std::uint8_t>(code.size() - code_at);
        code_at = code.size();
        code.push_back(0);
    };
    for (std::size_t i = 0; i < data.size(); ++i) {
        if (data[i] == 0) {
            close_run();
            continue;
        }
        code.push_back(data[i]);
        if (code.size() - code_at == longest_run + 1 && i + 1 < data.size()) close_run();
    }
    code[code_at] = static_cast<std::uint8_t>(code.size() - code_at);
    return code;
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
