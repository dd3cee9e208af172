// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <string>

#include "haptogram/base/error.hpp"

/// For the writers of TOML files. Not installed: no public header includes it.
namespace haptogram::section {

/// The shortest digits that read back as the same number, with a decimal point so that TOML takes it for a
/// floating-point number: as a whole number, -0 would lose its sign.
inline std::string number_text(double value) {
    std::string text = fmt::format("{}", value);
    if (text.find_first_of(".en") == std::string::npos) text += ".0";
    return text;
}

/// A text between quotation marks, on one line, that reads back as the same text. Not toml++'s own writer: of a text
/// with line breaks it makes one of several lines, in which it leaves backslashes and tabs as they are.
/// @throws Error{bad_input} for a text that is not UTF-8, which no TOML file can hold
inline std::string quoted_text(const std::string& text) {
    std::string quoted;
    try {
        quoted = nlohmann::json(text).dump();
    } catch (const nlohmann::json::type_error&) {
        const std::string shown = nlohmann::json(text).dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
        throw bad_input(shown, "it is not UTF-8, which a TOML file has to be; give the file another name");
    }
    // All that JSON may hold as it is, TOML may, too, except for DEL.
    for (std::size_t at = 0; (at = quoted.find('\x7f', at)) != std::string::npos;) quoted.replace(at, 1, "\\u007F");
    return quoted;
}

}  // namespace haptogram::section
