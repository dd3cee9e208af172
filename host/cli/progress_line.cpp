// SPDX-License-Identifier: Apache-2.0
#include "progress_line.hpp"

#include <fmt/core.h>
#include <unistd.h>

#include <utility>

#include "haptogram/base/notice.hpp"

namespace haptogram::cli {

ProgressLine::ProgressLine(std::string title) : title_(std::move(title)), on_terminal_(::isatty(STDERR_FILENO) == 1) {}

ProgressLine::~ProgressLine() {
    if (drawn_) write_within(STDERR_FILENO, "\r\033[K");
}

void ProgressLine::update(double fraction, const std::string& note) {
    if (on_terminal_) draw(fmt::format("{:3.0f} % {}", 100.0 * fraction, note));
}

Progress ProgressLine::callback() {
    return [this](double fraction, std::string_view stage) {
        update(fraction, std::string(stage));
        return true;
    };
}

void ProgressLine::note(const std::string& text) {
    if (on_terminal_) draw(text);
}

void ProgressLine::draw(const std::string& text) {
    const link::Clock::Time now = link::machine_clock().now();
    if (drawn_ && now - last_ < std::chrono::milliseconds(100)) return;
    last_ = now;
    drawn_ = true;
    write_within(STDERR_FILENO, fmt::format("\r{} {}\033[K", title_, printable(text)));
}

}  // namespace haptogram::cli
