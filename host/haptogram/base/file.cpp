// SPDX-License-Identifier: Apache-2.0
#include "haptogram/base/file.hpp"

#include <fmt/core.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <memory>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include "haptogram/base/bundle.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/shipped.hpp"
#include "haptogram/base/system.hpp"
#include "haptogram/base/text.hpp"

namespace haptogram {
namespace {

namespace fs = std::filesystem;
constexpr int standard_input = 0, standard_output = 1, standard_error = 2;
/// Bytes of a pipe or a device, which do not say how many come.
constexpr std::size_t most_of_a_stream = std::size_t{1} << 28;
constexpr std::chrono::seconds most_silence{60};

std::string reason() { return std::generic_category().message(errno); }

/// Is closed at the end; `std::ifstream` would lose the reason of a failure.
struct Descriptor {
    const int number;
    ~Descriptor() {
        if (number > standard_error) system::close(number);
    }
};

/// False, with errno set, when not everything could be written.
bool write_all(int descriptor, std::string_view content) {
    while (!content.empty()) {
        const std::ptrdiff_t count = system::write(descriptor, content.data(), content.size());
        if (count < 0) {
            if (errno == EINTR) continue;
            return false;
        }
        content.remove_prefix(static_cast<std::size_t>(count));
    }
    return true;
}

Error cannot_write(const std::filesystem::path& path) {
    return bad_input(
        path.string(),
        fmt::format("cannot be written: {}; choose another place or make room, nothing was left behind", reason()));
}

}  // namespace

std::string ending_of(const std::filesystem::path& path) { return lower_case(path.extension().string()); }

StagedFile::StagedFile(fs::path path) : path_(std::move(path)) {
    std::error_code ignored;
    const fs::file_status status = fs::status(path_, ignored);
    const bool exists = fs::exists(status);
    if (path_ == "-" || (exists && !fs::is_regular_file(status))) {
        descriptor_ = path_ == "-" ? system::standard(standard_output) : system::open_to_write(path_);
        if (descriptor_ < 0) throw cannot_write(path_);
        return;
    }
    target_ = exists ? fs::canonical(path_) : path_;  // keep a symbolic link
    const auto [descriptor, beside] = system::create_beside(target_);
    if (descriptor < 0) throw cannot_write(path_);
    descriptor_ = descriptor;
    beside_ = beside;
}

StagedFile::~StagedFile() {
    if (descriptor_ > standard_error) system::close(descriptor_);
    std::error_code ignored;
    if (!beside_.empty()) fs::remove(beside_, ignored);
}

void StagedFile::fill(std::string_view content) {
    if (!write_all(descriptor_, content) || (!beside_.empty() && !system::sync(descriptor_))) fail();
}

void StagedFile::commit() {
    if (beside_.empty()) return;
    beside();
    system::close(std::exchange(descriptor_, -1));  // Windows renames no file that is open
    if (!system::rename(beside_, target_)) fail();
    beside_.clear();
}

const fs::path& StagedFile::beside() {
    if (!beside_.empty() && !named_ && !system::give_name(descriptor_, beside_)) fail();
    named_ = true;  // and whoever writes by name may have put another file there
    return beside_;
}

void StagedFile::fail() const { throw cannot_write(path_); }

std::string read_file(const std::filesystem::path& path) {
    if (const auto shipped = shipped_file(path.string())) return std::string(*shipped);
    if (std::optional<std::string> bundled = read_bundled(path)) return *std::move(bundled);
    const Descriptor file{path == "-" ? system::standard(standard_input) : system::open_to_read(path)};
    if (file.number < 0) throw bad_input(path.string(), fmt::format("cannot be opened: {}; check the path", reason()));
    std::string content;
    std::error_code no_file;
    if (const std::uintmax_t size = fs::file_size(path, no_file); !no_file) content.reserve(size);
    if (no_file && path != "-" && !system::wait_to_read(file.number, most_silence))
        throw bad_input(
            path.string(),
            fmt::format("nobody wrote into it for {} s; give a file, or first start the program that writes",
                        most_silence.count()));
    std::array<char, 1 << 16> buffer{};
    for (;;) {
        const std::ptrdiff_t count = system::read(file.number, buffer.data(), buffer.size());
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) throw bad_input(path.string(), fmt::format("cannot be read: {}", reason()));
        if (count == 0) return content;
        if (no_file && content.size() > most_of_a_stream)
            throw bad_input(path.string(),
                            fmt::format("has no end within {} MiB; give a file", most_of_a_stream >> 20));
        content.append(buffer.data(), static_cast<std::size_t>(count));
    }
}

void write_file(const std::filesystem::path& path, std::string_view content) {
    StagedFile file(path);
    file.fill(content);
    file.commit();
}

void write_files(const std::vector<std::pair<std::filesystem::path, std::string>>& files) {
    std::vector<std::unique_ptr<StagedFile>> staged;
    for (const auto& [path, content] : files) {
        staged.push_back(std::make_unique<StagedFile>(path));
        staged.back()->fill(content);
    }
    for (const auto& file : staged) file->beside();  // which may fail, as with a name too long
    for (const auto& file : staged) file->commit();
}

}  // namespace haptogram
