// SPDX-License-Identifier: Apache-2.0
// The Ethernet port between the PHY and the instrument, its two clocks drifting, against the rules that net_frames.hpp
// works out.
#include <Vudp_link.h>

#include <algorithm>
#include <cstdlib>
#include <deque>
#include <functional>

#include "bench.hpp"
#include "net_frames.hpp"

using net::Bytes;
using net::operator+;  // Bytes is a type of the standard library, so nobody looks for it here

namespace {

constexpr long peer_clocks = PARAMETER_PEER_CLOCKS;
constexpr long half_eth_ps = 4000, half_clk_ps = 10003;
constexpr std::uint8_t up = 0xdd, down = 0xcc, at_100_mbit = 0xbb, untold = 0;  // RGMII's in-band status, on both edges
const Bytes preamble = {0x55, 0x55, 0x55, 0x55, 0x55, 0x55, 0x55, 0xd5};

std::uint16_t identity_word(unsigned place) { return static_cast<std::uint16_t>(0xa5c3U ^ (place * 0x1357U)); }
Bytes identity() {
    Bytes block;
    for (unsigned k = 0; k < 26; ++k) block = block + net::little(identity_word(k));
    return block;
}

/// The port with a PHY on one side and an instrument on the other, which answers what it is told.
class Port {
public:
    Bench<Vudp_link> bench;
    net::Rules rules{identity(), peer_clocks};
    double takes = 1.0;       ///< how often the instrument takes a byte that is there
    bool answers = true;      ///< it replies to each datagram
    Bytes core;               ///< what came for the instrument
    std::vector<Bytes> sent;  ///< frames from the port, with preamble and FCS
    unsigned breaks = 0, stops = 0, ends = 0;
    std::vector<std::uint8_t> old;  ///< of each byte for the instrument, what it was sent before
    long now = 0;                   ///< in clocks of the PHY
    bool clock_runs = true;
    long half_ps = half_eth_ps;  ///< of the PHY's clock
    std::uint8_t status;         ///< what the PHY tells between frames

    explicit Port(std::uint8_t told = up) : status(told) {
        bench->eth_clk = 0;
        bench->i_dv = bench->i_er = bench->i_data = 0;
        bench->i_take = bench->i_valid = bench->i_byte = bench->i_enabled = bench->i_off = 0;
        idle(20);
        bench->rst = 0;
        idle(600);     // until the status counts
        sent.clear();  // what its registers held at power-up
    }

    /// A clock of the PHY with this on its pins.
    void clock(bool dv, std::uint8_t data = 0, bool error = false) {
        bench->i_dv = dv;
        bench->i_data = data;
        bench->i_er = error;
        for (bool level : {true, false}) {
            while (next_clk_ps_ <= time_ps_) core_edge();
            if (level) watch_sent();
            bench->eth_clk = clock_runs && level;
            evaluate();
            time_ps_ += half_ps;
        }
        ++now;
    }
    void idle(long clocks) {
        for (long k = 0; k < clocks; ++k) clock(false, status);
    }
    /// Until nothing has gone out or in for a while.
    void settle() {
        long quiet = 0;
        while (quiet < 140) {
            const bool busy = bench->o_en || bench->o_valid || !replies_.empty();
            quiet = busy ? 0 : quiet + 1;
            clock(false, status);
        }
    }
    /// @param error  the byte behind the preamble at which the PHY reports an error
    void send(const Bytes& frame, long error = -1, const Bytes& before = preamble) {
        const Bytes all = before + frame;
        for (std::size_t k = 0; k < all.size(); ++k)
            clock(true, all[k], static_cast<long>(k) == error + static_cast<long>(before.size()) && error >= 0);
        idle(12);
    }

