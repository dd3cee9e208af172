// SPDX-License-Identifier: Apache-2.0
#include "reference_frames.hpp"

#include <algorithm>
#include <bit>

#include "haptogram/link/frame.hpp"

namespace haptogram::sim {
namespace {

constexpr std::size_t crc_bytes = 2;
constexpr std::size_t shortest = 2 + crc_bytes;  // sequence number, command
constexpr std::size_t plain_command = 2 + crc_bytes;

}  // namespace

/// Sequence number and command, address, record; or a PUSH_FOCI with as many foci as bring the line to its rate.
std::uint32_t longest_frame(const interface::CoreParameters& p) {
    constexpr std::uint32_t write_head = 6, foci_frame = 4 + 8 * 60;
    return std::max(write_head + 2 * (p.channels + interface::record_header_words), p.foci != 0 ? foci_frame : 0);
}

/// Room for two of the longest frames, each with a word for its length.
FrameInput::FrameInput(const interface::CoreParameters& p)
    : room_(std::bit_ceil(2 * (std::uint64_t{longest_frame(p)} / 2 + 1))) {}

void FrameInput::clear() {
    bytes_.clear();
    full_ = arriving_ = false;
    count_ = 0;
    left_ = 0;
    zero_ = false;
}

void FrameInput::reset() {
    clear();
    frames.clear();
    start_ = 0;
    number_ = 0;
}

FrameInput::Outcome FrameInput::byte(Clock clock, std::uint8_t byte, std::uint64_t taken) {
    last_command_.reset();
    if (byte != 0) {
        arriving_ = true;
        const bool is_code = left_ == 0;
        const bool yields = !is_code || zero_;
        if (yields) {
            const std::uint8_t value = is_code ? 0 : byte;
            if (count_ < first_.size()) first_[count_] = value;
            ++count_;
            data(value, taken);
        }
        left_ = static_cast<std::uint8_t>((is_code ? byte : left_) - 1);
        if (is_code) zero_ = byte != 0xff;
        return Outcome::nothing;
    }
    const bool intact = left_ == 0;
    const bool whole = intact && !full_ && bytes_.size() >= shortest && link::crc16(bytes_) == 0;
    const bool empty = intact && count_ == 0;
    if (intact && count_ == plain_command && link::crc16(first_) == 0) last_command_ = first_[1];
    if (whole) {
        bytes_.resize(bytes_.size() - crc_bytes);
        frames.push_back({bytes_, clock + 2, ++number_});
        start_ += frames.back().words();
    }
    clear();
    return whole ? Outcome::good : empty ? Outcome::nothing : Outcome::damaged;
}

/// A pair of bytes takes a word, when its second one comes. The word before the first pair is kept for the length.
void FrameInput::data(std::uint8_t byte, std::uint64_t taken) {
    if (full_) return;
    bytes_.push_back(byte);
    if (bytes_.size() % 2 == 0) full_ = start_ + bytes_.size() / 2 - taken >= room_;
}

bool FrameInput::urgent(interface::Command command) const {
    return last_command_ == static_cast<std::uint8_t>(command);
}

}  // namespace haptogram::sim
