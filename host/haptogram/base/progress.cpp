// SPDX-License-Identifier: Apache-2.0
#include "haptogram/base/progress.hpp"

#include <fmt/core.h>
#include <unistd.h>

#include <cstdio>
#include <utility>

namespace haptogram {

Progress::Progress(std::string title) : title_(std::move(title)), on_terminal_(::isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() {
    if (drawn_) std::fputs("\r\033[K", stderr);
}

void Progress::update(double fraction, const std::string& note) {
    if (on_terminal_) draw(fmt::format("{:3.0f} % {}", 100.0 * fraction, note));
}

void Progress::note(const std::string& text) {
    if (on_terminal_) draw(text);
}

void Progress::draw(const std::string& text) {
    const auto now = std::chrono::steady_clock::now();
    if (drawn_ && now - last_ < std::chrono::milliseconds(100)) return;
    last_ = now;
    drawn_ = true;
    std::fputs(fmt::format("\r{} {}\033[K", title_, text).c_str(), stderr);
    std::fflush(stderr);
}

}  // namespace haptogram
