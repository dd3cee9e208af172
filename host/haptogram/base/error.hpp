// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace haptogram {

/// What kind of thing went wrong.
enum class ErrorCode {
    failed,        ///< the work was done and its result is not good: a contract is broken, a focus is off
    bad_argument,  ///< what the caller asked for makes no sense
    bad_input,     ///< a file or a value in it cannot be used, or an output cannot be written
    device,        ///< the board, or the link to it
    cancelled,     ///< the caller asked the work to end (base/progress.hpp)
};

/// The one exception type of the project. `where` names the file, line, record or setting; `message` says what was
/// found, what was expected and what to do. `remedies` names the settings, as the option structs of `instrument` call
/// them, that could mend it: a command line shows them as its options, a page as buttons.
class Error : public std::runtime_error {
public:
    Error(ErrorCode code, std::string where, const std::string& message, std::vector<std::string> remedies = {})
        : std::runtime_error(where.empty() ? message : where + ": " + message),
          code_(code),
          where_(std::move(where)),
          message_(message),
          remedies_(std::move(remedies)) {}

    [[nodiscard]] ErrorCode code() const noexcept { return code_; }
    [[nodiscard]] const std::string& where() const noexcept { return where_; }
    /// Whether `where` is the name of a setting, and not that of a file or a thing.
    [[nodiscard]] bool names_setting() const noexcept { return names_setting_; }
    /// Without `where`, which what() puts in front.
    [[nodiscard]] const std::string& message() const noexcept { return message_; }
    [[nodiscard]] const std::vector<std::string>& remedies() const noexcept { return remedies_; }

private:
    ErrorCode code_;
    std::string where_, message_;
    std::vector<std::string> remedies_;
    bool names_setting_ = false;

    friend Error bad_argument(std::string setting, const std::string& message, std::vector<std::string> remedies);
    friend Error impossible(std::string setting, const std::string& message, std::vector<std::string> remedies);
};

[[nodiscard]] inline Error bad_input(std::string where, const std::string& message,
                                     std::vector<std::string> remedies = {}) {
    return {ErrorCode::bad_input, std::move(where), message, std::move(remedies)};
}

/// A setting that makes no sense. @param setting  its name in the option struct, or the setting's place in a file
[[nodiscard]] inline Error bad_argument(std::string setting, const std::string& message,
                                        std::vector<std::string> remedies = {}) {
    Error error(ErrorCode::bad_argument, std::move(setting), message, std::move(remedies));
    error.names_setting_ = true;
    return error;
}

/// A setting that makes sense, but does not suit the other inputs.
[[nodiscard]] inline Error impossible(std::string setting, const std::string& message,
                                      std::vector<std::string> remedies = {}) {
    Error error(ErrorCode::bad_input, std::move(setting), message, std::move(remedies));
    error.names_setting_ = true;
    return error;
}

}  // namespace haptogram
