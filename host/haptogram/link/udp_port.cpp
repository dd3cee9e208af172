// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/udp_port.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netdb.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <system_error>
#include <utility>

#include "haptogram/base/error.hpp"

namespace haptogram::link {
namespace {

using interface::Command;

constexpr std::string_view scheme = "udp:";
constexpr std::array<std::uint8_t, 2> letters = {'H', 'G'};
constexpr std::size_t identity_bytes = 2 * std::size_t{interface::identity_words};

std::string reason() { return std::generic_category().message(errno); }

Error wrong_name(const std::string& name) {
    return {ErrorCode::bad_argument, name,
            "expected udp:ADDRESS or udp:ADDRESS:PORT, such as udp:169.254.71.1, with a port from 1 to 65534; tiles "
            "of a network have an address each"};
}

struct Target {
    std::string host;
    std::uint16_t port = interface::network::port;
};

Target target_of(const std::string& name) {
    if (!names_udp(name) || name.find('#') != std::string::npos) throw wrong_name(name);
    const std::string rest = name.substr(scheme.size());
    const std::size_t colon = rest.find(':');
    Target target{rest.substr(0, colon)};
    if (target.host.empty()) throw wrong_name(name);
    if (colon == std::string::npos) return target;
    const char *const begin = rest.data() + colon + 1, *const end = rest.data() + rest.size();
    const auto [last, error] = std::from_chars(begin, end, target.port);
    if (error != std::errc() || last != end || target.port == 0 || target.port == 65535) throw wrong_name(name);
    return target;
}

sockaddr_in address_of(const std::string& name, const Target& target) {
    addrinfo hints{};
    hints.ai_family = AF_INET;
    hints.ai_socktype = SOCK_DGRAM;
    addrinfo* found = nullptr;
    if (const int error = ::getaddrinfo(target.host.c_str(), nullptr, &hints, &found); error != 0)
        throw Error(ErrorCode::device, name,
                    fmt::format("there is no address {}: {}; 'haptogram device list --net' shows the boards",
                                target.host, ::gai_strerror(error)));
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr = reinterpret_cast<const sockaddr_in*>(found->ai_addr)->sin_addr;
    address.sin_port = htons(target.port);
    ::freeaddrinfo(found);
    return address;
}

int connected_socket(const std::string& name, sockaddr_in address, std::uint16_t port) {
    address.sin_port = htons(port);
    const int socket = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (socket < 0 || ::connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
        const std::string why = reason();
        if (socket >= 0) ::close(socket);
        throw Error(ErrorCode::device, name, fmt::format("there is no way to it: {}", why));
    }
    return socket;
}

bool readable(int socket, std::chrono::microseconds patience) {
    pollfd wait{socket, POLLIN, 0};
    const timespec most{patience.count() / 1'000'000, patience.count() % 1'000'000 * 1'000};
    return ::ppoll(&wait, 1, &most, nullptr) > 0;
}

using Datagram = std::array<std::uint8_t, 65536>;

/// Networks to which a question to all can go, and this machine.
std::vector<in_addr> everybody() {
    std::vector<in_addr> found(1);
    found.front().s_addr = htonl(INADDR_LOOPBACK);
    ifaddrs* all = nullptr;
    if (::getifaddrs(&all) != 0) return found;
    for (const ifaddrs* one = all; one != nullptr; one = one->ifa_next)
        if (one->ifa_addr != nullptr && one->ifa_addr->sa_family == AF_INET && (one->ifa_flags & IFF_BROADCAST) != 0 &&
            (one->ifa_flags & IFF_UP) != 0 && one->ifa_broadaddr != nullptr)
            found.push_back(reinterpret_cast<const sockaddr_in*>(one->ifa_broadaddr)->sin_addr);
    ::freeifaddrs(all);
    return found;
}

}  // namespace

bool names_udp(std::string_view name) { return name.starts_with(scheme); }

std::vector<std::uint8_t> open_question(Command command) {
    return {letters[0], letters[1], static_cast<std::uint8_t>(command), 0};
}

std::optional<AboutBoard> to_about(std::span<const std::uint8_t> answer, Command command) {
    constexpr std::size_t head = 4, counters = 3;
    if (answer.size() != head + identity_bytes + 2 * counters || !std::ranges::equal(answer.first(2), letters) ||
        answer[2] != (static_cast<std::uint8_t>(command) | 0x80U))
        return {};
    const auto word = [&](std::size_t place) {
        return static_cast<std::uint16_t>(answer[place] | answer[place + 1] << 8);
    };
    constexpr std::size_t counted = head + identity_bytes;
    return AboutBoard{"",
                      to_identity({answer.begin() + head, answer.begin() + head + identity_bytes}),
                      (answer[3] & 1U) != 0,
                      (answer[3] & 2U) != 0,
                      word(counted),
                      word(counted + 2),
                      word(counted + 4)};
}

UdpPort::UdpPort(const std::string& name) : name_(name) {
    const Target target = target_of(name);
    const sockaddr_in address = address_of(name, target);
    socket_ = connected_socket(name, address, target.port);
    try {
        open_socket_ = connected_socket(name, address, static_cast<std::uint16_t>(target.port + 1));
    } catch (...) {
        ::close(socket_);
        throw;
    }
}

UdpPort::~UdpPort() {
    try {
        flush();
    } catch (const Error&) {  // nobody can be told any more
    }
    ::close(open_socket_);
    ::close(socket_);
}

/// A datagram that does not go out is lost like any other. Nobody listening, which only this machine tells, may be a
/// board that starts yet: the session finds out.
void UdpPort::send(int socket, std::span<const std::uint8_t> bytes) {
    if (::send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL) >= 0) return;
    if (errno != ECONNREFUSED && errno != EAGAIN && errno != ENOBUFS && errno != EINTR)
        throw LinkLost(name_, fmt::format("nothing can be sent: {}; is the network's cable in?", reason()));
}

void UdpPort::flush() {
    if (!waiting_.empty()) send(socket_, std::exchange(waiting_, {}));
}

void UdpPort::write(std::span<const std::uint8_t> bytes) {
    if (waiting_.size() + bytes.size() > interface::network::datagram_bytes) flush();
    waiting_.insert(waiting_.end(), bytes.begin(), bytes.end());
}

std::vector<std::uint8_t> UdpPort::read(std::chrono::microseconds patience) {
    flush();
    if (!readable(socket_, patience)) return {};
    Datagram datagram;
    std::vector<std::uint8_t> all;
    for (ssize_t count = 0; (count = ::recv(socket_, datagram.data(), datagram.size(), 0)) >= 0;)
        all.insert(all.end(), datagram.begin(), datagram.begin() + count);
    if (errno != EAGAIN && errno != ECONNREFUSED && errno != EINTR)
        throw LinkLost(name_, fmt::format("nothing can be received: {}", reason()));
    // Nobody listens on this machine: poll() says so at once, so the patience is waited for here.
    if (all.empty() && errno == ECONNREFUSED)
        ::usleep(static_cast<useconds_t>(std::min<long>(patience.count(), 20'000)));
    return all;
}

void UdpPort::send_break() {
    flush();
    off_asked_ = true;
    off_ = false;
    send(open_socket_, open_question(Command::disable));
    send(open_socket_, open_question(Command::stop));
}

bool UdpPort::break_has_acted() {
    if (!off_asked_ || off_) return off_;
    off_ = open_answer(Command::disable, std::chrono::microseconds(0)).has_value();
    if (!off_) send(open_socket_, open_question(Command::disable));
    return off_;
}

std::optional<AboutBoard> UdpPort::open_answer(Command command, std::chrono::microseconds patience) {
    const auto until = now() + patience;
    do {
        const auto left = std::chrono::duration_cast<std::chrono::microseconds>(until - now());
        if (!readable(open_socket_, std::max(left, std::chrono::microseconds(0)))) return {};
        Datagram datagram;
        const ssize_t count = ::recv(open_socket_, datagram.data(), datagram.size(), 0);
        if (count < 0) return {};
        if (auto about = to_about({datagram.data(), static_cast<std::size_t>(count)}, command)) {
            about->port = name_;
            return about;
        }
    } while (true);
}

std::optional<AboutBoard> UdpPort::ask(std::chrono::microseconds patience) {
    send(open_socket_, open_question(Command::identify));
    return open_answer(Command::identify, patience);
}

std::string UdpPort::why_silent() {
    const auto about = ask(std::chrono::milliseconds(50));
    if (!about) return "check the network's cable and the address; 'haptogram device list --net' shows the boards";
    if (about->held)
        return "the board is there, but another program holds it until that has been silent for a second; 'haptogram "
               "device disable' works for anybody";
    return "the board is there and free, but does not answer; try again";
}

std::vector<AboutBoard> boards_of_networks(std::chrono::milliseconds patience) {
    const int socket = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    const int on = 1;
    if (socket < 0 || ::setsockopt(socket, SOL_SOCKET, SO_BROADCAST, &on, sizeof on) != 0)
        throw Error(ErrorCode::device, "udp", fmt::format("the system gives no socket: {}", reason()));
    const std::vector<std::uint8_t> question = open_question(Command::identify);
    for (const in_addr& to : everybody()) {
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_addr = to;
        address.sin_port = htons(interface::network::open_port);
        static_cast<void>(::sendto(socket, question.data(), question.size(), 0,
                                   reinterpret_cast<const sockaddr*>(&address), sizeof address));
    }
    std::vector<AboutBoard> boards;
    const auto until = std::chrono::steady_clock::now() + patience;
    for (auto now = until - patience; now < until; now = std::chrono::steady_clock::now()) {
        if (!readable(socket, std::chrono::duration_cast<std::chrono::microseconds>(until - now))) break;
        Datagram datagram;
        sockaddr_in from{};
        socklen_t size = sizeof from;
        const ssize_t count =
            ::recvfrom(socket, datagram.data(), datagram.size(), 0, reinterpret_cast<sockaddr*>(&from), &size);
        if (count < 0) continue;
        auto about = to_about({datagram.data(), static_cast<std::size_t>(count)}, Command::identify);
        if (!about) continue;
        std::array<char, INET_ADDRSTRLEN> text{};
        ::inet_ntop(AF_INET, &from.sin_addr, text.data(), text.size());
        about->port = fmt::format("udp:{}", text.data());
        if (std::ranges::find(boards, about->port, &AboutBoard::port) == boards.end()) boards.push_back(*about);
    }
    ::close(socket);
    std::ranges::sort(boards, {}, &AboutBoard::port);
    return boards;
}

}  // namespace haptogram::link
