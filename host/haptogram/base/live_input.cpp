// SPDX-License-Identifier: Apache-2.0
#include "haptogram/base/live_input.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "haptogram/base/error.hpp"

namespace haptogram {

LiveInput::LiveInput(const std::string& path)
    : name_(path == "-" ? "standard input" : path),
      descriptor_(path == "-" ? STDIN_FILENO : ::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
    struct stat state {};
    if (descriptor_ < 0 || ::fstat(descriptor_, &state) != 0)
        throw bad_input(path,
                        fmt::format("cannot be opened: {}; check the path", std::generic_category().message(errno)));
    is_file_ = S_ISREG(state.st_mode);
    // Pictures are larger than the 64 KiB that a pipe usually holds. Where the system allows no more, it takes more
    // calls.
    if (S_ISFIFO(state.st_mode)) ::fcntl(descriptor_, F_SETPIPE_SZ, 1 << 20);
}

LiveInput::~LiveInput() {
    if (descriptor_ != STDIN_FILENO) ::close(descriptor_);
}

bool LiveInput::read(std::string& to, std::chrono::milliseconds patience) {
    if (ended_) return true;
    pollfd wait{descriptor_, POLLIN, 0};
    if (::poll(&wait, 1, static_cast<int>(patience.count())) <= 0) return false;
    constexpr std::size_t most = std::size_t{1} << 18U;
    const std::size_t before = to.size();
    to.resize(before + most);
    const ssize_t count = ::read(descriptor_, to.data() + before, most);
    const int error = errno;
    to.resize(before + (count > 0 ? static_cast<std::size_t>(count) : 0));
    if (count < 0 && error == EINTR) return false;
    if (count < 0) throw bad_input(name_, fmt::format("cannot be read: {}", std::generic_category().message(error)));
    ended_ = count == 0;
    return true;
}

std::optional<std::string> LiveText::next(std::chrono::milliseconds patience) {
    std::size_t newline = text_.find('\n');
    while (newline == std::string::npos && !input_.ended()) {
        const std::size_t seen = text_.size();
        if (!input_.read(text_, patience)) return {};
        newline = text_.find('\n', seen);
    }
    if (newline == std::string::npos && text_.empty()) return {};
    std::string line = text_.substr(0, newline);
    text_.erase(0, newline == std::string::npos ? newline : newline + 1);
    ++number_;
    return line;
}

std::string LiveText::where() const { return fmt::format("{}:{}", input_.name(), number_); }

}  // namespace haptogram
