// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <functional>
#include <string>

#include "haptogram/perception/feel.hpp"

namespace haptogram::cli {

/// The skin of the hands in a recording's frame, for `feel --hand`.
using SkinOfHand = std::function<HandSkin(Vec3)> (*)(const std::string& recording, const std::string& model,
                                                     std::size_t frame);

/// Lets `feel` know hands; the extra hands does it. Without it, `feel --hand` is refused.
void use_skin_of_hand(SkinOfHand skin);

}  // namespace haptogram::cli
