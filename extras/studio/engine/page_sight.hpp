// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <optional>
#include <string>

#include "haptogram/link/clock.hpp"

namespace haptogram::studio {

/// A page that drives the outputs says so often that it is alive; after this long without a word they go off.
inline constexpr std::chrono::milliseconds most_silence{1000};
/// Of a page out of sight browsers call the timers once a second only.
inline constexpr std::chrono::milliseconds most_silence_hidden{2500};
/// After this long out of sight they go off, too.
inline constexpr std::chrono::seconds most_hidden{10};

/// When a page was alive, and in sight, the last time.
class PageSight {
public:
    explicit PageSight(const link::Clock& clock) : clock_(clock) {}

    void heard() { heard_ = clock_.now(); }
    void beat(bool hidden) {
        heard();
        if (!hidden)
            hidden_ = {};
        else if (!hidden_)
            hidden_ = clock_.now();
    }
    /// It was just asked to play, which only somebody who sees it does.
    void seen() { hidden_ = {}; }

    /// Why a page that plays must have its outputs turned off now; nothing when they may stay on.
    [[nodiscard]] std::optional<std::string> too_long() const {
        const link::Clock::Time now = clock_.now();
        if (now - heard_ > (hidden_ ? most_silence_hidden : most_silence))
            return "the page that drove the board was silent";
        if (hidden_ && now - *hidden_ > most_hidden) return "the page that drove the board was out of sight";
        return {};
    }

private:
    const link::Clock& clock_;
    link::Clock::Time heard_ = clock_.now();
    std::optional<link::Clock::Time> hidden_{};  // since when
};

}  // namespace haptogram::studio
