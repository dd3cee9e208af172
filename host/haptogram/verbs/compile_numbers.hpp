// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <nlohmann/json.hpp>

#include "haptogram/verbs/compile.hpp"

namespace haptogram {

/// What compiling came to, in numbers for programs: the members that `haptogram compile --json` prints and the studio
/// shows. A name's end is its unit; without one it is a count, a text or a share.
[[nodiscard]] nlohmann::ordered_json numbers_of(const Compiled& compiled);

}  // namespace haptogram
