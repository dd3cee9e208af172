// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string>

#include "simulate.hpp"

namespace haptogram::cli {

/// What `simulate --rig` was asked.
struct SimulateRigOptions {
    std::string rig;  ///< its manifest
    std::uint32_t passes = 1;
    double drift_ppm = 50.0;
    std::uint32_t seed = 1;
    std::string pulses, report;
    bool json = false;
};

/// @return the exit code
int simulate_rig(const SimulateRigOptions& options);

}  // namespace haptogram::cli
