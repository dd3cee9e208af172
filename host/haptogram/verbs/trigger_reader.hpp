// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <cstddef>
#include <deque>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "haptogram/base/live_input.hpp"
#include "haptogram/link/play.hpp"
#include "haptogram/verbs/trigger_table.hpp"

#pragma once

namespace haptogram {

/// Of the lines in which a live session tells its scenes: 2 tells all objects. Triggers read the hands, which are the
/// same from version 1 on.
inline constexpr int scene_version = 2, oldest_scene_version = 1;

/// What lines of text say: the key or the word of a trigger, or a scene of a live session, whose hands enter regions.
class TriggerLines {
public:
    /// @param triggers  outlive this
    explicit TriggerLines(std::span<const Trigger> triggers) : triggers_(triggers), inside_(triggers.size()) {}

    /// The numbers of the triggers that a line fires. A region is entered by the first joint, or palm, of any hand in
    /// it.
    /// @throws Error{bad_input} naming `where` for a line that says something else
    [[nodiscard]] std::vector<std::size_t> fired(std::string_view line, const std::string& where);

private:
    std::span<const Trigger> triggers_;
    std::vector<bool> inside_;  // whether a hand was there
};

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
