// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/iso_surface.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "haptogram/base/error.hpp"

namespace haptogram {
namespace {

struct Corner {
    Vec3 at;
    double value;
};

/// Where the value is between two corners, one below and one not. The lower one always comes first, so that neighbours
/// find the same point to the last bit.
Vec3 between(const Corner& below, const Corner& above, double value) {
    return below.at + (value - below.value) / (above.value - below.value) * (above.at - below.at);
}

/// The one or two triangles of a tetrahedron.
void cut(const std::array<Corner, 4>& corners, double value, std::vector<std::array<Vec3, 3>>& triangles) {
    std::array<const Corner*, 4> below{}, above{};
    std::size_t low = 0, high = 0;
    for (const Corner& corner : corners)
        if (corner.value < value)
            below[low++] = &corner;
        else
            above[high++] = &corner;
    if (low == 0 || high == 0) return;
    Vec3 downwards{};  // from above to below
    for (std::size_t i = 0; i < low; ++i) downwards = downwards + (1.0 / static_cast<double>(low)) * below[i]->at;
    for (std::size_t i = 0; i < high; ++i) downwards = downwards - (1.0 / static_cast<double>(high)) * above[i]->at;
    const auto add = [&](Vec3 a, Vec3 b, Vec3 c) {
        const Vec3 normal = cross(b - a, c - a);
        if (dot(normal, normal) == 0.0) return;
        if (dot(normal, downwards) < 0.0) std::swap(b, c);
        triangles.push_back({a, b, c});
    };
    const auto point = [&](std::size_t i, std::size_t j) { return between(*below[i], *above[j], value); };
    if (low == 1) {
        add(point(0, 0), point(0, 1), point(0, 2));
    } else if (high == 1) {
        add(point(0, 0), point(1, 0), point(2, 0));
    } else {
        add(point(0, 0), point(0, 1), point(1, 1));
        add(point(0, 0), point(1, 1), point(1, 0));
    }
}

/// The corners of a cell on the six ways from corner 0 to corner 7 along its edges: x, y and z in any order. Bit 0 of a
/// corner's number is along x, bit 1 along y, bit 2 along z.
constexpr std::array<std::array<unsigned, 4>, 6> tetrahedra{
    {{0, 1, 3, 7}, {0, 1, 5, 7}, {0, 2, 3, 7}, {0, 2, 6, 7}, {0, 4, 5, 7}, {0, 4, 6, 7}}};

}  // namespace

IsoSurface iso_surface(const Field& volume, double value) {
    const Grid& grid = volume.region.grid;
    const std::size_t nx = grid.x.size(), ny = grid.y.size(), nz = grid.z.size();
    if (volume.parts.size() != 1) throw bad_argument("quantity", "a complex field has no surface of one value");
    if (nx < 2 || ny < 2 || nz < 2)
        throw bad_argument("surface", "expected a volume of at least two points along each axis");
    const std::vector<float>& values = volume.parts.front();
    IsoSurface surface{value, {}, false};
    for (std::size_t k = 0; k + 1 < nz; ++k)
        for (std::size_t j = 0; j + 1 < ny; ++j)
            for (std::size_t i = 0; i + 1 < nx; ++i) {
                std::array<Corner, 8> corners;
                unsigned low = 0;
                bool unknown = false;
                for (unsigned c = 0; c < 8; ++c) {
                    const std::size_t at = i + (c & 1U) + nx * (j + (c >> 1U & 1U) + ny * (k + (c >> 2U)));
                    corners[c] = {volume.region.point(at), static_cast<double>(values[at])};
                    low += corners[c].value < value ? 1U : 0U;
                    unknown = unknown || std::isnan(values[at]);
                }
                surface.leaves = surface.leaves || (unknown && low > 0);
                if (low == 0 || low == 8 || unknown) continue;
                for (const auto& [a, b, c, d] : tetrahedra)
                    cut({corners[a], corners[b], corners[c], corners[d]}, value, surface.triangles);
            }
    for (std::size_t at = 0; at < values.size() && !surface.leaves; ++at) {
        const std::size_t i = at % nx, j = at / nx % ny, k = at / (nx * ny);
        const bool edge = i == 0 || i + 1 == nx || j == 0 || j + 1 == ny || k == 0 || k + 1 == nz;
        surface.leaves = edge && static_cast<double>(values[at]) >= value;
    }
    return surface;
}

IsoSurface surface_below(const Field& volume, double below_db) {
    if (!(below_db > 0.0)) throw bad_argument("below", fmt::format("found {} dB, expected a number above 0", below_db));
    const std::vector<float>& values = volume.parts.front();
    double most = -INFINITY;
    for (const float value : values) most = std::max(most, static_cast<double>(std::isnan(value) ? -INFINITY : value));
    const double value = volume.kind == Quantity::level       ? most - below_db
                         : volume.kind == Quantity::radiation ? most * std::pow(10.0, -below_db / 10.0)
                                                              : most * std::pow(10.0, -below_db / 20.0);
    return iso_surface(volume, value);
}

std::string to_stl(const IsoSurface& surface) {
    std::string bytes = "Haptogram: a surface of one value of a sound field, millimetres";
    bytes.resize(80, ' ');
    const auto append = [&](const auto& value) { bytes.append(reinterpret_cast<const char*>(&value), sizeof value); };
    append(static_cast<std::uint32_t>(surface.triangles.size()));
    bytes.reserve(bytes.size() + 50 * surface.triangles.size());
    for (const auto& [a, b, c] : surface.triangles) {
        const Vec3 normal = cross(b - a, c - a);
        for (const Vec3& v :
             {(1.0 / norm(normal)) * normal, (1.0 / millimetre) * a, (1.0 / millimetre) * b, (1.0 / millimetre) * c})
            for (const double coordinate : {v.x, v.y, v.z}) append(static_cast<float>(coordinate));
        append(std::uint16_t{0});
    }
    return bytes;
}

std::string description_of(const IsoSurface& surface) {
    return fmt::format("{} triangles where the field is {:.6g}{}", surface.triangles.size(), surface.value,
                       surface.leaves ? "; the surface is open where it leaves the volume" : "");
}

}  // namespace haptogram
