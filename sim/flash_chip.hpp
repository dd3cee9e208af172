// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <vector>

namespace haptogram::sim {

/// The flash at a core's pins (SPI, mode 0), for what a core asks of it: command 03h, an address of 24 bits, and bytes
/// from there on. What is not written reads as FFh. After the last address comes the first.
class FlashChip {
public:
    /// What the core's pins show after a clock's edge.
    struct Pins {
        bool select_n, clk, data;
    };

    /// What lies in it from an address on.
    void write(std::uint32_t address, const std::vector<std::uint8_t>& bytes) {
        first_ = address;
        bytes_ = bytes;
    }
    [[nodiscard]] bool data() const { return data_; }

    void clock(const Pins& pins) {
        if (pins.select_n) {
            bits_ = 0;
            command_ = 0;
            data_ = true;
        } else if (pins.clk && !clk_) {
            if (bits_ < 32) command_ = command_ << 1 | (pins.data ? 1U : 0U);
            ++bits_;
        } else if (!pins.clk && clk_ && bits_ >= 32) {
            constexpr std::uint32_t read = 3;
            const std::uint64_t place = bits_ - 32;
            data_ = command_ >> 24 != read || (byte((command_ + place / 8) & 0xff'ffffU) >> (7 - place % 8) & 1U) != 0;
        }
        clk_ = pins.clk;
    }

private:
    [[nodiscard]] std::uint8_t byte(std::uint64_t address) const {
        return address >= first_ && address - first_ < bytes_.size() ? bytes_[address - first_] : 0xff;
    }

    std::uint32_t first_ = 0;
    std::vector<std::uint8_t> bytes_;
    std::uint64_t bits_ = 0;  // that have come since the chip was selected
    std::uint32_t command_ = 0;
    bool clk_ = false, data_ = true;
};

}  // namespace haptogram::sim