    /// Sends a frame and compares all that comes of it.
    void check(const Bytes& frame, long error = -1, const Bytes& before = preamble) {
        while (std::abs(rules.silence(now) - peer_clocks) < 2500)
            idle(100);  // when it is forgotten is not to the clock
        core.clear();
        old.clear();
        sent.clear();
        breaks = stops = ends = 0;
        const bool heard = before.size() > 1 && before.back() == 0xd5 &&
                           std::all_of(before.begin(), before.end() - 1, [](auto byte) { return byte == 0x55; });
        send(frame, error, before);
        const auto outcome = heard ? rules.take(frame, now, error >= 0) : net::Rules::Outcome{};
        settle();
        const Bytes got = core;
        if (got != outcome.core.value_or(Bytes{})) FAIL("the instrument got " << text(got) << " of " << text(frame));
        std::vector<Bytes> expected;
        if (outcome.answer) expected.push_back(*outcome.answer);
        if (answers && !got.empty()) expected.push_back(rules.to_peer(reply_to(got)));
        for (Bytes& each : expected) each = preamble + each + net::fcs(each);
        if (sent != expected)
            FAIL("sent " << (sent.empty() ? "nothing" : text(sent.front())) << " instead of "
                         << (expected.empty() ? "nothing" : text(expected.front())) << " to " << text(frame));
        if (ends != (outcome.disable || outcome.changed ? 1U : 0U))
            FAIL(ends << " ends of a session by " << text(frame));
        if (breaks != (outcome.disable ? 1U : 0U) || stops != (outcome.stop ? 1U : 0U))
            FAIL(breaks << " breaks and " << stops << " stops of " << text(frame));
    }
    /// Its counters, as the open port tells them.
    void check_counters() { check(net::whole(net::question(net::stranger, 1))); }

    static Bytes reply_to(const Bytes& datagram) {
        Bytes reply = net::cut(datagram, 0, std::min<std::size_t>(16, datagram.size()));
        for (std::uint8_t& byte : reply) byte |= 1U;
        reply.push_back(0);
        return reply;
    }
    void reply(const Bytes& bytes) { replies_.insert(replies_.end(), bytes.begin(), bytes.end()); }
    static std::string text(const Bytes& bytes) {
        std::string out;
        for (const std::uint8_t byte : bytes) {
            out += "0123456789abcdef"[byte >> 4];
            out += "0123456789abcdef"[byte & 15];
        }
        return out;
    }

private:
    void evaluate() {
        bench->eval();
        bench->i_identity_word = identity_word(bench->o_identity_place);
        bench->eval();
    }
    void watch_sent() {
        if (!clock_runs) return;
        if (bench->o_en)
            frame_.push_back(bench->o_data);
        else if (!frame_.empty())
            sent.push_back(std::exchange(frame_, {}));
    }
    void core_edge() {
        next_clk_ps_ += half_clk_ps;
        if (!bench->clk) {
            if (bench->i_take) {
                core.push_back(bench->o_byte);
                old.push_back(bench->o_old);
                fresh_.push_back(bench->o_byte);
            }
            if (bench->i_valid && bench->o_ready) replies_.pop_front();
            breaks += bench->o_off + bench->o_lost;
            ends += bench->o_end;
            stops += bench->o_stop;
        }
        bench->clk = !bench->clk;
        evaluate();
        if (!bench->clk) return;
        bench->i_take = bench->o_valid && bench.chance(takes);
        // The datagram has ended when nothing more is there: they come one at a time where replies are looked at.
        quiet_ = bench->o_valid ? 0 : quiet_ + 1;
        if (answers && quiet_ > 8 && !fresh_.empty()) reply(reply_to(std::exchange(fresh_, {})));
        if (!answers) fresh_.clear();
        bench->i_valid = !replies_.empty();
        if (!replies_.empty()) bench->i_byte = replies_.front();
        evaluate();
    }

