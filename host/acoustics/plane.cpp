// SPDX-License-Identifier: Apache-2.0
#include "acoustics/plane.hpp"

#include <fmt/core.h>

#include <charconv>
#include <cmath>

#include "acoustics/field.hpp"
#include "base/error.hpp"
#include "base/progress.hpp"

namespace haptogram {
namespace {

constexpr double most_plane_points = 4e6;

double& coordinate(Vec3& v, char axis) { return axis == 'x' ? v.x : axis == 'y' ? v.y : v.z; }

std::vector<double> steps(char axis, double extent_m, double step_m) {
    std::vector<double> values;
    const auto count = static_cast<long>(std::floor(extent_m / step_m + 1e-9));
    if (axis == 'z')
        for (long i = 1; i <= 2 * count; ++i) values.push_back(static_cast<double>(i) * step_m);
    else
        for (long i = -count; i <= count; ++i) values.push_back(static_cast<double>(i) * step_m);
    return values;
}

}  // namespace

Vec3 Plane::point(std::size_t column, std::size_t row) const {
    Vec3 p = origin;
    coordinate(p, u_axis.front()) = u[column];
    coordinate(p, v_axis.front()) = v[row];
    return p;
}

Plane parse_plane(const std::string& text, double extent_m, double step_m) {
    const auto fail = [&] {
        return Error(ErrorCode::usage, "--plane",
                     fmt::format("expected xy@z=NUMBER, xz@y=NUMBER or yz@x=NUMBER (mm), found '{}'", text));
    };
    if (text.size() < 6 || text[2] != '@' || text[4] != '=') throw fail();
    const std::string axes = text.substr(0, 2) + text[3];
    if (axes != "xyz" && axes != "xzy" && axes != "yzx") throw fail();
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data() + 5, text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) throw fail();
    if (axes == "xyz" && value <= 0.0)
        throw Error(ErrorCode::usage, "--plane", "the plane lies on or behind the array; z must be positive");
    if (!(step_m > 0.0) || !(extent_m >= step_m))
        throw Error(ErrorCode::usage, "--step",
                    fmt::format("must be positive and no more than --extent, found {} mm and {} mm",
                                step_m / millimetre, extent_m / millimetre));
    const double per_side = 2.0 * extent_m / step_m + 1.0;
    if (!(per_side * per_side < most_plane_points))
        throw Error(ErrorCode::usage, "--step",
                    fmt::format("{:.4g} points are too many, at most {:.4g}; take a larger step or a smaller --extent",
                                per_side * per_side, most_plane_points));
    Plane plane;
    plane.u_axis = axes.substr(0, 1);
    plane.v_axis = axes.substr(1, 1);
    plane.u = steps(axes[0], extent_m, step_m);
    plane.v = steps(axes[1], extent_m, step_m);
    coordinate(plane.origin, axes[2]) = value * millimetre;
    return plane;
}

std::vector<double> mean_radiation_pressure(const Manifest& manifest, const std::vector<MeasuredRecord>& records,
                                            const Plane& plane) {
    constexpr double alpha = 2.0;
    const Array& array = manifest.array;
    const std::size_t elements = array.elements.size();
    double cycles = 0.0;
    for (const MeasuredRecord& record : records) cycles += static_cast<double>(record.cycles);
    std::vector<double> mean;
    Progress progress("field");
    for (std::size_t row = 0; row < plane.v.size(); ++row) {
        std::vector<Vec3> points;
        for (std::size_t column = 0; column < plane.u.size(); ++column) points.push_back(plane.point(column, row));
        const auto matrix = propagation_matrix(array, points);
        for (std::size_t i = 0; i < points.size(); ++i) {
            double squares = 0.0;
            for (const MeasuredRecord& record : records) {
                double real = 0.0;
                double imaginary = 0.0;
                for (std::size_t m = 0; m < elements;
                     ++m) {  // written out: std::complex's product checks for infinities
                    const std::complex<double> g = matrix[i * elements + m];
                    const std::complex<double> a = record.drives[m];
                    real += g.real() * a.real() - g.imag() * a.imag();
                    imaginary += g.real() * a.imag() + g.imag() * a.real();
                }
                squares += static_cast<double>(record.cycles) * (real * real + imaginary * imaginary) / 2.0;
            }
            const double c = array.medium.speed_m_s;
            mean.push_back(cycles > 0.0 ? alpha * squares / cycles / (array.medium.density_kg_m3 * c * c) : 0.0);
        }
        progress.update(static_cast<double>(row + 1) / static_cast<double>(plane.v.size()));
    }
    return mean;
}

}  // namespace haptogram
