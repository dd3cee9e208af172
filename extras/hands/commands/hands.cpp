// SPDX-License-Identifier: Apache-2.0
#include "command.hpp"
#include "extras.hpp"
#include "haptogram/hand/project.hpp"
#include "haptogram/hand/recording.hpp"
#include "haptogram/hand/render.hpp"
#include "skin_of_hand.hpp"

namespace haptogram::cli {

void add_render(CLI::App& app, Action& action);
void add_movement(CLI::App& app, Action& action);
void add_interact(CLI::App& app, Action& action);
void add_align(CLI::App& app, Action& action);

namespace {

std::function<HandSkin(Vec3)> skin_of_hand(const std::string& recording, const std::string& model, std::size_t frame) {
    return nearest_skin(skin_of(open_hands(recording, model), frame));
}

}  // namespace

void register_hands(Extras& extras) {
    for (const AddCommand add : {add_render, add_movement, add_interact}) extras.commands[Purpose::make].push_back(add);
    extras.commands[Purpose::hands].push_back(add_align);
    extras.makers.of_hand = haptogram::path_makers().of_hand;
    use_skin_of_hand(skin_of_hand);
}

}  // namespace haptogram::cli
