// SPDX-License-Identifier: Apache-2.0
#include "pseudo_terminal.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <system_error>

#include "haptogram/base/error.hpp"
#include "haptogram/link/serial_line.hpp"

namespace haptogram::sim {
namespace {

constexpr std::size_t most_waiting = 1U << 20;

std::string reason() { return std::generic_category().message(errno); }

/// Has bytes pass unchanged in both directions, as on a serial line; the setting lasts while our end is open.
bool make_raw(const std::string& device) {
    const int descriptor = ::open(device.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
    termios settings{};
    bool done = descriptor >= 0 && ::tcgetattr(descriptor, &settings) == 0;
    ::cfmakeraw(&settings);
    done = done && ::tcsetattr(descriptor, TCSANOW, &settings) == 0;
    if (descriptor >= 0) ::close(descriptor);
    return done;
}

}  // namespace

PseudoTerminal::PseudoTerminal(std::uint32_t baud, const std::filesystem::path& link)
    : baud_(baud), descriptor_(::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC | O_NONBLOCK)) {
    std::array<char, 128> name{};
    const bool open = descriptor_ >= 0 && ::grantpt(descriptor_) == 0 && ::unlockpt(descriptor_) == 0 &&
                      ::ptsname_r(descriptor_, name.data(), name.size()) == 0 && make_raw(name.data());
    const std::string why = open ? "" : reason();
    std::error_code error;
    if (open && !link.empty()) std::filesystem::create_symlink(name.data(), link, error);
    if (!open || error) {
        if (descriptor_ >= 0) ::close(descriptor_);
        if (error)
            throw bad_input(link.string(), fmt::format("cannot be made a link to {}: {}; name a place where nothing is",
                                                       name.data(), error.message()));
        throw Error(ErrorCode::device, "pseudo-terminal", fmt::format("the system gives none: {}", why));
    }
    device_ = name.data();
    link_ = link;
}

PseudoTerminal::~PseudoTerminal() {
    std::error_code error;  // somebody may have removed the link, or put something else in its place
    if (!link_.empty() && std::filesystem::read_symlink(link_, error) == device_) std::filesystem::remove(link_, error);
    ::close(descriptor_);
}

std::vector<std::uint8_t> PseudoTerminal::read(std::chrono::milliseconds patience) {
    pollfd wait{descriptor_, POLLIN, 0};
    if (patience.count() > 0 && ::poll(&wait, 1, static_cast<int>(patience.count())) > 0 &&
        (wait.revents & POLLIN) == 0)
        ::poll(nullptr, 0,
               static_cast<int>(patience.count()));  // while nobody has it open, poll() returns at once, so sleep
    std::array<std::uint8_t, 4096> buffer{};
    const ssize_t count = ::read(descriptor_, buffer.data(), buffer.size());
    if (count <= 0 || !same_rate()) return {};
    return {buffer.begin(), buffer.begin() + count};
}

/// 8N1 works while both ends differ by less than some 4 %.
bool PseudoTerminal::same_rate() const {
    const std::uint32_t theirs = link::baud_rate(descriptor_);
    return theirs > baud_ - baud_ / 25 && theirs < baud_ + baud_ / 25;
}

void PseudoTerminal::write(std::span<const std::uint8_t> bytes) {
    if (same_rate())
        waiting_.insert(waiting_.end(), bytes.begin(), bytes.end());
    else
        waiting_.clear();
    pollfd state{descriptor_, POLLOUT, 0};
    ::poll(&state, 1, 0);
    if ((state.revents & POLLHUP) != 0 || waiting_.size() > most_waiting) waiting_.clear();
    if (waiting_.empty()) return;
    const ssize_t count = ::write(descriptor_, waiting_.data(), waiting_.size());
    if (count > 0) waiting_.erase(waiting_.begin(), waiting_.begin() + count);
}

}  // namespace haptogram::sim
