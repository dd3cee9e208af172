// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace haptogram {

/// Of the lines in which a live session tells its scenes: 2 tells all objects. Triggers read the hands, which are the
/// same from version 1 on.
inline constexpr int scene_version = 2, oldest_scene_version = 1;

}  // namespace haptogram
