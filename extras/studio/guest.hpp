// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <thread>

#include "child.hpp"

namespace haptogram::studio {

/// A session of a page in a process of its own, which may have the board meanwhile: a participant's of a study, or a
/// live one. It says what is to be shown in lines of JSON.
class Guest {
public:
    struct Settings {
        /// Told in some thread each line of JSON, or {"show": "note", "text"} for a line of words.
        std::function<void(nlohmann::ordered_json)> shown;
        /// Told in some thread, last of all, that it has ended, with its exit code; none when it had to be killed.
        std::function<void(std::optional<int>)> ended;
    };
    /// How long a process that is to end may take to turn a board's outputs off and close its results.
    static constexpr std::chrono::milliseconds most_ending{1500};

    /// Starts the process and returns at once.
    Guest(Child::Command command, Settings settings);
    Guest(const Guest&) = delete;
    Guest& operator=(const Guest&) = delete;
    /// Ends it, and waits until it has.
    ~Guest();

    void answer(std::uint32_t number, const std::string& text);
    /// Asks it to stop where it is; the same session goes on later.
    void leave();
    /// Ends it at once, as Ctrl-C does. May be called again.
    void end();

private:
    void say(const nlohmann::ordered_json& line);
    void run(const Child::Command& command);
    bool hear(Child& child, std::string& text);
    void show(std::string_view line) const;

    Settings settings_;
    std::mutex mutex_;
    Child* child_ = nullptr;  // while there is one
    std::optional<std::chrono::steady_clock::time_point> ending_;
    std::thread thread_;
};

}  // namespace haptogram::studio
