// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace haptogram {

/// The whole of a file. "-" is standard input; "shipped:…" is a file of the library (shipped.hpp),
/// and "NAME.haptogram/…" a file of a bundle (bundle.hpp).
/// @throws Error{bad_input} naming the path and the system's reason
[[nodiscard]] std::string read_file(const std::filesystem::path& path);

/// @return ".png" of "a/b.png": what a file's name says that it is, in small letters; empty without one
[[nodiscard]] std::string ending_of(const std::filesystem::path& path);

/// A file that is written beside its final place. commit() renames it into that place; without commit(), it is removed.
/// Standard output ("-"), devices and pipes, which cannot be renamed onto, are written directly.
class StagedFile {
public:
    /// @throws Error{bad_input} when nothing can be written there
    explicit StagedFile(std::filesystem::path path);
    StagedFile(const StagedFile&) = delete;
    StagedFile& operator=(const StagedFile&) = delete;
    ~StagedFile();

    void fill(std::string_view content);
    void commit();
    /// Where it is until it is committed, for a library that writes files by name; empty for what is written directly.
    const std::filesystem::path& beside();

private:
    [[noreturn]] void fail() const;

    std::filesystem::path path_;
    std::filesystem::path target_;
    std::filesystem::path beside_;
    int descriptor_ = -1;
    bool named_ = false;
};

/// Writes `content` beside `path` and renames it into place once all of it is on the disk, so that a reader sees the
/// old file or the new one and a failure leaves nothing half-written. "-" is standard output; a device or a pipe, which
/// cannot be renamed onto, is written directly.
/// @throws Error{bad_input} naming the path and the system's reason (no such folder, no permission, disk full)
void write_file(const std::filesystem::path& path, std::string_view content);

/// Several files at once: all are written beside their places before the first is renamed, so that a failure to write
/// any leaves all of them as they were.
void write_files(const std::vector<std::pair<std::filesystem::path, std::string>>& files);

/// Lower-case hexadecimal SHA-256.
[[nodiscard]] std::string sha256(std::string_view content);

}  // namespace haptogram
