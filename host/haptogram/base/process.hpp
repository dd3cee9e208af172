// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace haptogram {

/// A temporary folder, in which one program leaves files for another. It is removed together with this object.
class TemporaryFolder {
public:
    /// @throws Error{bad_input} when none can be made
    TemporaryFolder();
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;
    ~TemporaryFolder();

    [[nodiscard]] const std::filesystem::path& path() const { return path_; }

private:
    std::filesystem::path path_;
};

/// How a program ended, and what it said on its standard error.
struct ProcessResult {
    bool succeeded = false;
    std::string said;
};

/// Runs a program in `folder` and waits for its end.
/// @param command  the program, found in PATH unless it has a slash, and its arguments
/// @param input    file that is its standard input; empty for none
/// @param output   file that its standard output goes to; empty for none
/// @throws Error{failed} when it cannot be started
[[nodiscard]] ProcessResult run_process(const std::filesystem::path& folder, const std::vector<std::string>& command,
                                        const std::filesystem::path& input = {},
                                        const std::filesystem::path& output = {});

/// The program of that name in PATH; empty when there is none.
[[nodiscard]] std::filesystem::path find_program(const std::string& name);

/// The file of the program that runs.
[[nodiscard]] std::filesystem::path own_program();

/// A file or folder that came with the program: ../share/haptogram/NAME from where it lies, in the build's tree, too.
/// It need not exist.
[[nodiscard]] std::filesystem::path own_data(const std::string& name);

/// Python: what the variable HAPTOGRAM_PYTHON names, else the one that this program was built with when it lies in its
/// build's tree, else python3 in PATH.
[[nodiscard]] std::string python_program();

}  // namespace haptogram
