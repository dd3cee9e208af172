// SPDX-License-Identifier: Apache-2.0
#include <zlib.h>

#include "../refusal.hpp"
#include "bench.hpp"

using namespace haptogram;
using namespace haptogram::test;
using interface::Command;
using interface::Status;

namespace {

link::Reply one(Bench& bench, std::uint8_t sequence, Command command, const Bytes& payload) {
    const auto replies = bench.talk(link::encode_request(sequence, command, payload));
    REQUIRE(replies.size() == 1);
    REQUIRE(replies[0].sequence == sequence);
    REQUIRE(replies[0].command == command);
    return replies[0];
}

Bytes playable_record() {
    Bytes bytes;
    for (const std::uint16_t word : primary_words(image_of(16, {record(16, 100, 1, 30, 5)})))
        for (const unsigned shift : {0U, 8U}) bytes.push_back(static_cast<std::uint8_t>(word >> shift));
    return bytes;
}

std::uint16_t status_word(Bench& bench, std::uint8_t sequence, interface::StatusWord word) {
    const Bytes data = one(bench, sequence, Command::status, {}).data;
    return static_cast<std::uint16_t>(data.at(2 * static_cast<std::size_t>(word)) |
                                      data.at(2 * static_cast<std::size_t>(word) + 1) << 8);
}

}  // namespace

