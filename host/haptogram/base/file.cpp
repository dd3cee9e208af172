// SPDX-License-Identifier: Apache-2.0
#include "haptogram/base/file.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <memory>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include "haptogram/base/bundle.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/shipped.hpp"
#include "haptogram/base/text.hpp"

namespace haptogram {
namespace {

std::string reason() { return std::generic_category().message(errno); }

/// Owns a POSIX descriptor; `std::ofstream` would lose the reason of a failure, and cannot sync.
class Descriptor {
public:
    explicit Descriptor(int number) : number_(number) {}
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    ~Descriptor() {
        if (number_ > STDERR_FILENO) ::close(number_);
    }
    [[nodiscard]] int get() const { return number_; }

private:
    int number_;
};

/// False, with errno set, when not everything could be written.
bool write_all(int descriptor, std::string_view content) {
    while (!content.empty()) {
        const ssize_t count = ::write(descriptor, content.data(), content.size());
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

StagedFile::StagedFile(std::filesystem::path path) : path_(std::move(path)) {
    struct stat status = {};
    const bool exists = ::stat(path_.c_str(), &status) == 0;
    if (path_ == "-" || (exists && !S_ISREG(status.st_mode))) {
        descriptor_ = path_ == "-" ? STDOUT_FILENO : ::open(path_.c_str(), O_WRONLY | O_CLOEXEC);
        if (descriptor_ < 0) throw cannot_write(path_);
        return;
    }
    target_ = exists ? std::filesystem::canonical(path_) : path_;  // keep a symbolic link
    std::string beside = target_.string() + ".XXXXXX";
    descriptor_ = ::mkstemp(beside.data());
    if (descriptor_ < 0) throw cannot_write(path_);
    beside_ = beside;
    const mode_t mask = ::umask(0);
    ::umask(mask);
    if (::fchmod(descriptor_, exists ? status.st_mode & 07777 : 0666 & ~mask) != 0) fail();
}

StagedFile::~StagedFile() {
    if (descriptor_ > STDERR_FILENO) ::close(descriptor_);
    if (!beside_.empty()) ::unlink(beside_.c_str());
}

void StagedFile::fill(std::string_view content) {
    if (!write_all(descriptor_, content) || (!beside_.empty() && ::fsync(descriptor_) != 0)) fail();
}

void StagedFile::commit() {
    if (beside_.empty()) return;
    if (::rename(beside_.c_str(), target_.c_str()) != 0) fail();
    beside_.clear();
}

void StagedFile::fail() const { throw cannot_write(path_); }

std::string read_file(const std::filesystem::path& path) {
    if (const auto shipped = shipped_file(path.string())) return std::string(*shipped);
    if (std::optional<std::string> bundled = read_bundled(path)) return *std::move(bundled);
    const bool standard = path == "-";
    const Descriptor file(standard ? STDIN_FILENO : ::open(path.c_str(), O_RDONLY | O_CLOEXEC));
    if (file.get() < 0) throw bad_input(path.string(), fmt::format("cannot be opened: {}; check the path", reason()));
    std::string content;
    struct stat status = {};
    if (::fstat(file.get(), &status) == 0 && S_ISREG(status.st_mode))
        content.reserve(static_cast<std::size_t>(status.st_size));
    std::array<char, 1 << 16> buffer{};
    for (;;) {
        const ssize_t count = ::read(file.get(), buffer.data(), buffer.size());
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) throw bad_input(path.string(), fmt::format("cannot be read: {}", reason()));
        if (count == 0) return content;
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
    for (const auto& file : staged) file->commit();
}

}  // namespace haptogram
