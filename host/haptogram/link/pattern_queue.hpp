// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <span>
#include <vector>

#include "haptogram/link/clock.hpp"

namespace haptogram::link {

/// Patterns that wait for a carrier period each, from a thread that never waits to the one that sends them. When none
/// waits, the last one goes on.
class PatternQueue {
public:
    static constexpr std::size_t most = 4096;  ///< that can wait, 0.1 s

    /// @param words  of a pattern
    PatternQueue(std::size_t words, const Clock& clock) : words_(words), clock_(clock) {}

    [[nodiscard]] std::size_t words() const { return words_; }
    /// Appends whole patterns. @return how many of them there was room for, the first ones
    std::size_t put(std::span<const std::uint16_t> patterns);
    /// In the place of all that wait: the newest wins.
    void set(std::span<const std::uint16_t> pattern);
    /// Fills in the next ones. @return how many: all, or none before there was any
    /// @param most_age  for so long the last one goes on; 0: for ever
    std::size_t take(std::span<std::uint16_t> patterns, std::chrono::milliseconds most_age);
    void clear();

private:
    std::size_t words_;
    const Clock& clock_;
    std::mutex mutex_;  // held while some words are copied
    std::deque<std::uint16_t> waiting_;
    std::vector<std::uint16_t> last_;
    Clock::Time taken_at_{};
};

}  // namespace haptogram::link
