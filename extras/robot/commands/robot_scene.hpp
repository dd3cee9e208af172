// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "command.hpp"

namespace haptogram::cli {

/// `haptogram robot explore` and `haptogram robot tell`: the modes W1 and W2 of cables and ultrasound together.
void add_robot_explore(CLI::App& robot, Action& action);
void add_robot_tell(CLI::App& robot, Action& action);

}  // namespace haptogram::cli
