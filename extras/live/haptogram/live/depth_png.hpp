// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <string_view>

#include "haptogram/live/depth.hpp"

namespace haptogram {

/// Reads a depth picture: a PNG of one grey channel of 16 bits, of the camera's size. Its counts are taken as they are,
/// whatever gamma the file speaks of.
/// @param where  names the file in messages
/// @throws Error{bad_input} saying what is damaged, or which size and kind was found and which was expected
[[nodiscard]] DepthPicture depth_from_png(std::string_view bytes, const std::string& where, const DepthCamera& camera);

/// The same picture as the bytes of a PNG.
/// @throws Error{bad_argument} when the picture has not the camera's size
[[nodiscard]] std::string depth_to_png(const DepthPicture& picture, const DepthCamera& camera);

}  // namespace haptogram
