// SPDX-License-Identifier: Apache-2.0
// For a build without simulated boards.
#include "haptogram/base/error.hpp"
#include "live_board.hpp"

namespace haptogram::cli {

std::unique_ptr<LiveBoard> reference_board(const std::string&) {
    throw bad_argument("port",
                       "this build has no simulated board; name a serial port, or build with HAPTOGRAM_SIMULATION=ON, "
                       "which needs Verilator");
}

std::unique_ptr<LiveBoard> reference_rig(const std::string& configuration, const Rig&, const link::RigSettings&) {
    return reference_board(configuration);
}

}  // namespace haptogram::cli
