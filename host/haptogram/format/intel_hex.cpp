// SPDX-License-Identifier: Apache-2.0
#include "haptogram/format/intel_hex.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <span>

#include "haptogram/base/error.hpp"
#include "haptogram/base/text.hpp"

namespace haptogram::intel_hex {
namespace {

constexpr std::size_t bytes_per_record = 16;
enum class Type : std::uint8_t {
    data = 0,
    end = 1,
    extended_segment = 2,
    start_segment = 3,
    extended_linear = 4,
    start_linear = 5
};

void append_record(std::string& text, Type type, std::uint16_t offset, std::span<const std::uint8_t> bytes) {
    constexpr std::string_view digits = "0123456789ABCDEF";
    unsigned sum = 0;
    const auto put = [&](unsigned byte) {
        sum += byte;
        text += digits[byte >> 4 & 0xfU];
        text += digits[byte & 0xfU];
    };
    text += ':';
    put(static_cast<unsigned>(bytes.size()));
    put(offset >> 8U);
    put(offset & 0xffU);
    put(static_cast<unsigned>(type));
    for (const std::uint8_t byte : bytes) put(byte);
    put((0x100U - (sum & 0xffU)) & 0xffU);
    text += '\n';
}

int digit_value(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    return -1;
}

/// One line's bytes, from the length to the checksum, with all checks that need no other line.
std::vector<std::uint8_t> record_bytes(std::string_view line, const std::string& where) {
    if (line.front() != ':')
        throw bad_input(
            where, fmt::format("a record begins with ':', found {:?}; is this an Intel HEX file?", line.substr(0, 1)));
    const std::string_view digits = line.substr(1);
    const auto odd = std::find_if(digits.begin(), digits.end(), [](char c) { return digit_value(c) < 0; });
    if (odd != digits.end())
        throw bad_input(where, fmt::format("column {}: expected a hexadecimal digit, found {:?}",
                                           odd - digits.begin() + 2, std::string_view(&*odd, 1)));
    if (digits.size() % 2 != 0 || digits.size() < 10)
        throw bad_input(where, fmt::format("{} digits make no whole record; the line is cut short", digits.size()));
    std::vector<std::uint8_t> bytes(digits.size() / 2);
    for (std::size_t i = 0; i < bytes.size(); ++i)
        bytes[i] = static_cast<std::uint8_t>(digit_value(digits[2 * i]) * 16 + digit_value(digits[2 * i + 1]));
    if (bytes.size() != bytes[0] + 5U)
        throw bad_input(
            where, fmt::format("the record says {} data bytes and holds {}; the line is cut short or garbled", bytes[0],
                               static_cast<int>(bytes.size()) - 5));
    const unsigned sum = std::accumulate(bytes.begin(), bytes.end() - 1, 0U);
    const unsigned expected = (0x100U - (sum & 0xffU)) & 0xffU;
    if (bytes.back() != expected)
        throw bad_input(
            where, fmt::format("bad checksum: expected {:02X}, found {:02X}; the file is damaged, compile it again",
                               expected, bytes.back()));
    return bytes;
}

std::vector<Segment> join(std::map<std::uint32_t, Segment>& pieces) {
    std::vector<Segment> segments;
    for (auto& [address, piece] : pieces) {
        if (!segments.empty() && segments.back().address + segments.back().bytes.size() == address)
            segments.back().bytes.insert(segments.back().bytes.end(), piece.bytes.begin(), piece.bytes.end());
        else
            segments.push_back(std::move(piece));
    }
    return segments;
}

/// Adds a piece unless it overlaps one that is there.
void insert(std::map<std::uint32_t, Segment>& pieces, Segment piece, const std::string& where) {
    if (piece.bytes.empty()) return;
    const std::uint64_t end = std::uint64_t{piece.address} + piece.bytes.size();
    const auto next = pieces.lower_bound(piece.address);
    std::uint64_t twice = end;
    if (next != pieces.end() && next->first < end) twice = next->first;
    if (next != pieces.begin()) {
        const Segment& before = std::prev(next)->second;
        if (before.address + before.bytes.size() > piece.address) twice = piece.address;
    }
    if (twice != end || end > 0x1'0000'0000)
        throw bad_input(where, end > 0x1'0000'0000
                                   ? "the record runs over the end of the address space"
                                   : fmt::format("address {:08X} is written twice; records must not overlap", twice));
    pieces.emplace(piece.address, std::move(piece));
}

}  // namespace

std::string write(const std::vector<Segment>& segments) {
    std::string text;
    std::uint32_t upper = 0;
    for (const Segment& segment : segments) {
        for (std::size_t done = 0; done < segment.bytes.size();) {
            const std::uint32_t address = segment.address + static_cast<std::uint32_t>(done);
            if (address >> 16 != upper) {
                upper = address >> 16;
                const std::array<std::uint8_t, 2> high = {static_cast<std::uint8_t>(upper >> 8),
                                                          static_cast<std::uint8_t>(upper)};
                append_record(text, Type::extended_linear, 0, high);
            }
            const std::size_t to_boundary = 0x10000 - (address & 0xffffU);
            const std::size_t count = std::min({bytes_per_record, segment.bytes.size() - done, to_boundary});
            append_record(text, Type::data, static_cast<std::uint16_t>(address),
                          std::span(segment.bytes).subspan(done, count));
            done += count;
        }
    }
    append_record(text, Type::end, 0, {});
    return text;
}

std::vector<Segment> read(std::string_view text, const std::string& where) {
    text = without_byte_order_mark(text);
    std::map<std::uint32_t, Segment> pieces;
    std::uint32_t base = 0;
    bool ended = false;
    std::size_t number = 0;
    while (!text.empty()) {
        ++number;
        const std::size_t newline = text.find('\n');
        std::string_view line = text.substr(0, newline);
        text.remove_prefix(newline == std::string_view::npos ? text.size() : newline + 1);
        // Control-Z is old systems' end of a text.
        line = line.substr(0, line.find_last_not_of(ended ? " \t\r\x1a" : " \t\r") + 1);
        if (line.empty()) continue;
        const std::string here = fmt::format("{}:{}", where, number);
        if (ended) throw bad_input(here, "there is text after the end record; two files may have been joined");
        const std::vector<std::uint8_t> bytes = record_bytes(line, here);
        const std::size_t length = bytes[0];
        const auto offset = static_cast<std::uint32_t>(bytes[1] << 8 | bytes[2]);
        const auto value = length == 2 ? static_cast<std::uint32_t>(bytes[4] << 8 | bytes[5]) : 0U;
        const auto expect_length = [&](std::size_t expected) {
            if (length != expected)
                throw bad_input(here, fmt::format("a record of type {:02X} has {} data bytes, found {}", bytes[3],
                                                  expected, length));
        };
        switch (static_cast<Type>(bytes[3])) {
            case Type::data: insert(pieces, {base + offset, {bytes.begin() + 4, bytes.end() - 1}}, here); break;
            case Type::end:
                expect_length(0);
                ended = true;
                break;
            case Type::extended_segment:
                expect_length(2);
                base = value << 4;
                break;
            case Type::extended_linear:
                expect_length(2);
                base = value << 16;
                break;
            case Type::start_segment:
            case Type::start_linear:
                if (std::any_of(bytes.begin() + 4, bytes.end() - 1, [](std::uint8_t byte) { return byte != 0; }))
                    throw bad_input(here,
                                    "a start address has no meaning for an image; was this file made for a processor?");
                break;  // 0 is what linkers and objcopy write of themselves
            default:
                throw bad_input(here, fmt::format("unknown record type {:02X}; known are 00, 01, 02 and 04", bytes[3]));
        }
    }
    if (!ended)
        throw bad_input(where, number == 0 ? "the file is empty; expected Intel HEX records"
                                           : "no end record (:00000001FF) found; the file is cut short");
    return join(pieces);
}

}  // namespace haptogram::intel_hex
