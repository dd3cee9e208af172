// SPDX-License-Identifier: Apache-2.0
#include "haptogram/base/notice.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "haptogram/base/system.hpp"

namespace haptogram {
namespace {

// As much goes into a pipe at once when it has room for anything (POSIX: PIPE_BUF).
constexpr std::size_t piece_bytes = 512;

unsigned byte(char letter) { return static_cast<unsigned char>(letter); }

/// The bytes of the letter that a text begins with; 0 when a terminal must not be given its first one.
std::size_t letter_bytes(std::string_view text) {
    const unsigned first = byte(text.front());
    if (first < 0x80) return (first >= 0x20 && first != 0x7f) || first == '\n' || first == '\t' ? 1 : 0;
    const std::size_t length = first >= 0xc2 && first < 0xe0 ? 2 : first >= 0xe0 && first < 0xf0 ? 3 : 4;
    if (first < 0xc2 || first >= 0xf5 || text.size() < length) return 0;
    for (std::size_t i = 1; i < length; ++i)
        if ((byte(text[i]) & 0xc0U) != 0x80) return 0;
    return first == 0xc2 && byte(text[1]) < 0xa0 ? 0 : length;  // U+0080 to U+009F are control characters
}

}  // namespace

std::string printable(std::string_view text, std::size_t most_bytes) {
    std::string shown;
    while (!text.empty()) {
        const std::size_t length = letter_bytes(text);
        const std::string next =
            length == 0 ? fmt::format("\\x{:02x}", byte(text.front())) : std::string(text.substr(0, length));
        if (shown.size() + next.size() > most_bytes) return shown + "…";
        shown += next;
        text.remove_prefix(std::max<std::size_t>(length, 1));
    }
    return shown;
}

std::size_t write_within(int descriptor, std::string_view text, std::chrono::milliseconds patience) {
    std::size_t gone = 0;
    while (gone < text.size() && system::wait_to_write(descriptor, patience)) {
        const std::string_view piece = text.substr(gone, piece_bytes);
        const std::ptrdiff_t written = system::write(descriptor, piece.data(), piece.size());
        if (written <= 0) break;
        gone += static_cast<std::size_t>(written);
    }
    return gone;
}

}  // namespace haptogram
