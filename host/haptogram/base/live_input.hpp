// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <cstddef>
#include <optional>
#include <string>

namespace haptogram {

/// The bytes of a pipe, a terminal or a file, as they come.
class LiveInput {
public:
    /// @param path  "-" is standard input
    /// @throws Error{bad_input} when it cannot be opened
    explicit LiveInput(const std::string& path);
    /// A named pipe that any program may write to, now or later, one after the other: it has no end.
    /// @throws Error{bad_argument} naming `what` when the path is no such pipe
    [[nodiscard]] static LiveInput of_pipe(const std::string& path, const std::string& what);
    LiveInput(LiveInput&& other) noexcept;
    LiveInput& operator=(const LiveInput&) = delete;
    ~LiveInput();

    /// Waits for bytes, at most for `patience`, and appends those that are there. More may be left.
    /// @return whether anything came, or the end
    /// @throws Error{bad_input} naming the file and the system's reason
    bool read(std::string& to, std::chrono::milliseconds patience);
    [[nodiscard]] bool ended() const { return ended_; }
    /// Whether it is a file, all of which is there already.
    [[nodiscard]] bool is_file() const { return is_file_; }
    /// For messages.
    [[nodiscard]] const std::string& name() const { return name_; }

private:
    LiveInput(std::string name, int descriptor);

    std::string name_;
    int descriptor_;  // 0, which is not closed: standard input
    bool ended_ = false, is_file_ = false;
};

/// The lines of such an input.
class LiveText {
public:
    /// As LiveInput.
    explicit LiveText(const std::string& path) : input_(path) {}
    [[nodiscard]] static LiveText of_pipe(const std::string& path, const std::string& what) {
        return LiveText(path, what);
    }

    static constexpr std::size_t longest_line = 1'000'000;  ///< bytes; those of scenes and hands are shorter

    /// The next line without its end; empty when there is none yet.
    /// @throws Error{bad_input} as LiveInput::read(), and for a line that is longer
    std::optional<std::string> next(std::chrono::milliseconds patience);
    [[nodiscard]] bool ended() const { return input_.ended() && text_.empty(); }
    [[nodiscard]] bool is_file() const { return input_.is_file(); }
    /// The last line, for messages.
    [[nodiscard]] std::string where() const;

private:
    LiveText(const std::string& path, const std::string& what) : input_(LiveInput::of_pipe(path, what)) {}

    LiveInput input_;
    std::string text_;
    std::size_t number_ = 0;
};

}  // namespace haptogram
