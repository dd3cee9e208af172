// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "haptogram/base/error.hpp"

namespace haptogram {

/// @throws Error{bad_argument} unless `value` is positive and finite
void require_positive(const char* setting, double value);

/// Walks over the lines of a text. A line ends with LF or CRLF, which are not part of it. Lines count from 1.
class Lines {
public:
    /// @param end  what ends a line when it is not LF: CR, as on very old computers
    explicit Lines(std::string_view text, std::size_t lines_before = 0, char end = '\n')
        : rest_(text), number_(lines_before), end_(end) {}

    /// Moves to the next line; false at the end of the text.
    bool next();
    [[nodiscard]] std::string_view line() const { return line_; }
    [[nodiscard]] std::size_t number() const { return number_; }
    /// What follows the present line.
    [[nodiscard]] std::string_view rest() const { return rest_; }

private:
    std::string_view rest_;
    std::string_view line_;
    std::size_t number_;
    char end_;
};

/// Takes the next word, ended by white space, off the front of `rest`; empty when there is none.
[[nodiscard]] std::string_view take_word(std::string_view& rest);

/// A whole word as a number with a decimal point, whatever the locale. Nothing when the word is no number; "nan" and
/// "inf" are numbers here.
[[nodiscard]] std::optional<double> parse_number(std::string_view word);

/// True for a coordinate that is finite and at most 1e12, which is more than any shape needs in any unit. Larger ones
/// are damage, and their products would overflow.
[[nodiscard]] bool is_coordinate(double value);

using Fields = std::vector<std::string_view>;

/// The fields of a row. A field loses the blanks and quotation marks around it; a separator between quotation marks
/// separates nothing.
void split_at(char separator, std::string_view line, Fields& fields);

/// What separates the fields of a row: a semicolon or a tab when there is one, otherwise a comma.
[[nodiscard]] char separator_of(std::string_view line);

[[nodiscard]] std::string_view without_byte_order_mark(std::string_view text);

[[nodiscard]] std::string lower_case(std::string_view text);

/// With "?" for all that is no printable ASCII: what files and devices say may go to a terminal.
[[nodiscard]] std::string printable(std::string_view text);

/// `text` in quotation marks for a message: shortened, and printable.
[[nodiscard]] std::string shown(std::string_view text);

[[nodiscard]] std::string at_line(const std::string& file, std::size_t line);

/// The error of a word that should have been a coordinate.
[[nodiscard]] Error bad_coordinate(std::string where, std::string_view found);

/// 128 bits from the system's random source, as 32 hexadecimal digits. @throws Error{failed} when there is none
[[nodiscard]] std::string make_token();

/// Whether a token is the right one, in a time that does not tell how much of it is right.
[[nodiscard]] bool is_token(std::string_view found, std::string_view expected);

}  // namespace haptogram
