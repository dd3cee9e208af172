// SPDX-License-Identifier: Apache-2.0
// The file has a line "RATE PORT" for each port, the latest last.
#include "haptogram/link/port_rates.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <mutex>
#include <string_view>
#include <system_error>
#include <vector>

#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/link/chain.hpp"

namespace haptogram::link {
namespace {

namespace fs = std::filesystem;
constexpr std::size_t most_ports = 100;

/// Empty when the user has no such folder.
fs::path file() {
    const auto folder = [](const char* variable) {
        const char* const value = std::getenv(variable);
        return fs::path(value == nullptr ? "" : value);
    };
    if (const fs::path state = folder("XDG_STATE_HOME"); state.is_absolute()) return state / "haptogram" / "ports";
    if (const fs::path home = folder("HOME"); home.is_absolute()) return home / ".local/state/haptogram/ports";
    return {};
}

/// The tiles of a chain have one port.
std::string key_of(const std::string& name) {
    const auto chained = chained_port(name);
    const std::string port = chained ? chained->port : name;
    if (port.starts_with("ftdi:")) return port;
    std::error_code error;
    return fs::absolute(port, error).lexically_normal().string();
}

std::vector<std::string> lines_of(const fs::path& path) {
    std::error_code error;
    if (path.empty() || !fs::is_regular_file(path, error)) return {};
    std::vector<std::string> lines;
    try {
        const std::string text = read_file(path);
        for (std::size_t at = 0, end = 0; (end = text.find('\n', at)) != std::string::npos; at = end + 1)
            lines.push_back(text.substr(at, end - at));
    } catch (const Error&) {  // it may not be read
    }
    return lines;
}

bool is_of(std::string_view line, std::string_view key) {
    const std::size_t space = line.find(' ');
    return space != std::string_view::npos && line.substr(space + 1) == key;
}

std::mutex mutex;
std::map<std::string, std::uint32_t>& here() {
    static std::map<std::string, std::uint32_t> rates;
    return rates;
}

}  // namespace

std::optional<std::uint32_t> remembered_rate(const std::string& port) {
    const std::string key = key_of(port);
    const std::lock_guard lock(mutex);
    if (const auto known = here().find(key); known != here().end()) return known->second;
    for (const std::string& line : lines_of(file())) {
        std::uint32_t baud = 0;
        if (!is_of(line, key)) continue;
        const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), baud);
        if (error == std::errc() && *end == ' ' && baud > 0) return baud;
    }
    return {};
}

void remember_rate(const std::string& port, std::uint32_t baud) {
    const std::string key = key_of(port);
    const std::lock_guard lock(mutex);
    here()[key] = baud;
    const fs::path path = file();
    if (path.empty() || key.find('\n') != std::string::npos) return;
    std::vector<std::string> lines = lines_of(path);
    const std::string mine = fmt::format("{} {}", baud, key);
    if (std::ranges::find(lines, mine) != lines.end()) return;
    std::erase_if(lines, [&](const std::string& line) { return is_of(line, key); });
    lines.push_back(mine);
    if (lines.size() > most_ports) lines.erase(lines.begin(), lines.end() - most_ports);
    std::error_code error;
    fs::create_directories(path.parent_path(), error);
    try {
        write_file(path, fmt::format("{}\n", fmt::join(lines, "\n")));
    } catch (const Error&) {  // the next program looks for the rate again
    }
}

}  // namespace haptogram::link
