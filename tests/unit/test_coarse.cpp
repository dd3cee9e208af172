// SPDX-License-Identifier: Apache-2.0
// Interpolated fields, fields by fitted patterns, and gradients, against sums that are written here anew.
#include <tbb/global_control.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <numbers>
#include <random>

#include "every_target.hpp"
#include "haptogram/acoustics/coarse.hpp"
#include "haptogram/acoustics/field.hpp"
#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/acoustics/shift.hpp"
#include "haptogram/acoustics/wave.hpp"
#include "haptogram/array/rig.hpp"
#include "haptogram/base/error.hpp"

using namespace haptogram;

namespace {

using Complex = std::complex<double>;
using Drive = std::vector<Complex>;

std::mt19937& randomness() {
    static std::mt19937 generator;
    return generator;
}

unsigned reseed() {
    const unsigned seed = static_cast<unsigned>(Catch::rngSeed());
    randomness().seed(seed);
    return seed;
}

double random(double from, double to) { return std::uniform_real_distribution<double>(from, to)(randomness()); }

Array grid_array(std::uint32_t columns, std::uint32_t rows, double pitch) {
    Array array;
    array.columns = columns;
    for (std::uint32_t m = 0; m < columns * rows; ++m)
        array.elements.push_back(
            {{(m % columns - (columns - 1) / 2.0) * pitch, (m / columns - (rows - 1) / 2.0) * pitch, 0.0}});
    return array;
}

Drive random_drives(const Array& array) {
    Drive drives;
    for (std::size_t m = 0; m < array.elements.size(); ++m)
        drives.push_back(std::polar(random(0.5, 5.0), random(-3.0, 3.0)));
    return drives;
}

std::vector<double> axis(double from, double step, std::size_t count) {
    std::vector<double> found(count);
    for (std::size_t i = 0; i < count; ++i) found[i] = from + step * static_cast<double>(i);
    return found;
}

/// Amplitude against the angle to the axis, radians.
double directivity_of(const Array& array, double angle) {
    const Transducer& t = array.transducer;
    const double k = 2.0 * std::numbers::pi * array.carrier_hz / array.medium.speed_m_s;
    if (t.pattern == Pattern::point) return 1.0;
    if (t.pattern == Pattern::piston) {
        const double x = k * t.radius_m * std::sin(angle);
        return x == 0.0 ? 1.0 : 2.0 * std::cyl_bessel_j(1.0, x) / x;
    }
    if (angle > std::numbers::pi / 2.0) return 0.0;
    const double place = angle / (std::numbers::pi / 2.0) * static_cast<double>(t.table.size() - 1);
    const auto low = std::min(static_cast<std::size_t>(place), t.table.size() - 2);
    const double part = place - static_cast<double>(low);
    return (1.0 - part) * t.table[low] + part * t.table[low + 1];
}

struct Sum {
    Complex pressure;
    double most = 0.0;  ///< with all waves in phase
};

Sum sum_at(const Array& array, const Drive& drives, Vec3 point) {
    const double k = 2.0 * std::numbers::pi * array.carrier_hz / array.medium.speed_m_s;
    Sum sum;
    for (std::size_t m = 0; m < drives.size(); ++m) {
        const Element& e = array.elements[m];
        const double dx = point.x - e.position.x, dy = point.y - e.position.y, dz = point.z - e.position.z;
        const double range = std::hypot(dx, dy, dz);
        const double along = dx * e.normal.x + dy * e.normal.y + dz * e.normal.z;
        const double across = std::sqrt(std::max(0.0, range * range - along * along));
        const double size =
            directivity_of(array, std::atan2(across, along)) * std::exp(-array.medium.absorption_np_m * range) / range;
        sum.pressure += drives[m] * size * Complex(std::cos(k * range), -std::sin(k * range));
        sum.most += std::abs(drives[m] * size);
    }
    return sum;
}

/// The largest error of a field at about `checked` of its points, over the largest |p| that the drives can make there.
double error_of(const Array& array, const Drive& drives, const Grid& grid,
                const std::vector<std::complex<float>>& found, std::size_t checked = 2000) {
    REQUIRE(found.size() == grid.size());
    const std::size_t step = grid.size() / checked + 1;
    double worst = 0.0, most = 0.0;
    for (std::size_t i = 0; i < grid.size(); i += step) {
        const Sum sum = sum_at(array, drives, grid.point(i));
        worst = std::max(worst, std::abs(sum.pressure - Complex(found[i])));
        most = std::max(most, sum.most);
    }
    return worst / most;
}

struct Case {
    const char* name;
    Array array;
    Grid grid;
};

/// Four grids of elements around a place 15 cm above the origin, which face it.
Array around() {
    Rig rig{"around", {}};
    for (const Vec3 angles : {Vec3{0, 0, 0}, Vec3{0, 90, 0}, Vec3{-90, 0, 0}, Vec3{40, -35, 10}}) {
        Pose pose = pose_of({}, angles);
        pose.origin = Vec3{0.0, 0.0, 0.15} + pose.z * -0.15;
        rig.arrays.push_back({grid_array(5, 4, 0.0103), pose});
    }
    return joined(rig);
}

std::vector<Case> interpolated_cases() {
    const Array tile = grid_array(10, 10, 0.01);
    Array listed = tile;
    listed.columns = 0;
    const Pose oblique = pose_of({0.01, -0.02, 0.14}, {25, -35, 15});
    return {
        {"plane of an odd step", tile, {axis(-0.1, 0.2 / 199, 200), axis(-0.1, 0.2 / 199, 200), {0.13}}},
        {"plane at three wavelengths", tile, {axis(-0.06, 0.9e-3, 131), axis(-0.06, 0.9e-3, 131), {0.0258}}},
        {"plane beside the array", listed, {axis(0.05, 1e-3, 90), axis(-0.2, 1e-3, 111), {0.1}}},
        {"upright plane", listed, {axis(-0.08, 1e-3, 161), {0.0}, axis(0.06, 1e-3, 150)}},
        {"another, behind", tile, {{0.004}, axis(-0.05, 0.7e-3, 150), axis(-0.2, 0.7e-3, 200)}},
        {"volume", tile, {axis(-0.03, 1e-3, 61), axis(-0.03, 1e-3, 59), axis(0.08, 1e-3, 47)}},
        {"volume of a list", listed, {axis(-0.03, 1e-3, 61), axis(-0.03, 1e-3, 59), axis(0.08, 1e-3, 47)}},
        {"volume near the array", tile, {axis(-0.03, 1e-3, 61), axis(-0.03, 1e-3, 59), axis(0.024, 0.7e-3, 60)}},
        {"oblique plane", seen_from(tile, oblique), {axis(-0.06, 1e-3, 120), axis(-0.06, 1e-3, 130), {0.0}}},
        {"rig around the volume", around(), {axis(-0.02, 0.5e-3, 81), axis(-0.02, 0.5e-3, 81), axis(0.13, 0.5e-3, 33)}},
        {"volume in slabs", tile, {axis(-0.05, 1e-3, 101), axis(-0.05, 1e-3, 101), axis(0.1, 0.2e-3, 250)}},
        {"plane of small steps", tile, {axis(-0.01, 1e-4, 201), axis(-0.01, 1e-4, 197), {0.2}}},
    };
}

}  // namespace

