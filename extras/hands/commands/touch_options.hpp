// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "command.hpp"
#include "haptogram/hand/touch.hpp"

namespace haptogram::cli {

/// Measures of the algorithms from A to L, as `render` and `live` take them.
struct TouchArguments {
    TouchOptions touch{};
    std::optional<double> speed_m_s{}, frequency_hz{};
    std::string jump = "hop", corner = "rotating-line", priority = "gap";
    bool off_skin = false;
};

/// All of them but the seed.
void add_touch_options(CLI::App& sub, TouchArguments& arguments);

/// @param seed  of what is random
[[nodiscard]] TouchOptions touch_of(const TouchArguments& arguments, std::uint64_t seed);

/// Refuses those of another algorithm, --seed among them.
/// @param given  as given_to()  @param algorithm  a letter, or what has none of them
/// @throws Error{bad_argument} naming the option
void require_touch_effect(const std::vector<std::string>& given, const std::string& algorithm,
                          const TouchArguments& arguments);

}  // namespace haptogram::cli
