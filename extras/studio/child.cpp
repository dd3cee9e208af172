// SPDX-License-Identifier: Apache-2.0
#include "child.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <thread>

#include "haptogram/base/error.hpp"

extern char** environ;

namespace haptogram::studio {
namespace {

/// Pointers to words as exec wants them.
std::vector<char*> pointers(std::vector<std::string>& words) {
    std::vector<char*> found;
    for (std::string& word : words) found.push_back(word.data());
    found.push_back(nullptr);
    return found;
}

/// Our environment, with `changed` in it.
std::vector<std::string> environment_with(const std::vector<std::string>& changed) {
    std::vector<std::string> all = changed;
    for (char** each = environ; *each != nullptr; ++each) {
        const std::string_view have = *each;
        const std::string_view name = have.substr(0, have.find('=') + 1);
        if (std::none_of(changed.begin(), changed.end(), [&](const auto& other) { return other.starts_with(name); }))
            all.emplace_back(have);
    }
    return all;
}

}  // namespace

Child::Child(const std::string& name, std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "/proc/self/exe");
    // It computes as fast as it can, and the page wants to move meanwhile.
    start(name, {.words = std::move(arguments), .environment = {}}, -1, 10);
}

Child::Child(const std::string& name, const Command& command) {
    // Unlike a pipe, a socket can be written to without waiting, and without a signal when nobody reads.
    std::array<int, 2> ends{};
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0)
        throw Error(ErrorCode::failed, name, "no pipe can be made; close other programs");
    told_ = ends[0];
    try {
        start(name, command, ends[1], 0);
    } catch (...) {
        ::close(ends[0]);
        ::close(ends[1]);
        throw;
    }
    ::close(ends[1]);
}

void Child::start(const std::string& name, const Command& command, int input, int priority) {
    std::array<int, 2> pipe{};
    if (::pipe2(pipe.data(), O_CLOEXEC) != 0)
        throw Error(ErrorCode::failed, name, "no pipe can be made; close other programs");
    std::vector<std::string> words = command.words, environment = environment_with(command.environment);
    const std::vector<char*> arguments = pointers(words), variables = pointers(environment);
    const std::string folder = command.folder.string();
    process_ = ::fork();
    if (process_ == 0) {                     // only what is safe between fork and exec
        ::setpgid(0, 0);                     // Ctrl-C is for us: the outputs go off first
        ::prctl(PR_SET_PDEATHSIG, SIGTERM);  // nobody else would end it
        if (priority != 0) ::setpriority(PRIO_PROCESS, 0, priority);
        if (input >= 0) ::dup2(input, STDIN_FILENO);
        ::dup2(pipe[1], STDOUT_FILENO);
        ::dup2(pipe[1], STDERR_FILENO);
        ::close_range(3, ~0U, 0);  // at once: until exec a port of ours would be locked
        if (folder.empty() || ::chdir(folder.c_str()) == 0) ::execve(arguments[0], arguments.data(), variables.data());
        ::_exit(127);
    }
    ::close(pipe[1]);
    if (process_ < 0) {
        ::close(pipe[0]);
        throw Error(ErrorCode::failed, name, "no process can be started; close other programs");
    }
    ::setpgid(process_, process_);  // here, too, so that it is so before anybody sends a signal
    said_ = pipe[0];
}

Child::~Child() {
    if (process_ > 0) {
        ::kill(process_, SIGTERM);
        while (::waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {
        }
    }
    ::close(said_);
    if (told_ >= 0) ::close(told_);
}

Child::Heard Child::hear(std::string& text, std::chrono::milliseconds patience) const {
    pollfd waiting{said_, POLLIN, 0};
    if (::poll(&waiting, 1, static_cast<int>(patience.count())) <= 0) return Heard::nothing;
    std::array<char, 4096> bytes{};
    const ssize_t count = ::read(said_, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) return Heard::nothing;
    if (count <= 0) return Heard::end;
    text.append(bytes.data(), static_cast<std::size_t>(count));
    return Heard::more;
}

bool Child::say(std::string_view text) const {
    return ::send(told_, text.data(), text.size(), MSG_NOSIGNAL | MSG_DONTWAIT) == static_cast<ssize_t>(text.size());
}

void Child::signal(int number) const {
    if (process_ > 0) ::kill(-process_, number);
}

std::optional<int> Child::wait(std::chrono::milliseconds patience) {
    const auto until = std::chrono::steady_clock::now() + patience;
    int status = 0;
    for (;;) {
        const pid_t ended = ::waitpid(process_, &status, WNOHANG);
        if (ended == process_) break;
        if (ended < 0 && errno != EINTR) break;
        if (std::chrono::steady_clock::now() >= until) signal(SIGKILL);
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    process_ = -1;
    if (!WIFEXITED(status)) return {};
    return WEXITSTATUS(status);
}

}  // namespace haptogram::studio
