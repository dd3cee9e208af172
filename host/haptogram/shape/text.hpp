// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "haptogram/base/error.hpp"

namespace haptogram {

/// Walks over the lines of a text; line ends (LF or CRLF) are not part of a line, and lines count from 1.
class Lines {
public:
    explicit Lines(std::string_view text, std::size_t lines_before = 0) : rest_(text), number_(lines_before) {}

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
};

/// Takes the next word, ended by white space, off the front of `rest`; empty when there is none.
[[nodiscard]] std::string_view take_word(std::string_view& rest);

/// A whole word as a number with a decimal point, whatever the locale; "nan" and "inf" are numbers here.
[[nodiscard]] std::optional<double> parse_number(std::string_view word);

/// A coordinate that can be reckoned with: finite, and no larger than any unit of length can make sense of.
[[nodiscard]] bool is_coordinate(double value);

[[nodiscard]] std::string lower_case(std::string_view text);

/// `text` in quotation marks, fit for a message: shortened, and without control characters.
[[nodiscard]] std::string shown(std::string_view text);

[[nodiscard]] std::string at_line(const std::string& file, std::size_t line);

/// The error of a word that should have been a coordinate.
[[nodiscard]] Error bad_coordinate(std::string where, std::string_view found);

}  // namespace haptogram
