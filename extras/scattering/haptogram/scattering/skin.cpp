// SPDX-License-Identifier: Apache-2.0
#include "haptogram/scattering/skin.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace haptogram::scattering {
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
