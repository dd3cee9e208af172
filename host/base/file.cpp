// SPDX-License-Identifier: Apache-2.0
#include "base/file.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <openssl/evp.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <system_error>

#include "base/error.hpp"

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
    return bad_input(path.string(), fmt::format("cannot be written: {}; choose another place or make room, nothing was left behind", reason()));
}

}  // namespace

std::string read_file(const std::filesystem::path& path) {
    const bool standard = path == "-";
    const Descriptor file(standard ? STDIN_FILENO : ::open(path.c_str(), O_RDONLY | O_CLOEXEC));
    if (file.get() < 0) throw bad_input(path.string(), fmt::format("cannot be opened: {}; check the path", reason()));
    std::string content;
    struct stat status = {};
    if (::fstat(file.get(), &status) == 0 && S_ISREG(status.st_mode)) content.reserve(static_cast<std::size_t>(status.st_size));
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
    struct stat status = {};
    const bool exists = ::stat(path.c_str(), &status) == 0;
    if (path == "-" || (exists && !S_ISREG(status.st_mode))) {
        const Descriptor file(path == "-" ? STDOUT_FILENO : ::open(path.c_str(), O_WRONLY | O_CLOEXEC));
        if (file.get() < 0 || !write_all(file.get(), content)) throw cannot_write(path);
        return;
    }
    const std::filesystem::path target = exists ? std::filesystem::canonical(path) : path;  // keep a symbolic link
    std::string beside = target.string() + ".XXXXXX";
    const int number = ::mkstemp(beside.data());
    if (number < 0) throw cannot_write(path);
    const Descriptor file(number);
    const mode_t mask = ::umask(0);
    ::umask(mask);
    const mode_t mode = exists ? status.st_mode & 07777 : 0666 & ~mask;
    if (!write_all(number, content) || ::fchmod(number, mode) != 0 || ::fsync(number) != 0 ||
        ::rename(beside.c_str(), target.c_str()) != 0) {
        const Error error = cannot_write(path);
        ::unlink(beside.c_str());
        throw error;
    }
}

std::string sha256(std::string_view content) {
    std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
    unsigned length = 0;
    if (EVP_Digest(content.data(), content.size(), digest.data(), &length, EVP_sha256(), nullptr) != 1)
        throw Error(ErrorCode::run_failed, "sha256", "the cryptographic library refused to compute a digest");
    std::string text;
    for (unsigned i = 0; i < length; ++i) text += fmt::format("{:02x}", digest.at(i));
    return text;
}

}  // namespace haptogram
