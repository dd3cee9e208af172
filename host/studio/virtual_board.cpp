// SPDX-License-Identifier: Apache-2.0
#include "virtual_board.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <nlohmann/json.hpp>

#include "haptogram/base/error.hpp"
#include "haptogram/link/port.hpp"

namespace haptogram::studio {

VirtualBoard::VirtualBoard(std::uint32_t channels, std::string model) {
    std::array<int, 2> pipe{};
    if (::pipe2(pipe.data(), O_CLOEXEC) != 0)
        throw Error(ErrorCode::failed, "virtual board", "no pipe can be made; close other programs");
    std::string count = std::to_string(channels);
    std::string words[] = {"haptogram", "board", "run", "--json", "--model", "--channels"};
    char* const arguments[] = {words[0].data(), words[1].data(), words[2].data(), words[3].data(), words[4].data(),
                               model.data(),    words[5].data(), count.data(),    nullptr};
    process_ = ::fork();
    if (process_ == 0) {                     // only what is safe between fork and exec
        ::setpgid(0, 0);                     // Ctrl-C is for us: the outputs go off first
        ::prctl(PR_SET_PDEATHSIG, SIGTERM);  // nobody else would end it
        ::setpriority(PRIO_PROCESS, 0, 10);  // it simulates as fast as it can, and the page wants to move meanwhile
        ::dup2(pipe[1], STDOUT_FILENO);
        ::dup2(pipe[1], STDERR_FILENO);
        ::execv("/proc/self/exe", arguments);
        ::_exit(127);
    }
    ::close(pipe[1]);
    said_ = pipe[0];
    if (process_ < 0) {
        ::close(said_);
        throw Error(ErrorCode::failed, "virtual board", "no process can be started; close other programs");
    }
}

VirtualBoard::~VirtualBoard() {
    ::kill(process_, SIGTERM);
    while (::waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {
    }
    ::close(said_);
}

std::unique_ptr<link::Transport> VirtualBoard::open(std::chrono::milliseconds patience) {
    const std::lock_guard lock(mutex_);
    const auto until = std::chrono::steady_clock::now() + patience;
    while (!port_ && text_.find('\n') == std::string::npos) {
        const auto left =
            std::chrono::duration_cast<std::chrono::milliseconds>(until - std::chrono::steady_clock::now());
        pollfd waiting{said_, POLLIN, 0};
        if (left.count() <= 0 || ::poll(&waiting, 1, static_cast<int>(left.count())) == 0)
            throw Error(ErrorCode::device, "virtual board", "it is still starting");
        std::array<char, 4096> bytes{};
        const ssize_t count = ::read(said_, bytes.data(), bytes.size());
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) throw Error(ErrorCode::device, "virtual board", "it ended without a word");
        text_.append(bytes.data(), static_cast<std::size_t>(count));
    }
    if (!port_) {
        const nlohmann::json line = nlohmann::json::parse(text_.substr(0, text_.find('\n')), nullptr, false);
        if (!line.is_object() || !line.contains("port"))
            throw Error(ErrorCode::device, "virtual board", text_.substr(0, text_.find('\n')));
        port_ = Port{line["port"], line["baud"]};
    }
    return link::open_port(port_->name, port_->baud);
}

}  // namespace haptogram::studio
