// SPDX-License-Identifier: Apache-2.0
#include "hands.hpp"

#include "command.hpp"
#include "haptogram/hand/open.hpp"
#include "haptogram/hand/project.hpp"
#include "haptogram/hand/render.hpp"

namespace haptogram::cli {

PathMakers path_makers() { return haptogram::path_makers(); }

std::function<HandSkin(Vec3)> skin_of_hand(const std::string& recording, const std::string& model, std::size_t frame) {
    return nearest_skin(skin_of(open_hands(recording, model), frame));
}

}  // namespace haptogram::cli
