// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <cstddef>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "haptogram/base/live_input.hpp"
#include "haptogram/link/play.hpp"
#include "haptogram/verbs/trigger_table.hpp"

namespace haptogram {

/// Lines of another program that fire triggers.
class TriggerReader final : public link::TriggerSource {
public:
    using Told = std::function<void(const std::string&)>;

    /// @param lines  none: nothing fires
    /// @param told   what is wrong with a line; the next is read
    /// @param clock  of the device that they play on
    TriggerReader(std::vector<Trigger> triggers, std::optional<LiveText> lines, Told told, link::Clock& clock);

    [[nodiscard]] std::optional<std::size_t> next(std::chrono::milliseconds patience) override;
    [[nodiscard]] bool ended() const override;

private:
    const std::vector<Trigger> triggers_;
    TriggerLines fired_by_;
    std::optional<LiveText> text_;
    const Told told_;
    link::Clock& clock_;
    std::deque<std::size_t> fired_;
};

}  // namespace haptogram