TEST_CASE("coarse: weights give back every wave of their band", "[coarse]") {
    const std::vector<double> wanted = axis(0.0137, 0.9e-3, 150);
    for (const Band band : {Band{-600, 600}, Band{100, 700}, Band{-720, -500}}) {
        const double step = 2.0 * widest_band / (band.high - band.low);
        const CoarseAxis found = interpolated_axis(wanted, band, step, 0.0021);
        REQUIRE(found.taps == interpolation_taps);
        REQUIRE(found.size == wanted.size());
        const auto error = [&](double kappa) {
            double worst = 0.0;
            for (std::size_t i = 0; i < wanted.size(); ++i) {
                Complex sum = 0.0;
                for (std::size_t t = 0; t < found.taps; ++t) {
                    const Complex weight(static_cast<double>(found.re[t * found.stride + i]),
                                         static_cast<double>(found.im[t * found.stride + i]));
                    sum +=
                        weight * std::polar(1.0, -kappa * found.coarse[static_cast<std::size_t>(found.first[i]) + t]);
                }
                worst = std::max(worst, std::abs(sum - std::polar(1.0, -kappa * wanted[i])));
            }
            return worst;
        };
        double worst = 0.0;
        for (int i = 0; i <= 200; ++i) worst = std::max(worst, error(band.low + (band.high - band.low) * i / 200.0));
        CAPTURE(band.low, band.high, worst);
        REQUIRE(worst <= 4e-5);
        REQUIRE(error(band.high + 0.5 * (band.high - band.low)) > 0.01);  // others are not
    }
}

