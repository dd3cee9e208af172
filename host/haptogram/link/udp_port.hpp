// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "haptogram/format/interface.hpp"
#include "haptogram/link/commands.hpp"
#include "haptogram/link/transport.hpp"

namespace haptogram::link {

/// What a board's open port answers to anybody.
struct AboutBoard {
    std::string port;  ///< its name, such as "udp:169.254.71.1"
    Identity identity;
    bool held = false;                                     ///< by a peer
    bool enabled = false;                                  ///< its outputs were on
    std::uint16_t accepted = 0, refused = 0, damaged = 0;  ///< datagrams
};

/// A question to the open port, which needs no session.
[[nodiscard]] std::vector<std::uint8_t> open_question(interface::Command command);
/// What the open port's answer says, without the port's name; empty when the bytes are no such answer.
[[nodiscard]] std::optional<AboutBoard> to_about(std::span<const std::uint8_t> answer, interface::Command command);

/// "udp:ADDRESS[:PORT]"
[[nodiscard]] bool names_udp(std::string_view name);

/// Bytes of datagrams that a board's port has room for (net/udp_link.v, RX_BITS).
inline constexpr std::size_t port_room = 4096;

/// A board behind Ethernet. Whole frames gather into datagrams until something is read; what is lost or comes twice is
/// the session's to deal with. A datagram of a board has whole frames, too.
class UdpPort final : public Transport {
public:
    /// @param name  "udp:ADDRESS[:PORT]"; ADDRESS is of IPv4, or a name of one
    /// @throws Error{bad_argument} when it is no such name, Error{device} when there is no such address
    explicit UdpPort(const std::string& name);
    ~UdpPort() override;

    void write(std::span<const std::uint8_t> bytes) override;
    void flush() override;
    [[nodiscard]] std::vector<std::uint8_t> read(std::chrono::microseconds patience) override;
    void discard_output() override { waiting_.clear(); }
    /// Asks the board's open port to turn the outputs off, which it does for anybody.
    void send_break() override;
    [[nodiscard]] bool break_has_acted() override;
    [[nodiscard]] std::chrono::microseconds patience() const override {
        return std::chrono::milliseconds(interface::network::patience_ms);
    }
    [[nodiscard]] unsigned rounds() const override {
        return interface::link_policy::patience_ms / interface::network::patience_ms;
    }
    [[nodiscard]] unsigned window() const override { return interface::network::window; }
    [[nodiscard]] std::size_t window_bytes() const override { return port_room; }
    /// Of the board, by its open port; empty when nothing answers within so long.
    [[nodiscard]] std::optional<AboutBoard> ask(std::chrono::microseconds patience);
    [[nodiscard]] std::string why_silent() override;

    struct Socket;

private:
    struct Sockets;

    void send(Socket& socket, std::span<const std::uint8_t> bytes);
    void ask_off();
    [[nodiscard]] std::optional<AboutBoard> open_answer(interface::Command command, std::chrono::microseconds patience);

    std::string name_;
    std::unique_ptr<Sockets> sockets_;
    std::vector<std::uint8_t> waiting_;     // whole frames of the next datagram
    std::optional<Clock::Time> asked_off_;  // when the question went out last
    bool off_ = false;
};

/// The boards that answer a question to all on every network of this machine, and on this machine itself, within so
/// long; sorted by port.
[[nodiscard]] std::vector<AboutBoard> boards_of_networks(std::chrono::milliseconds patience);

}  // namespace haptogram::link
