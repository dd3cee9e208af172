// SPDX-License-Identifier: Apache-2.0
// Who is let in: every rule of guard.hpp, and what stands in queries.
#include <catch2/catch.hpp>
#include <set>

#include "guard.hpp"
#include "haptogram/base/text.hpp"

using namespace haptogram::serve;
using haptogram::make_token;

namespace {

const std::string token = "0123456789abcdef0123456789abcdef";
const Access ours = access_for(8123, token);
const std::string host = "127.0.0.1:8123";

/// A request of the page itself.
RequestHead page_request(const std::string& method, const std::string& target) {
    RequestHead head;
    head.method = method;
    head.target = target;
    head.host = host;
    head.fetch_site = "same-origin";
    return head;
}

RequestHead api_request() {
    RequestHead head = page_request("GET", "/api/hello");
    head.authorization = "Bearer " + token;
    return head;
}

RequestHead socket_request() {
    RequestHead head = page_request("GET", "/ws");
    head.upgrade = true;
    head.origin = "http://" + host;
    head.protocols = "haptogram.1, token." + token;
    return head;
}

unsigned status(const RequestHead& head) {
    const auto refusal = refuse(head, ours);
    return refusal ? refusal->status : 200;
}

}  // namespace

TEST_CASE("studio guard: the page, the interface and the socket are served") {
    CHECK(status(page_request("GET", "/")) == 200);
    CHECK(status(page_request("HEAD", "/boot.js")) == 200);
    CHECK(status(api_request()) == 200);
    CHECK(status(socket_request()) == 200);
    RequestHead named = page_request("GET", "/");
    named.host = "localhost:8123";
    CHECK(status(named) == 200);
}

TEST_CASE("studio guard: a second field that says the host is refused") {
    RequestHead head = api_request();
    head.hosts = 2;
    CHECK(status(head) == 400);
}

TEST_CASE("guard of a service: programs and named pages with the token are let in, and nobody else") {
    Access service = access_for(8123, token);
    service.origins = {"https://example.org"};
    const auto status_of = [&](const RequestHead& head) {
        const auto refusal = refuse(head, service);
        return refusal ? refusal->status : 200;
    };
    RequestHead program;
    program.method = "GET";
    program.target = "/";
    program.host = host;
    program.upgrade = true;
    CHECK(status_of(program) == 401);
    program.authorization = "Bearer " + token;
    CHECK(status_of(program) == 200);
    program.upgrade = false;
    CHECK(status_of(program) == 426);
    program.upgrade = true;
    program.hosts = 2;  // or origins
    CHECK(status_of(program) == 400);
    program.hosts = 1;
    program.host = "evil.example:8123";
    CHECK(status_of(program) == 421);

    RequestHead page = socket_request();
    page.target = "/";
    CHECK(status_of(page) == 403);  // a page of this very server, which has none
    page.origin = "https://example.org";
    page.fetch_site = "cross-site";
    CHECK(status_of(page) == 200);
    page.protocols = "token." + token;
    CHECK(status_of(page) == 401);

    service = access_for(8123, "");
    service.origins.emplace();
    CHECK(status_of(page) == 403);
    page.origin.clear();
    CHECK(status_of(page) == 200);
}

TEST_CASE("studio guard: STOP is told from other requests") {
    RequestHead head = api_request();
    head.method = "POST";
    CHECK_FALSE(is_stop(head));
    head.target = "/api/stop";
    CHECK(is_stop(head));
    head.method = "GET";
    CHECK_FALSE(is_stop(head));
}

TEST_CASE("studio guard: other hosts are refused before anything else") {
    for (const std::string wrong :
         {"", "127.0.0.1", "127.0.0.1:8124", "evil.example:8123", "127.0.0.1:8123.evil.example", "LOCALHOST.:8123"}) {
        INFO(wrong);
        for (RequestHead head : {page_request("GET", "/"), api_request(), socket_request()}) {
            head.host = wrong;
            head.origin = "http://" + wrong;
            CHECK(status(head) == 421);
        }
    }
}

