// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <stdexcept>
#include <string>
#include <utility>

namespace haptogram {

/// What went wrong, as the exit code that a command ends with.
enum class ErrorCode : int {
    run_failed = 1,  ///< a contract was broken or a focus was off
    usage = 2,       ///< the command line makes no sense
    bad_input = 3,   ///< a file or a value in it cannot be used, or an output cannot be written
    device = 4,      ///< the board or the link to it
};

/// The one exception type of the project. `where` names the file, line or record; `message` says what was found, what
/// was expected and what to do.
class Error : public std::runtime_error {
public:
    Error(ErrorCode code, std::string where, const std::string& message)
        : std::runtime_error(where.empty() ? message : where + ": " + message), code_(code), where_(std::move(where)) {}

    [[nodiscard]] ErrorCode code() const noexcept { return code_; }
    [[nodiscard]] const std::string& where() const noexcept { return where_; }

private:
    ErrorCode code_;
    std::string where_;
};

[[nodiscard]] inline Error bad_input(std::string where, const std::string& message) {
    return {ErrorCode::bad_input, std::move(where), message};
}

}  // namespace haptogram
