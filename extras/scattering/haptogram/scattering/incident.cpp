// SPDX-License-Identifier: Apache-2.0
#include "haptogram/scattering/incident.hpp"

namespace haptogram::scattering {
namespace {

using Complex = std::complex<double>;

/// @param wave  gives the pressure and its slope along the panel's normal
template <class Wave>
IncidentSound each_panel(const Body& body, Wave wave) {
    IncidentSound sound;
    for (const Panel& panel : body.panels) {
        const auto [pressure, slope] = wave(panel);
        sound.pressure.emplace_back(pressure);
        sound.slope.emplace_back(slope);
    }
    return sound;
}

}  // namespace

IncidentSound incident_from(const Array& array, Drives drives, const Body& body, const FieldOptions& options) {
    std::vector<Vec3> centres;
    for (const Panel& panel : body.panels) centres.push_back(panel.centre);
    IncidentSound sound;
    sound.pressure = pressure_at(array, drives, centres, options);
    const std::vector<PressureGradient> gradients = pressure_gradient_at(array, drives, centres, options);
    for (std::size_t i = 0; i < centres.size(); ++i) {
        const Vec3 n = body.panels[i].normal;
        sound.slope.push_back(gradients[i].x * static_cast<float>(n.x) + gradients[i].y * static_cast<float>(n.y) +
                              gradients[i].z * static_cast<float>(n.z));
    }
    return sound;
}

IncidentSound plane_wave_on(const Body& body, Vec3 direction, double wave_number) {
    const Vec3 k = direction * (wave_number / norm(direction));
    return each_panel(body, [&](const Panel& panel) {
        const Complex p = std::polar(1.0, -dot(k, panel.centre));
        return std::pair(p, Complex(0.0, -dot(k, panel.normal)) * p);
    });
}

IncidentSound point_source_on(const Body& body, Vec3 source, double wave_number) {
    return each_panel(body, [&](const Panel& panel) {
        const Vec3 away = panel.centre - source;
        const double r = norm(away);
        const Complex p = std::polar(1.0 / r, -wave_number * r);
        return std::pair(p, -p * Complex(1.0 / r, wave_number) * (dot(away, panel.normal) / r));
    });
}

}  // namespace haptogram::scattering
