// SPDX-License-Identifier: Apache-2.0
#include "haptogram/format/pulses.hpp"

#include <fmt/format.h>

#include <charconv>
#include <iterator>

#include "haptogram/base/error.hpp"

namespace haptogram {
namespace {

constexpr std::string_view header = "channel,rise_clk,fall_clk,index";

/// Removes one number, and the separator after it, from the front of `line`.
template <class T>
bool take(std::string_view& line, T& value, bool last) {
    const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), value);
    if (error != std::errc()) return false;
    line.remove_prefix(static_cast<std::size_t>(end - line.data()));
    if (last) return line.empty();
    if (line.empty() || line.front() != ',') return false;
    line.remove_prefix(1);
    return true;
}

}  // namespace

std::string to_csv(const std::vector<Pulse>& pulses) {
    fmt::memory_buffer text;
    fmt::format_to(std::back_inserter(text), "{}\n", header);
    for (const Pulse& p : pulses)
        fmt::format_to(std::back_inserter(text), "{},{},{},{}\n", p.channel, p.rise, p.fall, p.index);
    return fmt::to_string(text);
}

bool is_pulses_csv(std::string_view text) { return text.starts_with(header); }

std::vector<Pulse> pulses_from_csv(std::string_view text, const std::string& where) {
    if (text.empty()) throw bad_input(where, fmt::format("the file is empty; expected the header '{}'", header));
    std::vector<Pulse> pulses;
    for (std::size_t number = 1; !text.empty(); ++number) {
        const std::size_t newline = text.find('\n');
        if (newline == std::string_view::npos)
            throw bad_input(fmt::format("{}:{}", where, number), "the last line has no end; the file is cut short");
        std::string_view line = text.substr(0, newline);
        text.remove_prefix(newline + 1);
        if (number == 1) {
            if (line != header)
                throw bad_input(fmt::format("{}:1", where),
                                fmt::format("expected the header '{}'; is this a pulse file?", header));
            continue;
        }
        Pulse p{};
        if (!take(line, p.channel, false) || !take(line, p.rise, false) || !take(line, p.fall, false) ||
            !take(line, p.index, true) || p.fall <= p.rise)
            throw bad_input(
                fmt::format("{}:{}", where, number),
                "expected four whole numbers 'channel,rise_clk,fall_clk,index' with the fall after the rise");
        pulses.push_back(p);
    }
    return pulses;
}

}  // namespace haptogram
