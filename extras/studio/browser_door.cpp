// SPDX-License-Identifier: Apache-2.0
#include "browser_door.hpp"

#include <fmt/format.h>
#include <spawn.h>
#include <unistd.h>

#include <cstdlib>

#include "haptogram/base/process.hpp"

extern char** environ;

namespace haptogram::studio {

BrowserDoor::BrowserDoor(const std::string& address) {
    const std::filesystem::path program = find_program("xdg-open");
    const char* const folder = std::getenv("XDG_RUNTIME_DIR");
    if (program.empty() || folder == nullptr ||
        (std::getenv("DISPLAY") == nullptr && std::getenv("WAYLAND_DISPLAY") == nullptr))
        return;
    std::string name = (std::filesystem::path(folder) / "haptogram-XXXXXX.html").string();
    const int descriptor = ::mkstemps(name.data(), 5);  // readable by the user alone
    if (descriptor < 0) return;
    file_ = name;
    const std::string text =
        fmt::format("<!DOCTYPE html><meta http-equiv=\"refresh\" content=\"0;url={}\">\n", address);
    const bool written = ::write(descriptor, text.data(), text.size()) == static_cast<ssize_t>(text.size());
    ::close(descriptor);
    if (!written) return;
    std::string path = program.string();
    char* const arguments[] = {path.data(), name.data(), nullptr};
    pid_t child = 0;
    (void)::posix_spawn(&child, path.c_str(), nullptr, nullptr, arguments, environ);
}

BrowserDoor::~BrowserDoor() {
    std::error_code ignored;
    if (!file_.empty()) std::filesystem::remove(file_, ignored);
}

}  // namespace haptogram::studio