    long time_ps_ = 0, next_clk_ps_ = 5003, quiet_ = 0;
    Bytes frame_, fresh_;
    std::deque<std::uint8_t> replies_;
};

Bytes random_bytes(Port& port, int count) {
    Bytes bytes;
    for (int k = 0; k < count; ++k) bytes.push_back(static_cast<std::uint8_t>(port.bench.number(0, 255)));
    return bytes;
}

Bytes changed(Bytes frame, std::size_t place, std::uint8_t value) {
    frame[place] = value;
    return frame;
}
/// With another field of its IP header, whose sum is put right again.
Bytes with_ip(Bytes frame, std::size_t place, std::uint8_t value) {
    frame[place] = value;
    net::put(frame, 24, 0);
    net::put(frame, 24, 0xffff ^ net::sum(net::cut(frame, 14, 34)));
    return frame;
}
Bytes without_udp_sum(Bytes frame) {
    net::put(frame, 40, 0);
    return frame;
}
Bytes wrong_length(Bytes frame, unsigned total, unsigned datagram) {
    frame = with_ip(with_ip(without_udp_sum(frame), 16, net::big(total)[0]), 17, net::big(total)[1]);
    net::put(frame, 38, datagram);
    return frame;
}

/// Good frames of every kind, and what is wrong with one in one way only.
std::vector<Bytes> frames(Port& port) {
    using namespace net;
    std::vector<Bytes> all;
    for (const Bytes& mac : {everybody, board.mac, stranger.mac}) all.push_back(arp(host, mac, board.ip));
    all.push_back(arp(host, everybody, stranger.ip));
    all.push_back(arp(host, board.mac, board.ip, 2));
    for (const int size : {0, 1, 18, 19, 200, 1000, 1472}) all.push_back(ping(host, board, random_bytes(port, size)));
    all.push_back(ping(host, with_port(stranger, 0), Bytes(40, 7)));
    Bytes near_all_ones = ping(host, board, Bytes(40));
    put(near_all_ones, 36, 0xf8ff);
    all.push_back(near_all_ones);
    for (const int size : {0, 1, 2, 17, 18, 19, 208, 1000, 1471, 1472})
        all.push_back(udp_frame(host, board, random_bytes(port, size)));
    for (int k = 0; k < 16; ++k) all.push_back(udp_frame(host, board, random_bytes(port, 40 + k)));
    const Bytes good = udp_frame(host, board, random_bytes(port, 60));
    all.push_back(without_udp_sum(good));
    all.push_back(changed(good, 60, static_cast<std::uint8_t>(good[60] ^ 1)));  // the sum is wrong
    all.push_back(changed(good, 24, static_cast<std::uint8_t>(good[24] ^ 1)));  // the header's
    for (const std::uint8_t bits : {0x00, 0x20, 0x40, 0x41, 0x60, 0x80, 0xc0, 0x9f})
        all.push_back(with_ip(good, 20, bits));
    all.push_back(with_ip(good, 21, 1));     // a fragment
    all.push_back(with_ip(good, 14, 0x46));  // options
    all.push_back(with_ip(good, 14, 0x65));
    all.push_back(with_ip(good, 15, 0xb8));
    all.push_back(with_ip(good, 22, 1));
    for (int bit = 0; bit < 8; ++bit)  // other protocols, each a bit off
        for (const Bytes& one : {good, ping(host, board, Bytes(30, 2))})
            all.push_back(with_ip(one, 23, static_cast<std::uint8_t>(one[23] ^ 1 << bit)));
    all.push_back(with_ip(good, 23, 6));
    for (const unsigned total : {0U, 5U, 20U, 27U, 28U, 87U, 88U, 89U, 90U, 91U, 92U, 93U, 100U, 2000U, 65535U})
        all.push_back(wrong_length(good, total, total - 20));
    for (const unsigned length : {0U, 8U, 67U, 69U, 65535U}) all.push_back(wrong_length(good, 88, length));
    all.push_back(cut(good, 0, 12) + Bytes{0x81, 0, 0, 3} + cut(good, 12, good.size()));  // VLAN
    all.push_back(changed(changed(good, 12, 0x86), 13, 0xdd));
    for (const Address& to :
         {with_port(board, 9), Address{board.mac, stranger.ip, 4807}, Address{stranger.mac, board.ip, 4807},
          Address{everybody, board.ip, 4807}, Address{everybody, Bytes(4, 0xff), 4807},
          Address{{1, 0, 0x5e, 0, 0, 1}, {224, 0, 0, 1}, 4807}})
        all.push_back(udp_frame(host, to, Bytes(30, 5)));
    for (const std::uint8_t command : {0, 1, 4, 5, 9, 13}) {
        all.push_back(question(stranger, command));
        all.push_back(question(host, command, everybody, Bytes(4, 0xff)));
        all.push_back(question(host, command, everybody, board.ip));
    }
    all.push_back(udp_frame(host, with_port(board, open_port), {'H', 'G', 1}));
    all.push_back(udp_frame(host, with_port(board, open_port), {'H', 'G', 1, 0, 0}));
    all.push_back(udp_frame(host, with_port(board, open_port), {'H', 'g', 1, 0}));
    all.push_back(udp_frame(host, with_port(board, open_port), {'h', 'G', 1, 0}));
    all.push_back(udp_frame(host, with_port(board, open_port), {'H', 'G', 1, 1}));
    all.push_back(udp_frame(stranger, board, Bytes(30, 5)));
    all.push_back(udp_frame(with_port(host, 51112), board, Bytes(30, 5)));
    all.push_back(udp_frame({host.mac, {169, 254, 1, 3}, 51111}, board, Bytes(30, 5)));
    return all;
}

/// Changes at random, half of them with sums put right, so that they get deep into the rules.
Bytes mutated(Port& port, const std::vector<Bytes>& seeds) {
    auto& bench = port.bench;
    Bytes body = seeds[static_cast<std::size_t>(bench.number(0, static_cast<int>(seeds.size()) - 1))];
    if (body.size() > 300 && bench.chance(0.8))
        body = net::udp_frame(net::host, net::board, random_bytes(port, bench.number(0, 60)));
    for (int k = bench.number(-2, 3); k > 0; --k) {
        const int reach = std::min<int>(static_cast<int>(body.size()), bench.chance(0.7) ? 46 : 2000);
        std::uint8_t& byte = body[static_cast<std::size_t>(bench.number(0, reach - 1))];
        byte = static_cast<std::uint8_t>(bench.chance(0.5) ? byte ^ 1 << bench.number(0, 7) : bench.number(0, 255));
    }
    if (bench.chance(0.1)) body.resize(static_cast<std::size_t>(bench.number(14, static_cast<int>(body.size()))));
    if (bench.chance(0.1)) body = body + random_bytes(port, bench.number(1, 40));
    if (bench.chance(0.4) && body.size() > 34) body = with_ip(body, 22, 64);
    if (bench.chance(0.4) && body.size() > 42) body = without_udp_sum(body);
    Bytes frame = bench.chance(0.95) ? net::whole(body) : body + net::fcs(body);
    if (bench.chance(0.1))
        frame[static_cast<std::size_t>(bench.number(0, static_cast<int>(frame.size()) - 1))] ^=
            static_cast<std::uint8_t>(1 << bench.number(0, 7));
    return frame;
}

}  // namespace

