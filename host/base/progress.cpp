// SPDX-License-Identifier: Apache-2.0
#include "base/progress.hpp"

#include <fmt/core.h>
#include <unistd.h>

#include <cstdio>
#include <utility>

namespace haptogram {

Progress::Progress(std::string title) : title_(std::move(title)), on_terminal_(::isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() {
    if (drawn_) fmt::print(stderr, "\r\033[K");
}

void Progress::update(double fraction, const std::string& note) {
    if (!on_terminal_) return;
    const auto now = std::chrono::steady_clock::now();
    if (drawn_ && now - last_ < std::chrono::milliseconds(100)) return;
    last_ = now;
    drawn_ = true;
    fmt::print(stderr, "\r{} {:3.0f} % {}\033[K", title_, 100.0 * fraction, note);
    std::fflush(stderr);
}

}  // namespace haptogram
