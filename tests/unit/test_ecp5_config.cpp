// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <random>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "../refusal.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/format/ecp5_config.hpp"

using namespace haptogram;

namespace {

using Words = std::vector<std::uint32_t>;
using Rams = std::map<unsigned, Words>;  // rows by the number of the section

Words random_words(std::size_t count, unsigned width, unsigned seed) {
    std::mt19937 generator(seed);
    Words words(count);
    for (std::uint32_t& word : words) word = static_cast<std::uint32_t>(generator()) >> (32 - width);
    return words;
}

/// A configuration as nextpnr-ecp5 writes it.
std::string to_text(const Rams& rams) {
    std::string text = ".device LFE5U-25F\n\n.comment no .bram_init 9\n\n.tile CIB_R1C1:CIB\narc: A0 B0\n\n";
    for (const auto& [number, rows] : rams) {
        text += fmt::format(".bram_init {}\n", number);
        for (std::size_t row = 0; row < rows.size(); ++row)
            text += fmt::format("{:03x}{}", rows[row], row % 8 == 7 ? '\n' : ' ');
        text += '\n';
    }
    return text + ".tile_group MIB_R10C1:EBR0\nenum: EBR3.CEAMUX CEA\n";
}

Rams read_rams(const std::string& text) {
    Rams rams;
    std::istringstream stream(text);
    Words* rows = nullptr;
    for (std::string line; std::getline(stream, line);) {
        if (line.rfind(".bram_init ", 0) == 0) {
            rows = &rams[static_cast<unsigned>(std::stoul(line.substr(11)))];
        } else if (line.empty() || line[0] == '.') {
            rows = nullptr;
        } else if (rows != nullptr) {
            std::istringstream words(line);
            for (std::string word; words >> word;)
                rows->push_back(static_cast<std::uint32_t>(std::stoul(word, nullptr, 16)));
        }
    }
    return rams;
}

constexpr std::size_t deep_words = 2048 + 500;
constexpr std::size_t wide_words = 1024;
constexpr std::size_t widest_words = 300;

/// 9-bit mode: sections 7, 3 (words below 2048), 12 and 5; the lower nine bits of a word and the upper seven.
void put_deep(Rams& rams, const Words& memory) {
    const unsigned low[] = {7, 12}, high[] = {3, 5};
    for (std::size_t i = 0; i < memory.size(); ++i) {
        rams[low[i / 2048]][i % 2048] = memory[i] & 0x1ffU;
        rams[high[i / 2048]][i % 2048] = memory[i] >> 9;
    }
}

Words get_deep(const Rams& rams) {
    Words memory;
    for (std::size_t i = 0; i < 2048; ++i) memory.push_back(rams.at(7)[i] | rams.at(3)[i] << 9);
    for (std::size_t i = 0; i < 500; ++i) memory.push_back(rams.at(12)[i] | rams.at(5)[i] << 9);
    return memory;
}

/// 18-bit mode: section 8 has the lower eighteen bits of a word, section 6 the upper fourteen.
void put_wide(Rams& rams, const Words& memory) {
    for (std::size_t i = 0; i < memory.size(); ++i) {
        rams[8][2 * i] = memory[i] & 0x1ffU;
        rams[8][2 * i + 1] = memory[i] >> 9 & 0x1ffU;
        rams[6][2 * i] = memory[i] >> 18 & 0x1ffU;
        rams[6][2 * i + 1] = memory[i] >> 27;
    }
}

Words get_wide(const Rams& rams) {
    Words memory;
    for (std::size_t i = 0; i < 2048; i += 2)
        memory.push_back(rams.at(8)[i] | rams.at(8)[i + 1] << 9 | rams.at(6)[i] << 18 | rams.at(6)[i + 1] << 27);
    return memory;
}

/// 36-bit mode: section 10.
void put_widest(Rams& rams, const Words& memory) {
    for (std::size_t i = 0; i < memory.size(); ++i)
        for (unsigned row = 0; row < 4; ++row) rams[10][4 * i + row] = memory[i] >> 9 * row & 0x1ffU;
}

Words get_widest(const Rams& rams) {
    Words memory;
    for (std::size_t i = 0; i < 4 * widest_words; i += 4) {
        const Words& rows = rams.at(10);
        memory.push_back(rows[i] | rows[i + 1] << 9 | rows[i + 2] << 18 | rows[i + 3] << 27);
    }
    return memory;
}

/// All three, an empty block RAM (1), one of somebody else (4), and one that is all ones (11).
struct Example {
    Words deep = random_words(deep_words, 16, 1);
    Words wide = random_words(wide_words, 32, 2);
    Words widest = random_words(widest_words, 32, 3);
    Rams rams;
    std::string text;

