// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "haptogram/shape/readers.hpp"

namespace haptogram::formats {

/// Of all formats of shapes that the core does not read.
[[nodiscard]] ShapeReaders readers();

}  // namespace haptogram::formats