TEST_CASE("studio guard: other origins are refused, and a socket must have one") {
    for (const std::string wrong :
         {"null", "http://evil.example", "https://127.0.0.1:8123", "http://127.0.0.1:8124", "http://localhost:8123"}) {
        INFO(wrong);
        for (RequestHead head : {page_request("GET", "/"), api_request(), socket_request()}) {
            head.origin = wrong;
            CHECK(status(head) == 403);
        }
    }
    RequestHead none = socket_request();
    none.origin.clear();
    CHECK(status(none) == 403);
}

TEST_CASE("studio guard: another site may open the page by a link and nothing else") {
    for (const std::string site : {"cross-site", "same-site"}) {
        for (RequestHead head :
             {page_request("GET", "/boot.js"), page_request("GET", "/"), api_request(), socket_request()}) {
            head.fetch_site = site;
            CHECK(status(head) == 403);
        }
        RequestHead link = page_request("GET", "/");
        link.fetch_site = site;
        link.fetch_mode = "navigate";
        link.fetch_dest = "document";
        CHECK(status(link) == 200);
        link.fetch_dest = "iframe";
        CHECK(status(link) == 403);
        link.fetch_dest = "document";
        link.target = "/api/hello";
        CHECK(status(link) == 403);
    }
}

TEST_CASE("studio guard: without the whole token there is neither interface nor socket") {
    const std::string other(32, '0');
    for (const std::string& wrong :
         {std::string(), std::string("Bearer"), "Bearer " + other, "Bearer " + token.substr(1), "bearer " + token,
          "Basic " + token, "Bearer " + token + " "}) {
        INFO(wrong);
        RequestHead head = api_request();
        head.authorization = wrong;
        CHECK(status(head) == 401);
        head.target = "/api/nothing";
        CHECK(status(head) == 401);
    }
    for (const std::string& wrong :
         {std::string(), std::string("haptogram.1"), "token." + token, "haptogram.1, token." + other,
          "haptogram.2, token." + token, "haptogram.1, token." + token + "0"}) {
        INFO(wrong);
        RequestHead head = socket_request();
        head.protocols = wrong;
        CHECK(status(head) == 401);
    }
    RequestHead elsewhere = socket_request();
    elsewhere.target = "/api/hello";
    CHECK(status(elsewhere) == 404);
}

TEST_CASE("studio guard: methods and sizes") {
    for (const std::string method : {"OPTIONS", "PUT", "DELETE", "TRACE", "CONNECT", "PATCH"}) {
        RequestHead head = api_request();
        head.method = method;
        CHECK(status(head) == 405);
    }
    CHECK(status(page_request("POST", "/")) == 405);
    RequestHead body = api_request();
    body.method = "POST";
    body.target = "/api/files?name=a.ply";
    body.content_length = most_body_bytes;
    CHECK(status(body) == 200);
    *body.content_length += 1;
    CHECK(status(body) == 413);
}

TEST_CASE("studio guard: tokens are 128 bits and never the same") {
    std::set<std::string> found;
    for (int i = 0; i < 100; ++i) {
        const std::string made = make_token();
        CHECK(made.size() == 32);
        CHECK(made.find_first_not_of("0123456789abcdef") == std::string::npos);
        found.insert(made);
    }
    CHECK(found.size() == 100);
}

TEST_CASE("studio guard: values in queries") {
    CHECK(query_value("name=a.ply&as=hex", "as") == "hex");
    CHECK(query_value("name=%E2%97%8F%20b.stl", "name") == "\xE2\x97\x8F b.stl");
    CHECK(query_value("name=", "name") == "");
    CHECK_FALSE(query_value("", "name"));
    CHECK_FALSE(query_value("names=a", "name"));
    for (const std::string wrong : {"name=%", "name=%4", "name=%4g", "name=%+1", "name"}) {
        INFO(wrong);
        CHECK_FALSE(query_value(wrong, "name"));
    }
}
