// SPDX-License-Identifier: Apache-2.0
// What commands ask of the extension *hand*, which a build may leave out.
#pragma once
#include <cstddef>
#include <functional>
#include <string>

#include "haptogram/perception/feel.hpp"

namespace haptogram::cli {

/// The skin of the hands in a recording's frame, for `feel`.
/// @throws as open_hands() and skin_of(); Error{bad_argument} naming "hand" in a build without them
[[nodiscard]] std::function<HandSkin(Vec3)> skin_of_hand(const std::string& recording, const std::string& model,
                                                         std::size_t frame);

}  // namespace haptogram::cli
