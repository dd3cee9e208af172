// SPDX-License-Identifier: Apache-2.0
#include "haptogram/acoustics/skin_pressure.hpp"

#include <fmt/core.h>

#include <cmath>

#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/base/error.hpp"

namespace haptogram {

double radiation_pressure(const PatchSound& sound, const Medium& medium) {
    return (std::norm(sound.pressure) - std::norm(sound.along) - std::norm(sound.across)) /
           (medium.density_kg_m3 * medium.speed_m_s * medium.speed_m_s);
}

std::vector<PatchSound> waves_at_patch(const Array& array, Vec3 point, Vec3 normal) {
    const double length = norm(normal);
    if (!(length > 0.0 && std::isfinite(length)))
        throw bad_argument("normal", fmt::format("({:g}, {:g}, {:g}) is no direction; expected three numbers of which "
                                                 "one is not 0, such as 0,0,-1 for skin that faces the array",
                                                 normal.x, normal.y, normal.z));
    const Vec3 out = normal * (1.0 / length);
    // Any direction that is not nearly the normal's leads to two directions along the skin.
    const Vec3 other = std::abs(out.x) < 0.5 ? Vec3{1.0, 0.0, 0.0} : Vec3{0.0, 1.0, 0.0};
    Vec3 along = other - out * dot(other, out);
    along = along * (1.0 / norm(along));
    const Vec3 across = cross(out, along);
    std::vector<PatchSound> waves;
    waves.reserve(array.elements.size());
    for (const Element& element : array.elements) {
        const std::complex<double> wave = propagation(array, element, point);
        const Vec3 way = (point - element.position) * (1.0 / distance(element, point));
        if (dot(way, out) < 0.0)
            waves.push_back({wave, dot(way, along) * wave, dot(way, across) * wave});
        else
            waves.emplace_back();
    }
    return waves;
}

PatchSound sound_at_patch(std::span<const PatchSound> waves, std::span<const std::complex<double>> drives) {
    PatchSound sum;
    for (std::size_t m = 0; m < waves.size(); ++m)
        sum += {drives[m] * waves[m].pressure, drives[m] * waves[m].along, drives[m] * waves[m].across};
    return sum;
}

}  // namespace haptogram
