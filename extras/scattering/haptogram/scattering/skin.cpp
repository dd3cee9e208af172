// SPDX-License-Identifier: Apache-2.0
#include "haptogram/scattering/skin.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "haptogram/scattering/scatterer.hpp"
#include "haptogram/scattering/shells.hpp"

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

namespace {

/// Panels that share a corner with another one.
std::vector<std::vector<std::uint32_t>> panels_at_corners(const Mesh& mesh) {
    std::vector<std::vector<std::uint32_t>> found(mesh.vertices.size());
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
        for (const std::uint32_t corner : mesh.triangles[t]) found[corner].push_back(t);
    return found;
}

}  // namespace

Skin::Skin(const Body& body) : panels_(body.panels), shares_(body.panels.size()) {
    const auto at_corner = panels_at_corners(body.mesh);
    const auto with_neighbours = [&](const std::vector<std::uint32_t>& panels) {
        std::vector<std::uint32_t> all;
        for (const std::uint32_t one : panels)
            for (const std::uint32_t corner : body.mesh.triangles[one])
                all.insert(all.end(), at_corner[corner].begin(), at_corner[corner].end());
        std::sort(all.begin(), all.end());
        all.erase(std::unique(all.begin(), all.end()), all.end());
        return all;
    };
    for (std::uint32_t t = 0; t < panels_.size(); ++t) {
        std::vector<std::uint32_t> near = with_neighbours(with_neighbours({t}));
        std::erase(near, t);
        add_shares(t, near);
    }
}

/// The differences of pressure as a polynomial along the panel by least squares, near ones counting more. Degree 3:
/// with a square one the slope would be 8 % too low at ten triangles a wavelength.
void Skin::add_shares(std::uint32_t t, const std::vector<std::uint32_t>& near) {
    const Panel& panel = panels_[t];
    const Vec3 side = std::abs(panel.normal.x) < 0.7 ? Vec3{1.0, 0.0, 0.0} : Vec3{0.0, 1.0, 0.0};
    Vec3 u = cross(panel.normal, side);
    u = u * (1.0 / norm(u));
    const Vec3 v = cross(panel.normal, u);
    const double scale = 1.0 / panel.longest_edge;
    using Powers = Eigen::Matrix<double, 9, 1>;
    std::vector<Powers> rows;
    Eigen::Matrix<double, 9, 9> squares =
        Eigen::Matrix<double, 9, 9>::Identity() * 1e-9;  // where edges hide a direction
    for (const std::uint32_t one : near) {
        const Vec3 to = (panels_[one].centre - panel.centre) * scale;
        const double a = dot(to, u), b = dot(to, v), weight = 1.0 / dot(to, to);
        Powers row;
        row << a, b, a * a, a * b, b * b, a * a * a, a * a * b, a * b * b, b * b * b;
        squares.noalias() += weight * row * row.transpose();
        rows.emplace_back(weight * row);
    }
    Eigen::Matrix<double, 9, 2> slopes = Eigen::Matrix<double, 9, 2>::Zero();
    slopes(0, 0) = slopes(1, 1) = scale;
    squares.ldlt().solveInPlace(slopes);
    for (std::size_t i = 0; i < near.size(); ++i)
        shares_[t].push_back(
            {near[i], static_cast<float>(rows[i].dot(slopes.col(0))), static_cast<float>(rows[i].dot(slopes.col(1)))});
}

std::vector<float> Skin::radiation_pressure(std::span<const std::complex<float>> pressure, double wave_number,
                                            const Medium& medium) const {
    const double scale = 1.0 / (4.0 * medium.density_kg_m3 * medium.speed_m_s * medium.speed_m_s);
    std::vector<float> found;
    for (std::size_t t = 0; t < panels_.size(); ++t) {
        std::complex<float> along, across;
        for (const Share& share : shares_[t]) {
            const std::complex<float> more = pressure[share.panel] - pressure[t];
            along += more * share.along;
            across += more * share.across;
        }
        const auto slopes = static_cast<double>(std::norm(along)) + static_cast<double>(std::norm(across));
        found.push_back(static_cast<float>(
            scale * (static_cast<double>(std::norm(pressure[t])) - slopes / (wave_number * wave_number))));
    }
    return found;
}

Vec3 Skin::force(std::span<const float> radiation) const {
    Vec3 sum;
    for (std::size_t t = 0; t < panels_.size(); ++t)
        sum = sum - static_cast<double>(radiation[t]) * panels_[t].area * panels_[t].normal;
    return sum;
}

}  // namespace haptogram::scattering
