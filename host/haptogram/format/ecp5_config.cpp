// SPDX-License-Identifier: Apache-2.0
#include "haptogram/format/ecp5_config.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bitset>
#include <charconv>
#include <cstddef>
#include <stdexcept>
#include <unordered_map>

#include "haptogram/base/error.hpp"

namespace haptogram {
namespace {

constexpr std::size_t rows = 2048;
constexpr unsigned columns = 9;
constexpr std::size_t rows_a_line = 8;
constexpr std::size_t digits = 3;
constexpr std::size_t row_size = digits + 1;  // with the space or the newline after it
constexpr std::string_view keyword = ".bram_init ";

using Bits = std::bitset<rows>;  // of a slice; a shorter one has zeros at the end

/// A block RAM of the configuration.
struct BlockRam {
    std::size_t text = 0;  ///< where its first row begins
    std::array<std::uint16_t, rows> words{};
    bool changed = false;
};

/// Rows phase, phase + stride, … of a column.
struct Place {
    std::size_t section = 0;
    std::size_t phase = 0;
    unsigned column = 0;
};

/// One bit of the words first, first + packed, … of the memory.
struct Slice {
    std::size_t first = 0;  ///< word
    unsigned bit = 0;
    bool has_twin = false;   ///< another slice looks the same
    std::size_t places = 0;  ///< where it was found
    Place place;             ///< the last of them
};

/// Where the memory is, if each of its words takes `stride` rows, or if a row holds `packed` words.
struct Layout {
    std::size_t stride = 1;
    std::size_t packed = 1;
    std::size_t wanted = 0;     ///< slices that must have a place
    std::vector<Slice> slices;  ///< those that have exactly one

