// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <system_error>
#ifdef __APPLE__
#include <mach-o/dyld.h>
#endif

#include "haptogram/base/system.hpp"
#include "haptogram/base/text.hpp"

extern char** environ;

namespace haptogram::system {

namespace fs = std::filesystem;

int open_to_read(const fs::path& path) {
    const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (descriptor >= 0) static_cast<void>(::fcntl(descriptor, F_SETFL, 0));
    return descriptor;
}

int open_pipe(const fs::path& path) {
    struct stat status = {};
    if (::stat(path.c_str(), &status) != 0) return -1;
    if (S_ISFIFO(status.st_mode)) return ::open(path.c_str(), O_RDWR | O_CLOEXEC | O_NONBLOCK);  // its own writer, too
    errno = ESPIPE;
    return -1;
}

int open_to_write(const fs::path& path) { return ::open(path.c_str(), O_WRONLY | O_CLOEXEC); }

namespace {

std::string link_to(int descriptor) { return "/proc/self/fd/" + std::to_string(descriptor); }

int create_nameless([[maybe_unused]] const fs::path& target) {
#ifdef O_TMPFILE
    const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
    const int descriptor = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0666);
    if (descriptor < 0 || ::access(link_to(descriptor).c_str(), F_OK) == 0) return descriptor;
    ::close(descriptor);
#endif
    return -1;
}

}  // namespace

std::pair<int, fs::path> create_beside(const fs::path& target) {
    for (;;) {
        const fs::path name = target.string() + "." + make_token().substr(0, 8);
        int descriptor = create_nameless(target);
        if (descriptor < 0) descriptor = ::open(name.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (descriptor < 0 && errno == EEXIST) continue;
        struct stat there = {};
        if (descriptor >= 0 && ::stat(target.c_str(), &there) == 0 &&
            ::fchmod(descriptor, there.st_mode & 07777) != 0) {
            const int reason = errno;
            ::close(descriptor);
            ::unlink(name.c_str());
            errno = reason;
            return {-1, {}};
        }
        return {descriptor, name};
    }
}

bool is_file(int descriptor) {
    struct stat status = {};
    return ::fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode);
}

int standard(int descriptor) { return descriptor; }
void close(int descriptor) { ::close(descriptor); }
std::ptrdiff_t read(int descriptor, char* to, std::size_t most) { return ::read(descriptor, to, most); }
std::ptrdiff_t write(int descriptor, const char* from, std::size_t most) { return ::write(descriptor, from, most); }
bool sync(int descriptor) { return ::fsync(descriptor) == 0; }

bool give_name(int descriptor, const fs::path& name) {
    struct stat status = {};
    return ::fstat(descriptor, &status) == 0 &&
           (status.st_nlink > 0 ||
            ::linkat(AT_FDCWD, link_to(descriptor).c_str(), AT_FDCWD, name.c_str(), AT_SYMLINK_FOLLOW) == 0);
}

bool rename(const fs::path& from, const fs::path& to) { return ::rename(from.c_str(), to.c_str()) == 0; }

bool wait_to_read(int descriptor, std::chrono::milliseconds patience) {
    pollfd wait{descriptor, POLLIN, 0};
    return ::poll(&wait, 1, static_cast<int>(patience.count())) > 0;
}

bool wait_to_write(int descriptor, std::chrono::milliseconds patience) {
    pollfd wait{descriptor, POLLOUT, 0};
    return ::poll(&wait, 1, static_cast<int>(patience.count())) > 0 && (wait.revents & POLLOUT) != 0;
}

void widen_pipe([[maybe_unused]] int descriptor) {
#ifdef F_SETPIPE_SZ
    ::fcntl(descriptor, F_SETPIPE_SZ, 1 << 20);
#endif
}

fs::path create_folder(const fs::path& in) {
    std::string name = (in / "haptogram-XXXXXX").string();
    return ::mkdtemp(name.data()) == nullptr ? fs::path() : fs::path(name);
}

int run(const fs::path& folder, const std::vector<std::string>& command, const fs::path& input, const fs::path& output,
        const fs::path& said) {
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
    const auto open = [&actions](int descriptor, const fs::path& file, int flags) {
        posix_spawn_file_actions_addopen(&actions, descriptor, file.empty() ? "/dev/null" : file.c_str(), flags, 0600);
    };
    open(STDIN_FILENO, input, O_RDONLY);
    open(STDOUT_FILENO, output, O_WRONLY | O_CREAT | O_TRUNC);
    open(STDERR_FILENO, said, O_WRONLY | O_CREAT | O_TRUNC);
    std::vector<char*> arguments;
    for (const std::string& argument : command) arguments.push_back(const_cast<char*>(argument.c_str()));
    arguments.push_back(nullptr);
    pid_t child = 0;
    const int error = ::posix_spawnp(&child, arguments[0], &actions, nullptr, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (error != 0) {
        errno = error;
        return -1;
    }
    int status = 0;
    while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

bool is_program(const fs::path& path) { return ::access(path.c_str(), X_OK) == 0; }

fs::path own_program() {
#ifdef __APPLE__
    std::uint32_t size = 0;
    _NSGetExecutablePath(nullptr, &size);
    std::string name(size, '\0');
    _NSGetExecutablePath(name.data(), &size);
    return name.c_str();
#else
    std::error_code ignored;
    return fs::read_symlink("/proc/self/exe", ignored);
#endif
}

const char between_folders = ':';

double memory_bytes() {
    return static_cast<double>(::sysconf(_SC_PHYS_PAGES)) * static_cast<double>(::sysconf(_SC_PAGE_SIZE));
}

}  // namespace haptogram::system
