// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "command.hpp"

namespace haptogram::cli {

/// `haptogram robot place`, which needs the array and the board beside the robot.
void add_robot_place(CLI::App& robot, Action& action);

}  // namespace haptogram::cli
