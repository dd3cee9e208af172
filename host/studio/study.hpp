// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <filesystem>
#include <functional>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>

#include "child.hpp"
#include "messages.hpp"
#include "virtual_board.hpp"

/// Studies with people. Orders, questions, checks and results are those of Python's haptogram.study; here is only the
/// way between its runner and a page.
namespace haptogram::studio {

/// The protocols that are shipped, and those in a folder, as `haptogram-study list --json` prints them.
/// @throws Error{failed} with Python's own words when the runner cannot be started
[[nodiscard]] nlohmann::ordered_json study_protocols(const std::filesystem::path& folder);

/// The command that runs a participant's session in a folder. @param port  none: nothing is played
[[nodiscard]] Child::Command study_command(const StudyMessage& asked, const std::filesystem::path& folder,
                                           const std::optional<BoardPort>& port);

/// A session under way, in a process of its own.
class Study {
public:
    struct Settings {
        /// Told in some thread what the runner shows, {"show", …}, or {"show": "note", "text"} for a line of words.
        std::function<void(nlohmann::ordered_json)> shown;
        /// Told in some thread, last of all, that it has ended, with its exit code; none when it had to be killed.
        std::function<void(std::optional<int>)> ended;
    };
    /// How long a runner that is to end may take to turn a board's outputs off and close its results.
    static constexpr std::chrono::milliseconds most_ending{1500};

    /// Starts the runner and returns at once.
    Study(Child::Command command, Settings settings);
    Study(const Study&) = delete;
    Study& operator=(const Study&) = delete;
    /// Ends it, and waits until it has.
    ~Study();

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