TEST_CASE("coarse: interpolated fields keep the error that they state", "[coarse]") {
    CAPTURE(reseed());
    for (Case& c : interpolated_cases())
        for (const Pattern pattern : {Pattern::piston, Pattern::point}) {
            c.array.transducer.pattern = pattern;
            c.array.medium.absorption_np_m = pattern == Pattern::piston ? 0.0 : 0.13;
            const Drive drives = random_drives(c.array);
            const PressureField found = pressure_field(c.array, drives, c.grid);
            const double error = error_of(c.array, drives, c.grid, found.values);
            CAPTURE(c.name, static_cast<int>(pattern), found.error, error);
            CHECK(found.method == FieldMethod::interpolated);
            CHECK(found.error <= 1e-4);
            CHECK(error <= found.error);
            CHECK(found.pattern_error == 0.0);
            // Summed, it is nearer still.
            FieldOptions summed;
            summed.interpolation_error = 0.0;
            const PressureField sums = pressure_field(c.array, drives, c.grid, summed);
            CHECK(sums.method != FieldMethod::interpolated);
            CHECK(error_of(c.array, drives, c.grid, sums.values) <= sums.error);
        }
}

TEST_CASE("coarse: what cannot be interpolated is summed", "[coarse]") {
    CAPTURE(reseed());
    Array array = grid_array(10, 10, 0.01);
    const Drive drives = random_drives(array);
    const auto method_of = [&](const Grid& grid) {
        std::vector<double> told;
        FieldOptions options;
        options.progress = [&](double part, std::string_view) {
            told.push_back(part);
            return true;
        };
        const PressureField found = pressure_field(array, drives, grid, options);
        CHECK(std::is_sorted(told.begin(), told.end()));
        CHECK(told.back() == 1.0);
        CHECK(error_of(array, drives, grid, found.values, 500) <= found.error);
        return found.method;
    };
    CHECK(method_of({axis(-0.06, 0.93e-3, 131), axis(-0.06, 0.93e-3, 131), {0.015}}) == FieldMethod::sums);  // near
    CHECK(method_of({axis(-0.06, 1e-3, 131), axis(-0.06, 1e-3, 131), {0.015}}) == FieldMethod::shifts);
    CHECK(method_of({axis(-0.06, 4.7e-3, 30), axis(-0.06, 4.7e-3, 30), {0.1}}) == FieldMethod::sums);  // already coarse
    Grid uneven{axis(-0.06, 0.93e-3, 131), axis(-0.06, 0.93e-3, 131), {0.1}};
    for (double& x : uneven.x) x += 1e-5 * random(-1.0, 1.0);
    for (double& y : uneven.y) y += 1e-5 * random(-1.0, 1.0);
    CHECK(method_of(uneven) == FieldMethod::sums);
    // A pattern with a step in it makes a field that no band holds: the checked points tell.
    array.transducer.pattern = Pattern::table;
    array.transducer.table = std::vector<double>(91, 1.0);
    std::fill(array.transducer.table.begin() + 20, array.transducer.table.end(), 0.0);
    CHECK(method_of({axis(-0.06, 0.93e-3, 131), axis(-0.06, 0.93e-3, 131), {0.1}}) == FieldMethod::sums);
}

TEST_CASE("coarse: one, two and three threads, and every instruction set", "[coarse]") {
    CAPTURE(reseed());
    const tbb::global_control allowed(tbb::global_control::max_allowed_parallelism, 4);
    const std::vector<Case> cases = interpolated_cases();
    on_every_target(wave_target, [&] {
        for (const std::size_t i : {0U, 3U, 5U}) {
            const Case& c = cases[i];
            const Drive drives = random_drives(c.array);
            const PressureField found = pressure_field(c.array, drives, c.grid);
            CAPTURE(c.name);
            REQUIRE(found.method == FieldMethod::interpolated);
            REQUIRE(error_of(c.array, drives, c.grid, found.values, 200) <= found.error);
            for (const unsigned threads : {2U, 3U}) {
                const PressureField again = pressure_field(c.array, drives, c.grid, {.threads = threads});
                REQUIRE(again.error == found.error);
                REQUIRE(std::memcmp(again.values.data(), found.values.data(),
                                    found.values.size() * sizeof(found.values[0])) == 0);
            }
        }
    });
}

