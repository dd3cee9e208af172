// SPDX-License-Identifier: Apache-2.0
// Values that a user gives to the parameters of a pattern.
#pragma once
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace haptogram {

using Parameters = std::map<std::string, double, std::less<>>;  ///< values by name

/// Reads "push=0.5,depth=2"; nothing for a text of another form.
[[nodiscard]] std::optional<Parameters> parameters_of(std::string_view text);
inline constexpr std::string_view parameters_form = "NAME=VALUE, several with commas between them, each name once";
inline constexpr std::string_view parameters_pattern =
    "^[^=,\"]+=[-+]?([0-9]+\\.?[0-9]*|\\.[0-9]+)(,[^=,\"]+=[-+]?([0-9]+\\.?[0-9]*|\\.[0-9]+))*$";

}  // namespace haptogram
