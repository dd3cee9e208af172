// SPDX-License-Identifier: Apache-2.0
#include "network_port.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/format/interface.hpp"
#include "identity.hpp"

namespace haptogram::sim {
namespace {

using interface::Command;

constexpr std::chrono::milliseconds silence{interface::network::silence_ms};
constexpr std::size_t reply_bytes = 1024;     // of a datagram of replies, at most
constexpr std::size_t most_datagrams = 4096;  // datagrams

bool same(const sockaddr_in& a, const sockaddr_in& b) {
    return a.sin_addr.s_addr == b.sin_addr.s_addr && a.sin_port == b.sin_port;
}

sockaddr_in address_of(const std::string& address, std::uint16_t port) {
    sockaddr_in result{};
    result.sin_family = AF_INET;
    result.sin_port = htons(port);
    if (::inet_pton(AF_INET, address.c_str(), &result.sin_addr) != 1)
        throw bad_argument("net", fmt::format("'{}' is no address of IPv4, such as 127.0.0.1", address));
    return result;
}

/// A socket at this address, or -1.
int bound_socket(const sockaddr_in& address) {
    const int socket = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (socket >= 0 && ::bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
        const int why = errno;
        ::close(socket);
        errno = why;
        return -1;
    }
    return socket;
}

std::uint16_t port_of(int socket) {
    sockaddr_in address{};
    socklen_t size = sizeof address;
    ::getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size);
    return ntohs(address.sin_port);
}

}  // namespace

NetworkPort::NetworkPort(Board& board, const std::string& address, std::uint16_t port, const NetworkFaults& faults)
    : board_(board),
      address_(address),
      faults_(faults),
      random_(faults.seed),
      identity_(identity_bytes(board.parameters())) {
    const unsigned tries = port == 0 ? 50 : 1;  // until the port behind a free one is free, too
    for (unsigned k = 0; k < tries && open_socket_ < 0; ++k) {
        if (socket_ >= 0) ::close(std::exchange(socket_, -1));
        socket_ = bound_socket(address_of(address, port));
        if (socket_ < 0) break;
        port_ = port_of(socket_);
        open_socket_ = port_ == 65535 ? -1 : bound_socket(address_of(address, static_cast<std::uint16_t>(port_ + 1)));
    }
    if (open_socket_ >= 0) return;
    const std::string why = std::generic_category().message(errno);
    if (socket_ >= 0) ::close(socket_);
    throw Error(ErrorCode::device, fmt::format("udp:{}:{}", address, port),
                fmt::format("this port and the next one cannot be had: {}; name another one by --net-port", why));
}

NetworkPort::~NetworkPort() {
    ::close(open_socket_);
    ::close(socket_);
}

std::string NetworkPort::name() const {
    return port_ == interface::network::port ? fmt::format("udp:{}", address_)
                                             : fmt::format("udp:{}:{}", address_, port_);
}

void NetworkPort::hear(int socket, const std::function<void(Datagram)>& take) {
    std::array<std::uint8_t, 65536> buffer;
    sockaddr_in who{};
    socklen_t size = sizeof who;
    for (ssize_t count = 0;
         (count = ::recvfrom(socket, buffer.data(), buffer.size(), 0, reinterpret_cast<sockaddr*>(&who), &size)) >= 0;)
        take({Clock::now(), who, {buffer.begin(), buffer.begin() + count}});
}

/// Onto a line that loses, doubles and delays.
void NetworkPort::delay(std::deque<Datagram>& line, Datagram datagram) {
    std::uniform_real_distribution<double> part(0.0, 1.0);
    const int copies = (part(random_) < faults_.loss ? 0 : 1) + (part(random_) < faults_.duplicates ? 1 : 0);
    for (int k = 0; k < copies && line.size() < most_datagrams; ++k) {
        const std::chrono::duration<double, std::milli> late(faults_.jitter_ms * part(random_));
        datagram.due = Clock::now() + std::chrono::duration_cast<Clock::duration>(late);
        const auto after = std::ranges::upper_bound(line, datagram.due, {}, &Datagram::due);
        line.insert(after, datagram);
    }
}