TEST_CASE("coarse: progress of an interpolated field, and its end", "[coarse]") {
    CAPTURE(reseed());
    const Case c = interpolated_cases()[5];
    const Drive drives = random_drives(c.array);
    std::vector<double> told;
    FieldOptions options;
    options.progress = [&](double part, std::string_view) {
        told.push_back(part);
        return true;
    };
    REQUIRE(pressure_field(c.array, drives, c.grid, options).method == FieldMethod::interpolated);
    REQUIRE(told.size() > 2);
    REQUIRE(std::is_sorted(told.begin(), told.end()));
    REQUIRE(told.back() == 1.0);
    for (const std::size_t last : {std::size_t{1}, told.size() - 1}) {
        std::size_t count = 0;
        options.progress = [&](double, std::string_view) { return ++count < last; };
        try {
            (void)pressure_field(c.array, drives, c.grid, options);
            FAIL("not cancelled");
        } catch (const Error& error) {
            REQUIRE(error.code() == ErrorCode::cancelled);
        }
        REQUIRE(count == last);
    }
}

TEST_CASE("coarse: polynomials take the place of measured patterns, and state by how much they differ", "[coarse]") {
    CAPTURE(reseed());
    Array array = grid_array(6, 6, 0.01);
    array.columns = 0;
    array.transducer.pattern = Pattern::table;
    array.transducer.table = {1, 1, 1, 0.891, 0.708, 0.501, 0.355, 0.251, 0.200, 0.178};  // T4010A1
    const Drive drives = random_drives(array);
    for (const double allowed : {0.015, 0.01195}) {
        const FittedPattern fit = fit_pattern(array.transducer, 733.0, allowed);
        REQUIRE(fit.kind == FittedPattern::Kind::polynomial);
        REQUIRE(fit.values.size() == (allowed > 0.012 ? 6U : 9U));
        double worst = 0.0;
        for (int i = 0; i <= 9000; ++i) {
            const double angle = i * std::numbers::pi / 18000.0;
            double value = 0.0;
            for (std::size_t n = fit.values.size(); n-- > 0;)
                value = value * std::cos(2.0 * angle) + static_cast<double>(fit.values[n]);
            worst = std::max(worst, std::abs(value - directivity_of(array, angle)));
        }
        REQUIRE(worst <= fit.error * 1.001);
        REQUIRE(fit.error <= allowed);
        REQUIRE(worst >= fit.error * 0.9);
        FieldOptions options;
        options.pattern_error = allowed;
        for (const double tilt : {0.0, 50.0}) {  // tilted, parts of the plane are behind some elements
            const Array turned = seen_from(array, pose_of({0, 0, 0.05}, {tilt, 10 * tilt / 50.0, 0}));
            const Grid grid{axis(-0.1, 0.9e-3, 60), axis(-0.1, 1.3e-3, 70), {0.05}};
            const PressureField found = pressure_field(turned, drives, grid, options);
            REQUIRE(found.pattern_error == fit.error);
            double most = 0.0;  // of the sum without any directivity
            Array points = turned;
            points.transducer.pattern = Pattern::point;
            for (std::size_t i = 0; i < grid.size(); i += 7)
                most = std::max(most, sum_at(points, drives, grid.point(i)).most);
            for (std::size_t i = 0; i < grid.size(); i += 7) {
                const Complex exact = sum_at(turned, drives, grid.point(i)).pressure;
                REQUIRE(std::abs(exact - Complex(found.values[i])) <= (found.pattern_error + found.error) * most);
            }
        }
    }
    REQUIRE(fit_pattern(array.transducer, 733.0, 0.005).kind ==
            FittedPattern::Kind::table);  // no polynomial is so near
    REQUIRE(fit_pattern(array.transducer, 733.0).error == 0.0);
}

TEST_CASE("coarse: the mean square of a sequence on an oblique plane", "[coarse]") {
    CAPTURE(reseed());
    const Array array = grid_array(6, 5, 0.0098);
    const Pose pose = pose_of({0.01, 0.0, 0.09}, {40, -20, 70});
    std::vector<Drive> drives;
    std::vector<WeightedDrives> sequence;
    for (int r = 0; r < 7; ++r) drives.push_back(random_drives(array));
    double total = 0.0;
    for (const Drive& one : drives) {
        sequence.push_back({random(0.2, 2.0), one});
        total += sequence.back().weight;
    }
    const Grid grid{axis(-0.04, 1.1e-3, 70), axis(-0.03, 0.7e-3, 80), {0.0}};
    const auto found = mean_square_pressure(seen_from(array, pose), sequence, grid);
    for (std::size_t i = 0; i < grid.size(); i += 11) {
        double sum = 0.0, most = 0.0;
        for (const WeightedDrives& entry : sequence) {
            const Drive one(entry.drives.begin(), entry.drives.end());
            const Sum at = sum_at(array, one, pose.outwards(grid.point(i)));  // in the array's own coordinates
            sum += entry.weight / total * std::norm(at.pressure) / 2.0;
            most += entry.weight / total * at.most * at.most / 2.0;
        }
        REQUIRE(std::abs(static_cast<double>(found[i]) - sum) <= 1e-4 * most);
    }
}

