// SPDX-License-Identifier: Apache-2.0
// The board for a page without a server, called from a Worker of its own (../web/src/board_worker.ts), so that STOP
// never waits for a field. What is to be done with the port goes out by functions of the module.
#include <emscripten.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>

#include "failure.hpp"
#include "page_board.hpp"

// clang-format off
EM_JS(void, tell_message, (const char* text, std::size_t size), { Module["text"](HEAPU8.slice(text, text + size)); });
EM_JS(void, port_open, (unsigned baud), { Module["port"]({ open: baud }); });
EM_JS(void, port_write, (const std::uint8_t* bytes, std::size_t size), { Module["port"]({ write: HEAPU8.slice(bytes, bytes + size) }); });
EM_JS(void, port_discard, (), { Module["port"]({ discard: true }); });
EM_JS(void, port_break, (double milliseconds), { Module["port"]({ hold: milliseconds }); });
EM_JS(void, port_close, (), { Module["port"]({ close: true }); });
// clang-format on

namespace haptogram::studio {
namespace {

class Teller final : public Recipient {
public:
    void send(std::string text) override { tell_message(text.data(), text.size()); }
    void send(std::vector<std::uint8_t>) override {}
};

PageBoard& board() {
    static PageBoard one(
        {.open = port_open,
         .write = [](const link::Bytes& bytes) { port_write(bytes.data(), bytes.size()); },
         .discard = port_discard,
         .hold_break = [](std::chrono::microseconds time) { port_break(static_cast<double>(time.count()) / 1000.0); },
         .close = port_close},
        [](const nlohmann::ordered_json& message) { Teller().send(to_text(message)); });
    return one;
}

template <class Any>
void act_on_board(const Any& message) {
    if constexpr (requires { board().act(message); }) {
        if constexpr (requires { message.n; }) {
            Teller page;
            tell_failure(page, message.n, [&] { board().act(message); });
        } else {
            board().act(message);
        }
    }
}

}  // namespace

/// Takes a message of a board, as it would come over the WebSocket.
extern "C" EMSCRIPTEN_KEEPALIVE void board_message(const char* text, std::size_t size) {
    const auto wrong = error_of(
        [&] { std::visit([](const auto& each) { act_on_board(each); }, read_message(std::string_view(text, size))); });
    if (wrong) Teller().send(to_text({{"t", "error"}, {"error", *wrong}}));
    board().step();
}

/// Takes the image of a scene, as a file.
extern "C" EMSCRIPTEN_KEEPALIVE void board_image(const char* scene, const char* hex, std::size_t size) {
    const auto wrong = error_of([&] { board().keep(scene, std::string_view(hex, size)); });
    if (wrong) Teller().send(to_text({{"t", "error"}, {"error", *wrong}}));
}

extern "C" EMSCRIPTEN_KEEPALIVE void board_opened() { board().opened(); }
extern "C" EMSCRIPTEN_KEEPALIVE void board_lost(const char* why) { board().lost(why); }
extern "C" EMSCRIPTEN_KEEPALIVE void board_received(const std::uint8_t* bytes, std::size_t size) {
    board().received(link::Bytes(bytes, bytes + size));
}
extern "C" EMSCRIPTEN_KEEPALIVE void board_step() { board().step(); }

}  // namespace haptogram::studio