std::optional<NetworkPort::Datagram> NetworkPort::next(std::deque<Datagram>& line) {
    if (line.empty() || line.front().due > Clock::now()) return {};
    Datagram datagram = std::move(line.front());
    line.pop_front();
    return datagram;
}

std::vector<std::uint8_t> NetworkPort::read(std::chrono::milliseconds patience) {
    std::array<pollfd, 2> wait{pollfd{socket_, POLLIN, 0}, pollfd{open_socket_, POLLIN, 0}};
    const bool waits = in_.empty() && out_.empty();
    ::poll(wait.data(), wait.size(), waits ? static_cast<int>(patience.count()) : 0);
    hear(socket_, [this](Datagram datagram) { delay(in_, std::move(datagram)); });
    hear(open_socket_, [this](const Datagram& question) { answer(question); });
    std::vector<std::uint8_t> bytes;
    while (const auto datagram = next(in_)) take(*datagram, bytes);
    send_due();
    return bytes;
}

void NetworkPort::take(const Datagram& datagram, std::vector<std::uint8_t>& bytes) {
    const auto now = Clock::now();
    if (peer_ && now - heard_ > silence) peer_.reset();
    if (peer_ && !same(*peer_, datagram.who)) {
        ++counters_.refused;
        return;
    }
    if (last_peer_ && !same(*last_peer_, datagram.who)) board_.network_end();
    last_peer_ = peer_ = datagram.who;
    heard_ = now;
    ++counters_.accepted;
    bytes.insert(bytes.end(), datagram.bytes.begin(), datagram.bytes.end());
    if (!datagram.bytes.empty() && datagram.bytes.back() != 0) bytes.push_back(0);  // a frame ends with its datagram
}

/// Of the open port.
void NetworkPort::answer(const Datagram& question) {
    const std::vector<std::uint8_t>& asked = question.bytes;
    if (asked.size() != 4 || asked[0] != 'H' || asked[1] != 'G' || asked[3] != 0) return;
    const auto command = static_cast<Command>(asked[2]);
    if (command != Command::identify && command != Command::disable && command != Command::stop) return;
    if (command == Command::disable) board_.network_break();
    if (command == Command::stop) board_.network_stop();
    const bool held = peer_ && Clock::now() - heard_ <= silence;
    std::vector<std::uint8_t> answer = {'H', 'G', static_cast<std::uint8_t>(asked[2] | 0x80U),
                                        static_cast<std::uint8_t>((held ? 1 : 0) + (board_.present().enabled ? 2 : 0))};
    answer.insert(answer.end(), identity_.begin(), identity_.end());
    for (const std::uint16_t counter : {counters_.accepted, counters_.refused, counters_.damaged}) {
        answer.push_back(static_cast<std::uint8_t>(counter));
        answer.push_back(static_cast<std::uint8_t>(counter >> 8));
    }
    ::sendto(open_socket_, answer.data(), answer.size(), MSG_NOSIGNAL, reinterpret_cast<const sockaddr*>(&question.who),
             sizeof question.who);
}

void NetworkPort::write(std::span<const std::uint8_t> bytes) {
    replies_.insert(replies_.end(), bytes.begin(), bytes.end());
    while (true) {
        const auto most = replies_.begin() + static_cast<std::ptrdiff_t>(std::min(replies_.size(), reply_bytes));
        const auto last = std::find(std::make_reverse_iterator(most), replies_.rend(), 0).base();
        if (last == replies_.begin()) break;
        if (peer_) delay(out_, {{}, *peer_, {replies_.begin(), last}});
        replies_.erase(replies_.begin(), last);
    }
    send_due();
}

void NetworkPort::send_due() {
    while (const auto datagram = next(out_))
        ::sendto(socket_, datagram->bytes.data(), datagram->bytes.size(), MSG_NOSIGNAL,
                 reinterpret_cast<const sockaddr*>(&datagram->who), sizeof datagram->who);
}

}  // namespace haptogram::sim
