// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/excitation.hpp"

#include <fmt/core.h>

#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/base/error.hpp"

namespace haptogram {

std::vector<WeightedDrives> Excitation::sequence() const {
    std::vector<WeightedDrives> found;
    for (std::size_t i = 0; i < drives.size(); ++i) found.push_back({weights[i], drives[i]});
    return found;
}

void weaken(Excitation& excitation, double factor) {
    for (std::vector<std::complex<double>>& drives : excitation.drives)
        for (std::complex<double>& drive : drives) drive *= factor;
}

Excitation excitation_of(const Array& array, Vec3 focus) {
    if (const std::string why = array.unreachable(focus); !why.empty()) throw bad_argument("focus", why);
    return {array,
            {ideal_drives(array, focus)},
            {1.0},
            {focus},
            fmt::format("{}, exact phases for ({:g},{:g},{:g}) mm", array.name, focus.x / millimetre,
                        focus.y / millimetre, focus.z / millimetre)};
}

Excitation only(const Excitation& excitation, std::size_t place) {
    if (place >= excitation.drives.size())
        throw bad_argument("record",
                           fmt::format("there are {} sets of drives, not {}", excitation.drives.size(), place + 1));
    return {excitation.array, {excitation.drives[place]}, {1.0}, {}, excitation.title};
}

}  // namespace haptogram
