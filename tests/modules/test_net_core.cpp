// SPDX-License-Identifier: Apache-2.0
// The instrument over Ethernet, whole: what plays at the pins' side follows from frames at the PHY's.
#include <Vnet_core_bench.h>

#include <deque>
#include <initializer_list>
#include <span>

#include "bench.hpp"
#include "haptogram/format/interface.hpp"
#include "haptogram/link/frame.hpp"
#include "net_frames.hpp"

using net::Bytes;
using net::operator+;
using namespace haptogram;
using interface::Command;

namespace {

constexpr long half_eth_ps = 4000, half_clk_ps = 10003;
constexpr unsigned channels = PARAMETER_CHANNELS, records = PARAMETER_RECORDS;
constexpr unsigned record_words = channels + interface::record_header_words;

/// The board, its host, and the time between them in nanoseconds.
class Network {
public:
    Bench<Vnet_core_bench> bench;
    std::vector<unsigned> played;  ///< the index of each carrier period that began, with outputs on
    std::vector<link::Reply> replies;
    double now_ns = 0;

    Network() {
        bench->eth_clk = bench->i_link = bench->i_dv = bench->i_data = 0;
        run(2000);
        bench->rst = 0;
        listens_ = true;  // what was sent before was what its registers held at power-up
        frame_.clear();
        bench->i_link = 1;
        run(5000);
    }

    void send(const net::Address& from, const Bytes& payload, unsigned port = net::board.port) {
        send_frame(net::whole(net::udp_frame(from, net::with_port(net::board, port), payload)));
    }
    void send_frame(const Bytes& frame) {
        const Bytes preamble = {0x55, 0x55, 0x55, 0x55, 0x55, 0x55, 0x55, 0xd5};
        line_.insert(line_.end(), preamble.begin(), preamble.end());
        line_.insert(line_.end(), frame.begin(), frame.end());
        ends_.push_back(preamble.size() + frame.size());
    }
    Bytes frame(Command command, const Bytes& payload = {}) {
        return link::encode_request(number_++, command, payload);
    }

    /// Frames one behind the other, which a sum of two calls would not promise.
    Bytes frames(std::initializer_list<Command> commands) {
        Bytes all;
        for (const Command command : commands) all = all + frame(command);
        return all;
    }

    void run(double ns) {
        for (const double end = now_ns + ns; now_ns < end; now_ns = 1e-3 * static_cast<double>(time_ps_)) step();
    }
    /// Until so many answers have come; false after a millisecond.
    bool answered(std::size_t count) {
        for (const double end = now_ns + 1e6; replies.size() < count && now_ns < end;) run(1000);
        return replies.size() >= count;
    }

    [[nodiscard]] std::size_t frames_left() const { return ends_.size(); }

private:
    void step() {
        while (next_clk_ps_ <= time_ps_) core_edge();
        const bool rises = !bench->eth_clk;
        if (rises) {
            if (bench->o_en)
                frame_.push_back(bench->o_data);
            else if (!frame_.empty())
                heard(std::exchange(frame_, {}));
        }
        bench->eth_clk = rises;
        bench->eval();
        if (rises) drive();
        time_ps_ += half_eth_ps;
    }
    void drive() {
        const bool sends = gap_ == 0 && !line_.empty();
        bench->i_dv = sends;
        if (gap_ > 0) --gap_;
        if (sends) {
            bench->i_data = line_.front();
            line_.pop_front();
            if (--ends_.front() == 0) {
                ends_.pop_front();
                gap_ = 12;
            }
        }
        bench->eval();
    }
    void core_edge() {
        next_clk_ps_ += half_clk_ps;
        if (!bench->clk && bench->o_cycle_start && bench->o_enabled) played.push_back(bench->o_index);
        bench->clk = !bench->clk;
        bench->eval();
    }
    void heard(const Bytes& sent) {
        if (listens_) take(sent);
    }
    void take(const Bytes& sent) {
        const Bytes body = net::cut(sent, 8, sent.size() - 4);
        REQUIRE(net::fcs(body) == net::cut(sent, sent.size() - 4, sent.size()));
        if (net::at(body, 12) == 0x0800 && body[23] == 17 && net::at(body, 34) == net::board.port)
            decoder_.feed(net::cut(body, 42, 14 + net::at(body, 16)), replies);
    }

    long time_ps_ = 0, next_clk_ps_ = 5003, gap_ = 0;
    std::deque<std::uint8_t> line_;
    std::deque<std::size_t> ends_;
    bool listens_ = false;
    Bytes frame_;
    link::ReplyDecoder decoder_;
    std::uint8_t number_ = 7;
};

Bytes words(std::span<const std::uint16_t> values) {
    Bytes bytes;
    for (const std::uint16_t value : values) bytes = bytes + net::little(value);
    return bytes;
}

/// Amplitudes and phases of all channels, another pattern for each number.
Bytes write_of(Network& network, unsigned index, unsigned number) {
    std::vector<std::uint16_t> record(record_words, 0);
    interface::record_field::cycle_length.set(record, 1250);
    interface::record_field::prescaler.set(record, 1);
    interface::record_field::kind.set(record, 1);
    for (unsigned c = 0; c < channels; ++c)
        record[interface::record_header_words + c] =
            static_cast<std::uint16_t>((200 + (number + c) % 50) << 8 | (number * 7 + c * 3) % 256);
    const unsigned address = (index - 1) * record_words * 2;
    return network.frame(Command::write, net::little(address) + net::little(address >> 16) + words(record));
}

bool all_applied(const Network& network) {
    for (const link::Reply& reply : network.replies)
        if (reply.status != interface::Status::ok) return false;
    return true;
}

}  // namespace

