// SPDX-License-Identifier: Apache-2.0
#include "haptogram/perception/skin_force.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "haptogram/acoustics/skin_pressure.hpp"
#include "haptogram/base/error.hpp"

namespace haptogram::perception {
namespace {

using std::numbers::pi;

/// Adds what a sequence makes at a point to a sum, with a weight.
void add_pressure(std::vector<double>& sum, double weight, const Array& array, const DriveSequence& sequence,
                  Vec3 point, Vec3 normal) {
    const std::vector<PatchSound> waves = waves_at_patch(array, point, normal);
    std::vector<PatchSound> wanted;
    for (const auto& drives : sequence.drives) wanted.push_back(sound_at_patch(waves, drives));
    follow(sequence, array.transducer.bandwidth_hz, wanted, [&](std::uint64_t period, const PatchSound& sound) {
        sum[period] += weight * radiation_pressure(sound, array.medium);
    });
}

}  // namespace

SkinForce force_on_skin(const Array& array, const DriveSequence& sequence, const SkinPlace& place, double diameter_m) {
    if (!is_finite(place.position)) throw bad_argument("at", "a coordinate is not finite");
    if (!(diameter_m > 0.0 && std::isfinite(diameter_m)))
        throw bad_argument("contact", fmt::format("must be a positive length, found {:g} mm", diameter_m / millimetre));
    const std::uint64_t periods = sequence.periods();
    if (periods == 0) throw bad_input("sequence", "nothing is played; there is nothing to feel");
    SkinForce felt;
    felt.pressure_pa.assign(periods, 0.0);
    felt.force_n.assign(periods, 0.0);
    add_pressure(felt.pressure_pa, 1.0, array, sequence, place.position, place.normal);
    const Vec3 out = place.normal * (1.0 / norm(place.normal));
    const double range = norm(place.position);
    const double cosine = range > 0.0 ? -dot(place.position, out) / range : 0.0;
    felt.tilt = cosine > 0.0 ? cosine * cosine : 0.0;

    // Gauss-Legendre with four nodes on [0, 1]; a focus is at least some millimetres wide.
    constexpr std::array<double, 4> nodes = {0.0694318442029737, 0.3300094782075719, 0.6699905217924281,
                                             0.9305681557970263};
    constexpr std::array<double, 4> weights = {0.1739274225687269, 0.3260725774312731, 0.3260725774312731,
                                               0.1739274225687269};
    constexpr int around = 12;
    const Vec3 other = std::abs(out.x) < 0.5 ? Vec3{1.0, 0.0, 0.0} : Vec3{0.0, 1.0, 0.0};
    Vec3 along = other - out * dot(other, out);
    along = along * (1.0 / norm(along));
    const Vec3 across = cross(out, along);
    const double radius = diameter_m / 2.0;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        const double r = radius * nodes[i];
        const double area = weights[i] * radius * r * 2.0 * pi / around;
        for (int j = 0; j < around; ++j) {
            const double angle = 2.0 * pi * (j + 0.5 * static_cast<double>(i % 2)) / around;
            const Vec3 point = place.position + along * (r * std::cos(angle)) + across * (r * std::sin(angle));
            add_pressure(felt.force_n, area, array, sequence, point, out);
        }
    }
    return felt;
}

double steady_force(const Array& array, std::span<const std::complex<double>> drives, Vec3 place, double diameter_m) {
    DriveSequence steady;
    steady.drives.emplace_back(drives.begin(), drives.end());
    steady.steps.push_back({0, 1, 1});
    return force_on_skin(array, steady, {place}, diameter_m).force_n.front();
}

double modulation_depth(const std::vector<double>& signal) {
    if (signal.empty()) return 0.0;
    const auto [least, largest] = std::minmax_element(signal.begin(), signal.end());
    return *largest + *least > 0.0 ? (*largest - *least) / (*largest + *least) : 0.0;
}

}  // namespace haptogram::perception
