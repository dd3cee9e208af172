// SPDX-License-Identifier: Apache-2.0
#include "haptogram/base/process.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <system_error>

#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"

extern char** environ;

namespace haptogram {

namespace fs = std::filesystem;

TemporaryFolder::TemporaryFolder() {
    std::error_code error;
    std::string name = (fs::temp_directory_path(error) / "haptogram-XXXXXX").string();
    if (error || ::mkdtemp(name.data()) == nullptr)
        throw bad_input(name, "no temporary folder can be made; set TMPDIR to a place where one can");
    path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
}

ProcessResult run_process(const fs::path& folder, const std::vector<std::string>& command, const fs::path& input,
                          const fs::path& output) {
    const TemporaryFolder own;
    const std::string said = (own.path() / "stderr").string();
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
    if (error != 0)
        throw Error(ErrorCode::failed, command[0], fmt::format("cannot be started: {}", std::strerror(error)));
    int status = 0;
    while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    return {WIFEXITED(status) && WEXITSTATUS(status) == 0, read_file(said)};
}

fs::path find_program(const std::string& name) {
    const char* const path = std::getenv("PATH");
    std::string_view rest = path == nullptr ? "" : path;
    while (!rest.empty()) {
        const std::size_t end = std::min(rest.find(':'), rest.size());
        const fs::path candidate = fs::path(rest.substr(0, end)) / name;
        if (::access(candidate.c_str(), X_OK) == 0) return candidate;
        rest.remove_prefix(std::min(end + 1, rest.size()));
    }
    return {};
}

fs::path own_program() {
    std::error_code ignored;
    return fs::read_symlink("/proc/self/exe", ignored);
}

fs::path own_data(const std::string& name) {
    return (own_program().parent_path() / "../share/haptogram" / name).lexically_normal();
}

std::string python_program() {
    if (const char* const named = std::getenv("HAPTOGRAM_PYTHON"); named != nullptr && *named != '\0') return named;
    std::error_code ignored;
    const fs::path built_with = own_data("python3");
    if (fs::exists(built_with, ignored)) return built_with.string();
    const fs::path found = find_program("python3");
    return found.empty() ? "python3" : found.string();
}

}  // namespace haptogram
