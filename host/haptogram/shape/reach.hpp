// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "haptogram/array/array.hpp"
#include "haptogram/format/path.hpp"

namespace haptogram {

/// @throws Error{bad_input} that lists the foci of a path that are out of the array's reach
void require_reachable(const Path& path, const Array& array);

}  // namespace haptogram
