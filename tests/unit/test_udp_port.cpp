// SPDX-License-Identifier: Apache-2.0
// What a host takes for a board's word that its outputs are off, when datagrams are late.
#include <fmt/core.h>

#include <boost/asio/ip/udp.hpp>
#include <catch2/catch.hpp>
#include <vector>

#include "haptogram/link/udp_port.hpp"
#include "lying_board.hpp"

using namespace haptogram;
using namespace haptogram::link;
using boost::asio::ip::udp;

namespace {

/// The open port of a board that answers when it is told to. The port for frames is the one before it.
class OpenPort {
public:
    OpenPort() { socket_.non_blocking(false); }

    [[nodiscard]] std::string name() const {
        return fmt::format("udp:127.0.0.1:{}", socket_.local_endpoint().port() - 1);
    }
    /// The next question, and from where it came.
    udp::endpoint question(interface::Command command) {
        std::vector<std::uint8_t> bytes(64);
        udp::endpoint from;
        bytes.resize(socket_.receive_from(boost::asio::buffer(bytes), from));
        REQUIRE(bytes == open_question(command));
        return from;
    }
    void answer(interface::Command command, const udp::endpoint& to) {
        std::vector<std::uint8_t> bytes = open_question(command);
        bytes[2] |= 0x80U;
        const std::vector<std::uint8_t> identity = test::identity_block();
        bytes.insert(bytes.end(), identity.begin(), identity.end());
        bytes.resize(bytes.size() + 6);  // its counters
        socket_.send_to(boost::asio::buffer(bytes), to);
    }

private:
    boost::asio::io_context context_;
    udp::socket socket_{context_, udp::endpoint(boost::asio::ip::address_v4::loopback(), 0)};
};

}  // namespace

TEST_CASE("udp port: an answer to an earlier question does not say that the outputs are off", "[link]") {
    using interface::Command;
    OpenPort board;
    UdpPort port(board.name());
    CHECK_FALSE(port.break_has_acted());
    port.send_break();
    const udp::endpoint first = board.question(Command::disable);
    board.question(Command::stop);
    port.send_break();  // somebody has played meanwhile
    const udp::endpoint second = board.question(Command::disable);
    board.question(Command::stop);
    CHECK(second != first);
    board.answer(Command::disable, first);
    CHECK_FALSE(port.break_has_acted());
    board.answer(Command::stop, second);  // of another question
    CHECK_FALSE(port.break_has_acted());
    board.answer(Command::disable, second);
    CHECK(port.break_has_acted());
    CHECK(port.break_has_acted());
    port.send_break();
    CHECK_FALSE(port.break_has_acted());
}
