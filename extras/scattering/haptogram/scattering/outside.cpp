// SPDX-License-Identifier: Apache-2.0
#include "haptogram/scattering/outside.hpp"

#include <numbers>

namespace haptogram::scattering {
namespace {

using Complex = std::complex<double>;
using std::numbers::pi;

}  // namespace

Complex scattered_at(const Body& body, std::span<const std::complex<float>> pressure, double wave_number, Vec3 point) {
    Complex sum;
    for (std::size_t i = 0; i < body.panels.size(); ++i) {
        const Panel& panel = body.panels[i];
        const Vec3 from = point - panel.centre;
        const double r = norm(from);
        sum += Complex(pressure[i]) * std::polar(panel.area / (4.0 * pi * r), -wave_number * r) *
               Complex(1.0 / r, wave_number) * (dot(from, panel.normal) / r);
    }
    return sum;
}

Complex scattered_far(const Body& body, std::span<const std::complex<float>> pressure, double wave_number,
                      Vec3 direction) {
    Complex sum;
    for (std::size_t i = 0; i < body.panels.size(); ++i) {
        const Panel& panel = body.panels[i];
        sum += Complex(pressure[i]) * std::polar(panel.area / (4.0 * pi), wave_number * dot(direction, panel.centre)) *
               Complex(0.0, wave_number * dot(direction, panel.normal));
    }
    return sum;
}

}  // namespace haptogram::scattering