TEST_CASE("frames of every kind, and each with one thing wrong, are taken as the rules say") {
    Port port;
    port.takes = GENERATE(1.0, 0.3);
    for (const Bytes& body : frames(port)) port.check(net::whole(body));
    const Bytes good = net::whole(net::udp_frame(net::host, net::board, random_bytes(port, 208)));
    port.check(changed(good, good.size() - 1, static_cast<std::uint8_t>(good.back() ^ 0x80)));
    port.check(changed(good, 60, static_cast<std::uint8_t>(good[60] ^ 1)));
    port.check(good, 0);
    port.check(good, 100);
    port.check(good, static_cast<long>(good.size()) - 1);
    for (const std::size_t left : {1UL, 5UL, 14UL, 63UL, 64UL, 200UL}) port.check(net::cut(good, 0, left));
    const Bytes runt = net::udp_frame(net::host, net::board, Bytes(17, 3));
    port.check(runt + net::fcs(runt));  // 63 bytes
    const Bytes over = net::udp_frame(net::host, net::board, Bytes(1473, 3));
    port.check(over + net::fcs(over));  // 1,519
    // As long as a count of 11 bits would take for the good one.
    Bytes jumbo = net::udp_frame(net::host, net::board, Bytes(208, 3));
    jumbo.resize(jumbo.size() + 2048);
    port.check(jumbo + net::fcs(jumbo));
    port.check({}, -1, Bytes(3, 0x55));
    port.check(good, -1, Bytes{0x55, 0xd5});
    port.check(good, -1, Bytes(8, 0x55));
    port.check(good, -1, Bytes{0x55, 0x55, 0x54, 0xd5});
    port.check(good, -1, Bytes{0xd5});
    port.check(good);
    port.check_counters();
}

