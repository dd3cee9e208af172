// SPDX-License-Identifier: Apache-2.0
#include "haptogram/base/live_input.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/base/system.hpp"

namespace haptogram {

LiveInput::LiveInput(const std::string& path)
    : name_(path == "-" ? "standard input" : path),
      descriptor_(path == "-" ? system::standard(0) : system::open_to_read(path)) {
    if (descriptor_ < 0)
        throw bad_input(path,
                        fmt::format("cannot be opened: {}; check the path", std::generic_category().message(errno)));
    is_file_ = system::is_file(descriptor_);
    system::widen_pipe(descriptor_);  // pictures are larger than the 64 KiB that a pipe usually holds
}

LiveInput::LiveInput(std::string name, int descriptor) : name_(std::move(name)), descriptor_(descriptor) {
    system::widen_pipe(descriptor_);
}

LiveInput::LiveInput(LiveInput&& other) noexcept
    : name_(std::move(other.name_)),
      descriptor_(std::exchange(other.descriptor_, 0)),
      ended_(other.ended_),
      is_file_(other.is_file_) {}

LiveInput LiveInput::of_pipe(const std::string& path, const std::string& what) {
    const int descriptor = system::open_pipe(path);
    if (descriptor >= 0) return {path, descriptor};
    throw bad_argument(what, errno == ESPIPE ? fmt::format("{} is no named pipe; make one with mkfifo", path)
                                             : fmt::format("{} cannot be opened: {}; make a named pipe with mkfifo",
                                                           path, std::generic_category().message(errno)));
}

LiveInput::~LiveInput() {
    if (descriptor_ != 0) system::close(descriptor_);
}

bool LiveInput::read(std::string& to, std::chrono::milliseconds patience) {
    if (ended_) return true;
    if (!system::wait_to_read(descriptor_, patience)) return false;
    constexpr std::size_t most = std::size_t{1} << 18U;
    const std::size_t before = to.size();
    to.resize(before + most);
    const std::ptrdiff_t count = system::read(descriptor_, to.data() + before, most);
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
        if (newline == std::string::npos && text_.size() > longest_line)
            throw bad_input(where(), fmt::format("more than {} bytes without an end of line behind it; expected lines "
                                                 "of text",
                                                 longest_line));
    }
    if (newline == std::string::npos && text_.empty()) return {};
    std::string line = text_.substr(0, newline);
    text_.erase(0, newline == std::string::npos ? newline : newline + 1);
    ++number_;
    return line;
}

std::string LiveText::where() const { return fmt::format("{}:{}", input_.name(), number_); }

}  // namespace haptogram
