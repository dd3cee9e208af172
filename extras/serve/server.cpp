// SPDX-License-Identifier: Apache-2.0
#include "server.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <list>
#include <memory>
#include <optional>
#include <thread>

#include "haptogram/base/error.hpp"
#include "haptogram/base/notice.hpp"
#include "haptogram/base/text.hpp"

namespace haptogram::serve {
namespace {

namespace net = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using net::ip::tcp;
using net::ip::udp;
using Clock = std::chrono::steady_clock;

constexpr std::ptrdiff_t most_clients = 16;  // and as many strangers
constexpr std::size_t most_message_bytes = 16 << 20, most_header_bytes = 8192;
constexpr std::chrono::seconds handshake_time{5};  // all of it; asio's calls know no time
constexpr std::chrono::seconds silence{5};         // of a client that answers no ping, until it has gone
constexpr int look_ms = 100;                       // between two looks whether it is the end
constexpr double most_a_second = 200;  // requests of one client, but for foci; a second's worth may come at once

/// Lets through so many a second.
class Allowance {
public:
    bool take() {
        const auto now = Clock::now();
        left_ = std::min(most_a_second, left_ + most_a_second * std::chrono::duration<double>(now - last_).count());
        last_ = now;
        if (left_ < 1.0) return false;
        left_ -= 1.0;
        return true;
    }

private:
    double left_ = most_a_second;
    Clock::time_point last_ = Clock::now();
};

// A page cannot send the header Authorization, so it offers the token as a second subprotocol.
constexpr const char* subprotocol = "haptogram.1";

bool offers(const http::request<http::string_body>& request, const std::string& wanted) {
    const auto offered = http::token_list(request[http::field::sec_websocket_protocol]);
    return std::ranges::any_of(offered, [&](const auto& one) { return is_token({one.data(), one.size()}, wanted); });
}

/// Why a handshake is refused: a name of another site that leads to us, a page of another site, or no token.
std::optional<std::pair<http::status, std::string>> refusal(const http::request<http::string_body>& request,
                                                            const ServerOptions& options, std::uint16_t port) {
    const auto field = [&](http::field name) { return std::string(request[name].data(), request[name].size()); };
    const std::string host = field(http::field::host);
    const std::string names[] = {fmt::format("127.0.0.1:{}", port), fmt::format("localhost:{}", port)};
    if (request.count(http::field::host) != 1 || std::find(std::begin(names), std::end(names), host) == std::end(names))
        return {{http::status::misdirected_request, "this is no name of this service; use 127.0.0.1"}};
    const std::size_t origins = request.count(http::field::origin);
    if (origins > 1 ||
        (origins == 1 && std::ranges::find(options.origins, field(http::field::origin)) == options.origins.end()))
        return {{http::status::forbidden,
                 fmt::format("pages of '{}' are not let in; start the service with --origin and that",
                             field(http::field::origin))}};
    if (!websocket::is_upgrade(request)) return {{http::status::upgrade_required, "this is a WebSocket"}};
    if (!options.token.empty() && !is_token(field(http::field::authorization), "Bearer " + options.token) &&
        !(offers(request, subprotocol) && offers(request, "token." + options.token)))
        return {{http::status::unauthorized,
                 "the header Authorization needs 'Bearer' and the service's token; or the subprotocols are "
                 "'haptogram.1' and 'token.' with the token"}};
    return std::nullopt;
}

/// A client and its thread.
class Session {
public:
    Session(std::unique_ptr<net::io_context> context, tcp::socket socket, Verbs& verbs, const ServerOptions& options,
            std::uint16_t port, Verbs::Client client)
        : verbs_(verbs),
          options_(options),
          port_(port),
          client_(client),
          context_(std::move(context)),
          stream_(std::move(socket)) {
        thread_ = std::thread([this] {
            try {
                talk();
            } catch (const std::exception&) {  // the client went, or sent what is no WebSocket
            }
            verbs_.leave(client_);
            over_ = true;
        });
    }
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;
    ~Session() {
        hang_up();
        thread_.join();
    }