TEST_CASE("one peer holds the board until it has been silent, and anybody can turn it off") {
    using namespace net;
    Port port;
    const Bytes mine = whole(udp_frame(host, board, Bytes(30, 5))),
                other = whole(udp_frame(stranger, board, Bytes(30, 6)));
    port.check(mine);
    port.check(other);
    CHECK(port.rules.refused == 1);
    port.idle(peer_clocks / 2);
    port.check(mine);
    port.idle(peer_clocks / 2);
    port.check(other);
    CHECK(port.rules.refused == 2);
    port.check(whole(question(stranger, 5)));
    port.check(whole(question(stranger, 9)));
    port.bench->i_enabled = 1;
    port.rules.enabled = true;
    port.check_counters();
    port.check(mine);
    port.idle(peer_clocks + 3000);
    port.check(other);
    CHECK(port.rules.refused == 2);
    port.check(mine);
    CHECK(port.rules.refused == 3);
    port.check_counters();
}

TEST_CASE("a stranger whose frame ends as the peer is forgotten is refused, or becomes the peer with its own address") {
    using namespace net;
    Port port;
    const Bytes mine = whole(udp_frame(host, board, Bytes(30, 5))),
                other = whole(udp_frame(stranger, board, Bytes(30, 6)));
    int taken = 0, refused = 0;
    // It begins as the peer is forgotten, up to 25, and ends then, from 88 on.
    for (long before = 5; before < 105; before += before == 25 ? 63 : 1) {
        port.idle(peer_clocks + 100);
        port.send(mine);
        port.idle(peer_clocks - before);
        port.sent.clear();
        port.core.clear();
        port.send(other);
        port.settle();
        ++(port.core.empty() ? refused : taken);
        for (const Bytes& frame : port.sent) CHECK(cut(frame, 8, 14) == stranger.mac);
        CHECK(port.sent.size() == (port.core.empty() ? 0U : 1U));
    }
    CHECK(taken > 0);
    CHECK(refused > 0);
}

TEST_CASE("a link that is lost is a break, makes the peer a stranger, and leaves nothing of a datagram") {
    Port port;
    const Bytes frame = net::whole(net::udp_frame(net::host, net::board, random_bytes(port, 300)));
    port.check(frame);
    const bool stops_clock = GENERATE(false, true);
    port.core.clear();
    const Bytes all = preamble + frame;
    for (std::size_t k = 0; k < all.size() / 2; ++k) port.clock(true, all[k]);
    port.breaks = 0;
    if (stops_clock)
        port.clock_runs = false;
    else
        port.status = down;
    port.idle(1000);
    CHECK(port.breaks == 1);
    port.idle(5000);
    CHECK(port.breaks == 1);
    port.clock_runs = true;
    port.status = up;
    port.rules.lose_link();
    if (!stops_clock) port.idle(600);
    for (std::size_t k = all.size() / 2; k < all.size(); ++k) port.clock(true, all[k]);
    port.settle();
    CHECK(port.core.empty());
    port.idle(600);
    port.check(net::whole(net::udp_frame(net::stranger, net::board, random_bytes(port, 20))));
    CHECK(port.breaks == 0);
}

