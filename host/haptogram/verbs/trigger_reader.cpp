// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/trigger_reader.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "haptogram/base/error.hpp"

namespace haptogram {

TriggerReader::TriggerReader(std::vector<Trigger> triggers, std::optional<LiveText> lines, Told told,
                             link::Clock& clock)
    : triggers_(std::move(triggers)),
      fired_by_(triggers_),
      text_(std::move(lines)),
      told_(std::move(told)),
      clock_(clock) {}

std::optional<std::size_t> TriggerReader::next(std::chrono::milliseconds patience) {
    constexpr std::chrono::milliseconds look{1};
    const link::Clock::Time until = clock_.now() + patience;
    while (fired_.empty()) {
        const auto line = ended() ? std::nullopt : text_->next(std::chrono::milliseconds(0));
        if (line) try {
                for (const std::size_t number : fired_by_.fired(*line, text_->where())) fired_.push_back(number);
            } catch (const Error& error) {
                told_(error.what());
            }
        const link::Clock::Time now = clock_.now();
        if (now >= until) break;
        if (!line) clock_.rest_until(ended() ? until : std::min<link::Clock::Time>(until, now + look));
    }
    if (fired_.empty()) return {};
    const std::size_t first = fired_.front();
    fired_.pop_front();
    return first;
}

bool TriggerReader::ended() const { return fired_.empty() && (!text_ || text_->ended()); }

}  // namespace haptogram
