// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

namespace haptogram::studio {

/// Port that is taken when none is asked for and it is free, so that a browser finds again what it kept for the page.
inline constexpr std::uint16_t usual_port = 41040;

struct Options {
    std::filesystem::path project;  ///< that the page begins with; empty: an example
    std::uint16_t port = 0;         ///< of HTTP; 0: the usual one, or one that is free
    std::filesystem::path page;     ///< folder of the built page; empty: where it was built or installed
    std::filesystem::path placed = "build/boards";  ///< folder of what tools/bitstream.py placed
};

/// Serves the page on the loopback interface until `ended` says so. The outputs are off when it returns.
/// @param listening  told the address to open, whose fragment is the token, and what is missing, if anything is
/// @param ended      asked many times a second
/// @throws Error for a project that cannot be opened or a port that is taken
void run(const Options& options,
         const std::function<void(const std::string& address, const std::string& missing)>& listening,
         const std::function<bool()>& ended);

}  // namespace haptogram::studio
