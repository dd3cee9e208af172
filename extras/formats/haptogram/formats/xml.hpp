// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <pugixml.hpp>
#include <string>
#include <string_view>

namespace haptogram::formats {

/// @throws Error{bad_input} for what is no XML, is nested too deeply, or has more than 48 MiB
void parse_xml(pugi::xml_document& document, std::string_view text, const std::string& name);

/// A name without its namespace's prefix.
[[nodiscard]] inline std::string_view local(const char* name) {
    const std::string_view whole = name;
    return whole.substr(whole.find(':') == std::string_view::npos ? 0 : whole.find(':') + 1);
}

}  // namespace haptogram::formats
