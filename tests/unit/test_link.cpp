// SPDX-License-Identifier: Apache-2.0
#include <boost/crc.hpp>
#include <catch2/catch.hpp>
#include <deque>
#include <fstream>
#include <limits>
#include <numeric>
#include <random>
#include <sstream>

#include "../refusal.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/link/client.hpp"
#include "haptogram/link/frame.hpp"
#include "haptogram/link/transfer.hpp"
#include "lying_board.hpp"

using namespace haptogram;
using namespace haptogram::link;
using interface::Command;
using test::identity_block;
using test::reply_frame;

namespace {

Bytes random_bytes(std::mt19937& g, std::size_t length, unsigned values) {
    Bytes bytes(length);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(g() % values);
    return bytes;
}

Bytes from_hex(const std::string& text) {
    Bytes bytes;
    for (std::size_t i = 0; i + 1 < text.size(); i += 2)
        bytes.push_back(static_cast<std::uint8_t>(std::stoul(text.substr(i, 2), nullptr, 16)));
    return bytes;
}

/// A board in ten lines that keeps what it was sent, over a line that loses frames.
class LossyBoard final : public Transport {
public:
    explicit LossyBoard(unsigned lose_one_in) : lose_one_in_(lose_one_in) {}
    void write(std::span<const std::uint8_t> bytes) override {
        if (bytes.size() < 4 || lost()) return;
        unread_.push_back(bytes.size());
        most_waiting = std::max(most_waiting, std::accumulate(unread_.begin(), unread_.end(), std::size_t{0}));
        const auto frame = cobs_decode(bytes.first(bytes.size() - 1));
        REQUIRE(frame);
        REQUIRE(crc16(*frame) == 0);
        Reply reply{(*frame)[0], static_cast<Command>((*frame)[1]), interface::Status::ok, 0, 0, {}};
        if (reply.command == Command::identify) {
            expected_ = reply.sequence;
            reply.data = identity_block();
        }
        const auto ahead = static_cast<std::uint8_t>(reply.sequence - expected_);
        if (ahead == 0) {
            if (reply.command != Command::identify) applied.push_back(Bytes(frame->begin() + 2, frame->end() - 2));
            ++expected_;
        } else {
            reply.status = ahead >= 128 ? interface::Status::repeated : interface::Status::out_of_order;
        }
        reply.expected = expected_;
        if (!lost()) {
            const Bytes code = reply_frame(reply);
            waiting_.insert(waiting_.end(), code.begin(), code.end());
        }
    }
    std::vector<std::uint8_t> read(std::chrono::microseconds) override {
        const std::size_t count = std::min<std::size_t>(waiting_.size(), 7);  // replies come in pieces
        Bytes bytes(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(count));
        waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(count));
        for (auto ends = std::ranges::count(bytes, 0); ends > 0 && !unread_.empty(); --ends) unread_.pop_front();
        return bytes;
    }
    [[nodiscard]] std::size_t window_bytes() const override { return room; }
    std::vector<Bytes> applied;
    std::size_t room = std::numeric_limits<std::size_t>::max(), most_waiting = 0;  ///< bytes without a whole answer
    void lose_one_in(unsigned frames) { lose_one_in_ = frames; }

private:
    bool lost() { return lose_one_in_ != 0 && g_() % lose_one_in_ == 0; }
    unsigned lose_one_in_;
    std::mt19937 g_{Catch::rngSeed()};
    std::deque<std::uint8_t> waiting_;
    std::deque<std::size_t> unread_;  // bytes of each frame whose answer was not read
    std::uint8_t expected_ = 0;
};

}  // namespace

TEST_CASE("crc: against Boost.CRC and the catalogue's check value", "[link]") {
    const std::string check = "123456789";
    REQUIRE(crc16(Bytes(check.begin(), check.end())) == 0x29B1);
    std::mt19937 g(Catch::rngSeed());
    for (int i = 0; i < 500; ++i) {
        const Bytes bytes = random_bytes(g, g() % 300, 256);
        boost::crc_optimal<16, 0x1021, 0xFFFF, 0, false, false> crc;
        crc.process_bytes(bytes.data(), bytes.size());
        REQUIRE(crc16(bytes) == crc.checksum());
    }
}

TEST_CASE("cobs: against the vectors that Python's cobs package made", "[link]") {
    std::ifstream file(HAPTOGRAM_COBS_VECTORS);
    REQUIRE(file);
    std::size_t count = 0;
    for (std::string line; std::getline(file, line); ++count) {
        const std::size_t colon = line.find(':');
        const Bytes data = from_hex(line.substr(0, colon));
        const Bytes code = from_hex(line.substr(colon + 1));
        REQUIRE(cobs_encode(data) == code);
        REQUIRE(cobs_decode(code) == data);
    }
    REQUIRE(count >= 300);
}

