// SPDX-License-Identifier: Apache-2.0
#include "haptogram/scattering/finger_elements.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "haptogram/scattering/round_bodies.hpp"
#include "haptogram/scattering/scatterer.hpp"

namespace haptogram::scattering {
namespace {

using std::numbers::pi;

constexpr double radius = 1.0;  // all lengths are in radii
constexpr double length = 7.0;
constexpr double lean = 2.0;  ///< triangles' edges over the width of the weights by which values are taken from them

/// A place on the skin of a capsule along z, whose tip is at −z.
Vec3 place_at(double way, double turn) {
    const double round = std::min(way, pi / 2.0);
    const double across = std::sin(round);
    const double z = -0.5 * length + radius - std::cos(round) + std::max(0.0, way - pi / 2.0);
    return {across * std::cos(turn), across * std::sin(turn), z};
}

/// Panels near a place, with weights whose sum is 1.
std::vector<std::pair<std::size_t, float>> panels_at(const Body& body, Vec3 place, double edge) {
    std::vector<std::pair<std::size_t, float>> near;
    double sum = 0.0;
    for (std::size_t i = 0; i < body.panels.size(); ++i) {
        const double apart = lean * distance(body.panels[i].centre, place) / edge;
        if (apart > 4.0) continue;
        const double weight = body.panels[i].area * std::exp(-0.5 * apart * apart);
        near.emplace_back(i, static_cast<float>(weight));
        sum += weight;
    }
    for (auto& [panel, weight] : near) weight /= static_cast<float>(sum);
    return near;
}

/// The source lies in the plane of x and z, at +x.
Vec3 source_at(double tilt) { return {std::sin(tilt), 0.0, -std::cos(tilt)}; }

}  // namespace

FingerSound::Values finger_sound_by_elements(const FingerSound::Grid& grid, double size, double elements) {
    const double edge = 2.0 * pi / size / elements;
    const Body body = body_of(capsule_mesh(radius, length, edge), "finger");
    const auto angle = [](std::size_t i, std::size_t count) {
        return pi * static_cast<double>(i) / static_cast<double>(count - 1);
    };
    std::vector<IncidentSound> sounds;
    for (std::size_t t = 0; t < grid.tilts; ++t)
        sounds.push_back(plane_wave_on(body, -1.0 * source_at(angle(t, grid.tilts)), size));
    const auto total = Scatterer(body, size).pressures(sounds).pressure;
    FingerSound::Values values;
    for (const double way : grid.ways) {
        std::vector<std::vector<std::pair<std::size_t, float>>> at;
        for (std::size_t turn = 0; turn < grid.turns; ++turn)
            at.push_back(panels_at(body, place_at(way, angle(turn, grid.turns)), edge));
        for (std::size_t t = 0; t < grid.tilts; ++t)
            for (const auto& panels : at) {
                std::complex<float> sum;
                for (const auto& [panel, weight] : panels) sum += weight * total[t][panel] / sounds[t].pressure[panel];
                values.push_back(sum);
            }
    }
    return values;
}

}  // namespace haptogram::scattering
