// SPDX-License-Identifier: Apache-2.0
// The instrument over Ethernet, whole: what plays at the pins' side follows from frames at the PHY's.
#include "net_core.hpp"

using namespace haptogram;
using namespace net;

namespace {

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
    return network.frame(Command::write, little(address) + little(address >> 16) + words(record));
}

bool all_applied(const Network& network) {
    for (const link::Reply& reply : network.replies)
        if (reply.status != interface::Status::ok) return false;
    return true;
}

}  // namespace

TEST_CASE("over Ethernet: a session begins, outputs go on, and off when the link is lost or anybody says so") {
    Network network;
    network.send(host, network.frame(Command::identify));
    REQUIRE(network.answered(1));
    CHECK(network.replies.front().data.size() == 2 * interface::identity_words);
    network.send(host, network.frame(Command::enable));
    REQUIRE(network.answered(2));
    CHECK(network.bench->o_enabled);
    // A stranger turns nothing on, and everything off.
    const bool by_stranger = GENERATE(true, false);
    if (by_stranger) {
        network.send(stranger, {'H', 'G', 5, 0}, open_port);
        network.run(5'000);
        CHECK(!network.bench->o_enabled);
        network.send(stranger, network.frames({Command::identify, Command::enable}));
        network.run(100'000);
        CHECK(!network.bench->o_enabled);
    } else {
        // What waits in the port does not switch on again either: the link is lost while much of it does.
        for (int k = 0; k < 8; ++k) {
            Bytes many;
            for (int n = 0; n < 100; ++n) many = many + network.frame(Command::enable);
            network.send(host, many);
        }
        network.run(60'000);
        network.phy_status = 0xcc;
        network.run(10'000);
        CHECK(!network.bench->o_enabled);
        network.run(500'000);
        CHECK(!network.bench->o_enabled);
    }
}

TEST_CASE("over Ethernet: a line that is full of others' frames delays no DISABLE, of the peer or of anybody") {
    Network network;
    network.send(host, network.frames({Command::identify, Command::enable}));
    REQUIRE(network.answered(2));
    REQUIRE(network.bench->o_enabled);
    const bool of_peer = GENERATE(true, false);
    const auto flood = [&](int frames) {
        for (int k = 0; k < frames; ++k) switch (k % 3) {
                case 0: network.send(stranger, Bytes(18, 9)); break;
                case 1: network.send_frame(whole(arp(stranger, everybody, board.ip))); break;
                default: network.send(stranger, {'H', 'G', 1, 0}, open_port);
            }
    };
    flood(100);
    if (of_peer)
        network.send(host, network.frame(Command::disable));
    else
        network.send(stranger, {'H', 'G', 5, 0}, open_port);
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
    network.send(host, network.frame(Command::identify));
    REQUIRE(network.answered(1));
    network.send(host, network.frame(Command::watchdog, {0, 0}));
    network.send(host, network.frame(Command::enable));
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
        network.send(host, datagram);
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
