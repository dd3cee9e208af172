// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <netinet/in.h>

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "board.hpp"
#include "host_line.hpp"

namespace haptogram::sim {

/// What a network does to datagrams, each way.
struct NetworkFaults {
    double loss = 0.0, duplicates = 0.0;  ///< shares of the datagrams
    double jitter_ms = 0.0;               ///< each is late by up to so much, so they also come in another order
    std::uint32_t seed = 1;
};

/// Datagrams of the port that were taken, refused because they were not the peer's, and damaged: none here.
struct DatagramCounters {
    std::uint16_t accepted = 0, refused = 0, damaged = 0;
};

/// The UDP side of a board with a network port, with the rules of rtl/net/ from the IP datagram on: one peer, and an
/// open port for anybody. Ethernet, ARP and the checksums are the machine's: a TAP device, which needs rights, would
/// only show what tests/modules compares byte by byte.
class NetworkPort final : public HostLine {
public:
    /// @param port  the open port is the next one; 0: two that are free
    /// @throws Error{device} when they are in use
    NetworkPort(Board& board, const std::string& address, std::uint16_t port, const NetworkFaults& faults);
    ~NetworkPort() override;

    [[nodiscard]] std::string name() const override;
    [[nodiscard]] std::vector<std::uint8_t> read(std::chrono::milliseconds patience) override;
    /// Whole replies of the board, which go to the peer; to nobody if there is none.
    void write(std::span<const std::uint8_t> bytes) override;
    [[nodiscard]] const DatagramCounters& counters() const { return counters_; }

private:
    using Clock = std::chrono::steady_clock;
    struct Datagram {
        Clock::time_point due;
        sockaddr_in who{};
        std::vector<std::uint8_t> bytes;
    };
    void hear(int socket, const std::function<void(Datagram)>& take);
    void delay(std::deque<Datagram>& line, Datagram datagram);
    [[nodiscard]] std::optional<Datagram> next(std::deque<Datagram>& line);
    void take(const Datagram& datagram, std::vector<std::uint8_t>& bytes);
    void answer(const Datagram& question);
    void send_due();

    Board& board_;
    std::string address_;
    std::uint16_t port_ = 0;
    int socket_ = -1, open_socket_ = -1;
    NetworkFaults faults_;
    std::mt19937 random_;
    std::deque<Datagram> in_, out_;
    std::vector<std::uint8_t> replies_, identity_;  // replies_: those that are not whole yet, too
    std::optional<sockaddr_in> peer_, last_peer_;
    Clock::time_point heard_{};
    DatagramCounters counters_;
};

}  // namespace haptogram::sim