    Example() {
        for (unsigned number = 1; number <= 12; ++number)
            if (number != 2 && number != 9) rams[number] = Words(2048);
        rams[4] = random_words(2048, 9, 4);
        rams[11] = Words(2048, 0x1ff);
        put_deep(rams, deep);
        put_wide(rams, wide);
        put_widest(rams, widest);
        text = to_text(rams);
    }
};

}  // namespace

TEST_CASE("ecp5 config: a memory in 9-bit mode gets other contents", "[ecp5]") {
    const Example example;
    const Words to = random_words(deep_words, 16, 10);
    const std::string text = replace_block_ram(example.text, example.deep, to, 16, "f");
    Rams rams = example.rams;
    put_deep(rams, to);
    REQUIRE(get_deep(read_rams(text)) == to);
    REQUIRE((text == to_text(rams)));  // and nothing else is other than it was
    REQUIRE((replace_block_ram(text, to, example.deep, 16, "f") == example.text));
}

TEST_CASE("ecp5 config: a memory in 18-bit mode gets other contents", "[ecp5]") {
    const Example example;
    const Words to = random_words(wide_words, 32, 11);
    const std::string text = replace_block_ram(example.text, example.wide, to, 32, "f");
    Rams rams = example.rams;
    put_wide(rams, to);
    REQUIRE(get_wide(read_rams(text)) == to);
    REQUIRE((text == to_text(rams)));
    REQUIRE((replace_block_ram(text, to, example.wide, 32, "f") == example.text));
}

TEST_CASE("ecp5 config: a memory in 36-bit mode gets other contents", "[ecp5]") {
    const Example example;
    const Words to = random_words(widest_words, 32, 12);
    const std::string text = replace_block_ram(example.text, example.widest, to, 32, "f");
    Rams rams = example.rams;
    put_widest(rams, to);
    REQUIRE(get_widest(read_rams(text)) == to);
    REQUIRE((text == to_text(rams)));
    REQUIRE((replace_block_ram(text, to, example.widest, 32, "f") == example.text));
}

TEST_CASE("ecp5 config: a memory in a mode narrower than 9 bits gets other contents", "[ecp5]") {
    // 8 / bits words a row; bits 0 to bits - 1 of a word in one section, the next bits in the next. Bit 8 is not used.
    const unsigned bits = GENERATE(4U, 2U, 1U);
    CAPTURE(bits);
    const std::size_t a_row = 8 / bits;
    const auto config = [&](const Words& memory) {
        Rams rams;
        for (unsigned part = 0; part < 16 / bits; ++part) {
            Words& rows = rams[part] = Words(2048);
            for (std::size_t i = 0; i < memory.size(); ++i)
                rows[i / a_row] |= (memory[i] >> bits * part & ((1U << bits) - 1U)) << bits * (i % a_row);
        }
        rams[20] = random_words(2048, 9, 20);
        return to_text(rams);
    };
    const std::size_t count = 2048 * a_row - 333;
    const Words from = random_words(count, 16, 21), to = random_words(count, 16, 22);
    REQUIRE((replace_block_ram(config(from), from, to, 16, "f") == config(to)));
}

TEST_CASE("ecp5 config: several memories one after the other, foreign block RAMs stay as they are", "[ecp5]") {
    const Example example;
    const Words deep(deep_words, 0);  // zeros may be written, though they are never found
    const Words wide = random_words(wide_words, 32, 13);
    std::string text = replace_block_ram(example.text, example.deep, deep, 16, "f");
    text = replace_block_ram(text, example.wide, wide, 32, "f");
    const Rams rams = read_rams(text);
    REQUIRE(get_deep(rams) == deep);
    REQUIRE(get_wide(rams) == wide);
    REQUIRE(get_widest(rams) == example.widest);
    for (const unsigned foreign : {1U, 4U, 11U}) REQUIRE(rams.at(foreign) == example.rams.at(foreign));
}