TEST_CASE("coarse: the mean square of one set of drives keeps the error that it states", "[coarse]") {
    CAPTURE(reseed());
    const Array array = grid_array(7, 6, 0.01);
    const Drive drives = random_drives(array), silent(drives.size(), 1.0);
    const std::vector<WeightedDrives> sequence{{0.0, silent}, {random(0.2, 2.0), drives}};
    const Grid grid{axis(-0.05, 1.3e-3, 77), axis(-0.04, 0.9e-3, 90), {random(0.03, 0.2)}};
    const MeanSquareField found = mean_square_field(array, sequence, grid);
    REQUIRE(found.method == FieldMethod::interpolated);
    REQUIRE(found.error <= 1e-4);
    double most = 0.0;
    for (std::size_t i = 0; i < grid.size(); i += 7) most = std::max(most, sum_at(array, drives, grid.point(i)).most);
    for (std::size_t i = 0; i < grid.size(); i += 7) {
        const double rms = std::abs(sum_at(array, drives, grid.point(i)).pressure) / std::sqrt(2.0);
        REQUIRE(std::abs(std::sqrt(static_cast<double>(found.values[i])) - rms) <= found.error * most / std::sqrt(2.0));
    }
    // Two sets that are the same are summed, and agree.
    const std::vector<WeightedDrives> twice{{1.0, drives}, {1.0, drives}};
    const MeanSquareField summed = mean_square_field(array, twice, grid);
    REQUIRE(summed.method == FieldMethod::sums);
    for (std::size_t i = 0; i < grid.size(); i += 7)
        REQUIRE(std::abs(std::sqrt(summed.values[i]) - std::sqrt(found.values[i])) <=
                static_cast<float>((found.error + summed.error) * most));
}

TEST_CASE("coarse: gradients equal differences of the sums", "[coarse]") {
    CAPTURE(reseed());
    Array upright = grid_array(4, 5, 0.011), tilted = around();
    on_every_target(wave_target, [&] {
        for (Array array : {upright, tilted})
            for (const Pattern pattern : {Pattern::piston, Pattern::point, Pattern::table})
                for (const double radius : {4.5e-3, 9e-3, 0.015}) {
                    if (pattern != Pattern::piston && radius > 5e-3) continue;
                    array.transducer.pattern = pattern;
                    array.transducer.radius_m = radius;
                    array.transducer.table = {1.0, 0.9, 0.6, 0.5, 0.1};
                    array.medium.absorption_np_m = radius > 5e-3 ? 0.3 : 0.0;
                    const Drive drives = random_drives(array);
                    std::vector<Vec3> points;
                    for (int i = 0; i < 300; ++i)
                        points.push_back({random(-0.04, 0.04), random(-0.04, 0.04), random(0.11, 0.19)});
                    const auto found = pressure_gradient_at(array, drives, points);
                    const double k = 2.0 * std::numbers::pi / array.wavelength_m();
                    double most = 0.0, worst = 0.0;
                    for (std::size_t i = 0; i < points.size(); ++i) {
                        constexpr double h = 2e-6;
                        const auto slope = [&](Vec3 step) {
                            return (sum_at(array, drives, points[i] + step).pressure -
                                    sum_at(array, drives, points[i] + step * -1.0).pressure) /
                                   (2.0 * h);
                        };
                        most = std::max(most, sum_at(array, drives, points[i]).most);
                        worst = std::max({worst, std::abs(slope({h, 0, 0}) - Complex(found[i].x)),
                                          std::abs(slope({0, h, 0}) - Complex(found[i].y)),
                                          std::abs(slope({0, 0, h}) - Complex(found[i].z))});
                    }
                    CAPTURE(static_cast<int>(pattern), radius, array.elements.size());
                    // Straight lines that meet within the difference's step have two slopes.
                    REQUIRE(worst / (k * most) <= (pattern == Pattern::table ? 5e-3 : 1e-4));
                }
    });
    REQUIRE_THROWS_AS(pressure_gradient_at(upright, Drive(3), {}), Error);
    std::vector<Vec3> on{upright.elements[3].position};
    REQUIRE_THROWS_AS(pressure_gradient_at(upright, Drive(20, 1.0), on), Error);
}
