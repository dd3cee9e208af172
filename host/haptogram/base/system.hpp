// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

/// What each operating system does in its own way: system_posix.cpp and system_windows.cpp have the same functions.
/// Where one fails, errno says why.
namespace haptogram::system {

/// Waits for nobody who writes into a named pipe.
/// @return a descriptor of bytes, not of lines; −1 when it fails
[[nodiscard]] int open_to_read(const std::filesystem::path& path);
/// A named pipe. Opening does not wait for a writer, and the pipe does not end when a writer closes it.
[[nodiscard]] int open_pipe(const std::filesystem::path& path);
[[nodiscard]] int open_to_write(const std::filesystem::path& path);
/// A new file in the folder of `target`, with the target's rights, or those of any new file. Where the system allows,
/// the file has no name yet, so that nothing of it stays when the program is killed.
/// @return its descriptor, −1 when it fails; and the name beside `target` that it has or will get
[[nodiscard]] std::pair<int, std::filesystem::path> create_beside(const std::filesystem::path& target);
[[nodiscard]] bool is_file(int descriptor);
/// Standard input or output as bytes.
[[nodiscard]] int standard(int descriptor);
void close(int descriptor);
/// @return how many bytes; −1 when it fails
[[nodiscard]] std::ptrdiff_t read(int descriptor, char* to, std::size_t most);
[[nodiscard]] std::ptrdiff_t write(int descriptor, const char* from, std::size_t most);
/// Waits until it is on the disk.
[[nodiscard]] bool sync(int descriptor);
/// Gives a file of create_beside() its name, if it has none yet.
[[nodiscard]] bool give_name(int descriptor, const std::filesystem::path& name);
/// In one step, also onto a file that is there.
[[nodiscard]] bool rename(const std::filesystem::path& from, const std::filesystem::path& to);

/// Whether something, or the end, can be read within so long.
[[nodiscard]] bool wait_to_read(int descriptor, std::chrono::milliseconds patience);
/// Whether something can be written within so long. True where the system does not say.
[[nodiscard]] bool wait_to_write(int descriptor, std::chrono::milliseconds patience);
/// A pipe holds more after it, where the system allows that.
void widen_pipe(int descriptor);

/// A new folder with a name of its own, which only this user may read; empty when it fails.
[[nodiscard]] std::filesystem::path create_folder(const std::filesystem::path& in);
/// Runs a program to its end. The files are its standard input, output and error; an empty one is none.
/// @return its exit code; −1 when it cannot be started
[[nodiscard]] int run(const std::filesystem::path& folder, const std::vector<std::string>& command,
                      const std::filesystem::path& input, const std::filesystem::path& output,
                      const std::filesystem::path& said);
[[nodiscard]] bool is_program(const std::filesystem::path& path);
/// The file of the program that runs.
[[nodiscard]] std::filesystem::path own_program();
/// Between the folders of PATH.
extern const char between_folders;

/// Of this machine.
[[nodiscard]] double memory_bytes();

}  // namespace haptogram::system