    [[nodiscard]] bool over() const { return over_; }
    /// Whether it has shown that it may be let in.
    [[nodiscard]] bool known() const { return stage_ == Stage::known; }
    /// Whether it has not yet, and may still.
    [[nodiscard]] bool stranger() const { return stage_ == Stage::stranger; }
    [[nodiscard]] Clock::time_point since() const { return since_; }
    /// Ends a stranger's session.
    void turn_away() {
        if (Stage expected = Stage::stranger; stage_.compare_exchange_strong(expected, Stage::turned_away)) hang_up();
    }

private:
    enum class Stage { stranger, known, turned_away };

    void hang_up() { ::shutdown(stream_.next_layer().native_handle(), SHUT_RDWR); }

    void talk() {
        tcp::socket& socket = stream_.next_layer();
        socket.set_option(tcp::no_delay(true));
        beast::flat_buffer buffer;
        http::request_parser<http::string_body> parser;
        parser.header_limit(most_header_bytes);
        parser.body_limit(most_header_bytes);
        http::read(socket, buffer, parser);
        const http::request<http::string_body> request = parser.release();
        if (const auto refused = refusal(request, options_, port_)) {
            http::response<http::string_body> response{refused->first, request.version()};
            response.body() = refused->second + "\n";
            response.prepare_payload();
            response.keep_alive(false);
            http::write(socket, response);
            return;
        }
        if (Stage expected = Stage::stranger; !stage_.compare_exchange_strong(expected, Stage::known)) return;
        stream_.read_message_max(most_message_bytes);
        if (offers(request, subprotocol))
            stream_.set_option(websocket::stream_base::decorator([](websocket::response_type& response) {
                response.set(http::field::sec_websocket_protocol, subprotocol);
            }));
        // Whoever drives and hangs must not keep the outputs on. Libraries answer a ping by themselves.
        stream_.set_option(websocket::stream_base::timeout{handshake_time, silence, true});
        finish([&](auto done) { stream_.async_accept(request, std::move(done)); });
        for (Allowance allowance;;) {
            beast::flat_buffer message;
            finish([&](auto done) {
                stream_.async_read(
                    message, [done = std::move(done)](beast::error_code error, std::size_t) mutable { done(error); });
            });
            take(message, allowance);
        }
    }

    /// Waits for what is begun, while pings come and go.
    template <class Begin>
    void finish(const Begin& begin) {
        bool over = false;
        beast::error_code error;
        begin([&](beast::error_code found) {
            over = true;
            error = found;
        });
        while (!over) {
            context_->restart();
            context_->run_one();
        }
        if (error) throw beast::system_error(error);
    }

    void take(const beast::flat_buffer& message, Allowance& allowance) {
        const auto* const data = static_cast<const char*>(message.data().data());
        if (stream_.got_binary()) {
            try {
                verbs_.focus({reinterpret_cast<const std::uint8_t*>(data), message.size()}, client_);
            } catch (const std::exception& error) {
                if (allowance.take()) send(failure(error));
            }
            return;
        }
        const std::string request(data, message.size());
        // A stop is never too much.
        if (!allowance.take() && !Verbs::ends(request))
            send(failure(bad_argument("request", fmt::format("more than {:.0f} a second; foci as binary messages are "
                                                             "not counted",
                                                             most_a_second))));
        else
            send(verbs_.answer(request, client_));
    }

    void send(const nlohmann::ordered_json& said) {
        stream_.text(true);
        const std::string text = said.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
        finish([&](auto done) {
            stream_.async_write(net::buffer(text), [done = std::move(done)](beast::error_code error,
                                                                            std::size_t) mutable { done(error); });
        });
    }

    Verbs& verbs_;
    const ServerOptions& options_;
    std::uint16_t port_;
    Verbs::Client client_;
    std::unique_ptr<net::io_context> context_;
    websocket::stream<tcp::socket> stream_;
    std::atomic<bool> over_ = false;
    std::atomic<Stage> stage_ = Stage::stranger;
    Clock::time_point since_ = Clock::now();
    std::thread thread_;
};

/// Whether one more may come in. Clients that are known have their places; a stranger's goes to the next who comes when
/// there are too many of them, the oldest first, so that nobody without the token can keep a client out.
bool has_room(std::list<Session>& sessions) {
    if (std::ranges::count_if(sessions, &Session::known) >= most_clients) return false;
    const auto oldest = std::ranges::find_if(sessions, &Session::stranger);
    if (std::ranges::count_if(sessions, &Session::stranger) >= most_clients) oldest->turn_away();
    return true;
}

/// Says what is wrong with datagrams, a line a second at most, because their senders cannot be told. Nobody is waited
/// for: a stop may be next.
class Complaints {
public:
    void tell(const std::string& trouble) {
        constexpr std::size_t most_bytes = 400;  // of what may be a stranger's
        if (Clock::now() - told_ < std::chrono::seconds(1)) return;
        told_ = Clock::now();
        write_within(STDERR_FILENO, printable("haptogram: " + trouble, most_bytes) + "\n");
    }

