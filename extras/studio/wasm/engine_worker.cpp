// SPDX-License-Identifier: Apache-2.0
// The engine for a page without a server: what ../engine answers, called from the page's Worker (../web/src/worker.ts).
// Text goes in as bytes that JavaScript has put into this memory; answers go out by functions of the module.
#include <emscripten.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "answers.hpp"
#include "failure.hpp"
#include "haptogram/base/error.hpp"

// clang-format off
EM_JS(void, tell_text, (const char* text, std::size_t size), { Module["text"](HEAPU8.slice(text, text + size)); });
EM_JS(void, tell_bulk, (const std::uint8_t* bulk, std::size_t size), { Module["bulk"](HEAPU8.slice(bulk, bulk + size)); });
EM_JS(void, tell_answer, (unsigned status, const char* body, std::size_t size), { Module["answer"](status, HEAPU8.slice(body, body + size)); });
// clang-format on

namespace haptogram::studio {
namespace {

class Worker : public Recipient {
public:
    void send(std::string text) override { tell_text(text.data(), text.size()); }
    void send(std::vector<std::uint8_t> bulk) override { tell_bulk(bulk.data(), bulk.size()); }
};

Scenes& scenes() {
    static Scenes all;
    return all;
}

Error needs_program(const char* what) {
    return {
        ErrorCode::failed, what,
        "this page has no program behind it; install Haptogram and start 'haptogram studio' for boards, the simulated "
        "Verilog and studies"};
}

template <class Any>
void act(Worker& page, const Any& message) {
    if constexpr (requires { answer(scenes(), page, message); })
        answer(scenes(), page, message);
    else if constexpr (requires { message.n; })
        tell_failure(page, message.n, [] { throw needs_program("board"); });
}

// Nothing is on that could be turned off, and each work ends before the next message is heard.
void act(Worker& page, const StopMessage& message) {
    page.send(to_text({{"t", "off"}, {"n", message.n}, {"confirmed", true}}));
}
void act(Worker&, const CancelMessage&) {}

Answer answer_to(Request request) {
    if (request.path == "/api/hello") {
        nlohmann::ordered_json hello = hello_json(scenes(), "example");
        hello["ports"] = nlohmann::ordered_json::array();
        return {.body = to_text(hello)};
    }
    const std::string path = request.path;
    const ReportPicture none = [](const Timeline&, const Progress&) { return std::string(); };
    if (const auto writing = writing_of(scenes(), request, none))
        return {.type = "application/octet-stream", .body = (*writing)({})};
    if (auto found = answer_at_once(scenes(), std::move(request))) return *std::move(found);
    throw needs_program(path == "/api/bitstream" ? "bitstream" : path.c_str());
}

}  // namespace

/// Takes a message, as it would come over the WebSocket.
extern "C" EMSCRIPTEN_KEEPALIVE void take_message(const char* text, std::size_t size) {
    Worker page;
    const auto wrong = error_of(
        [&] { std::visit([&](const auto& each) { act(page, each); }, read_message(std::string_view(text, size))); });
    if (wrong) page.send(to_text({{"t", "error"}, {"error", *wrong}}));
}

/// Takes a request, as it would come over HTTP. @param target  path?query
extern "C" EMSCRIPTEN_KEEPALIVE void take_request(const char* method, const char* target, const char* body,
                                                  std::size_t size) {
    const std::string_view whole = target;
    const std::size_t mark = std::min(whole.find('?'), whole.size());
    Request request{.method = method,
                    .path = std::string(whole.substr(0, mark)),
                    .query = std::string(whole.substr(std::min(mark + 1, whole.size()))),
                    .body = std::string(body, size)};
    Answer answer;
    if (const auto wrong = error_of([&] { answer = answer_to(std::move(request)); }))
        answer = error_answer(422, wrong->at("message"));
    tell_answer(answer.status, answer.body.data(), answer.body.size());
}

}  // namespace haptogram::studio
