// SPDX-License-Identifier: Apache-2.0
#include "virtual_board.hpp"

#include <nlohmann/json.hpp>
#include <vector>

#include "haptogram/base/error.hpp"
#include "haptogram/link/port.hpp"

namespace haptogram::studio {

namespace {

/// Whether its name alone says all of it.
bool is_known(const Core& core) {
    try {
        return find_core(core.name) == core;
    } catch (const Error&) {
        return false;
    }
}

std::vector<std::string> command(const Core& core, const std::string& model) {
    std::vector<std::string> words = {"board", "run", "--json", "--model", model};
    if (is_known(core))
        words.insert(words.end(), {"--board", core.name});
    else
        words.insert(words.end(), {"--channels", std::to_string(core.parameters.channels)});
    return words;
}

}  // namespace

VirtualBoard::VirtualBoard(const Core& core, const std::string& model)
    : child_("virtual board", command(core, model)) {}

std::unique_ptr<link::Transport> VirtualBoard::open(std::chrono::milliseconds patience) {
    const std::lock_guard lock(mutex_);
    const auto until = std::chrono::steady_clock::now() + patience;
    while (!port_ && text_.find('\n') == std::string::npos) {
        const auto left =
            std::chrono::duration_cast<std::chrono::milliseconds>(until - std::chrono::steady_clock::now());
        if (left.count() <= 0) throw Error(ErrorCode::device, "virtual board", "it is still starting");
        if (child_.hear(text_, left) == Child::Heard::end)
            throw Error(ErrorCode::device, "virtual board", "it ended without a word");
    }
    if (!port_) {
        const nlohmann::json line = nlohmann::json::parse(text_.substr(0, text_.find('\n')), nullptr, false);
        if (!line.is_object() || !line.contains("port"))
            throw Error(ErrorCode::device, "virtual board", text_.substr(0, text_.find('\n')));
        port_ = BoardPort{line["port"], line["baud"].get<std::uint32_t>()};
    }
    return link::open_port({.port = port_->name, .baud = port_->baud});
}

std::optional<BoardPort> VirtualBoard::port() const {
    const std::lock_guard lock(mutex_);
    return port_;
}

}  // namespace haptogram::studio
