// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/pattern_queue.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "haptogram/base/error.hpp"

namespace haptogram::link {

std::size_t PatternQueue::put(std::span<const std::uint16_t> patterns) {
    if (patterns.size() % words_ != 0)
        throw bad_argument("patterns", fmt::format("{} words, expected a multiple of {}, those of a pattern",
                                                   patterns.size(), words_));
    const std::lock_guard lock(mutex_);
    const std::size_t count = std::min(patterns.size() / words_, most - waiting_.size() / words_);
    waiting_.insert(waiting_.end(), patterns.begin(), patterns.begin() + static_cast<std::ptrdiff_t>(count * words_));
    return count;
}

void PatternQueue::set(std::span<const std::uint16_t> pattern) {
    if (pattern.size() != words_)
        throw bad_argument("pattern", fmt::format("{} words, expected {}", pattern.size(), words_));
    const std::lock_guard lock(mutex_);
    waiting_.assign(pattern.begin(), pattern.end());
}

void PatternQueue::clear() {
    const std::lock_guard lock(mutex_);
    waiting_.clear();
    last_.clear();
}

std::size_t PatternQueue::take(std::span<std::uint16_t> patterns, std::chrono::milliseconds most_age) {
    const std::lock_guard lock(mutex_);
    const auto now = clock_.now();
    if (most_age.count() > 0 && waiting_.empty() && now - taken_at_ > most_age) last_.clear();
    const std::size_t count = patterns.size() / words_;
    for (std::size_t i = 0; i < count; ++i) {
        if (!waiting_.empty()) {
            const auto end = waiting_.begin() + static_cast<std::ptrdiff_t>(words_);
            last_.assign(waiting_.begin(), end);
            waiting_.erase(waiting_.begin(), end);
            taken_at_ = now;
        }
        if (last_.empty()) return 0;
        std::ranges::copy(last_, patterns.begin() + static_cast<std::ptrdiff_t>(i * words_));
    }
    return count;
}

}  // namespace haptogram::link
