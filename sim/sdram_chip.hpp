// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <random>
#include <span>
#include <stdexcept>
#include <vector>

namespace haptogram::sim {

/// The SDRAM at a core's pins, with a board's registers between them: rows, and words that are written and read. What a
/// chip forbids beside these, above all times, is looked at in tests/sdram.
class SdramChip {
public:
    /// What the core's pins show after a clock's edge.
    struct Pins {
        std::uint32_t command, bank, address, data;
        bool drive;
    };

    explicit SdramChip(std::uint32_t mib) : bank_bits_(mib == 8 ? 2 : 1), halves_(std::size_t{mib} << 19) {}

    /// As after power-up, when it holds anything.
    void scramble(std::uint32_t seed) {
        std::mt19937 random(seed);
        for (std::uint16_t& half : halves_) half = static_cast<std::uint16_t>(random());
    }

    /// The word at the core's pins before the clock's edge: that of the READ four edges ago.
    [[nodiscard]] std::uint32_t word() const { return coming_[0]; }

    /// @throws std::logic_error when a row is used that is not open, or is opened while another one is
    void clock(const Pins& pins) {
        coming_ = {coming_[1], coming_[2], coming_[3], 0xdead'beef};
        auto& open = open_[pins.bank];
        constexpr std::uint32_t all_banks = 1U << 10;
        switch (pins.command) {
            case activate:
                if (open) throw std::logic_error("the SDRAM is asked for a row beside an open one");
                open = true;
                row_[pins.bank] = pins.address;
                break;
            case precharge:
                if ((pins.address & all_banks) != 0)
                    open_ = {};
                else
                    open = false;
                break;
            case read:
            case write: {
                if (!open) throw std::logic_error("the SDRAM is asked for a word of a row that is not open");
                const std::size_t half =
                    2 * ((std::size_t{row_[pins.bank]} << bank_bits_ | pins.bank) << 8 | (pins.address & 0xffU));
                if (pins.command == read) {
                    coming_[3] = std::uint32_t{halves_[half + 1]} << 16 | halves_[half];
                } else {
                    if (!pins.drive) throw std::logic_error("a word is written to the SDRAM that nobody drives");
                    halves_[half] = static_cast<std::uint16_t>(pins.data);
                    halves_[half + 1] = static_cast<std::uint16_t>(pins.data >> 16);
                }
                break;
            }
            default: break;
        }
    }

    [[nodiscard]] std::span<std::uint16_t> halves() { return halves_; }

private:
    static constexpr std::uint32_t precharge = 2, activate = 3, write = 4, read = 5;  // RAS, CAS and WE, active low

    std::uint32_t bank_bits_;
    std::vector<std::uint16_t> halves_;  // of words, the lower one first
    std::array<bool, 4> open_{};
    std::array<std::uint32_t, 4> row_{};
    std::array<std::uint32_t, 4> coming_{};
};

}  // namespace haptogram::sim
