// SPDX-License-Identifier: Apache-2.0
#include "guard.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "haptogram/base/text.hpp"

namespace haptogram::serve {
namespace {

/// The members of a header field that is a list.
std::vector<std::string_view> members(std::string_view list) {
    std::vector<std::string_view> found;
    while (!list.empty()) {
        const std::size_t end = std::min(list.find(','), list.size());
        std::string_view member = list.substr(0, end);
        while (!member.empty() && member.front() == ' ') member.remove_prefix(1);
        while (!member.empty() && member.back() == ' ') member.remove_suffix(1);
        found.push_back(member);
        list.remove_prefix(std::min(end + 1, list.size()));
    }
    return found;
}

bool has_token(const RequestHead& head, const Access& access) {
    constexpr std::string_view bearer = "Bearer ";
    const std::string_view given = head.authorization;
    return given.starts_with(bearer) && is_token(given.substr(bearer.size()), access.token);
}

bool offers_token(const RequestHead& head, const Access& access) {
    constexpr std::string_view prefix = "token.";
    return offers_subprotocol(head.protocols) &&
           std::ranges::any_of(members(head.protocols), [&](std::string_view offered) {
               return offered.starts_with(prefix) && is_token(offered.substr(prefix.size()), access.token);
           });
}

const char* const no_token =
    "the token is missing or is not that of this server, which it printed when it began: a page is opened at that "
    "address or offers the subprotocols 'haptogram.1' and 'token.' with the token; a program sends the header "
    "Authorization with 'Bearer' and the token";

/// Of a service, whose pages are those of other sites.
std::optional<Refusal> refuse_client(const RequestHead& head, const Access& access) {
    if (!head.origin.empty() && std::ranges::find(*access.origins, head.origin) == access.origins->end())
        return Refusal{
            403, fmt::format("pages of '{}' are not let in; start the service with --origin and that", head.origin)};
    if (!head.upgrade) return Refusal{426, "this is a WebSocket"};
    if (!access.token.empty() && !has_token(head, access) && !offers_token(head, access)) return Refusal{401, no_token};
    return {};
}

}  // namespace

Access access_for(std::uint16_t port, std::string token) {
    return {{fmt::format("127.0.0.1:{}", port), fmt::format("localhost:{}", port)}, std::move(token)};
}

std::optional<Refusal> refuse(const RequestHead& head, const Access& access) {
    if (head.hosts > 1)
        return Refusal{400, fmt::format("{} fields say the host or the origin, and two programs may read two; send one",
                                        head.hosts)};
    if (std::find(access.hosts.begin(), access.hosts.end(), head.host) == access.hosts.end())
        return Refusal{421, fmt::format("the host is '{}', expected {}", head.host, access.hosts.front())};
    if (access.origins) return refuse_client(head, access);
    const std::string_view path = std::string_view(head.target).substr(0, head.target.find('?'));
    if (!head.origin.empty() && head.origin != "http://" + head.host)
        return Refusal{403, "the request comes from a page of another origin"};
    const bool follows_link =
        head.method == "GET" && path == "/" && head.fetch_mode == "navigate" && head.fetch_dest == "document";
    if (!head.fetch_site.empty() && head.fetch_site != "same-origin" && head.fetch_site != "none" && !follows_link)
        return Refusal{403, "the request was made by a page of another site"};
    if (head.upgrade) {
        if (path != "/ws") return Refusal{404, "there is a WebSocket at /ws only"};
        if (head.origin.empty()) return Refusal{403, "a WebSocket needs an Origin"};
        if (!offers_token(head, access)) return Refusal{401, no_token};
        return {};
    }
    const bool api = path.starts_with("/api/");
    if (head.method != "GET" && head.method != "HEAD" && !(head.method == "POST" && api))
        return Refusal{405, fmt::format("{} is not served here", head.method)};
    if (api && !has_token(head, access)) return Refusal{401, no_token};
    if (head.content_length.value_or(0) > most_body_bytes)
        return Refusal{413,
                       fmt::format("{} bytes are more than the {} that the studio takes; 'haptogram compile' takes "
                                   "files of any size",
                                   *head.content_length, most_body_bytes)};
    return {};
}

bool offers_subprotocol(std::string_view protocols) {
    const auto offered = members(protocols);
    return std::ranges::find(offered, subprotocol) != offered.end();
}

bool is_stop(const RequestHead& head) { return head.method == "POST" && head.target == "/api/stop"; }

}  // namespace haptogram::serve
