// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/udp_port.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <charconv>
#include <thread>
#include <utility>
#ifndef _WIN32
#include <ifaddrs.h>
#include <net/if.h>
#endif

#include "haptogram/base/error.hpp"

namespace haptogram::link {
namespace asio = boost::asio;
using asio::ip::udp;
using boost::system::error_code;
namespace {

using interface::Command;

constexpr std::string_view scheme = "udp:";
constexpr std::array<std::uint8_t, 2> letters = {'H', 'G'};
constexpr std::size_t identity_bytes = 2 * std::size_t{interface::identity_words};

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

using Datagram = std::array<std::uint8_t, 65536>;

/// What a port that nobody listens at is told by its own machine; a board may start there yet.
bool means_nobody(const error_code& error) {
    return error == asio::error::connection_refused || error == asio::error::connection_reset;
}

/// Networks to which a question to all can go, and this machine.
std::vector<asio::ip::address_v4> everybody() {
    std::vector<asio::ip::address_v4> found = {asio::ip::address_v4::loopback()};
#ifdef _WIN32
    found.push_back(asio::ip::address_v4::broadcast());
#else
    ifaddrs* all = nullptr;
    if (::getifaddrs(&all) != 0) return found;
    for (const ifaddrs* one = all; one != nullptr; one = one->ifa_next)
        if (one->ifa_addr != nullptr && one->ifa_addr->sa_family == AF_INET && (one->ifa_flags & IFF_BROADCAST) != 0 &&
            (one->ifa_flags & IFF_UP) != 0 && one->ifa_broadaddr != nullptr)
            found.emplace_back(ntohl(reinterpret_cast<const sockaddr_in*>(one->ifa_broadaddr)->sin_addr.s_addr));
    ::freeifaddrs(all);
#endif
    return found;
}

}  // namespace

/// A socket that waits only where it is asked to.
struct UdpPort::Socket {
    asio::io_context context;
    udp::socket socket{context};
    udp::endpoint from;

    void open() {
        socket.open(udp::v4());
        socket.non_blocking(true);
    }
    /// The next datagram's bytes, into `to`; none when an error says why.
    [[nodiscard]] std::size_t receive(Datagram& to, error_code& error) {
        return socket.receive_from(asio::buffer(to), from, 0, error);
    }
    [[nodiscard]] bool wait(std::chrono::microseconds patience) {
        if (socket.available() > 0) return true;
        bool ready = false;
        context.restart();
        socket.async_wait(udp::socket::wait_read, [&ready](const error_code& error) { ready = !error; });
        context.run_for(patience);
        if (context.stopped()) return ready;
        socket.cancel();
        context.run();
        return ready;
    }
};

struct UdpPort::Sockets {
    Socket frames, open;
    udp::endpoint at_open_port;