TEST_CASE("over Ethernet: a session begins, outputs go on, and off when the link is lost or anybody says so") {
    Network network;
    network.send(net::host, network.frame(Command::identify));
    REQUIRE(network.answered(1));
    CHECK(network.replies.front().data.size() == 2 * interface::identity_words);
    network.send(net::host, network.frame(Command::enable));
    REQUIRE(network.answered(2));
    CHECK(network.bench->o_enabled);
    // A stranger turns nothing on, and everything off.
    const bool by_stranger = GENERATE(true, false);
    if (by_stranger) {
        network.send(net::stranger, {'H', 'G', 5, 0}, net::open_port);
        network.run(5'000);
        CHECK(!network.bench->o_enabled);
        network.send(net::stranger, network.frames({Command::identify, Command::enable}));
        network.run(100'000);
        CHECK(!network.bench->o_enabled);
    } else {
        // What waits in the port does not switch on again either: the link is lost while much of it does.
        for (int k = 0; k < 8; ++k) {
            Bytes many;
            for (int n = 0; n < 100; ++n) many = many + network.frame(Command::enable);
            network.send(net::host, many);
        }
        network.run(60'000);
        network.bench->i_link = 0;
        network.run(10'000);
        CHECK(!network.bench->o_enabled);
        network.run(500'000);
        CHECK(!network.bench->o_enabled);
    }
}

TEST_CASE("over Ethernet: a line that is full of others' frames delays no DISABLE, of the peer or of anybody") {
    Network network;
    network.send(net::host, network.frames({Command::identify, Command::enable}));
    REQUIRE(network.answered(2));
    REQUIRE(network.bench->o_enabled);
    const bool of_peer = GENERATE(true, false);
    const auto flood = [&](int frames) {
        for (int k = 0; k < frames; ++k) switch (k % 3) {
                case 0: network.send(net::stranger, Bytes(18, 9)); break;
                case 1: network.send_frame(net::whole(net::arp(net::stranger, net::everybody, net::board.ip))); break;
                default: network.send(net::stranger, {'H', 'G', 1, 0}, net::open_port);
            }
    };
    flood(100);
    if (of_peer)
        network.send(net::host, network.frame(Command::disable));
    else
        network.send(net::stranger, {'H', 'G', 5, 0}, net::open_port);
    flood(300);
    while (network.frames_left() > 300) network.run(8);
    CHECK(network.bench->o_enabled);
    const double arrived = network.now_ns;
    while (network.bench->o_enabled && network.now_ns < arrived + 1e6) network.run(20);
    CHECK(network.now_ns - arrived < 1'000);
    CHECK(network.frames_left() > 290);
}

TEST_CASE("over Ethernet: a new pattern of all channels in every carrier period, live") {
    Network network;
    network.send(net::host, network.frame(Command::identify));
    REQUIRE(network.answered(1));
    network.send(net::host, network.frame(Command::watchdog, {0, 0}));
    network.send(net::host, network.frame(Command::enable));
    REQUIRE(network.answered(3));
    constexpr unsigned each = 4, datagrams = 150, slots = records * 2 / 3;
    const double begun = network.now_ns;
    for (unsigned k = 0; k < datagrams; ++k) {
        Bytes datagram;
        std::vector<std::uint16_t> indices;
        for (unsigned n = 0; n < each; ++n) {
            const unsigned number = k * each + n, index = number % slots + 1;
            datagram = datagram + write_of(network, index, number);
            indices.push_back(static_cast<std::uint16_t>(index));
        }
        datagram = datagram + network.frame(Command::push, Bytes{1, 0} + words(indices));
        REQUIRE(datagram.size() <= interface::network::datagram_bytes);
        network.send(net::host, datagram);
        // The board's clock is a little slow, and a few patterns are ahead of it.
        const double due = begun + (k < 3 ? 0 : k - 2) * each * 25'010.0;
        if (due > network.now_ns) network.run(due - network.now_ns);
    }
    network.run(1e6);
    CHECK(all_applied(network));
    CHECK(network.replies.size() == 3 + datagrams * (each + 1));
    std::vector<unsigned> live;
    for (const unsigned index : network.played)
        if (index != 0) live.push_back(index);
    REQUIRE(live.size() >= datagrams * each);
    unsigned wrong = 0;
    for (unsigned number = 0; number < datagrams * each; ++number) wrong += live[number] != number % slots + 1;
    CHECK(wrong == 0);
}
