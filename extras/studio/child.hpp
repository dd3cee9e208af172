// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace haptogram::studio {

/// A program in a process of its own, usually this one with other arguments. It ends with this object, and also with
/// the thread that made it, whatever became of that.
class Child {
public:
    /// What is started, and how.
    struct Command {
        std::vector<std::string> words;        ///< path of the program, and its arguments
        std::filesystem::path folder = {};     ///< that it runs in; empty: ours
        std::vector<std::string> environment;  ///< "NAME=VALUE", in place of what we have of these names
    };

    /// Starts this program at a lowered priority, without an input, and returns at once.
    /// @param name       for messages
    /// @param arguments  of the program, without its name
    /// @throws Error{failed} when no process can be started
    Child(const std::string& name, std::vector<std::string> arguments);
    /// Starts any program, and returns at once; say() speaks to it.
    /// @throws Error{failed} when no process can be started
    Child(const std::string& name, const Command& command);
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;
    /// Asks it to end, and waits until it has.
    ~Child();

    enum class Heard {
        more,     ///< text was appended
        nothing,  ///< in that time
        end,      ///< it has closed its outputs: nothing more will come
    };
    /// Waits for more of what it says on its standard output and standard error.
    Heard hear(std::string& text, std::chrono::milliseconds patience) const;
    /// Text for its standard input. Never waits.
    /// @return whether it was taken; not so by a process that has ended, or that does not read
    bool say(std::string_view text) const;
    /// Sends a signal to it and to all that it started.
    void signal(int number) const;
    /// Waits for its end, for so long; then it is killed.
    /// @return its exit code; none when a signal ended it
    std::optional<int> wait(std::chrono::milliseconds patience);

private:
    void start(const std::string& name, const Command& command, int input, int priority);

    pid_t process_ = -1;  // -1: it has ended
    int said_ = -1;       // its standard output and standard error
    int told_ = -1;       // its standard input
};

}  // namespace haptogram::studio