TEST_CASE("a status of the PHY that was received wrongly is no loss of the link, and one that stays is") {
    using namespace net;
    Port port;
    const auto wrong = static_cast<std::uint8_t>(GENERATE(as<int>{}, down, at_100_mbit, untold, 0xff));
    const Bytes mine = whole(udp_frame(host, board, Bytes(30, 5))),
                other = whole(udp_frame(stranger, board, Bytes(30, 6)));
    const auto says = [&](std::uint8_t what, long readings) {
        port.status = what;
        port.idle(readings);
        port.status = up;
    };
    port.check(mine);
    port.breaks = 0;
    for (const long readings : {1, 2, 511}) {
        says(wrong, readings);
        port.idle(1 + port.bench.number(0, 20));
        port.check(other);  // is refused: there is a peer
    }
    for (int k = 0; k < 500; ++k) {
        says(wrong, 1);
        port.idle(1);
    }
    port.settle();
    CHECK(port.breaks == 0);
    port.check(other);
    CHECK(port.rules.refused == 4);
    // Not even when each gap of many frames ends in a wrong one.
    for (int k = 0; k < 100; ++k) {
        port.send(mine);
        port.rules.take(mine, port.now);
        says(wrong, 1);
    }
    port.settle();
    CHECK(port.breaks == 0);
    port.breaks = 0;
    says(wrong, 514);  // and it is there again as soon as can be
    port.idle(1000);
    CHECK(port.breaks == 1);
    port.rules.lose_link();
    port.check(other);
    port.check(mine);
    CHECK(port.rules.refused == 5);
    port.check_counters();
}

TEST_CASE("a PHY that tells no status has a link as long as its clock runs") {
    using namespace net;
    Port port(static_cast<std::uint8_t>(GENERATE(as<int>{}, untold, at_100_mbit, 0xff)));
    port.check(whole(udp_frame(host, board, Bytes(30, 5))));
    port.check(whole(udp_frame(stranger, board, Bytes(30, 6))));
    port.breaks = 0;
    port.idle(5000);
    CHECK(port.breaks == 0);
    port.check_counters();
    port.clock_runs = false;
    port.idle(1000);
    CHECK(port.breaks == 1);
}

TEST_CASE("a PHY's clock that is too slow is no link, and is lost at most once") {
    Port port(untold);  // it need not tell that it is at 10 Mbit/s
    port.breaks = 0;
    port.half_ps = 200'000;  // 2.5 MHz
    port.idle(400);
    CHECK(port.breaks == 1);
    port.idle(2000);
    CHECK(port.breaks == 1);
    port.core.clear();
    port.send(net::whole(net::udp_frame(net::host, net::board, random_bytes(port, 30))));
    port.settle();
    CHECK(port.core.empty());
    port.half_ps = half_eth_ps;
    port.idle(600);
    CHECK(port.breaks == 1);
    port.check(net::whole(net::udp_frame(net::host, net::board, random_bytes(port, 30))));
}

TEST_CASE("what is in the port when something happens comes out as old, what comes later as new") {
    using namespace net;
    Port port;
    port.answers = false;
    port.check(whole(udp_frame(host, board, Bytes(30, 1))));
    const int what = GENERATE(0, 1, 2);  // the instrument switches off; STOP and DISABLE of anybody
    const std::uint8_t bits[] = {1, 2, 5};
    port.core.clear();
    port.old.clear();
    port.takes = 0.02;
    port.send(whole(udp_frame(host, board, Bytes(99, 2) + Bytes{0})));
    if (what == 0) {
        const Bytes second = preamble + whole(udp_frame(host, board, Bytes(199, 3) + Bytes{0}));
        for (std::size_t k = 0; k < second.size(); ++k) {  // is arriving then
            port.bench->i_off = k >= 3 && k < 10;
            port.clock(true, second[k]);
        }
    }
    if (what == 1) port.send(whole(question(stranger, 9)));
    if (what == 2) port.send(whole(question(stranger, 5)));
    port.idle(40);
    const std::size_t before = what == 0 ? 300 : 100;
    port.send(whole(udp_frame(host, board, Bytes(49, 4) + Bytes{0})));
    port.takes = 1;
    port.settle();
    REQUIRE(port.old.size() >= before + 50);
    for (std::size_t k = 20; k < before; ++k) REQUIRE(port.old[k] == bits[what]);
    for (std::size_t k = before; k < before + 50; ++k) REQUIRE(port.old[k] == 0);
}

