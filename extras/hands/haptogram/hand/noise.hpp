// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

namespace haptogram {

/// Random numbers of simulated sensors, the same on every machine. Not installed: no public header includes it.
class Noise {
public:
    explicit Noise(std::uint64_t seed) : generator_(seed) {}
    /// Normal, of standard deviation 1 (Box and Muller's transform).
    double normal() {
        const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
        return radius * std::cos(2.0 * std::numbers::pi * uniform());
    }
    /// From 0 to less than 1.
    double uniform() { return static_cast<double>(generator_() >> 11U) * 0x1p-53; }

private:
    std::mt19937_64 generator_;
};

}  // namespace haptogram