    /// Said once.
    void tell_of_time(std::uint16_t port) {
        if (std::exchange(told_of_time_, true)) return;
        write_within(STDERR_FILENO,
                     fmt::format("haptogram: a bundle from port {} has a time tag; times are not kept, and "
                                 "what it says is done at once; send it when it is due\n",
                                 port));
    }

private:
    Clock::time_point told_{};
    bool told_of_time_ = false;
};

/// Takes what datagrams wait.
void take_datagrams(udp::socket& socket, Verbs& verbs, Complaints& complaints) {
    std::array<std::uint8_t, 65536> bytes{};
    for (boost::system::error_code error;;) {
        udp::endpoint from;
        const std::size_t count = socket.receive_from(net::buffer(bytes), from, 0, error);
        if (error) break;
        try {
            for (const OscMessage& message : parse_osc({bytes.data(), count})) {
                if (message.timed) complaints.tell_of_time(from.port());
                verbs.act(message, Verbs::osc(from.address().to_v4().to_uint(), from.port()));
            }
        } catch (const std::exception& trouble) {
            complaints.tell(fmt::format("a datagram from port {}: {}", from.port(), trouble.what()));
        }
    }
    if (const std::string trouble = verbs.take_trouble(); !trouble.empty()) complaints.tell(trouble);
}

template <class Socket, class Protocol>
void bind_loopback(Socket& socket, std::uint16_t port, const char* setting) {
    try {
        socket.open(Protocol::v4());
        if constexpr (std::is_same_v<Socket, tcp::acceptor>) socket.set_option(net::socket_base::reuse_address(true));
        socket.bind({net::ip::address_v4::loopback(), port});
    } catch (const boost::system::system_error& error) {
        throw bad_argument(setting, fmt::format("port {}: {}; take another", port, error.code().message()));
    }
}

}  // namespace

void run(Verbs& verbs, const ServerOptions& options, const std::function<void(std::uint16_t)>& listening,
         const std::function<bool()>& go_on) {
    net::io_context context;
    tcp::acceptor door(context);
    bind_loopback<tcp::acceptor, tcp>(door, options.port, "port");
    door.listen();
    door.non_blocking(true);
    udp::socket datagrams(context);
    if (options.osc_port != 0) {
        bind_loopback<udp::socket, udp>(datagrams, options.osc_port, "osc");
        datagrams.non_blocking(true);
    }
    const std::uint16_t port = door.local_endpoint().port();
    listening(port);
    std::list<Session> sessions;
    std::array<pollfd, 2> waits{
        {{door.native_handle(), POLLIN, 0}, {options.osc_port != 0 ? datagrams.native_handle() : -1, POLLIN, 0}}};
    Complaints complaints;
    for (Verbs::Client next = 1; go_on();) {
        ::poll(waits.data(), waits.size(), look_ms);
        if (options.osc_port != 0) take_datagrams(datagrams, verbs, complaints);
        verbs.expire();
        for (Session& session : sessions)
            if (Clock::now() - session.since() > handshake_time) session.turn_away();
        sessions.remove_if([](const Session& session) { return session.over(); });
        boost::system::error_code error;
        auto own = std::make_unique<net::io_context>(1);
        tcp::socket socket(*own);
        door.accept(socket, error);
        if (error) {
            // There is somebody, and no descriptor for him: he is still there at once.
            if (error != net::error::would_block) std::this_thread::sleep_for(std::chrono::milliseconds(look_ms));
            continue;
        }
        socket.non_blocking(false);
        if (has_room(sessions)) sessions.emplace_back(std::move(own), std::move(socket), verbs, options, port, next++);
    }
}

}  // namespace haptogram::serve
