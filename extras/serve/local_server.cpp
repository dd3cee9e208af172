// SPDX-License-Identifier: Apache-2.0
#include "local_server.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <deque>
#include <exception>
#include <limits>
#include <list>
#include <optional>
#include <string_view>
#include <variant>

#include "haptogram/base/error.hpp"
#include "haptogram/base/text.hpp"

namespace haptogram::serve {
namespace {

namespace net = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using net::ip::tcp;
using Clock = std::chrono::steady_clock;
using Socket = websocket::stream<beast::tcp_stream>;

// Of a client that has shown its token; of any other, in taking an answer.
constexpr std::chrono::seconds most_pause{30};
constexpr std::chrono::seconds stranger_pause{5};     // of any other, until its request is whole
constexpr std::size_t most_queued = 8 * 1024 * 1024;  // bytes for a page that takes nothing
constexpr std::chrono::seconds most_stalled{5};       // of a page that has so many waiting

std::string text(beast::string_view view) { return {view.data(), view.size()}; }

RequestHead head_of(const http::request_header<>& header, std::optional<std::uint64_t> length, bool upgrade) {
    return {text(header.method_string()),
            text(header.target()),
            text(header[http::field::host]),
            text(header[http::field::origin]),
            text(header["Sec-Fetch-Site"]),
            text(header["Sec-Fetch-Mode"]),
            text(header["Sec-Fetch-Dest"]),
            text(header[http::field::authorization]),
            text(header[http::field::sec_websocket_protocol]),
            length,
            upgrade,
            std::max(header.count(http::field::host), header.count(http::field::origin))};
}

http::response<http::string_body> response_of(Answer answer, bool head_only, bool keep_alive) {
    http::response<http::string_body> response{http::int_to_status(answer.status), 11};
    for (const Header& each : answer_headers)
        response.set(beast::string_view(each.name.data(), each.name.size()),
                     beast::string_view(each.value.data(), each.value.size()));
    response.set(http::field::content_type, answer.type);
    if (answer.gzip) response.set(http::field::content_encoding, "gzip");
    response.keep_alive(keep_alive);
    response.content_length(answer.body.size());
    if (!head_only) response.body() = std::move(answer.body);
    return response;
}

/// A page's WebSocket. All of it happens in the server's thread but send() and close(), which go there.
class OpenPage final : public Page, public std::enable_shared_from_this<OpenPage> {
public:
    OpenPage(Socket socket, std::uint64_t number) : socket_(std::move(socket)), number_(number) {}

    [[nodiscard]] std::uint64_t number() const override { return number_; }
    [[nodiscard]] const std::string& trouble() const override { return trouble_; }
    void send(std::string message) override { queue(std::move(message)); }
    void send(std::vector<std::uint8_t> bulk) override { queue(std::move(bulk)); }
    void close(const std::string& reason) override {
        net::post(socket_.get_executor(), [self = shared_from_this(), reason = close_reason(reason)] {
            self->socket_.async_close({websocket::close_code::policy_error, reason}, [self](beast::error_code) {});
        });
    }

    net::awaitable<void> read(const Server::Callbacks& callbacks) {
        for (;;) {
            beast::flat_buffer buffer;
            co_await socket_.async_read(buffer, net::use_awaitable);
            const auto& take = socket_.got_text() ? callbacks.message : callbacks.bytes;
            if (take)
                take(*this, beast::buffers_to_string(buffer.data()));
            else
                close("messages to the studio are text");
        }
    }

private:
    using Item = std::variant<std::string, std::vector<std::uint8_t>>;

    void queue(Item item) {
        net::post(socket_.get_executor(), [self = shared_from_this(), item = std::move(item)]() mutable {
            if (!self->trouble_.empty()) return;
            const std::size_t size = std::visit([](const auto& each) { return each.size(); }, item);
            if (self->queued_ + size > most_queued && !self->items_.empty()) {
                if (std::holds_alternative<std::vector<std::uint8_t>>(item)) return;
                if (Clock::now() - self->writes_since_ > most_stalled) return self->give_up();
            }
            self->queued_ += size;
            self->items_.push_back(std::move(item));
            if (self->items_.size() == 1) self->write();
        });
    }
    /// No closing handshake: that would wait behind what the page does not take.
    void give_up() {
        trouble_ = fmt::format("its page has taken nothing for {} s, and {} bytes waited for it", most_stalled.count(),
                               queued_);
        socket_.next_layer().close();
    }
    void write() {
        writes_since_ = Clock::now();
        const Item& item = items_.front();
        socket_.text(std::holds_alternative<std::string>(item));
        const net::const_buffer bytes = std::visit([](const auto& each) { return net::buffer(each); }, item);
        socket_.async_write(bytes, [self = shared_from_this()](beast::error_code error, std::size_t) {
            if (error) return;  // reading ends then, too
            self->queued_ -= std::visit([](const auto& each) { return each.size(); }, self->items_.front());
            self->items_.pop_front();
            if (!self->items_.empty()) self->write();
        });
    }

