// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace haptogram {

/// Of the lines in which a live session tells its scenes. Triggers read their hands, which are in all versions from
/// scene_version (trigger_table.hpp) on the same; 2 tells all objects.
inline constexpr int newest_scene_version = 2;

}  // namespace haptogram
