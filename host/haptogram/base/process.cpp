// SPDX-License-Identifier: Apache-2.0
#include "haptogram/base/process.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <string_view>
#include <system_error>

#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/system.hpp"

namespace haptogram {

namespace fs = std::filesystem;

TemporaryFolder::TemporaryFolder() {
    std::error_code error;
    const fs::path in = fs::temp_directory_path(error);
    if (!error) path_ = system::create_folder(in);
    if (path_.empty())
        throw bad_input(in.string(), "no temporary folder can be made in it; set TMPDIR to a place where one can");
}

TemporaryFolder::~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
}

ProcessResult run_process(const fs::path& folder, const std::vector<std::string>& command, const fs::path& input,
                          const fs::path& output) {
    const TemporaryFolder own;
    const fs::path said = own.path() / "stderr";
    const int code = system::run(folder, command, input, output, said);
    if (code < 0)
        throw Error(ErrorCode::failed, command[0],
                    fmt::format("cannot be started: {}", std::generic_category().message(errno)));
    return {code == 0, read_file(said)};
}

fs::path find_program(const std::string& name) {
    const char* const path = std::getenv("PATH");
    std::string_view rest = path == nullptr ? "" : path;
    while (!rest.empty()) {
        const std::size_t end = std::min(rest.find(system::between_folders), rest.size());
        const fs::path candidate = fs::path(rest.substr(0, end)) / name;
        if (system::is_program(candidate)) return candidate;
        rest.remove_prefix(std::min(end + 1, rest.size()));
    }
    return {};
}

fs::path own_program() { return system::own_program(); }

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