    Socket socket_;
    std::uint64_t number_;
    std::deque<Item> items_;
    std::size_t queued_ = 0;
    Clock::time_point writes_since_{};  // the first of the items
    std::string trouble_;
};

}  // namespace

std::string close_reason(std::string_view message) {
    constexpr std::size_t room = 123;
    return printable(std::string_view(message).substr(0, room));
}

class Server::Inside {
public:
    Inside(std::initializer_list<std::uint16_t> ports, const char* setting, const Limits& limits)
        : limits_(limits), acceptor_(context_), ticker_(context_) {
        beast::error_code error;
        for (const std::uint16_t port : ports)
            if (error = listen(port); !error) return;
        throw bad_argument(setting, fmt::format("port {} cannot be listened at: {}; take another", *(ports.end() - 1),
                                                error.message()));
    }

    [[nodiscard]] std::uint16_t port() const { return acceptor_.local_endpoint().port(); }

    void run(const Access& access, Callbacks callbacks) {
        access_ = access;
        callbacks_ = std::move(callbacks);
        net::co_spawn(context_, accept(), net::detached);
        net::co_spawn(context_, tick(), [](std::exception_ptr error) {
            if (error) std::rethrow_exception(error);
        });
        context_.run();
    }

    void post(std::function<void()> work) { net::post(context_, std::move(work)); }

private:
    beast::error_code listen(std::uint16_t port) {
        const tcp::endpoint place(net::ip::address_v4::loopback(), port);
        beast::error_code error;
        if (acceptor_.is_open()) acceptor_.close();
        acceptor_.open(place.protocol());
        acceptor_.set_option(net::socket_base::reuse_address(true));
        acceptor_.bind(place, error);
        if (!error) acceptor_.listen(net::socket_base::max_listen_connections, error);
        return error;
    }

    net::awaitable<void> tick() {
        while (callbacks_.tick()) {
            ticker_.expires_after(tick_pause);
            co_await ticker_.async_wait(net::use_awaitable);
        }
        context_.stop();
    }

    net::awaitable<void> accept() {
        for (;;) {
            beast::error_code error;
            tcp::socket socket = co_await acceptor_.async_accept(net::redirect_error(net::use_awaitable, error));
            if (error) {  // such as too many open files
                net::steady_timer pause(context_, tick_pause);
                co_await pause.async_wait(net::use_awaitable);
                continue;
            }
            net::co_spawn(context_, connection(std::move(socket)), net::detached);
        }
    }

    /// One that has not yet shown a token, whether it is waited for or takes an answer. When there are too many, the
    /// one that came first is let go.
    class Stranger {
    public:
        Stranger(std::list<beast::tcp_stream*>& all, beast::tcp_stream* stream) : all_(all), stream_(stream) {
            if (all_.size() >= most_strangers) {
                all_.front()->close();  // what it waits for ends with an error
                all_.pop_front();
            }
            all_.push_back(stream_);
        }
        Stranger(const Stranger&) = delete;
        Stranger& operator=(const Stranger&) = delete;
        ~Stranger() { all_.remove(stream_); }

    private:
        std::list<beast::tcp_stream*>& all_;
        beast::tcp_stream* stream_;
    };

    net::awaitable<void> connection(tcp::socket socket) {
        ++connections_;
        try {
            beast::tcp_stream stream(std::move(socket));
            stream.socket().set_option(tcp::no_delay(true));
            co_await requests(std::move(stream));
        } catch (const std::exception&) {
            // The client is gone, or spoke no HTTP and was told so.
        }
        --connections_;
    }

    net::awaitable<void> answer(beast::tcp_stream& stream, Answer answer, bool head_only, bool keep_alive) {
        const auto response = response_of(std::move(answer), head_only, keep_alive);
        co_await http::async_write(stream, response, net::use_awaitable);
    }

