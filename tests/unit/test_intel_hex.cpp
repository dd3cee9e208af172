// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>
#include <tuple>

#include "../refusal.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/format/image.hpp"
#include "haptogram/format/intel_hex.hpp"

using namespace haptogram;

TEST_CASE("intel hex: a known record, from the format's own specification", "[hex]") {
    // The example every description of the format gives.
    const auto segments = intel_hex::read(":0B0010006164647265737320676170A7\n:00000001FF\n", "f");
    REQUIRE(segments.size() == 1);
    REQUIRE(segments[0].address == 0x10);
    REQUIRE(std::string(segments[0].bytes.begin(), segments[0].bytes.end()) == "address gap");
    REQUIRE(intel_hex::write({segments[0]}) == ":0B0010006164647265737320676170A7\n:00000001FF\n");
}

TEST_CASE("intel hex: records never cross 64 KiB and segments come back joined", "[hex]") {
    std::vector<std::uint8_t> bytes(70'000);
    for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(i * 7);
    const std::string text = intel_hex::write({{0x1234FFF8, bytes}, {0x20000000, {1, 2, 3}}});
    REQUIRE_THAT(text, Catch::Contains(":020000041234B4\n:08FFF800"));
    const auto segments = intel_hex::read(text, "f");
    REQUIRE(segments.size() == 2);
    REQUIRE(segments[0].address == 0x1234FFF8);
    REQUIRE(segments[0].bytes == bytes);
    REQUIRE(segments[1].bytes == std::vector<std::uint8_t>{1, 2, 3});
}

TEST_CASE("intel hex: lower case, CR LF and extended segments are understood", "[hex]") {
    const auto segments = intel_hex::read(":020000021000ec\r\n:0100040055a6\r\n:00000001ff\r\n", "f");
    REQUIRE(segments.at(0).address == 0x10004);
    REQUIRE(segments.at(0).bytes == std::vector<std::uint8_t>{0x55});
}

TEST_CASE("intel hex: what other tools add and means nothing is stepped over", "[hex]") {
    for (const char* const text :
         {":0400000500000000F7\n:0100040055A6\n:00000001FF\n", ":0400000300000000F9\n:0100040055A6\n:00000001FF\n",
          ":0100040055A6  \n:00000001FF\t\r\n   \n", ":0100040055A6\n:00000001FF\n\x1a",
          "\xEF\xBB\xBF"
          ":0100040055A6\n:00000001FF\n"})
        CHECK(intel_hex::read(text, "f").at(0).bytes == std::vector<std::uint8_t>{0x55});
    CHECK_REFUSED(intel_hex::read("\x1a\n:0100040055A6\n:00000001FF\n", "f"));
}

TEST_CASE("intel hex: every kind of damage is an error that names the line", "[hex]") {
    const std::string text =
        GENERATE(as<std::string>{}, "", "hello\n", ":00000001FF\n:00000001FF\n", ":0100040055A7\n", ":0100040055A6\n",
                 ":0100040055\n", ":010004005\n", ":0100040G55A6\n", ":0100000001FE\n:0100000002FD\n:00000001FF\n",
                 ":0200000001 02FB\n", ":0400000500000001F6\n", ":00000006FA\n", ":0100000400FB\n",
                 ":02000004FFFFFC\n:02FFFF000102FD\n:00000001FF\n");
    CAPTURE(text);
    REQUIRE_REFUSED(intel_hex::read(text, "f"));
}

namespace {

Image small_image() {
    Image image;
    image.channels = 3;
    image.clock_hz = 50'000'000;
    image.records = {{250, 5, 125, {0, 249, 0xffff}}, {0x023456, 0x040102, 7, {1, 2, 3}}};
    image.sequence = {{1, 20}, {2, 65535}, {0, 1}};
    image.loops = 9;
    return image;
}

}  // namespace

TEST_CASE("image: what is written is read back", "[image]") {
    const Image image = small_image();
    const std::string text = to_intel_hex(image);
    REQUIRE(from_intel_hex(text, "f") == image);
    REQUIRE(text == to_intel_hex(image));
}

TEST_CASE("image: words lie where the address map says", "[image]") {
    const auto primary = primary_words(small_image());
    REQUIRE(primary == std::vector<std::uint16_t>{250, 125 << 8, 5, 0, 0, 249, 0xffff, 0x3456, 7 << 8 | 0x02, 0x0102,
                                                  0x04, 1, 2, 3});
    REQUIRE(sequence_words(small_image()) ==
            std::vector<std::uint32_t>{3 | 9 << 16, 1 | 20 << 16, 2 | 65535U << 16, 1 << 16});
}

TEST_CASE("image: readmemh text has a word a line", "[image]") {
    REQUIRE_THAT(primary_readmemh(small_image()), Catch::StartsWith("00fa\n7d00\n0005\n0000\n0000\n00f9\nffff\n"));
    REQUIRE(sequence_readmemh(small_image()) == "00090003\n00140001\nffff0002\n00010000\n");
}

TEST_CASE("image: regions that are missing, short, long or unknown are errors", "[image]") {
    const Image image = small_image();
    const auto whole = intel_hex::read(to_intel_hex(image), "f");
    REQUIRE(whole.size() == 3);
    for (std::size_t left_out = 0; left_out < 3; ++left_out) {
        auto segments = whole;
        segments.erase(segments.begin() + static_cast<std::ptrdiff_t>(left_out));
        REQUIRE_REFUSED(from_intel_hex(intel_hex::write(segments), "f"));
        segments = whole;
        segments[left_out].bytes.pop_back();
        REQUIRE_REFUSED(from_intel_hex(intel_hex::write(segments), "f"));
        segments[left_out].bytes.resize(segments[left_out].bytes.size() + 3);
        REQUIRE_REFUSED(from_intel_hex(intel_hex::write(segments), "f"));
    }
    auto extra = whole;
    extra.push_back({0x50000000, {1}});
    REQUIRE_REFUSED(from_intel_hex(intel_hex::write(extra), "f"));
    auto other = whole;
    other[2].bytes[0] ^= 1U;
    REQUIRE_REFUSED(from_intel_hex(intel_hex::write(other), "f"));
    auto header = whole;
    header[1].bytes[0] = 2;
    REQUIRE_REFUSED(from_intel_hex(intel_hex::write(header), "f"));
    for (const auto& [at, value] : {std::pair(10, 128), {10, 0}, {11, 24}}) {
        auto bits = whole;
        bits[2].bytes.at(at) = static_cast<std::uint8_t>(value);
        REQUIRE_REFUSED(from_intel_hex(intel_hex::write(bits), "f"));
    }
    auto reserved = whole;
    reserved[0].bytes[7] = 2;
    REQUIRE_REFUSED(from_intel_hex(intel_hex::write(reserved), "f"));
}

TEST_CASE("image: problems name the record or the entry", "[image]") {
    Image image = small_image();
    REQUIRE(problems(image).size() == 1);
    REQUIRE_SAID(problems(image)[0]);
    image.records[1].prescaler = 1;
    REQUIRE(problems(image).empty());
    image.records[0].pulse_length = 250 - 1;
    REQUIRE(problems(image).empty());
    image.records[0].cycle_length = 249;
    image.records[1].prescaler = 0;
    image.sequence[1].index = 3;
    image.sequence[2].dwell = 0;
    const auto found = problems(image);
    REQUIRE(found.size() == 4);
    REQUIRE_SAID(found[0]);
    REQUIRE_SAID(found[1]);
    REQUIRE_SAID(found[2]);
    REQUIRE_SAID(found[3]);
    image.sequence.clear();
    REQUIRE_SAID(problems(image).back());
}
