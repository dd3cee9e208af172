// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <sys/types.h>

#include <chrono>
#include <optional>
#include <string>
#include <vector>

namespace haptogram::studio {

/// This program with other arguments, in a process of its own and at a lowered priority. It ends with this object, and
/// also with the thread that made it, whatever became of that.
class Child {
public:
    /// Starts it and returns at once.
    /// @param name       for messages
    /// @param arguments  of the program, without its name
    /// @throws Error{failed} when no process can be started
    Child(const std::string& name, std::vector<std::string> arguments);
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

private:
    pid_t process_ = -1;
    int said_ = -1;  // its standard output and standard error
};

}  // namespace haptogram::studio
