// SPDX-License-Identifier: Apache-2.0
#include "haptogram/base/text.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <random>
#include <system_error>
#include <utility>

namespace haptogram {
namespace {

bool is_blank(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

constexpr double largest_coordinate = 1e12;

}  // namespace

void require_positive(const char* setting, double value) {
    if (!(value > 0.0) || !std::isfinite(value))
        throw bad_argument(setting, fmt::format("found {}, expected a positive number", value));
}

bool Lines::next() {
    if (rest_.empty()) return false;
    const std::size_t end = rest_.find(end_);
    line_ = rest_.substr(0, end);
    rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
    if (line_.ends_with('\r')) line_.remove_suffix(1);
    ++number_;
    return true;
}

std::string_view take_word(std::string_view& rest) {
    const auto* const begin = std::find_if_not(rest.begin(), rest.end(), is_blank);
    const auto* const end = std::find_if(begin, rest.end(), is_blank);
    const std::string_view word(begin, static_cast<std::size_t>(end - begin));
    rest.remove_prefix(static_cast<std::size_t>(end - rest.begin()));
    return word;
}

std::optional<double> parse_number(std::string_view word) {
    if (word.starts_with('+') && !word.starts_with("+-")) word.remove_prefix(1);
    double value = 0.0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (word.empty() || error != std::errc{} || end != word.data() + word.size()) return std::nullopt;
    return value;
}

bool is_coordinate(double value) { return std::abs(value) <= largest_coordinate; }

void split_at(char separator, std::string_view line, Fields& fields) {
    fields.clear();
    constexpr std::string_view around = " \t\"";
    bool inside = false;
    for (std::size_t begin = 0, i = 0; i <= line.size(); ++i) {
        if (i < line.size() && line[i] == '"') inside = !inside;
        if (i < line.size() && (inside || line[i] != separator)) continue;
        std::string_view field = line.substr(begin, i - begin);
        field.remove_prefix(std::min(field.find_first_not_of(around), field.size()));
        field.remove_suffix(field.size() - (field.find_last_not_of(around) + 1));
        fields.push_back(field);
        begin = i + 1;
    }
}

char separator_of(std::string_view line) {
    for (const char separator : {';', '\t'})
        if (line.find(separator) != std::string_view::npos) return separator;
    return ',';
}

std::string_view without_byte_order_mark(std::string_view text) {
    if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
    return text;
}

std::string lower_case(std::string_view text) {
    std::string result(text);
    for (char& c : result)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return result;
}

std::string printable(std::string_view text) {
    std::string result(text);
    for (char& c : result)
        if (c < ' ' || c > '~') c = '?';
    return result;
}

std::string shown(std::string_view text) {
    constexpr std::size_t longest = 40;
    return fmt::format("\"{}{}\"", printable(text.substr(0, longest)), text.size() > longest ? "…" : "");
}

std::string at_line(const std::string& file, std::size_t line) { return fmt::format("{}, line {}", file, line); }

Error bad_coordinate(std::string where, std::string_view found) {
    return bad_input(std::move(where),
                     fmt::format("found {}, expected a finite coordinate with a decimal point, at most {:.0e}; "
                                 "correct or remove it",
                                 found.empty() ? "nothing" : shown(found), largest_coordinate));
}

std::string make_token() {
    std::random_device random;  // of the processor or the system, no sequence
    return fmt::format("{:08x}{:08x}{:08x}{:08x}", random(), random(), random(), random());
}

bool is_token(std::string_view found, std::string_view expected) {
    if (found.size() != expected.size()) return false;
    unsigned char difference = 0;
    for (std::size_t i = 0; i < found.size(); ++i)
        difference = static_cast<unsigned char>(difference | (found[i] ^ expected[i]));
    return difference == 0;
}

}  // namespace haptogram
