// SPDX-License-Identifier: Apache-2.0
// Writes host/haptogram/acoustics/finger_sound.txt to standard output: sound on fingers of several sizes, by boundary
// elements. It takes some minutes and a gigabyte.
#include <fmt/core.h>

#include <exception>
#include <numbers>

#include "haptogram/scattering/skin.hpp"

int main() try {
    using namespace haptogram;
    using namespace haptogram::scattering;
    constexpr double quarter = std::numbers::pi / 2.0;
    // At 40 kHz the radii are 5 to 10.5 mm.
    const FingerSound::Grid grid{
        {3.66, 5.0, 6.35, 7.7},
        {0.0, 0.25 * quarter, 0.5 * quarter, 0.75 * quarter, quarter, quarter + 0.4, quarter + 0.9, quarter + 1.8},
        13,
        19};
    std::vector<FingerSound::Values> values;
    for (const double size : grid.sizes) {
        fmt::print(stderr, "finger_sound: wave number times radius {}\n", size);
        values.push_back(finger_sound_by_elements(grid, size, 6.0));
    }
    fmt::print("{}", write_finger_sound(grid, values));
    return 0;
} catch (const std::exception& error) {
    fmt::print(stderr, "finger_sound: {}\n", error.what());
    return 1;
}
