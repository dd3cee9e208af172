// SPDX-License-Identifier: Apache-2.0
// The HTTP server, without the headers of the library behind it, which take half a minute to compile.
#pragma once
#include <chrono>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <memory>
#include <string>
#include <string_view>
#include <utility>  // for Boost 1.74, whose coroutines use std::exchange without it
#include <vector>

#include "guard.hpp"
#include "recipient.hpp"
#include "request.hpp"

namespace haptogram::serve {

/// Why a WebSocket is closed, as its protocol takes it: 123 bytes at most, and UTF-8. What a message quotes may be
/// neither, so bytes that are no printable ASCII become question marks.
[[nodiscard]] std::string close_reason(std::string_view message);

/// A page that is connected. A message to it is queued, from any thread. Bulk is dropped while the page takes nothing,
/// text never: when too much waits for too long, the connection ends.
class Page : public Recipient {
public:
    [[nodiscard]] virtual std::uint64_t number() const = 0;
    /// Why the server has ended the connection, in words; empty when it has not.
    [[nodiscard]] virtual const std::string& trouble() const = 0;
    /// Ends the connection and says why.
    virtual void close(const std::string& reason) = 0;
};

/// Takes the answer to a request, once; may be called from any thread, also after a while.
using Reply = std::function<void(Answer)>;

/// Serves requests and WebSockets on the loopback interface. All callbacks run in the thread that is in run(), one
/// after the other, and must return soon.
class Server {
public:
    struct Callbacks {
        /// Answers by the reply, or throws what is wrong: the client gets an Error as 422.
        std::function<void(Request, Reply)> request;
        std::function<void(std::shared_ptr<Page>)> opened;
        std::function<void(Page&, std::string)> message;
        std::function<void(Page&, std::string)> bytes{};  ///< a binary message; without this, all must be text
        std::function<void(Page&)> closed;
        std::function<bool()> tick;  ///< every tick_pause; false ends run()
    };
    static constexpr std::chrono::milliseconds tick_pause{50};
    static constexpr std::size_t most_connections = 32;
    struct Limits {
        std::size_t pages = 8;
        std::size_t message_bytes = most_message_bytes;
        std::chrono::seconds silence{20};  ///< of a page that answers no ping, until it has gone
    };
    /// Clients that have not yet shown a token: the one that came first makes room. They are not among
    /// most_connections. All clients are on this machine, so that this is also the most of one peer.
    static constexpr std::size_t most_strangers = 64;

    /// Listens from now on. @param ports  of which the first is taken that is free; 0 is any that is free
    /// @param setting  that says the port
    /// @throws Error{bad_argument} when none is
    Server(std::initializer_list<std::uint16_t> ports, const char* setting, const Limits& limits);
    ~Server();

    [[nodiscard]] std::uint16_t port() const;
    /// Serves until a tick says false.
    void run(const Access& access, Callbacks callbacks);
    /// Calls `work` from within run(); may be called from any thread.
    void post(std::function<void()> work);

private:
    class Inside;
    std::unique_ptr<Inside> inside_;
};

}  // namespace haptogram::serve