TEST_CASE("cobs: what is no code is said to be none", "[link]") {
    for (const Bytes& bad : {Bytes{0}, Bytes{3, 1}, Bytes{2, 0}, Bytes{2, 1, 0}, Bytes{255, 1, 2}})
        REQUIRE_FALSE(cobs_decode(bad));
    std::mt19937 g(Catch::rngSeed());
    for (int i = 0; i < 2000; ++i) static_cast<void>(cobs_decode(random_bytes(g, g() % 40, 8)));
}

TEST_CASE("replies: whole ones are understood, damaged ones counted and dropped", "[link]") {
    const Reply reply{7, Command::status, interface::Status::ok, 8, 300, {1, 0, 2}};
    const Bytes good = reply_frame(reply);
    for (std::size_t bit = 0; bit < 8 * (good.size() - 1); ++bit) {
        Bytes bytes = good;
        bytes[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
        bytes.insert(bytes.end(), good.begin(), good.end());
        ReplyDecoder decoder;
        std::vector<Reply> replies;
        for (const std::uint8_t byte : bytes) decoder.feed({&byte, 1}, replies);
        REQUIRE(replies.size() == 1);
        REQUIRE(decoder.damaged() >= 1);
        REQUIRE(replies[0].live_level == 300);
        REQUIRE(replies[0].data == reply.data);
    }
}

TEST_CASE("client: everything arrives once and in order over a line that loses frames", "[link]") {
    const unsigned lose = GENERATE(0U, 20U, 5U);
    LossyBoard board(lose);
    Client client(board);
    std::vector<Request> requests;
    for (std::uint8_t i = 0; i < 200; ++i) requests.push_back({Command::write, {i, 0, 0, 0, i, i}});
    std::size_t told = 0;
    const auto replies = client.pipeline(requests, [&](double, std::string_view) { return ++told > 0; });
    REQUIRE(replies.size() == 200);
    REQUIRE(told == 200);
    REQUIRE(board.applied.size() == 200);
    for (std::uint8_t i = 0; i < 200; ++i) REQUIRE(board.applied[i] == requests[i].payload);
    REQUIRE((client.retransmissions() > 0) == (lose > 0));
}

TEST_CASE("client: no more bytes are under way than the board has room for", "[link]") {
    LossyBoard board(0);
    board.room = GENERATE(100U, 700U, 4096U);
    const std::vector<Request> requests(50, {Command::write, Bytes(208, 7)});
    Client client(board);
    REQUIRE(client.pipeline(requests).size() == 50);
    REQUIRE(board.applied.size() == 50);
    CHECK(board.most_waiting <= std::max<std::size_t>(board.room, 216));  // one frame goes in any case
    CHECK(board.most_waiting > std::min<std::size_t>(board.room, 15 * 208) / 2);
}

TEST_CASE("client: a line on which nothing answers is a device error that says what to check", "[link]") {
    LossyBoard deaf(1);
    Client client(deaf);
    REQUIRE_REFUSED(client.identify());
    try {
        client.enable();
        FAIL("no error");
    } catch (const Error& error) {
        REQUIRE(error.code() == ErrorCode::device);
    }
}

TEST_CASE("client: the number of tries is the policy's, fewer before a board has answered at all", "[link]") {
    LossyBoard deaf(1);
    REQUIRE_REFUSED(Client(deaf).identify());
    LossyBoard board(0);
    Client client(board);
    client.identify();
    board.lose_one_in(1);
    REQUIRE_REFUSED(client.enable());
    REQUIRE_THROWS_AS(client.enable(), LinkLost);
}

TEST_CASE("client: work that is cancelled leaves a session that goes on", "[link]") {
    LossyBoard board(0);
    Client client(board);
    std::vector<Request> requests;
    for (std::uint8_t i = 0; i < 100; ++i) requests.push_back({Command::write, {i, 0, 0, 0, i, i}});
    std::size_t told = 0;
    REQUIRE_REFUSED(client.pipeline(requests, [&](double, std::string_view) { return ++told < 30; }));
    REQUIRE(told == 30);
    REQUIRE(board.applied.size() < 60);  // what was under way still arrives, the rest never does
    client.disable();
    REQUIRE(board.applied.back().empty());
    REQUIRE(told == 30);
}

TEST_CASE("client: an image is checked against the board before anything is written", "[link]") {
    Identity board{"Haptogram", 1, 0, 100, 400, 1024, 256, 16, 8, 50'000'000, 15, 214};
    Image image;
    image.channels = 100;
    image.clock_hz = 50'000'000;
    image.records.resize(400);
    image.sequence.resize(1023);
    REQUIRE_NOTHROW(require_fits(image, board, "i"));
    const auto fails = [&](auto change) {
        Image other = image;
        change(other);
        REQUIRE_REFUSED(require_fits(other, board, "i"));
    };
    fails([](Image& i) { i.channels = 324; });
    fails([](Image& i) { i.clock_hz = 48'000'000; });
    fails([](Image& i) { i.records.resize(401); });
    fails([](Image& i) { i.sequence.resize(1024); });
    board.timing_bits = 12;
    fails([](Image&) {});
}
