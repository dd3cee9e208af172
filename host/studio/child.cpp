// SPDX-License-Identifier: Apache-2.0
#include "child.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>

#include "haptogram/base/error.hpp"

namespace haptogram::studio {

Child::Child(const std::string& name, std::vector<std::string> arguments) {
    std::array<int, 2> pipe{};
    if (::pipe2(pipe.data(), O_CLOEXEC) != 0)
        throw Error(ErrorCode::failed, name, "no pipe can be made; close other programs");
    arguments.insert(arguments.begin(), "haptogram");
    std::vector<char*> words;
    for (std::string& argument : arguments) words.push_back(argument.data());
    words.push_back(nullptr);
    process_ = ::fork();
    if (process_ == 0) {                     // only what is safe between fork and exec
        ::setpgid(0, 0);                     // Ctrl-C is for us: the outputs go off first
        ::prctl(PR_SET_PDEATHSIG, SIGTERM);  // nobody else would end it
        ::setpriority(PRIO_PROCESS, 0, 10);  // it computes as fast as it can, and the page wants to move meanwhile
        ::dup2(pipe[1], STDOUT_FILENO);
        ::dup2(pipe[1], STDERR_FILENO);
        ::execv("/proc/self/exe", words.data());
        ::_exit(127);
    }
    ::close(pipe[1]);
    said_ = pipe[0];
    if (process_ < 0) {
        ::close(said_);
        throw Error(ErrorCode::failed, name, "no process can be started; close other programs");
    }
}

Child::~Child() {
    ::kill(process_, SIGTERM);
    while (::waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {
    }
    ::close(said_);
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

}  // namespace haptogram::studio