    /// From a port of its own, which answers to earlier questions do not reach.
    void ask_anew() {
        error_code ignored;
        open.socket.close(ignored);
        open.open();
        open.socket.connect(at_open_port);
    }
};

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

UdpPort::UdpPort(const std::string& name) : name_(name), sockets_(std::make_unique<Sockets>()) {
    const Target target = target_of(name);
    error_code error;
    const auto found = udp::resolver(sockets_->frames.context).resolve(udp::v4(), target.host, "", error);
    if (error)
        throw Error(ErrorCode::device, name,
                    fmt::format("there is no address {}: {}; 'haptogram device list --net' shows the boards",
                                target.host, error.message()));
    try {
        udp::endpoint to = *found.begin();
        to.port(target.port);
        sockets_->frames.open();
        sockets_->frames.socket.connect(to);
        sockets_->at_open_port = to;
        sockets_->at_open_port.port(static_cast<std::uint16_t>(target.port + 1));
        sockets_->ask_anew();
    } catch (const boost::system::system_error& no) {
        throw Error(ErrorCode::device, name, fmt::format("there is no way to it: {}", no.code().message()));
    }
}

UdpPort::~UdpPort() {
    try {
        flush();
    } catch (const Error&) {  // nobody can be told any more
    }
}

/// A datagram that does not go out is lost like any other. Nobody listening, which only this machine tells, may be a
/// board that starts yet: the session finds out.
void UdpPort::send(Socket& to, std::span<const std::uint8_t> bytes) {
    error_code error;
    to.socket.send(asio::buffer(bytes.data(), bytes.size()), 0, error);
    if (error && !means_nobody(error) && error != asio::error::would_block && error != asio::error::no_buffer_space &&
        error != asio::error::interrupted)
        throw LinkLost(name_, fmt::format("nothing can be sent: {}; is the network's cable in?", error.message()));
}

void UdpPort::flush() {
    if (!waiting_.empty()) send(sockets_->frames, std::exchange(waiting_, {}));
}

void UdpPort::write(std::span<const std::uint8_t> bytes) {
    if (waiting_.size() + bytes.size() > interface::network::datagram_bytes) flush();
    waiting_.insert(waiting_.end(), bytes.begin(), bytes.end());
}

std::vector<std::uint8_t> UdpPort::read(std::chrono::microseconds patience) {
    flush();
    if (!sockets_->frames.wait(patience)) return {};
    Datagram datagram;
    std::vector<std::uint8_t> all;
    error_code error;
    for (;;) {
        const std::size_t count = sockets_->frames.receive(datagram, error);
        if (error) break;
        all.insert(all.end(), datagram.begin(), datagram.begin() + static_cast<std::ptrdiff_t>(count));
    }
    if (error != asio::error::would_block && !means_nobody(error) && error != asio::error::interrupted)
        throw LinkLost(name_, fmt::format("nothing can be received: {}", error.message()));
    // Nobody listens on this machine, which is known at once, so the patience is waited for here.
    if (all.empty() && means_nobody(error))
        std::this_thread::sleep_for(std::min<std::chrono::microseconds>(patience, std::chrono::milliseconds(20)));
    return all;
}

/// What the board has answered to an earlier question says nothing about its outputs now.
void UdpPort::send_break() {
    flush();
    sockets_->ask_anew();
    off_ = false;
    ask_off();
    send(sockets_->open, open_question(Command::stop));
}

void UdpPort::ask_off() {
    send(sockets_->open, open_question(Command::disable));
    asked_off_ = machine_clock().now();
}

/// A copy goes out only when an answer is overdue, so that few are under way behind the answer.
bool UdpPort::break_has_acted() {
    if (!asked_off_ || off_) return off_;
    off_ = open_answer(Command::disable, std::chrono::microseconds(0)).has_value();
    if (!off_ && machine_clock().now() - *asked_off_ >= patience()) ask_off();
    return off_;
}

std::optional<AboutBoard> UdpPort::open_answer(Command command, std::chrono::microseconds patience) {
    const Clock::Time until = machine_clock().now() + patience;
    do {
        const auto left = std::chrono::duration_cast<std::chrono::microseconds>(until - machine_clock().now());
        if (!sockets_->open.wait(std::max(left, std::chrono::microseconds(0)))) return {};
        Datagram datagram;
        error_code error;
        const std::size_t count = sockets_->open.receive(datagram, error);
        if (error) return {};
        if (auto about = to_about({datagram.data(), count}, command)) {
            about->port = name_;
            return about;
        }
    } while (true);
}

std::optional<AboutBoard> UdpPort::ask(std::chrono::microseconds patience) {
    send(sockets_->open, open_question(Command::identify));
    return open_answer(Command::identify, patience);
}

std::string UdpPort::why_silent() {
    const auto about = ask(std::chrono::milliseconds(50));
    if (!about)
        return "a board that has just got power needs some seconds for its link: try again, or check the network's "
               "cable and the address; 'haptogram device list --net' shows the boards";
    if (about->held)
        return "the board is there, but another program holds it until that has been silent for a second; 'haptogram "
               "device disable' works for anybody";
    return "the board is there and free, but does not answer; try again";
}

std::vector<AboutBoard> boards_of_networks(std::chrono::milliseconds patience) {
    UdpPort::Socket socket;
    try {
        socket.open();
        socket.socket.set_option(asio::socket_base::broadcast(true));
    } catch (const boost::system::system_error& no) {
        throw Error(ErrorCode::device, "udp", fmt::format("the system gives no socket: {}", no.code().message()));
    }
    const std::vector<std::uint8_t> question = open_question(Command::identify);
    for (const asio::ip::address_v4& to : everybody()) {
        error_code ignored;
        socket.socket.send_to(asio::buffer(question), {to, interface::network::open_port}, 0, ignored);
    }
    std::vector<AboutBoard> boards;
    const auto until = std::chrono::steady_clock::now() + patience;
    for (auto now = until - patience; now < until; now = std::chrono::steady_clock::now()) {
        if (!socket.wait(std::chrono::duration_cast<std::chrono::microseconds>(until - now))) break;
        Datagram datagram;
        error_code error;
        const std::size_t count = socket.receive(datagram, error);
        if (error) continue;
        auto about = to_about({datagram.data(), count}, Command::identify);
        if (!about) continue;
        about->port = fmt::format("udp:{}", socket.from.address().to_string());
        if (std::ranges::find(boards, about->port, &AboutBoard::port) == boards.end()) boards.push_back(*about);
    }
    std::ranges::sort(boards, {}, &AboutBoard::port);
    return boards;
}

}  // namespace haptogram::link
