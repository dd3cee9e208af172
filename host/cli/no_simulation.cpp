// SPDX-License-Identifier: Apache-2.0
// In place of simulate.cpp, board_run.cpp, frame_pins.cpp and live_board.cpp in a build without Verilator
// (HAPTOGRAM_SIMULATION=OFF): the commands are known, and say why they do nothing.
#include "command.hpp"
#include "frame_pins.hpp"
#include "haptogram/base/error.hpp"
#include "live_board.hpp"

namespace haptogram::cli {
namespace {

void add_absent(CLI::App& app, const std::string& name, Action& action) {
    CLI::App* sub = app.add_subcommand(name, "Not in this build, which has no simulated board");
    sub->allow_extras();
    sub->callback([name, &action] {
        action = [name]() -> int {
            throw bad_argument(
                name, "this build has no simulated board; build with HAPTOGRAM_SIMULATION=ON, which needs Verilator");
        };
    });
}

}  // namespace

void add_simulate(CLI::App& app, Action& action) { add_absent(app, "simulate", action); }

void add_board_run(CLI::App& board, Action& action) { add_absent(board, "run", action); }

PinsOfFrame pins_of(const fusion::Frame&, const Array&, const Core&, const perception::Tables&) {
    throw bad_argument("frames",
                       "this build has no simulated board to play them; ask for 0, or build with "
                       "HAPTOGRAM_SIMULATION=ON, which needs Verilator");
}

std::unique_ptr<LiveBoard> reference_board(const std::string&) {
    throw bad_argument("port",
                       "this build has no simulated board; name a serial port, or build with HAPTOGRAM_SIMULATION=ON, "
                       "which needs Verilator");
}

}  // namespace haptogram::cli
