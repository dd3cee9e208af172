// SPDX-License-Identifier: Apache-2.0
#include "haptogram/perception/skin_wave.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "haptogram/base/error.hpp"

namespace haptogram::perception {
namespace {

using std::numbers::pi;

double largest_deflection(double speed_m_s, const SkinMembrane& skin) {
    constexpr int count = 512;
    constexpr double side_m = 0.4;
    // A Gaussian e^{−r²/a²} falls to half at r = a·√(ln 2).
    const double a = skin.focus_width_m / 2.0 / std::sqrt(std::numbers::ln2);
    const double omega = 2.0 * pi * skin.foundation_hz, c = skin.wave_speed_m_s;
    std::vector<std::complex<double>> along(count);  // the sum over k across the line, for each k along it
    for (int i = 0; i < count; ++i) {
        const double kx = 2.0 * pi / side_m * (i - count / 2), turn = kx * speed_m_s;
        for (int j = 0; j < count; ++j) {
            const double ky = 2.0 * pi / side_m * (j - count / 2), square = kx * kx + ky * ky;
            along[static_cast<std::size_t>(i)] +=
                std::exp(-square * a * a / 4.0) /
                std::complex<double>(omega * omega + c * c * square - turn * turn, 2.0 * skin.damping_1_s * turn);
        }
    }
    double largest = 0.0;
    for (int x = 0; x < count; ++x) {
        double sum = 0.0;
        for (int i = 0; i < count; ++i) {
            const double angle = 2.0 * pi * ((i - count / 2) * x % count) / count;
            sum += along[static_cast<std::size_t>(i)].real() * std::cos(angle) -
                   along[static_cast<std::size_t>(i)].imag() * std::sin(angle);
        }
        largest = std::max(largest, sum);
    }
    return largest;
}

}  // namespace

double deflection_over_static(double speed_m_s, const SkinMembrane& skin) {
    if (!(speed_m_s >= 0.0 && speed_m_s <= fastest_wave_m_s))
        throw bad_argument("speed", fmt::format("{:g} m/s lies outside of 0…{:g} m/s, for which the skin's waves "
                                                "were modelled",
                                                speed_m_s, fastest_wave_m_s));
    return largest_deflection(speed_m_s, skin) / largest_deflection(0.0, skin);
}

}  // namespace haptogram::perception
