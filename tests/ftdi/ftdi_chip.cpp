// SPDX-License-Identifier: Apache-2.0
#include "ftdi_chip.hpp"

#include <algorithm>
#include <array>

namespace haptogram::test {
namespace {

void append(Bytes& bytes, std::initializer_list<unsigned> more) {
    for (const unsigned byte : more) bytes.push_back(static_cast<std::uint8_t>(byte));
}

// Each interface n has an end point 2n - 1 in and 2n out.
unsigned in_of(unsigned interface) { return 0x80 | (2 * interface - 1); }
unsigned out_of(unsigned interface) { return 2 * interface; }

}  // namespace

Bytes FtdiChip::descriptors() const {
    Bytes bytes;
    const unsigned packet_low = type_.packet & 0xffU;
    const unsigned packet_high = type_.packet >> 8U;
    append(bytes, {18, 1, 0, 2, 0, 0, 0, 64, 0x03, 0x04, type_.product & 0xffU, type_.product >> 8U,
                   type_.release & 0xffU, type_.release >> 8U, 1, 2, serial_.empty() ? 0U : 3U, 1});
    append(bytes, {9, 2, 9U + 23U * type_.interfaces, 0, type_.interfaces, 1, 0, 0x80, 250});
    for (unsigned i = 1; i <= type_.interfaces; ++i) {
        append(bytes, {9, 4, i - 1, 0, 2, 0xff, 0xff, 0xff, 2});
        for (const unsigned end_point : {in_of(i), out_of(i)})
            append(bytes, {7, 5, end_point, 2, packet_low, packet_high, 0});
    }
    return bytes;
}

Bytes FtdiChip::text(std::uint8_t index) const {
    const std::array<std::string, 4> texts = {"\x09\x04", "FTDI", "Emulated board", serial_};
    Bytes bytes{0, 3};
    for (const char letter : texts.at(index)) {
        bytes.push_back(static_cast<std::uint8_t>(letter));
        if (index != 0) bytes.push_back(0);
    }
    bytes[0] = static_cast<std::uint8_t>(bytes.size());
    return bytes;
}

std::optional<Bytes> FtdiChip::control(const Setup& setup) {
    enum : unsigned { reset = 0, modem = 1, flow = 2, baud_rate = 3, line = 4, latency = 9, bit_mode = 11 };
    if (setup.type == 0x80 && setup.request == 6 && setup.value >> 8 == 3)
        return text(static_cast<std::uint8_t>(setup.value));
    if (setup.type != 0x40) return std::nullopt;
    const unsigned interface = setup.index & 0xffU;
    if (interface != type_.interfaces && !(type_.interfaces == 1 && interface == 0)) return std::nullopt;
    switch (setup.request) {
        case reset: settings.flushes += setup.value != 0 ? 1 : 0; break;
        case flow: settings.flow = setup.index >> 8; break;
        case baud_rate:
            // A chip with several interfaces has their number in the low byte, the bits above those of value over it.
            settings.divisor =
                setup.value | static_cast<std::uint32_t>(type_.interfaces > 1 ? setup.index >> 8 : setup.index) << 16;
            break;
        case line: settings.line = setup.value; break;
        case latency: settings.latency_ms = setup.value; break;
        case bit_mode: settings.bit_mode = setup.value; break;
        case modem: break;
        default: return std::nullopt;
    }
    return Bytes{};
}

double FtdiChip::baud() const {
    // AN_120: 14 bits of whole, three that stand for an eighth each way, and one for the faster clock of the H types.
    constexpr std::array<double, 8> fractions = {0, 0.5, 0.25, 0.125, 0.375, 0.625, 0.75, 0.875};
    const double clock = (settings.divisor & 0x20000U) != 0 ? 12e6 : 3e6;
    const std::uint32_t divisor = settings.divisor & 0x1ffffU;
    if (divisor == 0) return clock;
    if (divisor == 1) return clock / 1.5;
    return clock / ((divisor & 0x3fffU) + fractions.at(divisor >> 14U));
}

void FtdiChip::put(std::uint8_t end_point, std::span<const std::uint8_t> bytes) {
    if (board_ != nullptr && end_point == out_of(type_.interfaces)) board_->send(bytes);
}

Bytes FtdiChip::get(std::uint8_t end_point, std::size_t most) {
    const bool connected = board_ != nullptr && end_point == in_of(type_.interfaces);
    Bytes received;
    if (connected) {
        const std::size_t room = most / type_.packet * (type_.packet - 2U);
        const std::uint64_t clocks = std::uint64_t{board_->parameters().clock_hz} / 1000 * settings.latency_ms;
        board_->run_until([&] { return board_->received() >= room; }, clocks);
        received = board_->receive();
    }
    Bytes packets;
    for (std::size_t at = 0; at == 0 || at < received.size(); at += type_.packet - 2U) {
        append(packets, {0x01, 0x60});  // of the modem and of the line: nothing lost, ready to send
        const auto from = received.begin() + static_cast<std::ptrdiff_t>(at);
        packets.insert(packets.end(), from, from + std::min<std::ptrdiff_t>(type_.packet - 2, received.end() - from));
    }
    return packets;
}

}  // namespace haptogram::test