    net::awaitable<void> requests(beast::tcp_stream stream) {
        beast::flat_buffer buffer;
        std::optional<Stranger> stranger(std::in_place, strangers_, &stream);
        for (bool known = false;;) {
            stream.expires_after(known ? most_pause : stranger_pause);
            http::request_parser<http::string_body> parser;
            parser.header_limit(most_header_bytes);
            // refuse() knows the limit, and has an answer. Boost 1.74 takes "none" for 0.
            parser.body_limit(std::numeric_limits<std::uint64_t>::max());
            beast::error_code error;
            co_await http::async_read_header(stream, buffer, parser, net::redirect_error(net::use_awaitable, error));
            if (error == http::error::header_limit) {
                co_await answer(stream, error_answer(431, "the header is too long"), false, false);
                co_return;
            }
            if (error.category() == http::make_error_code(http::error::bad_method).category() &&
                error != http::error::end_of_stream && error != http::error::partial_message) {
                co_await answer(stream, error_answer(400, "this is no HTTP"), false, false);
                co_return;
            }
            if (error) co_return;
            const auto& header = parser.get();
            std::optional<std::uint64_t> length;
            if (parser.content_length()) length = *parser.content_length();
            const bool upgrade = websocket::is_upgrade(header);
            const RequestHead head = head_of(header, length, upgrade);
            std::optional<Refusal> refusal = refuse(head, access_);
            known = known || (!refusal && (upgrade || head.target.starts_with("/api/")));
            if (known) stranger.reset();
            const bool crowded = connections_ - strangers_.size() > most_connections;
            if (!refusal && crowded && !is_stop(head)) refusal = Refusal{503, "too many connections; close some"};
            if (!refusal && upgrade && pages_ >= limits_.pages) refusal = Refusal{503, "too many pages; close some"};
            if (refusal) {
                co_await answer(stream, error_answer(refusal->status, refusal->message), false, false);
                co_return;
            }
            if (upgrade) {
                const auto request = parser.release();
                co_await page(std::move(stream), request);
                co_return;
            }
            parser.body_limit(most_body_bytes);
            co_await http::async_read(stream, buffer, parser, net::redirect_error(net::use_awaitable, error));
            if (error == http::error::body_limit) {
                co_await answer(stream, error_answer(413, "the body is longer than the studio takes"), false, false);
                co_return;
            }
            if (error) co_return;
            auto request = parser.release();
            const bool keep_alive = request.keep_alive(), head_only = request.method() == http::verb::head;
            // A picture may take its time, but only who has a token can ask for one.
            if (known)
                stream.expires_never();
            else
                stream.expires_after(most_pause);
            co_await answer(stream, co_await answer_to(request), head_only, keep_alive);
            if (!keep_alive) co_return;
        }
    }

    /// Waits for the reply, which may come from another thread, and comes once.
    net::awaitable<Answer> answer_to(http::request<http::string_body>& request) {
        struct Waiting {
            explicit Waiting(net::io_context& context) : timer(context, net::steady_timer::time_point::max()) {}
            net::steady_timer timer;  // cancelled when the answer is there
            std::optional<Answer> answer;
        };
        const auto waiting = std::make_shared<Waiting>(context_);
        const Reply reply = [this, waiting](Answer answer) {
            net::post(context_, [waiting, answer = std::move(answer)]() mutable {
                waiting->answer = std::move(answer);
                waiting->timer.cancel();
            });
        };
        hand_over(request, reply);
        while (!waiting->answer) {
            beast::error_code cancelled;
            co_await waiting->timer.async_wait(net::redirect_error(net::use_awaitable, cancelled));
        }
        co_return std::move(*waiting->answer);
    }

    void hand_over(http::request<http::string_body>& request, const Reply& reply) {
        const std::string target = text(request.target());
        const std::size_t end = std::min(target.find('?'), target.size());
        const bool gzip = text(request[http::field::accept_encoding]).find("gzip") != std::string::npos;
        try {
            callbacks_.request({text(request.method_string()), target.substr(0, end),
                                target.substr(std::min(end + 1, target.size())), std::move(request.body()), gzip},
                               reply);
        } catch (const Error& error) {
            reply(error_answer(422, error.what()));
        } catch (const std::exception& error) {
            reply(error_answer(500, error.what()));
        }
    }

    net::awaitable<void> page(beast::tcp_stream stream, http::request<http::string_body> request) {
        stream.expires_never();
        Socket socket(std::move(stream));
        websocket::stream_base::timeout timeout = websocket::stream_base::timeout::suggested(beast::role_type::server);
        timeout.idle_timeout = limits_.silence;
        timeout.keep_alive_pings = true;
        socket.set_option(timeout);
        if (offers_subprotocol(text(request[http::field::sec_websocket_protocol])))
            socket.set_option(websocket::stream_base::decorator([](websocket::response_type& response) {
                response.set(http::field::sec_websocket_protocol,
                             beast::string_view(subprotocol.data(), subprotocol.size()));
            }));
        socket.read_message_max(limits_.message_bytes);
        socket.write_buffer_bytes(256 * 1024);
        socket.auto_fragment(false);
        co_await socket.async_accept(request, net::use_awaitable);
        const auto opened = std::make_shared<OpenPage>(std::move(socket), ++number_);
        ++pages_;
        callbacks_.opened(opened);
        try {
            co_await opened->read(callbacks_);
        } catch (const std::exception&) {
            // It was closed, by whomever.
        }
        --pages_;
        callbacks_.closed(*opened);
    }

    const Limits limits_;
    // Before the context, at whose end the connections that are still waited for take themselves off the list.
    std::list<beast::tcp_stream*> strangers_;  // the one that came first in front
    net::io_context context_{1};
    tcp::acceptor acceptor_;
    net::steady_timer ticker_;
    Access access_;
    Callbacks callbacks_;
    std::size_t connections_ = 0, pages_ = 0;
    std::uint64_t number_ = 0;
};

Server::Server(std::initializer_list<std::uint16_t> ports, const char* setting, const Limits& limits)
    : inside_(std::make_unique<Inside>(ports, setting, limits)) {}
Server::~Server() = default;
std::uint16_t Server::port() const { return inside_->port(); }
void Server::run(const Access& access, Callbacks callbacks) { inside_->run(access, std::move(callbacks)); }
void Server::post(std::function<void()> work) { inside_->post(std::move(work)); }

}  // namespace haptogram::serve
