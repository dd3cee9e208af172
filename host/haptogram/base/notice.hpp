// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <cstddef>
#include <string>
#include <string_view>

namespace haptogram {

/// A text of whomever as a terminal may be given it: control characters but line feed and tab, and what is no UTF-8,
/// are written as \xNN, and what is longer is cut and ends with "…".
[[nodiscard]] std::string printable(std::string_view text, std::size_t most_bytes = 4000);

/// Writes to a pipe, a terminal or a file, and waits at most so long for its reader.
/// @return how many bytes went; the rest is not kept
std::size_t write_within(int descriptor, std::string_view text, std::chrono::milliseconds patience = {});

}  // namespace haptogram