TEST_CASE("ecp5 config: bits above the width are ignored", "[ecp5]") {
    const Example example;
    const Words to = random_words(deep_words, 16, 14);
    Words from_more = example.deep, to_more = to;
    for (std::uint32_t& word : from_more) word |= 0xabcd0000U;
    for (std::uint32_t& word : to_more) word |= 0x12340000U;
    REQUIRE((replace_block_ram(example.text, from_more, to_more, 16, "f") ==
             replace_block_ram(example.text, example.deep, to, 16, "f")));
}

TEST_CASE("ecp5 config: a memory that is not there, or not all of it, or twice, is an error", "[ecp5]") {
    Example example;
    const Words to = random_words(deep_words, 16, 15);
    Words from = example.deep;
    std::string found = "32";
    SECTION("other contents") {
        from = to;
        found = "0";
    }
    SECTION("one bit differs") {
        from[2047] ^= 0x8000U;
        found = "31";
    }
    SECTION("one bit of a block RAM differs") {
        example.rams[12][499] ^= 1U;
        found = "31";
    }
    SECTION("the block RAM has something behind the memory's end") {
        example.rams[5][500] ^= 1U;
        found = "31";
    }
    SECTION("a block RAM is there twice") {
        example.rams[2] = example.rams[3];
        found = "25";
    }
    SECTION("two bits of the memory are the same") {
        for (std::size_t i = 0; i < 2048; ++i) from[i] = (from[i] & ~2U) | (from[i] & 1U) << 1;
        put_deep(example.rams, from);
        found = "30";
    }
    SECTION("nothing tells where a bit that is always zero is kept") {
        for (std::uint32_t& word : from) word &= ~0x10U;
        put_deep(example.rams, from);
        found = "30";
    }
    const std::string text = to_text(example.rams);
    try {
        static_cast<void>(replace_block_ram(text, from, to, 16, "placed.config"));
        FAIL("no error");
    } catch (const Error& error) {
        REQUIRE(error.code() == ErrorCode::failed);
        REQUIRE_REFUSAL(heard::Refusal(error));
        REQUIRE_REFUSAL(heard::Refusal(error));
    }
}

TEST_CASE("ecp5 config: a memory that fits in several modes or has nothing to look for is an error", "[ecp5]") {
    Rams rams{{1, Words(2048)}};
    rams[1][0] = 4;
    REQUIRE_REFUSED(replace_block_ram(to_text(rams), {1}, {1}, 1, "f"));
    REQUIRE_REFUSED(replace_block_ram(to_text(rams), {0}, {0}, 1, "f"));
    REQUIRE_REFUSED(replace_block_ram("", {1}, {0}, 1, "f"));
}

TEST_CASE("ecp5 config: a section of another form is an error that names it", "[ecp5]") {
    const Example example;
    const std::size_t begin = example.text.find("\n.bram_init 4\n") + 1;
    const std::size_t row = begin + std::string(".bram_init 4\n").size() + 44;  // the twelfth
    std::string text = example.text;
    SECTION("ten bits") { text.replace(row, 3, "200"); }
    SECTION("not hexadecimal") { text.replace(row, 3, "0g0"); }
    SECTION("two digits") { text.replace(row, 3, "00 "); }
    SECTION("another line length") { text[row + 3] = '\n'; }
    SECTION("a row less") { text.erase(row, 4); }
    SECTION("cut short") { text.resize(row); }
    SECTION("cut in its first line") { text.resize(begin + 12); }
    try {
        static_cast<void>(replace_block_ram(text, example.deep, example.deep, 16, "placed.config"));
        FAIL("no error");
    } catch (const Error& error) {
        REQUIRE(error.code() == ErrorCode::bad_input);
        REQUIRE_REFUSAL(heard::Refusal(error));
    }
}

TEST_CASE("ecp5 config: arguments that do not fit together are refused", "[ecp5]") {
    REQUIRE_THROWS_AS(replace_block_ram("", {1, 2}, {1}, 16, "f"), std::invalid_argument);
    REQUIRE_THROWS_AS(replace_block_ram("", {1}, {1}, 0, "f"), std::invalid_argument);
    REQUIRE_THROWS_AS(replace_block_ram("", {1}, {1}, 33, "f"), std::invalid_argument);
}
