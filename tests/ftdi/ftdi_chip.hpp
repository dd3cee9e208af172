// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "simulated_board.hpp"

namespace haptogram::test {

using Bytes = std::vector<std::uint8_t>;

/// What tells one type of chip from another, as its data sheet has it.
struct ChipType {
    unsigned product, release, interfaces, packet;
    unsigned megabits;  ///< of USB
};
constexpr ChipType ft2232h{0x6010, 0x0700, 2, 512, 480};
constexpr ChipType ft231x{0x6015, 0x1000, 1, 64, 12};

/// The head of a control transfer.
struct Setup {
    std::uint8_t type, request;
    std::uint16_t value, index, length;
};

/// An FTDI chip as it looks from USB, with a simulated board at the UART of its last interface. Written from the data
/// sheets and AN_120, not from the library that the host uses.
class FtdiChip {
public:
    FtdiChip(const ChipType& type, std::string serial, sim::SimulatedBoard* board = nullptr)
        : type_(type), serial_(std::move(serial)), board_(board) {}

    [[nodiscard]] const ChipType& type() const { return type_; }
    [[nodiscard]] Bytes descriptors() const;
    /// @return the answer, which is empty for what only sets something; nothing when the chip refuses the request
    [[nodiscard]] std::optional<Bytes> control(const Setup& setup);
    /// What the host sends to an end point.
    void put(std::uint8_t end_point, std::span<const std::uint8_t> bytes);
    /// What the UART's end point sends next: at most a transfer, at the latest when its latency timer has run out.
    [[nodiscard]] Bytes get(std::uint8_t end_point, std::size_t most);

    // What the host has set at the UART.
    [[nodiscard]] double baud() const;
    struct Settings {
        unsigned latency_ms = 16;
        std::uint16_t line = 0, flow = 0xffff, bit_mode = 0x0200;  ///< as a JTAG program leaves it
        unsigned flushes = 0;
        std::uint32_t divisor = 0;  ///< value, and above it what of index belongs to it
    } settings;

private:
    [[nodiscard]] Bytes text(std::uint8_t index) const;

    ChipType type_;
    std::string serial_;
    sim::SimulatedBoard* board_;
};

}  // namespace haptogram::test
