// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "request.hpp"

namespace haptogram::serve {

inline constexpr std::size_t most_header_bytes = 16 * 1024;
inline constexpr std::size_t most_message_bytes = 1024 * 1024;
/// The WebSocket's subprotocol. A page offers it together with "token.TOKEN": it cannot set other headers there, and a
/// token in the address would end up in logs.
inline constexpr std::string_view subprotocol = "haptogram.1";

/// Who may talk to the server: who knows the token, from a page that this server sent; or, of a service, programs and
/// the pages of other sites that are named.
struct Access {
    std::vector<std::string> hosts;                     ///< names that the server goes by, with its port
    std::string token;                                  ///< empty: no token is needed, of a service
    std::optional<std::vector<std::string>> origins{};  ///< of the other sites; a service when there is a list
};

/// For a server on the loopback interface at this port.
[[nodiscard]] Access access_for(std::uint16_t port, std::string token);

/// What a request says before its body. Header fields that it has not are empty.
struct RequestHead {
    std::string method, target;
    std::string host, origin, fetch_site, fetch_mode, fetch_dest, authorization, protocols;
    std::optional<std::uint64_t> content_length{};
    bool upgrade = false;   ///< wants to become a WebSocket
    std::size_t hosts = 1;  ///< how many fields say the host or, if they are more, the origin
};

/// Why a request is not served.
struct Refusal {
    unsigned status = 400;  ///< of HTTP
    std::string message;    ///< what was found, what was expected, what to do
};

/// Decides before the body is read. In this order:
/// - one field says the host, and one at most the origin (400); the host is ours (421), or another site's name would
///   lead to us: DNS rebinding;
/// - an Origin must be ours (403), and a WebSocket must have one; of a service, it must be named, or be absent;
/// - other sites may open the page by a link, and nothing else (403);
/// - a service has a WebSocket and nothing else (426);
/// - GET, HEAD and POST are the methods (405), POST to the interface alone;
/// - the interface and the WebSocket want the token (401), and bodies have a limit (413).
/// There are no cookies, so that there is nothing that a browser would send along by itself.
/// @return none when the request is to be served
[[nodiscard]] std::optional<Refusal> refuse(const RequestHead& head, const Access& access);

/// Whether the subprotocol is among those that a WebSocket offers.
[[nodiscard]] bool offers_subprotocol(std::string_view protocols);

/// Whether a request turns the outputs off: it is served however many connections there are.
[[nodiscard]] bool is_stop(const RequestHead& head);

/// The headers of every answer: nothing but our own files runs on the page, it cannot be framed, and talks to us alone.
struct Header {
    std::string_view name, value;
};
inline constexpr Header answer_headers[] = {
    {"Content-Security-Policy",
     "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; connect-src 'self'; "
     "base-uri 'none'; form-action 'none'; frame-ancestors 'none'; require-trusted-types-for 'script'"},
    {"X-Content-Type-Options", "nosniff"},
    {"Referrer-Policy", "no-referrer"},
    {"Cross-Origin-Opener-Policy", "same-origin"},
    {"Cross-Origin-Embedder-Policy", "require-corp"},
    {"Cross-Origin-Resource-Policy", "same-origin"},
    {"Cache-Control", "no-store"},
};

}  // namespace haptogram::serve
