// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

namespace haptogram::studio {

/// A page that drives the outputs says so often that it is alive; after this long without a word they go off.
inline constexpr std::chrono::milliseconds most_silence{1000};
/// Of a page out of sight browsers call the timers once a second only.
inline constexpr std::chrono::milliseconds most_silence_hidden{2500};
/// After this long out of sight they go off, too.
inline constexpr std::chrono::seconds most_hidden{10};

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
