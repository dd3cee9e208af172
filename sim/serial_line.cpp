// SPDX-License-Identifier: Apache-2.0
#include "serial_line.hpp"

#include <cmath>

namespace haptogram::sim {

bool SerialSender::level(std::uint64_t clock) {
    if (clock < next_change_) return level_;
    if (bit_ == idle_bit) {
        if (waiting_.empty()) return true;
        frame_ = (1U << 9) | (static_cast<unsigned>(waiting_.front()) << 1);
        waiting_.pop_front();
        // Back to back bytes keep the exact rate; after a pause a byte starts on this clock.
        started_ = static_cast<double>(clock) - started_ < 10.0 * clocks_per_bit_ + 1.0
                       ? started_ + 10.0 * clocks_per_bit_
                       : static_cast<double>(clock);
        bit_ = 0;
    }
    level_ = ((frame_ >> bit_) & 1U) != 0;
    ++bit_;
    next_change_ = static_cast<std::uint64_t>(std::ceil(started_ + bit_ * clocks_per_bit_));
    return level_;
}

void SerialSender::drop() {
    waiting_.clear();
    bit_ = idle_bit;
    level_ = true;
    next_change_ = 0;
}

std::optional<std::uint8_t> SerialReceiver::sample(std::uint64_t clock, bool level) {
    const bool falls = last_level_ && !level;
    last_level_ = level;
    if (bit_ < 0) {
        if (!falls) return {};
        bit_ = 0;
        started_ = static_cast<double>(clock);
        next_sample_ = clock + static_cast<std::uint64_t>(0.5 * clocks_per_bit_);
        return {};
    }
    if (clock < next_sample_) return {};
    const int bit = bit_++;
    next_sample_ = static_cast<std::uint64_t>(started_ + (bit_ + 0.5) * clocks_per_bit_);
    if (bit == 0) {
        if (level) bit_ = -1;
        return {};
    }
    if (bit <= 8) {
        shift_ = (shift_ >> 1) | (level ? 0x80U : 0U);
        return {};
    }
    bit_ = -1;
    if (!level) return {};  // no stop bit
    return static_cast<std::uint8_t>(shift_);
}

}  // namespace haptogram::sim
