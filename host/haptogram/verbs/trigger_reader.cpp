// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/trigger_reader.hpp"

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

#include "haptogram/base/error.hpp"

namespace haptogram {

TriggerReader::TriggerReader(std::vector<Trigger> triggers, std::optional<LiveText> lines, Told told)
    : triggers_(std::move(triggers)), fired_by_(triggers_), text_(std::move(lines)), told_(std::move(told)) {}

std::optional<std::size_t> TriggerReader::next(std::chrono::milliseconds patience) {
    if (ended()) std::this_thread::sleep_for(patience);
    const auto until = std::chrono::steady_clock::now() + patience;
    while (fired_.empty() && !ended()) {
        const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - std::chrono::steady_clock::now());
        const auto line = text_->next(std::max(left, std::chrono::milliseconds(0)));
        if (line) try {
                for (const std::size_t number : fired_by_.fired(*line, text_->where())) fired_.push_back(number);
            } catch (const Error& error) {
                told_(error.what());
            }
        if (left.count() <= 0) break;
    }
    if (fired_.empty()) return {};
    const std::size_t first = fired_.front();
    fired_.pop_front();
    return first;
}

bool TriggerReader::ended() const { return fired_.empty() && (!text_ || text_->ended()); }

}  // namespace haptogram
