// SPDX-License-Identifier: Apache-2.0
// For a build without simulated boards.
#include "frame_pins.hpp"
#include "haptogram/base/error.hpp"

namespace haptogram::cli {

PinsOfFrame pins_of(const fusion::Frame&, const Array&, const Core&, const perception::Tables&) {
    throw bad_argument("frames",
                       "this build has no simulated board to play them; ask for 0, or build with "
                       "HAPTOGRAM_SIMULATION=ON, which needs Verilator");
}

}  // namespace haptogram::cli