TEST_CASE("replies that come within a short time go in one datagram, and without a peer nowhere") {
    Port port;
    port.answers = false;
    port.reply({1, 2, 3, 0});
    port.settle();
    CHECK(port.sent.empty());
    port.check(net::whole(net::udp_frame(net::host, net::board, Bytes(10, 1))));
    port.reply({4, 5, 0});
    port.reply({6, 0});
    port.reply({7, 8});  // not whole yet
    port.settle();
    port.idle(300);
    const auto framed = [&](const Bytes& payload) {
        const Bytes frame = port.rules.to_peer(payload);
        return preamble + frame + net::fcs(frame);
    };
    REQUIRE(port.sent.size() == 1);
    CHECK(port.sent.front() == framed({4, 5, 0, 6, 0}));
    port.sent.clear();
    Bytes many = {7, 8, 9, 0};
    port.reply({9, 0});
    for (int k = 0; k < 60; ++k) {
        const Bytes one =
            Bytes(static_cast<std::size_t>(port.bench.number(1, 200)), static_cast<std::uint8_t>(k + 1)) + Bytes{0};
        port.reply(one);
        many = many + one;
    }
    port.settle();
    port.idle(300);
    Bytes got;
    for (const Bytes& frame : port.sent) {
        CHECK(frame.size() <= 8 + 42 + 1024 + 4);
        CHECK(net::fcs(net::cut(frame, 8, frame.size() - 4)) == net::cut(frame, frame.size() - 4, frame.size()));
        CHECK(frame[frame.size() - 5] == 0);  // only whole ones
        got = got + net::cut(frame, 50, 8 + 14 + net::at(frame, 24));
    }
    CHECK(got == many);
}

TEST_CASE("replies that gather while another frame is sent go in one long datagram") {
    Port port;
    port.answers = false;
    port.check(net::whole(net::udp_frame(net::host, net::board, Bytes(10, 1))));
    port.sent.clear();
    port.send(net::whole(net::ping(net::host, net::board, Bytes(1472, 5))));
    const Bytes reply = Bytes(199, 7) + Bytes{0};
    Bytes all;
    for (int k = 0; k < 5; ++k) all = all + reply;
    port.reply(all);
    port.settle();
    REQUIRE(port.sent.size() >= 2);
    const Bytes frame = port.rules.to_peer(net::cut(all, 0, net::at(port.sent[1], 46) - 8));
    CHECK(port.sent[1] == preamble + frame + net::fcs(frame));
    CHECK(frame.size() > 42 + 512);
    // The longest reply that a core may have needs all of the memory.
    port.sent.clear();
    const Bytes longest = Bytes(1000, 9) + Bytes{0};
    port.reply(longest);
    for (int k = 0; k < 20; ++k) port.settle();
    REQUIRE(port.sent.size() == 1);
    CHECK(port.sent.front().size() == 8 + 42 + longest.size() + 4);
}

