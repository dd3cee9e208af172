// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace haptogram {

/// Foci that turn slowly on a small circle, evenly around it and at the same time: felt as steady pressure instead of
/// vibration (Morisaki et al. 2022; slow lateral modulation).
struct PressOptions {
    double turns_hz = 5.0;
    double radius_m = 3e-3;
    unsigned foci = 4;  ///< on each circle
};

}  // namespace haptogram