    [[nodiscard]] bool complete() const { return wanted != 0 && slices.size() == wanted; }
};

BlockRam read_section(std::string_view config, std::size_t begin, const std::string& where) {
    BlockRam section;
    const std::size_t newline = config.find('\n', begin);
    bool good = newline != std::string_view::npos && config.size() - newline > rows * row_size;
    section.text = newline + 1;
    for (std::size_t row = 0; good && row < rows; ++row) {
        const char* const text = config.data() + section.text + row * row_size;
        std::uint16_t& word = section.words[row];
        const auto [end, error] = std::from_chars(text, text + digits, word, 16);
        good = error == std::errc() && end == text + digits && word < 1U << columns &&
               *end == ((row + 1) % rows_a_line == 0 ? '\n' : ' ');
    }
    if (!good)
        throw bad_input(where,
                        fmt::format("section '{}' must be {} lines of {} nine-bit words in {} hex digits each; "
                                    "run 'make bitstream' again",
                                    config.substr(begin, newline - begin), rows / rows_a_line, rows_a_line, digits));
    return section;
}

std::vector<BlockRam> read_sections(std::string_view config, const std::string& where) {
    std::vector<BlockRam> sections;
    for (std::size_t at = config.find(keyword); at != std::string_view::npos; at = config.find(keyword, at + 1))
        if (at == 0 || config[at - 1] == '\n') sections.push_back(read_section(config, at, where));
    return sections;
}

void write_section(const BlockRam& section, std::string& config) {
    char* text = config.data() + section.text;
    for (const std::uint16_t word : section.words) {
        for (std::size_t digit = 0; digit < digits; ++digit)
            text[digit] = "0123456789abcdef"[word >> 4 * (digits - 1 - digit) & 0xfU];
        text += row_size;
    }
}

Bits slice_of(const std::vector<std::uint32_t>& words, std::size_t first, const Layout& layout, unsigned bit) {
    Bits bits;
    for (std::size_t i = 0, word = first; i < rows / layout.stride && word < words.size(); ++i, word += layout.packed)
        bits[i] = (words[word] >> bit & 1U) != 0;
    return bits;
}

Bits read_place(const BlockRam& section, const Place& place, std::size_t stride) {
    Bits bits;
    for (std::size_t i = 0, row = place.phase; row < rows; ++i, row += stride)
        bits[i] = (section.words[row] >> place.column & 1U) != 0;
    return bits;
}

void write_place(BlockRam& section, const Place& place, std::size_t stride, const Bits& bits) {
    for (std::size_t i = 0, row = place.phase; row < rows; ++i, row += stride) {
        const unsigned others = section.words[row] & ~(1U << place.column);
        section.words[row] = static_cast<std::uint16_t>(others | static_cast<unsigned>(bits[i]) << place.column);
    }
    section.changed = true;
}

Layout find_memory(const std::vector<BlockRam>& sections, const std::vector<std::uint32_t>& from,
                   const std::vector<std::uint32_t>& to, unsigned width, Layout layout) {
    const std::size_t stride = layout.stride;
    const std::size_t block = rows / stride * layout.packed;  // words
    std::unordered_map<Bits, Slice> slices;
    for (std::size_t first = 0; first < from.size();
         first += first % block == layout.packed - 1 ? block - layout.packed + 1 : 1)
        for (unsigned bit = 0; bit < width; ++bit) {
            const Bits bits = slice_of(from, first, layout, bit);
            if (bits.any()) {
                const auto [entry, fresh] = slices.try_emplace(bits, Slice{first, bit, false, 0, {}});
                if (!fresh) entry->second.has_twin = true;
                ++layout.wanted;
            } else if (slice_of(to, first, layout, bit).any()) {
                ++layout.wanted;  // but it cannot be found: a slice of zeros looks like any empty column
            }
        }
    for (Place place; place.section < sections.size(); ++place.section)
        for (place.phase = 0; place.phase < stride; ++place.phase)
            for (place.column = 0; place.column < columns; ++place.column) {
                const auto entry = slices.find(read_place(sections[place.section], place, stride));
                if (entry == slices.end()) continue;
                ++entry->second.places;
                entry->second.place = place;
            }
    for (const auto& [bits, slice] : slices)
        if (slice.places == 1 && !slice.has_twin) layout.slices.push_back(slice);
    return layout;
}

}  // namespace

std::string replace_block_ram(std::string_view config, const std::vector<std::uint32_t>& from,
                              const std::vector<std::uint32_t>& to, unsigned width, const std::string& where) {
    if (width < 1 || width > 32 || from.size() != to.size())
        throw std::invalid_argument(
            fmt::format("replace_block_ram: {} words by {} of {} bits", from.size(), to.size(), width));
    std::vector<BlockRam> sections = read_sections(config, where);
    std::vector<Layout> layouts;
    for (const std::size_t stride : {1U, 2U, 4U})
        layouts.push_back(find_memory(sections, from, to, width, {stride, 1, 0, {}}));
    for (const std::size_t packed : {2U, 4U, 8U})
        layouts.push_back(find_memory(sections, from, to, width, {1, packed, 0, {}}));
    const auto complete = std::count_if(layouts.begin(), layouts.end(), [](const Layout& l) { return l.complete(); });
    const Layout& layout = *std::max_element(layouts.begin(), layouts.end(), [](const Layout& a, const Layout& b) {
        return a.complete() != b.complete() ? b.complete() : a.slices.size() < b.slices.size();
    });
    if (complete != 1)
        throw Error(ErrorCode::failed, where,
                    fmt::format("found {} of {} slices of the memory's initial contents exactly once{}, expected all "
                                "in one way; it was not built with these contents: run 'make bitstream' again",
                                layout.slices.size(), layout.wanted,
                                complete > 1 ? fmt::format(", but in {} ways", complete) : ""));
    for (const Slice& slice : layout.slices)
        write_place(sections[slice.place.section], slice.place, layout.stride,
                    slice_of(to, slice.first, layout, slice.bit));
    std::string result(config);
    for (const BlockRam& section : sections)
        if (section.changed) write_section(section, result);
    return result;
}

std::string replace_rx_delay(std::string config, unsigned from, unsigned to, const std::string& where) {
    constexpr std::string_view word = ".DELAY.DEL_VALUE ";
    constexpr std::size_t bits = 7, inputs = 5;
    const std::string old = std::bitset<bits>(from).to_string(), fresh = std::bitset<bits>(to).to_string();
    std::size_t found = 0;
    for (std::size_t at = 0; (at = config.find(word, at)) != std::string::npos;) {
        at += word.size();
        if (config.compare(at, bits, old) != 0) continue;
        config.replace(at, bits, fresh);
        ++found;
    }
    if (found != inputs)
        throw Error(ErrorCode::failed, where,
                    fmt::format("found {} inputs with a delay of {}, expected {}; it was not built with the rx_delay "
                                "of the board's file, or that is 0: run 'make bitstream' again",
                                found, from, inputs));
    return config;
}

}  // namespace haptogram