TEST_CASE("contract 5: a frame damaged in any single bit changes nothing, and the next good one is understood",
          "[contract5][long]") {
    Bench bench;
    one(bench, 0, Command::identify, {});
    one(bench, 1, Command::write, words({0, 0, 0x1111}));
    const Bytes good = link::encode_request(2, Command::write, words({0, 0, 0xabcd}));
    std::uint16_t damaged = 0;
    for (std::size_t bit = 0; bit < 8 * (good.size() - 1); ++bit) {  // the delimiter is the case after this one
        Bytes bad = good;
        bad[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
        CAPTURE(bit);
        REQUIRE(bench.talk(bad).empty());
        REQUIRE(bench.memory(interface::primary_base, 2) == words({0x1111}));
        ++damaged;
        if (bad[bit / 8] == 0)
            damaged = static_cast<std::uint16_t>(damaged + (bit / 8 > 0 && bit / 8 + 2 < good.size() ? 1 : 0));
    }
    const auto counted = status_word(bench, 2, interface::StatusWord::frames_damaged);
    REQUIRE(counted >= 8 * (good.size() - 1));
    REQUIRE(counted <= damaged);
    REQUIRE(one(bench, 3, Command::write, words({0, 0, 0xabcd})).status == Status::ok);
    REQUIRE(bench.memory(interface::primary_base, 2) == words({0xabcd}));
}

TEST_CASE("contract 5: frames cut short, run together, or preceded by noise", "[contract5]") {
    Bench bench;
    one(bench, 0, Command::identify, {});
    const Bytes good = link::encode_request(1, Command::write, words({0, 0, 0xabcd}));
    for (std::size_t length = 1; length + 1 < good.size(); ++length) {
        Bytes cut(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(length));
        cut.push_back(0);
        REQUIRE(bench.talk(cut).empty());
    }
    Bytes joined(good.begin(), good.end() - 1);  // its delimiter was lost
    const Bytes again = link::encode_request(1, Command::stop, {});
    joined.insert(joined.end(), again.begin(), again.end());
    REQUIRE(bench.talk(joined).empty());
    REQUIRE(bench.memory(interface::primary_base, 2) == words({0}));
    Bytes noisy = {0x55, 0xaa, 0x00, 0x00};
    noisy.insert(noisy.end(), good.begin(), good.end());
    const auto replies = bench.talk(noisy);
    REQUIRE(replies.size() == 1);
    REQUIRE(replies[0].status == Status::ok);
    REQUIRE(bench.memory(interface::primary_base, 2) == words({0xabcd}));
}

TEST_CASE("contract 5: what is refused says why and changes nothing", "[contract5][slow]") {
    Bench bench;  // 16 channels, 40 records of 20 words, 64 sequence words
    one(bench, 0, Command::identify, {});
    const std::uint16_t primary_end = 40 * 20 * 2;
    const auto [command, payload, status] = GENERATE_COPY(table<int, Bytes, Status>({
        {0x7f, {}, Status::unknown_command},
        {0x00, {}, Status::unknown_command},
        {static_cast<int>(Command::enable), {0, 0}, Status::bad_length},
        {static_cast<int>(Command::select), words({1}), Status::bad_length},
        {static_cast<int>(Command::select), words({1, 1, 1}), Status::bad_length},
        {static_cast<int>(Command::select), {1, 0, 1}, Status::bad_length},
        {static_cast<int>(Command::write), words({0, 0}), Status::bad_length},
        {static_cast<int>(Command::write), {0, 0, 0, 0, 7}, Status::bad_length},
        {static_cast<int>(Command::read), words({0, 0, 0}), Status::bad_length},
        {static_cast<int>(Command::read), words({0, 0, 42}), Status::bad_length},  // more than a record
        {static_cast<int>(Command::write), words({primary_end, 0, 7}), Status::bad_address},
        {static_cast<int>(Command::write), words({static_cast<std::uint16_t>(primary_end - 2), 0, 7, 7}),
         Status::bad_address},
        {static_cast<int>(Command::write), words({0, 0x0fff, 7}), Status::bad_address},
        {static_cast<int>(Command::write), words({256, 0x1000, 7, 7}), Status::bad_address},
        {static_cast<int>(Command::write), words({0, 0x2000, 7}), Status::bad_address},  // identity cannot be written
        {static_cast<int>(Command::write), words({0, 0x3000, 7}), Status::bad_address},
        {static_cast<int>(Command::write), words({0, 0x4000, 7}), Status::bad_address},
        {static_cast<int>(Command::read), words({2 * interface::identity_words, 0x2000, 2}), Status::bad_address},
        {static_cast<int>(Command::write), words({1, 0, 7}), Status::bad_alignment},
        {static_cast<int>(Command::write), words({2, 0x1000, 7, 7}), Status::bad_alignment},
        {static_cast<int>(Command::write), words({0, 0x1000, 7}), Status::bad_alignment},
        {static_cast<int>(Command::read), words({0, 0, 3}), Status::bad_alignment},
        {static_cast<int>(Command::digest), words({0, 0, 0}), Status::bad_length},
        {static_cast<int>(Command::digest), words({0, 0, 42}), Status::bad_length},
        {static_cast<int>(Command::digest), words({0, 0, 3}), Status::bad_alignment},
        {static_cast<int>(Command::digest), words({primary_end, 0, 2}), Status::bad_address},
        {static_cast<int>(Command::select), words({41, 0}), Status::bad_index},
        {static_cast<int>(Command::push), words({1, 1, 41, 1}), Status::bad_index},
        {static_cast<int>(Command::start), words({0, 1, 1}), Status::bad_range},
        {static_cast<int>(Command::start), words({1, 64, 1}), Status::bad_range},
        {static_cast<int>(Command::start), words({63, 2, 1}), Status::bad_range},
        {static_cast<int>(Command::start), words({0xffff, 0xffff, 1}), Status::bad_range},
        {static_cast<int>(Command::push), words({1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1}),
         Status::fifo_full},
    }));
    CAPTURE(command, payload, to_string(status));
    const auto reply = one(bench, 1, static_cast<Command>(command), payload);
    REQUIRE(reply.status == status);
    REQUIRE(reply.expected == 1);  // the sequence number is still to be used
    REQUIRE(reply.live_level == 0);
    REQUIRE(reply.data.empty());
    bench.board.run(20'000);
    REQUIRE(bench.board.outputs().index == 0);
    REQUIRE_FALSE(bench.board.outputs().enabled);
    REQUIRE(bench.memory(interface::primary_base, 1600) == Bytes(1600, 0));
    REQUIRE(bench.memory(interface::sequence_base, 256) == Bytes(256, 0));
    REQUIRE(one(bench, 1, Command::stop, {}).status == Status::ok);
}

TEST_CASE("contract 5: a frame sent again is acknowledged and not applied again", "[contract5]") {
    Bench bench;
    one(bench, 250, Command::identify, {});
    REQUIRE(one(bench, 251, Command::write, words({0, 0, 1})).expected == 252);
    REQUIRE(one(bench, 252, Command::push, words({100, 1, 2, 3})).live_level >= 1);
    const auto level = one(bench, 253, Command::status, {}).live_level;
    REQUIRE(one(bench, 252, Command::push, words({100, 1, 2, 3})).status == Status::repeated);
    REQUIRE(one(bench, 251, Command::write, words({0, 0, 9})).status == Status::repeated);
    REQUIRE(one(bench, 254, Command::stop, {}).status == Status::ok);
    REQUIRE(one(bench, 255, Command::push, words({100, 1, 2, 3})).status == Status::ok);
    const auto read_first = one(bench, 0, Command::status, {});
    REQUIRE(read_first.live_level == level);  // the number wraps around
    const auto read_again = one(bench, 0, Command::status, {});
    REQUIRE(read_again.status == Status::repeated);
    REQUIRE(read_again.data.size() == read_first.data.size());  // reading again does no harm
    REQUIRE(!read_again.data.empty());
    REQUIRE(status_word(bench, 1, interface::StatusWord::frames_repeated) == 3);
    REQUIRE(bench.memory(interface::primary_base, 2) == words({1}));
}

TEST_CASE("contract 5: a late copy of IDENTIFY is answered and begins nothing", "[contract5]") {
    Bench bench;
    const Bytes identity = one(bench, 7, Command::identify, {}).data;
    one(bench, 8, Command::write, words({0, 0, 1}));
    one(bench, 9, Command::gate, words({100, 0, 0}));
    const auto copy = [&](std::uint8_t expected) {
        const auto reply = one(bench, 7, Command::identify, {});
        REQUIRE(reply.status == Status::repeated);
        REQUIRE(reply.expected == expected);
        REQUIRE(reply.data == identity);
    };
    copy(10);
    REQUIRE(one(bench, 9, Command::write, words({0, 0, 9})).status == Status::repeated);
    std::uint8_t number = 10;
    for (int i = 0; i < 280; ++i, ++number) {  // its number comes again
        REQUIRE(one(bench, number, Command::keep_alive, {}).status == Status::ok);
        if (i % 9 == 0 || static_cast<std::uint8_t>(number + 1) == 7) copy(static_cast<std::uint8_t>(number + 1));
    }
    REQUIRE(one(bench, 6, Command::identify, {}).expected == 7);
    const auto in_order = one(bench, 7, Command::identify, {});
    REQUIRE((in_order.status == Status::ok && in_order.expected == 8));
}

TEST_CASE("contract 5: after a reset nothing is acknowledged before the host identifies", "[contract5]") {
    const std::uint8_t number = GENERATE(std::uint8_t{5}, std::uint8_t{0}, std::uint8_t{200});
    Bench bench;
    one(bench, static_cast<std::uint8_t>(number - 1), Command::identify, {});
    REQUIRE(one(bench, number, Command::stop, {}).status == Status::ok);
    bench.board.reset();
    for (const Command command : {Command::stop, Command::disable, Command::enable, Command::status})
        REQUIRE(one(bench, static_cast<std::uint8_t>(number + 1), command, {}).status == Status::out_of_order);
    if (number != 0) return;  // a client gives up only after many tries
    link::Client client(bench.line);
    client.identify();
    REQUIRE_NOTHROW(client.disable());
    bench.board.reset();
    REQUIRE_REFUSED(client.disable());
}

TEST_CASE("contract 5: a frame ahead of a lost one is refused and says what is expected", "[contract5]") {
    Bench bench;
    one(bench, 10, Command::identify, {});
    const auto reply = one(bench, 13, Command::write, words({0, 0, 5}));
    REQUIRE(reply.status == Status::out_of_order);
    REQUIRE(reply.expected == 11);
    REQUIRE(bench.memory(interface::primary_base, 2) == words({0}));
    REQUIRE(one(bench, 11, Command::write, words({0, 0, 5})).status == Status::ok);
    REQUIRE(status_word(bench, 12, interface::StatusWord::frames_refused) == 1);
}

TEST_CASE("contract 5: written memory reads back, also while it plays", "[contract5]") {
    auto g = generator();
    Bench bench;
    bench.open();
    std::vector<Bytes> contents;
    for (std::uint32_t r = 0; r < 40; ++r) {
        Image image = image_of(16, {random_record(g, 16, 100, 1, 30)});
        Bytes bytes;
        for (const std::uint16_t word : primary_words(image)) {
            bytes.push_back(static_cast<std::uint8_t>(word));
            bytes.push_back(static_cast<std::uint8_t>(word >> 8));
        }
        bench.client.write(interface::primary_base + r * 40, bytes);
        contents.push_back(bytes);
    }
    bench.client.write(interface::sequence_base + 4, {1, 0, 1, 0, 2, 0, 1, 0});
    bench.client.start(1, 2, 0);
    bench.wait_for_index(2);
    for (std::uint32_t r = 0; r < 40; ++r)
        REQUIRE(bench.client.read(interface::primary_base + r * 40, 40) == contents[r]);
    REQUIRE(bench.client.read(interface::sequence_base + 4, 8) == Bytes{1, 0, 1, 0, 2, 0, 1, 0});
    REQUIRE(bench.client.status().underruns == 0);
}

TEST_CASE("contract 5: a digest is zlib's CRC-32 of what is there, also while it plays", "[contract5]") {
    auto g = generator();
    Bench bench;
    bench.open();
    Bytes bytes(40);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(g());
    bench.client.write(interface::primary_base + 3 * 40, bytes);
    bench.client.write(interface::primary_base, playable_record());
    bench.client.write(interface::sequence_base + 4, {1, 0, 2, 0});
    bench.client.start(1, 1, 0);
    bench.wait_for_index(1);
    const auto digest = [&](std::uint32_t address, std::uint16_t length) {
        Bytes payload;
        for (const unsigned shift : {0U, 8U, 16U, 24U}) payload.push_back(static_cast<std::uint8_t>(address >> shift));
        for (const unsigned shift : {0U, 8U}) payload.push_back(static_cast<std::uint8_t>(length >> shift));
        const Bytes data = bench.client.request({Command::digest, payload}).data;
        REQUIRE(data.size() == 4);
        return data[0] | data[1] << 8 | data[2] << 16 | static_cast<std::uint32_t>(data[3]) << 24;
    };
    for (const std::uint16_t length : std::initializer_list<std::uint16_t>{2, 4, 38, 40}) {
        CAPTURE(length);
        REQUIRE(digest(interface::primary_base + 3 * 40, length) == ::crc32(0, bytes.data(), length));
    }
    REQUIRE(digest(interface::sequence_base + 4, 4) == ::crc32(0, Bytes{1, 0, 2, 0}.data(), 4));
    REQUIRE(bench.client.status().underruns == 0);
}

TEST_CASE("contract 5: an upload writes what differs, and says when the board does not keep it", "[contract5]") {
    auto g = generator();
    Bench bench;
    std::vector<Record> records;
    for (int i = 0; i < 12; ++i) records.push_back(random_record(g, 16, 100, 1, 30));
    Image image = image_of(16, records);
    bench.client.identify();
    const auto first = link::upload(bench.client, image);
    REQUIRE(first.pieces == 14);  // 13 sequence words go ten to a frame
    REQUIRE(first.written == 14);
    REQUIRE(link::compare(bench.client, image).empty());
    REQUIRE(link::upload(bench.client, image).written == 0);
    image.records[5].timings[7] ^= 1U;
    REQUIRE_FALSE(link::compare(bench.client, image).empty());
    REQUIRE(link::upload(bench.client, image).written == 1);
    REQUIRE(link::compare(bench.client, image).empty());
    const Image back = link::download(bench.client, bench.client.identify(), 0, "board");
    REQUIRE(back == [&] {
        Image expected = image;
        expected.timing_bits = bench.board.parameters().timing_bits;
        expected.pulse_bits = bench.board.parameters().pulse_bits;
        return expected;
    }());
}

TEST_CASE("contract 5: identify names the instrument", "[contract5]") {
    Bench bench;
    const link::Identity identity = bench.client.identify();
    const auto& p = bench.board.parameters();
    REQUIRE(identity.name == "Haptogram");
    REQUIRE(identity.version_major == interface::version_major);
    REQUIRE(identity.channels == p.channels);
    REQUIRE(identity.records == p.records);
    REQUIRE(identity.sequence_depth == p.sequence_depth);
    REQUIRE(identity.live_depth == p.live_depth);
    REQUIRE(identity.timing_bits == p.timing_bits);
    REQUIRE(identity.pulse_bits == p.pulse_bits);
    REQUIRE(identity.clock_hz == p.clock_hz);
    REQUIRE(identity.features == 0x90f);
    REQUIRE(identity.frame_bytes == 6 + 2 * (p.channels + 4));
}

TEST_CASE("contract 5: random bytes break nothing", "[contract5][fuzz][long]") {
    auto g = generator();
    Bench bench;
    bench.open();
    const Image image = image_of(16, {record(16, 250, 1, 100, 9)});
    bench.load(image);
    bench.client.select(1);
    bench.wait_for_index(1);
    const std::uint64_t begin = bench.board.now();
    for (int burst = 0; burst < 40; ++burst) {
        Bytes noise(500);
        for (auto& byte : noise) byte = static_cast<std::uint8_t>(g() % (burst % 2 == 0 ? 256 : 6));
        bench.board.send(noise);
        REQUIRE(bench.board.run_until([&] { return bench.board.line_idle(); }, 10'000'000));
    }
    bench.board.run(50'000);
    static_cast<void>(bench.board.receive());
    require_equal(bench.check(image), 16 * 1000);
    REQUIRE(bench.board.now() > begin);
    link::Client fresh(bench.line);
    fresh.identify();
    REQUIRE(fresh.status().present_index == 1);
    REQUIRE(fresh.status().enabled);
}
