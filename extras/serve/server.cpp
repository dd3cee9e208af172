// SPDX-License-Identifier: Apache-2.0
#include "server.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <list>
#include <memory>
#include <mutex>
#include <thread>

#include "haptogram/base/error.hpp"
#include "haptogram/base/notice.hpp"
#include "haptogram/base/text.hpp"
#include "local_server.hpp"

namespace haptogram::serve {
namespace {

namespace net = boost::asio;
using net::ip::udp;
using Clock = std::chrono::steady_clock;

constexpr Server::Limits limits{.pages = 16, .message_bytes = 16 << 20, .silence = std::chrono::seconds(5)};
constexpr std::size_t most_waiting_bytes = 2 * limits.message_bytes;  // of messages of one client
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

/// A client and the thread that does what it asks for, in turn.
class Session {
public:
    Session(std::shared_ptr<Page> page, Verbs& verbs)
        : page_(std::move(page)), verbs_(verbs), thread_([this] {
              work();
              verbs_.leave(page_->number());
              over_ = true;
          }) {}
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;
    ~Session() {
        end();
        thread_.join();
    }

    [[nodiscard]] bool is_of(const Page& page) const { return page_.get() == &page; }
    [[nodiscard]] bool over() const { return over_; }

    void take(std::string message, bool binary) {
        {
            const std::lock_guard lock(mutex_);
            waiting_bytes_ += message.size();
            if (waiting_bytes_ > most_waiting_bytes)
                return page_->close(fmt::format("more than {} MiB of messages wait; send them as answers come",
                                                most_waiting_bytes >> 20U));
            waiting_.push_back({std::move(message), binary});
        }
        news_.notify_all();
    }

    /// What still waits is not done.
    void end() {
        {
            const std::lock_guard lock(mutex_);
            ended_ = true;
        }
        news_.notify_all();
    }

private:
    struct Message {
        std::string content;
        bool binary;
    };

    void work() {
        for (Allowance allowance;;) {
            std::unique_lock lock(mutex_);
            news_.wait(lock, [this] { return ended_ || !waiting_.empty(); });
            if (ended_) return;
            const Message message = std::move(waiting_.front());
            waiting_.pop_front();
            waiting_bytes_ -= message.content.size();
            lock.unlock();
            message.binary ? focus(message.content, allowance) : answer(message.content, allowance);
        }
    }

    void focus(const std::string& message, Allowance& allowance) {
        try {
            verbs_.focus({reinterpret_cast<const std::uint8_t*>(message.data()), message.size()}, page_->number());
        } catch (const std::exception& error) {
            if (allowance.take()) send(failure(error));
        }
    }

    void answer(const std::string& request, Allowance& allowance) {
        // A stop is never too much.
        if (!allowance.take() && !Verbs::ends(request))
            send(failure(bad_argument("request", fmt::format("more than {:.0f} a second; foci as binary messages are "
                                                             "not counted",
                                                             most_a_second))));
        else
            send(verbs_.answer(request, page_->number()));
    }

    void send(const nlohmann::ordered_json& said) {
        page_->send(said.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
    }

    std::shared_ptr<Page> page_;
    Verbs& verbs_;
    std::mutex mutex_;
    std::condition_variable news_;
    std::deque<Message> waiting_;
    std::size_t waiting_bytes_ = 0;
    bool ended_ = false;
    std::atomic<bool> over_ = false;
    std::thread thread_;
};

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

/// OSC over UDP, and the thread that takes it.
class Datagrams {
public:
    Datagrams(std::uint16_t port, Verbs& verbs) : verbs_(verbs) {
        try {
            socket_.open(udp::v4());
            socket_.bind({net::ip::address_v4::loopback(), port});
        } catch (const boost::system::system_error& error) {
            throw bad_argument("osc", fmt::format("port {}: {}; take another", port, error.code().message()));
        }
        socket_.non_blocking(true);
        thread_ = std::thread([this] {
            constexpr int look_ms = 100;  // between two looks whether it is the end, or a sender has gone
            for (pollfd wait{socket_.native_handle(), POLLIN, 0}; !over_; ::poll(&wait, 1, look_ms)) {
                take();
                verbs_.expire();
            }
        });
    }
    Datagrams(const Datagrams&) = delete;
    Datagrams& operator=(const Datagrams&) = delete;
    ~Datagrams() {
        over_ = true;
        thread_.join();
    }

private:
    /// What waits.
    void take() {
        std::array<std::uint8_t, 65536> bytes{};
        for (boost::system::error_code error; !over_;) {
            udp::endpoint from;
            const std::size_t count = socket_.receive_from(net::buffer(bytes), from, 0, error);
            if (error) break;
            try {
                for (const OscMessage& message : parse_osc({bytes.data(), count})) {
                    if (message.timed) complaints_.tell_of_time(from.port());
                    verbs_.act(message, Verbs::osc(from.address().to_v4().to_uint(), from.port()));
                }
            } catch (const std::exception& trouble) {
                complaints_.tell(fmt::format("a datagram from port {}: {}", from.port(), trouble.what()));
            }
        }
        if (const std::string trouble = verbs_.take_trouble(); !trouble.empty()) complaints_.tell(trouble);
    }

    Verbs& verbs_;
    net::io_context context_;
    udp::socket socket_{context_};
    Complaints complaints_;
    std::atomic<bool> over_ = false;
    std::thread thread_;
};

}  // namespace

void run(Verbs& verbs, const ServerOptions& options, const std::function<void(std::uint16_t)>& listening,
         const std::function<bool()>& go_on) {
    Server server({options.port}, "listen", limits);
    std::optional<Datagrams> datagrams;
    if (options.osc_port != 0) datagrams.emplace(options.osc_port, verbs);
    Access access = access_for(server.port(), options.token);
    access.origins = options.origins;
    listening(server.port());
    std::list<Session> sessions;
    const auto session_of = [&](const Page& page) {
        return std::ranges::find_if(sessions, [&](const Session& session) { return session.is_of(page); });
    };
    server.run(access,
               {.request = [](const Request&, const Reply& reply) { reply(error_answer(426, "this is a WebSocket")); },
                .opened = [&](std::shared_ptr<Page> page) { sessions.emplace_back(std::move(page), verbs); },
                .message = [&](Page& page, std::string text) { session_of(page)->take(std::move(text), false); },
                .bytes = [&](Page& page, std::string bytes) { session_of(page)->take(std::move(bytes), true); },
                .closed = [&](Page& page) { session_of(page)->end(); },
                .tick =
                    [&] {
                        sessions.remove_if([](const Session& session) { return session.over(); });
                        return go_on();
                    }});
}

}  // namespace haptogram::serve
