// SPDX-License-Identifier: Apache-2.0
#include "guest.hpp"

#include <csignal>
#include <exception>
#include <utility>

#include "haptogram/base/depth.hpp"

namespace haptogram::studio {
namespace {

using nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

constexpr std::size_t longest_line = 1'000'000;  ///< bytes; a protocol's texts are shorter, and so are scenes

}  // namespace

Guest::Guest(Child::Command command, Settings settings)
    : settings_(std::move(settings)), thread_([this, command = std::move(command)] { run(command); }) {}

Guest::~Guest() {
    end();
    thread_.join();
}

void Guest::answer(std::uint32_t number, const std::string& text) {
    say({{"do", "answer"}, {"number", number}, {"text", text}});
}

void Guest::leave() { say({{"do", "stop"}}); }

void Guest::end() {
    const std::lock_guard lock(mutex_);
    if (ending_) return;
    ending_ = Clock::now();
    if (child_ != nullptr) child_->signal(SIGTERM);
}

void Guest::say(const ordered_json& line) {
    const std::lock_guard lock(mutex_);
    if (child_ != nullptr) (void)child_->say(line.dump() + "\n");  // one that takes nothing has ended, and will say so
}

void Guest::show(std::string_view line) const {
    ordered_json shown = is_shallow(line) ? ordered_json::parse(line, nullptr, false) : ordered_json();
    if (shown.is_object() && (shown.contains("show") || shown.contains("scene")))
        return settings_.shown(std::move(shown));
    // What it says on standard error, as in a terminal.
    for (const std::string_view prefix : {"haptogram-study: ", "haptogram: "})
        if (line.starts_with(prefix)) line.remove_prefix(prefix.size());
    settings_.shown({{"show", "note"}, {"text", line}});
}

bool Guest::hear(Child& child, std::string& text) {
    const Child::Heard heard = child.hear(text, std::chrono::milliseconds(100));
    for (std::size_t end; (end = text.find('\n')) != std::string::npos; text.erase(0, end + 1))
        show(std::string_view(text).substr(0, end));
    const std::lock_guard lock(mutex_);
    if (text.size() > longest_line || (ending_ && Clock::now() - *ending_ > most_ending)) child.signal(SIGKILL);
    return heard != Child::Heard::end;
}

void Guest::run(const Child::Command& command) {
    std::optional<int> code;
    try {
        Child child("session", command);
        {
            const std::lock_guard lock(mutex_);
            child_ = &child;
            if (ending_) child.signal(SIGTERM);
        }
        std::string text;
        while (hear(child, text)) {
        }
        if (!text.empty()) show(text);
        {
            const std::lock_guard lock(mutex_);
            child_ = nullptr;
        }
        code = child.wait(most_ending);
    } catch (const std::exception& error) {
        settings_.shown({{"show", "note"}, {"text", error.what()}});
    }
    settings_.ended(code);
}

}  // namespace haptogram::studio
