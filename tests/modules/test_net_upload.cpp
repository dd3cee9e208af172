// SPDX-License-Identifier: Apache-2.0
// Records over Ethernet, as fast as a host may send them: so many frames are under way as the window allows.
#include <algorithm>
#include <cstdlib>
#include <iostream>

#include "net_core.hpp"

using namespace haptogram;
using namespace net;

TEST_CASE("over Ethernet: records are written at more than 40 MB/s, and are what was sent") {
    Network network;
    if (has_sdram) network.run(300'000);  // until it has started
    network.send(host, network.frame(Command::identify));
    REQUIRE(network.answered(1));
    constexpr unsigned written = std::min(records, 1'000U), together = 6;  // frames of a datagram
    static_assert(together * 216 <= interface::network::datagram_bytes);
    std::vector<Bytes> contents;
    const auto address = [](unsigned record) {
        return little(record * record_words * 2) + little(record * record_words * 2 >> 16);
    };
    const double begun = network.now_ns;
    while (network.replies.size() < 1 + written) {
        const std::size_t under_way = contents.size() + 1 - network.replies.size();
        if (contents.size() < written && under_way + together <= interface::network::window) {
            Bytes datagram;
            for (unsigned k = 0; k < together && contents.size() < written; ++k) {
                Bytes record(2 * record_words);
                for (std::uint8_t& byte : record) byte = static_cast<std::uint8_t>(network.bench.random());
                datagram =
                    datagram + network.frame(Command::write, address(static_cast<unsigned>(contents.size())) + record);
                contents.push_back(record);
            }
            network.send(host, datagram);
        }
        network.run(500);
        REQUIRE(network.now_ns - begun < 1e5 * written);
    }
    const double rate = 1e3 * written * 2 * record_words / (network.now_ns - begun);
    if (std::getenv("HAPTOGRAM_FIGURES") != nullptr) std::cout << "upload over Ethernet: " << rate << " MB/s\n";
    CHECK(rate > 40);
    const std::size_t answers = network.replies.size();
    unsigned wrong = 0;
    for (const link::Reply& reply : network.replies) wrong += reply.status != interface::Status::ok;
    for (unsigned record = 0; record < written; record += 7) {
        network.send(host, network.frame(Command::read, address(record) + little(2 * record_words)));
        REQUIRE(network.answered(answers + record / 7 + 1));
        wrong += network.replies.back().data != contents[record];
    }
    CHECK(wrong == 0);
}