TEST_CASE("a line that is full of others' frames loses none of the peer's") {
    using namespace net;
    Port port;
    port.answers = false;
    const std::vector<Bytes> noise = {udp_frame(stranger, board, Bytes(18)),
                                      udp_frame(stranger, {everybody, Bytes(4, 0xff), 4807}, Bytes(18)),
                                      arp(host, everybody, board.ip),
                                      ping(stranger, board, Bytes(600)),
                                      udp_frame(host, with_port(board, 9), Bytes(200)),
                                      udp_frame(host, {stranger.mac, board.ip, 4807}, Bytes(1400)),
                                      question(stranger, 1)};
    Bytes wanted;
    for (int k = 0; k < 300; ++k) {
        const Bytes payload = random_bytes(port, 215) + Bytes{0};
        wanted = wanted + payload;
        port.send(whole(udp_frame(host, board, payload)));
        for (long room = 2800; room > 1500;) {
            const Bytes frame =
                whole(noise[static_cast<std::size_t>(port.bench.number(0, static_cast<int>(noise.size()) - 1))]);
            port.send(frame);
            room -= static_cast<long>(frame.size()) + 20;
        }
    }
    port.settle();
    CHECK(port.core == wanted);
    // What it answers meanwhile is what it would answer alone, or nothing.
    net::Rules rules(identity(), peer_clocks);
    unsigned known = 0;
    for (const Bytes& frame : port.sent) {
        CHECK(net::fcs(net::cut(frame, 8, frame.size() - 4)) == net::cut(frame, frame.size() - 4, frame.size()));
        const bool about = frame[8 + 12 + 1] == 0 && frame[8 + 23] == 17;  // which tells counters of the moment
        for (const Bytes& each : noise) {
            const auto answer = rules.take(whole(each), 0).answer;
            known += !about && answer && preamble + *answer + net::fcs(*answer) == frame;
        }
        known += about;
    }
    CHECK(known == port.sent.size());
    CHECK(known > 100);
}

TEST_CASE("at the line's full rate what finds no room is dropped whole, and counted") {
    Port port;
    port.answers = false;
    const int size = GENERATE(18, 216, 1472);
    const int count = 400;
    std::vector<Bytes> given;
    for (int k = 0; k < count; ++k) {
        given.push_back(net::big(static_cast<unsigned>(k)) + random_bytes(port, size - 3) + Bytes{0});
        port.send(net::whole(net::udp_frame(net::host, net::board, given.back())));
    }
    port.settle();
    unsigned whole = 0;
    std::size_t place = 0, next = 0;
    while (place < port.core.size()) {
        const std::size_t number = net::at(port.core, place);
        REQUIRE(number >= next);
        REQUIRE(number < given.size());
        REQUIRE(port.core.size() >= place + static_cast<std::size_t>(size));
        REQUIRE(net::cut(port.core, place, place + static_cast<std::size_t>(size)) == given[number]);
        next = number + 1;
        place += static_cast<std::size_t>(size);
        ++whole;
    }
    if (size == 18) CHECK(whole == count);
    CHECK(whole > count / 3);                                                                 // 50 MB/s of 125
    port.rules.take(net::whole(net::udp_frame(net::host, net::board, Bytes(18))), port.now);  // who the peer is
    port.rules.accepted = whole;
    port.rules.damaged = count - whole;
    port.check_counters();
}

// HAPTOGRAM_NET_FRAMES: how many instead, such as a million for a night.
TEST_CASE("frames that were changed at random are taken as the rules say", "[long]") {
    const char* const asked = std::getenv("HAPTOGRAM_NET_FRAMES");
    const long count = asked != nullptr ? std::atol(asked) : 100'000;
    REQUIRE(count > 0);
    Port port;
    const std::vector<Bytes> seeds = frames(port);
    for (long k = 0; k < count; ++k) {
        port.check(mutated(port, seeds), port.bench.chance(0.03) ? port.bench.number(0, 60) : -1);
        if (k % 1000 == 0) port.idle(peer_clocks + 3000);
        if (k % 1000 == 500) port.check_counters();
    }
    CHECK(port.rules.accepted > count / 20);
    CHECK(port.rules.damaged > count / 50);
    CHECK(port.rules.refused > count / 1000);
}
