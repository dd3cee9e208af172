// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <fmt/format.h>

#include <string>

/// For the writers of TOML files. Not installed: no public header includes it.
namespace haptogram::section {

/// The shortest digits that read back as the same number, with a decimal point so that TOML takes it for a
/// floating-point number: as a whole number, -0 would lose its sign.
inline std::string number_text(double value) {
    std::string text = fmt::format("{}", value);
    if (text.find_first_of(".en") == std::string::npos) text += ".0";
    return text;
}

}  // namespace haptogram::section
