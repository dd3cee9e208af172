// SPDX-License-Identifier: Apache-2.0
#include <hwy/targets.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <cstring>
#include <functional>
#include <numbers>
#include <random>
#include <thread>

#include "../refusal.hpp"
#include "every_target.hpp"
#include "haptogram/acoustics/field.hpp"
#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/acoustics/shift.hpp"
#include "haptogram/acoustics/wave.hpp"
#include "haptogram/array/rig.hpp"
#include "haptogram/base/error.hpp"

using namespace haptogram;

namespace {

using Field = std::vector<std::complex<float>>;
using Record = std::vector<std::complex<double>>;

std::mt19937& randomness() {
    static std::mt19937 generator;
    return generator;
}

/// Seeds the numbers that follow and names the seed in every failure.
unsigned reseed() {
    const unsigned seed = static_cast<unsigned>(Catch::rngSeed());
    randomness().seed(seed);
    return seed;
}

double random(double from, double to) { return std::uniform_real_distribution<double>(from, to)(randomness()); }

Vec3 random_point(double half, double z0, double z1) {
    return {random(-half, half), random(-half, half), random(z0, z1)};
}

std::vector<Vec3> random_points(std::size_t count, double half, double z0, double z1) {
    std::vector<Vec3> points(count);
    for (Vec3& p : points) p = random_point(half, z0, z1);
    return points;
}

Array grid_array(std::uint32_t columns, std::uint32_t rows, double pitch_x = 0.01, double pitch_y = 0.01) {
    Array array;
    array.columns = columns;
    for (std::uint32_t m = 0; m < columns * rows; ++m)
        array.elements.push_back(
            {(m % columns - (columns - 1) / 2.0) * pitch_x, (m / columns - (rows - 1) / 2.0) * pitch_y, 0.0});
    return array;
}

Array random_array(std::size_t elements) {
    Array array;
    for (std::size_t m = 0; m < elements; ++m) array.elements.push_back({random_point(0.06, -0.01, 0.01)});
    return array;
}

/// Two to four small grids of elements, each somewhere around the origin and turned any way.
Rig random_rig() {
    Rig rig{"random", {}};
    const int arrays = std::uniform_int_distribution<int>(2, 4)(randomness());
    for (int i = 0; i < arrays; ++i) {
        const Vec3 angles{random(-180, 180), random(-90, 90), random(-180, 180)};
        rig.arrays.push_back({grid_array(4, 3), pose_of(random_point(0.15, -0.05, 0.05), angles)});
    }
    return rig;
}

Record random_drives(const Array& array) {
    Record drives;
    for (std::size_t m = 0; m < array.elements.size(); ++m)
        drives.push_back(std::polar(random(0.0, 5.0), random(-9.0, 9.0)));
    return drives;
}

std::vector<double> axis(double from, double step, std::size_t count) {
    std::vector<double> found(count);
    for (std::size_t i = 0; i < count; ++i) found[i] = from + step * static_cast<double>(i);
    return found;
}

std::vector<Vec3> points_of(const Grid& grid) {
    std::vector<Vec3> points;
    for (std::size_t i = 0; i < grid.size(); ++i) points.push_back(grid.point(i));
    return points;
}

/// The largest error against the sum in double, over the largest |p| that the drives can make at any of the points.
double error(const Array& array, const Record& drives, const std::vector<Vec3>& points, const Field& found) {
    REQUIRE(found.size() == points.size());
    double worst = 0.0, peak = 0.0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const double off = std::abs(std::complex<double>(found[i]) - pressure(array, drives, points[i]));
        worst = std::isnan(off) ? INFINITY : std::max(worst, off);
        double most = 0.0;
        for (std::size_t m = 0; m < drives.size(); ++m)
            most += std::abs(drives[m] * propagation(array, array.elements[m], points[i]));
        peak = std::max(peak, most);
    }
    return worst / peak;
}

double error(const Array& array, const Record& drives, const std::vector<Vec3>& points) {
    return error(array, drives, points, pressure_at(array, drives, points));
}

template <class T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

const std::vector<double> measured_table{1, 1, 1, 0.891, 0.708, 0.501, 0.355, 0.251, 0.200, 0.178};

/// What single precision is held to here, where nothing stands in the way: a third of what the header promises.
constexpr double tight = 3e-5;
/// Of a piston. One of several wavelengths multiplies the rounding of the angle and is held to what the header
/// promises.
double allowed_error(double radius_m) { return radius_m > 0.02 ? 1e-4 : tight; }

}  // namespace

TEST_CASE("kernel: equal to the double sum for every pattern, with and without absorption", "[kernel]") {
    CAPTURE(reseed());
    Array array = random_array(37);
    auto points = random_points(2500, 0.15, -0.1, 0.3);
    for (Vec3& p : points)  // a table jumps at 90°
        for (const Element& e : array.elements)
            if (std::abs(p.z - e.position.z) < 1e-6) p.z = 0.2;
    const Record drives = random_drives(array);
    for (const double absorption : {0.0, 0.115, 3.0}) {
        array.medium.absorption_np_m = absorption;
        for (const Pattern pattern : {Pattern::piston, Pattern::point, Pattern::table}) {
            array.transducer.pattern = pattern;
            array.transducer.table = measured_table;
            CAPTURE(absorption, static_cast<int>(pattern));
            REQUIRE(error(array, drives, points) <= tight);
        }
    }
}

TEST_CASE("kernel: pistons and point sources of every size in wavelengths", "[kernel]") {
    CAPTURE(reseed());
    Array array = random_array(9);
    const auto points = random_points(700, 0.1, 0.05, 0.2);
    const Record drives = random_drives(array);
    for (const double radius : {0.0, 1e-6, 1e-3, 4.5e-3, 8e-3, 0.02, 0.05, 0.2}) {
        array.transducer.radius_m = radius;
        CAPTURE(radius);
        REQUIRE(error(array, drives, points) <= allowed_error(radius));
    }
}

TEST_CASE("kernel: tables of two and of many angles, steep ones too", "[kernel]") {
    CAPTURE(reseed());
    Array array = random_array(9);
    array.transducer.pattern = Pattern::table;
    const auto points = random_points(700, 0.1, 0.001, 0.2);
    const Record drives = random_drives(array);
    for (const std::vector<double>& table : {std::vector<double>{1, 0}, {1, 0.5, 0.9, 0.1, 0.4}, measured_table}) {
        array.transducer.table = table;
        REQUIRE(error(array, drives, points) <= tight);
    }
    std::vector<double> fine(181);
    for (std::size_t i = 0; i < fine.size(); ++i) fine[i] = std::cos(static_cast<double>(i) * 0.05);
    array.transducer.table = fine;
    REQUIRE(error(array, drives, points) <= tight);
}

TEST_CASE("kernel: a table on its axis, at 90° and behind", "[kernel]") {
    Array array;
    array.elements = {{0.013, -0.02, 0.004}};
    array.transducer.pattern = Pattern::table;
    array.transducer.table = measured_table;
    const Record drives{{2.0, -1.0}};
    const Vec3 e = array.elements[0].position;
    const std::vector<Vec3> points{e + Vec3{0, 0, 0.1}, e + Vec3{0.1, 0, 0}, e + Vec3{0, 0.07, 0}, e + Vec3{0, 0, -0.1},
                                   e + Vec3{0.1, 0.1, -0.001}};
    REQUIRE(error(array, drives, points) <= tight);
    const Field found = pressure_at(array, drives, points);
    REQUIRE(std::abs(found[1]) > 1.0);
    REQUIRE(found[3] == 0.0F);
    REQUIRE(found[4] == 0.0F);
}

TEST_CASE("kernel: elements that face any way radiate along their normals", "[kernel]") {
    CAPTURE(reseed());
    for (int repeat = 0; repeat < 5; ++repeat) {
        Array array = joined(random_rig());
        const Record drives = random_drives(array);
        auto points = random_points(1500, 0.25, -0.1, 0.4);
        // At 90° a table jumps, and there rounding decides on which side a point is.
        const auto at_the_jump = [&](Vec3 p) {
            return std::any_of(array.elements.begin(), array.elements.end(),
                               [&](const Element& e) { return std::abs(dot(p - e.position, e.normal)) < 1e-6; });
        };
        points.erase(std::remove_if(points.begin(), points.end(), at_the_jump), points.end());
        Array upright = array;
        for (Element& e : upright.elements) e.normal = {0.0, 0.0, 1.0};
        for (const double absorption : {0.0, 0.115}) {
            array.medium.absorption_np_m = upright.medium.absorption_np_m = absorption;
            for (const Pattern pattern : {Pattern::piston, Pattern::point, Pattern::table})
                for (const double radius : {1e-3, 4.5e-3, 0.02, 0.05}) {
                    array.transducer.pattern = upright.transducer.pattern = pattern;
                    array.transducer.table = upright.transducer.table = measured_table;
                    array.transducer.radius_m = upright.transducer.radius_m = radius;
                    const Field found = pressure_at(array, drives, points);
                    CAPTURE(repeat, absorption, static_cast<int>(pattern), radius);
                    REQUIRE(error(array, drives, points, found) <= allowed_error(radius));
                    // Only a point source sounds the same when it faces another way.
                    const bool same = error(upright, drives, points, found) <= tight;
                    if (radius > 2e-3) REQUIRE(same == (pattern == Pattern::point));
                }
        }
    }
}

TEST_CASE("kernel: a tilted table on its axis, beside it and behind", "[kernel]") {
    const Pose pose = pose_of({0.02, -0.01, 0.05}, {35.0, -50.0, 20.0});
    Array array;
    array.elements = {{pose.origin, pose.z}};
    array.transducer.pattern = Pattern::table;
    array.transducer.table = measured_table;
    const Record drives{{2.0, -1.0}};
    const auto at = [&](double degrees) {
        const double angle = degrees * std::numbers::pi / 180.0;
        return pose.outwards({0.0, 0.1 * std::sin(angle), 0.1 * std::cos(angle)});
    };
    for (const double degrees : {0.0, 1e-3, 15.0, 45.0, 60.0, 85.0, 89.99}) {
        CAPTURE(degrees);
        REQUIRE(error(array, drives, {at(degrees), at(-degrees)}) <= tight);
    }
    for (const double degrees : {90.01, 135.0, 180.0})
        REQUIRE(pressure_at(array, drives, std::vector{at(degrees)}) == Field{0.0F});
}

TEST_CASE("kernel: a rig turned as a whole turns its field", "[kernel]") {
    CAPTURE(reseed());
    for (int repeat = 0; repeat < 4; ++repeat) {
        const Rig rig = random_rig();
        const Pose pose =
            pose_of(random_point(0.3, -0.3, 0.3), {random(-180, 180), random(-90, 90), random(-180, 180)});
        Rig turned = rig;
        for (PosedArray& part : turned.arrays)
            part.pose = {pose.outwards(part.pose.origin), pose.turned(part.pose.x), pose.turned(part.pose.y),
                         pose.turned(part.pose.z)};
        const Array before = joined(rig), after = joined(turned);
        const Record drives = random_drives(before);
        const auto points = random_points(1200, 0.2, -0.2, 0.3);
        std::vector<Vec3> moved;
        for (const Vec3& p : points) moved.push_back(pose.outwards(p));
        REQUIRE(error(before, drives, points, pressure_at(after, drives, moved)) <= tight);
    }
}

TEST_CASE("kernel: any number of points and elements", "[kernel]") {
    CAPTURE(reseed());
    for (const std::size_t elements : {1U, 3U, 100U}) {
        const Array array = random_array(elements);
        const Record drives = random_drives(array);
        for (const std::size_t count : {1U, 2U, 7U, 15U, 16U, 17U, 31U, 33U, 64U, 1023U, 1024U, 1025U, 2049U}) {
            CAPTURE(elements, count);
            REQUIRE(error(array, drives, random_points(count, 0.1, 0.05, 0.2)) <= tight);
        }
    }
}

TEST_CASE("kernel: every instruction set of this processor", "[kernel]") {
    CAPTURE(reseed());
    const Grid grid{axis(-0.05, 1e-3, 77), axis(-0.05, 1e-3, 31), {0.1}};
    const auto points = random_points(1100, 0.1, 0.05, 0.2);
    // Upright elements and tilted ones take different ways through the kernel.
    const Rig facing{"facing",
                     {{grid_array(4, 3), pose_of({-0.1, 0.0, 0.02}, {0.0, 50.0, 0.0})},
                      {grid_array(4, 3), pose_of({0.02, 0.01, 0.3}, {170.0, 0.0, 30.0})}}};
    const Array arrays[] = {grid_array(6, 5), joined(facing)};
    on_every_target(wave_target, [&] {
        for (std::size_t i = 0; i < 2 * 3; ++i) {
            Array array = arrays[i / 3];
            array.transducer.pattern = std::array{Pattern::piston, Pattern::point, Pattern::table}[i % 3];
            array.transducer.table = measured_table;
            CAPTURE(i);
            const Record drives = random_drives(array);
            // Twice the same: the loops for sequences, which a single set does not take.
            const std::array<WeightedDrives, 2> twice{{{1.0, drives}, {2.0, drives}}};
            REQUIRE(error(array, drives, points) <= tight);
            const Field on = pressure_on(array, drives, grid);
            REQUIRE(error(array, drives, points_of(grid), on) <= tight);
            const auto mean = mean_square_pressure(array, twice, grid);
            float peak = 0.0F, worst = 0.0F;
            for (std::size_t j = 0; j < mean.size(); ++j) {
                peak = std::max(peak, mean[j]);
                worst = std::max(worst, std::abs(mean[j] - std::norm(on[j]) / 2.0F));
            }
            REQUIRE(worst <= 1e-4F * peak);
        }
    });
}

TEST_CASE("kernel: nothing asked, nothing played", "[kernel]") {
    Array array = grid_array(2, 2);
    const Record drives(4, 1.0);
    const Record silent(4, 0.0);
    const std::vector<Vec3> points(3, Vec3{0.0, 0.0, 0.1});
    REQUIRE(pressure_at(array, drives, {}).empty());
    REQUIRE(pressure_on(array, drives, {}).empty());
    REQUIRE(pressure_on(array, drives, {{1.0}, {}, {2.0}}).empty());
    REQUIRE(pressure_at(array, silent, points) == Field(3, 0.0F));
    REQUIRE(mean_square_pressure(array, {}, {{0.0}, {0.0}, {0.1}}) == std::vector<float>{0.0F});
    const WeightedDrives entry{1.0, drives};
    REQUIRE(mean_square_pressure(array, {&entry, 1}, {}).empty());
    array.elements.clear();
    REQUIRE(pressure_at(array, {}, points) == Field(3, 0.0F));
    REQUIRE(pressure_on(array, {}, {{0.0}, {0.0}, {0.1, 0.2}}) == Field(2, 0.0F));
}

TEST_CASE("kernel: the drives are one an element", "[kernel]") {
    const Array array = grid_array(2, 2);
    const Record drives(3, 1.0);
    const WeightedDrives entry{1.0, drives};
    const std::vector<Vec3> points(1, Vec3{0.0, 0.0, 0.1});
    REQUIRE_REFUSED(pressure_at(array, drives, points));
    REQUIRE_REFUSED(pressure_on(array, drives, {}));
    REQUIRE_REFUSED(mean_square_pressure(array, {&entry, 1}, {}));
}

TEST_CASE("kernel: near field, down to micrometres from an element", "[kernel]") {
    CAPTURE(reseed());
    Array array = grid_array(10, 10);
    const Record drives = random_drives(array);
    for (const double height : {1e-6, 1e-5, 1e-4, 1e-3, 3e-3, 0.01}) {
        CAPTURE(height);
        auto points = random_points(1500, 0.06, height, height);
        for (const Element& e : array.elements)
            points.push_back(e.position + Vec3{random(-height, height), 0.0, height});
        // Each point against what can be heard there: an element nearby makes the peak thousands of times higher.
        const Field found = pressure_at(array, drives, points);
        for (std::size_t i = 0; i < points.size(); ++i) REQUIRE(error(array, drives, {points[i]}, {found[i]}) <= 3e-5);
        const Grid grid{axis(-0.05, 1e-3, 101), axis(-0.05, 1e-3, 11), {height}};
        REQUIRE(error(array, drives, points_of(grid), pressure_on(array, drives, grid)) <= tight);
    }
}

TEST_CASE("kernel: far field, and far from the origin", "[kernel]") {
    CAPTURE(reseed());
    Array array = random_array(25);
    const Record drives = random_drives(array);
    for (const double far : {1.0, 5.0, 30.0}) {
        auto points = random_points(1200, 0.1, far, far + 0.1);
        CAPTURE(far);
        REQUIRE(error(array, drives, points) <= tight);
        const Vec3 move{far, -2.0 * far, 3.0 * far};
        Array moved = array;
        for (Element& e : moved.elements) e.position = e.position + move;
        points = random_points(1200, 0.1, 0.05, 0.2);
        for (Vec3& p : points) p = p + move;
        REQUIRE(error(moved, drives, points) <= tight);
    }
    // Points scattered over metres share a block.
    REQUIRE(error(array, drives, random_points(3000, 2.0, 0.1, 3.0)) <= 1e-4);
}

TEST_CASE("kernel: a focus has its full strength", "[kernel]") {
    const Array array = grid_array(10, 10);
    const std::vector<Vec3> foci{{0.0, 0.0, 0.13}, {0.02, -0.03, 0.1}, {-0.04, 0.01, 0.3}};
    for (const Vec3& focus : foci) REQUIRE(error(array, ideal_drives(array, focus), foci) <= tight);
}

TEST_CASE("kernel: a point on an element is refused", "[kernel]") {
    const Array array = grid_array(10, 10);
    const Record drives(100, 1.0);
    auto points = random_points(3000, 0.1, 0.05, 0.2);
    for (const std::size_t at : {0U, 1023U, 2999U}) {
        for (const double off : {0.0, 0.9e-9}) {
            auto bad = points;
            bad[at] = array.elements[55].position + Vec3{0.0, off, 0.0};
            for (const unsigned threads : {1U, 2U}) {
                const FieldOptions options{.threads = threads};
                REQUIRE_REFUSED(pressure_at(array, drives, bad, options));
            }
        }
    }
    points[5] = array.elements[55].position + Vec3{0.0, 2e-9, 0.0};
    REQUIRE(error(array, drives, points) <= tight);

    const WeightedDrives entry{1.0, drives};
    for (const double step : {1e-3, 2.5e-3, 9e-3}) {
        const Grid grid{axis(array.elements[0].position.x, step, 30),
                        axis(array.elements[0].position.y, step, 30),
                        {-0.1, 0.0, 0.1}};
        REQUIRE_REFUSED(pressure_on(array, drives, grid));
        REQUIRE_REFUSED(mean_square_pressure(array, {&entry, 1}, grid));
    }
    try {
        (void)pressure_at(array, drives, std::vector<Vec3>{array.elements[7].position});
        FAIL("no error");
    } catch (const Error& e) {
        REQUIRE(e.code() == ErrorCode::bad_input);
    }
}

TEST_CASE("kernel: shifts are found where they are, to the nanometre", "[kernel]") {
    const Array array = grid_array(10, 8);
    const auto square = [](double from, double step, std::size_t count) {
        return Grid{axis(from, step, count), axis(from, step, count), {0.1}};
    };
    const auto of_1_mm = find_shifts(array, square(-0.05, 1e-3, 100));
    REQUIRE(of_1_mm);
    REQUIRE(of_1_mm->x.size() == 100 + 9 * 10);
    REQUIRE(of_1_mm->step_columns == 10);
    REQUIRE(find_shifts(array, square(-0.0437, 2.5e-3, 33)));
    REQUIRE(find_shifts(array, square(0.2, 0.01, 5)));
    REQUIRE(find_shifts(array, square(0.0123, 0.01 / 3.0, 50)));
    REQUIRE_FALSE(find_shifts(array, square(-0.05, 1.1e-3, 100)));  // does not divide the pitch
    REQUIRE_FALSE(find_shifts(array, square(-0.05, 3e-3, 100)));    // neither
    REQUIRE_FALSE(find_shifts(array, square(-0.05, 0.02, 100)));    // more than the pitch
    REQUIRE_FALSE(find_shifts(array, square(0.05, -1e-3, 100)));    // backwards
    REQUIRE_FALSE(find_shifts(array, square(-0.05, 1.0001e-3, 100)));
    Grid uneven = square(-0.05, 1e-3, 100);
    uneven.y[50] += 2e-8;
    REQUIRE_FALSE(find_shifts(array, uneven));
    for (int part = 0; part < 3; ++part) {
        Array bent = array;
        (part == 0   ? bent.elements[33].position.x
         : part == 1 ? bent.elements[33].position.y
                     : bent.elements[33].position.z) += 2e-8;
        REQUIRE_FALSE(find_shifts(bent, square(-0.05, 1e-3, 100)));
    }
    Array listed = array;
    listed.columns = 0;
    REQUIRE_FALSE(find_shifts(listed, square(-0.05, 1e-3, 100)));
    // ±y are one row: with every row's mirror on the lattice, about half are left.
    const auto mirrored = find_shifts(array, square(-0.05, 1e-3, 101));
    REQUIRE(mirrored);
    REQUIRE(mirrored->y.size() < mirrored->rows.size() * 6 / 10);
}

TEST_CASE("kernel: shifted fields equal the direct sum", "[kernel]") {
    CAPTURE(reseed());
    struct Case {
        std::uint32_t columns, rows;
        double pitch_x, pitch_y;
        Grid grid;
    };
    const Case cases[] = {
        {10, 10, 0.01, 0.01, {axis(-0.05, 1e-3, 100), axis(-0.05, 1e-3, 60), {0.05, 0.13}}},
        {10, 10, 0.01, 0.01, {axis(-0.0501234567, 1e-3, 100), axis(-0.0307654321, 1e-3, 33), {0.1}}},
        {10, 7, 0.01, 0.012, {axis(-0.033, 2.5e-3, 31), axis(-0.04, 4e-3, 17), {-0.1, 0.002, 0.3}}},
        {4, 5, 0.01, 0.01, {axis(-0.1, 5e-3, 65), axis(0.03, 0.01, 9), {0.1, 0.11, 0.12}}},
        {6, 6, 0.01, 0.01, {axis(-0.1, 1e-3, 200), {0.0371}, {0.1}}},                        // a line
        {6, 6, 0.01, 0.01, {axis(-0.1, 1e-3, 200), {0.005}, axis(0.02, 2e-3, 40)}},          // an upright plane
        {6, 6, 0.01, 0.01, {{0.005}, axis(-0.1, 1e-3, 90), axis(0.02, 2e-3, 10)}},           // another
        {16, 1, 0.01, 0.01, {axis(-0.1, 1e-3, 200), axis(-0.0123, 7e-4, 30), {0.1}}},        // a row of elements
        {1, 16, 0.01, 0.01, {axis(-0.0133, 7e-4, 90), axis(-0.0123, 1e-3, 30), {0.1}}},      // a column
        {10, 10, 0.01, 0.01, {axis(-0.05, 1.1e-3, 70), axis(-0.05, 1e-3, 30), {0.1}}},       // falls back
        {10, 10, 0.01, 0.01, {axis(-0.05, 1e-3, 70), axis(-0.05, 1e-3, 30), {-1e-4, 0.1}}},  // through the elements
    };
    for (const Case& c : cases) {
        Array array = grid_array(c.columns, c.rows, c.pitch_x, c.pitch_y);
        for (Element& e : array.elements)
            e.position = e.position + Vec3{0.003, -0.002, 0.0};  // the array need not be centred
        const Record drives = random_drives(array);
        Array listed = array;
        listed.columns = 0;
        for (const Pattern pattern : {Pattern::piston, Pattern::table}) {
            array.transducer.pattern = listed.transducer.pattern = pattern;
            array.transducer.table = listed.transducer.table = measured_table;
            array.medium.absorption_np_m = listed.medium.absorption_np_m = 0.2;
            const Field found = pressure_on(array, drives, c.grid);
            CAPTURE(&c - cases, static_cast<int>(pattern));
            REQUIRE(error(array, drives, points_of(c.grid), found) <= tight);
            REQUIRE(error(array, drives, points_of(c.grid), pressure_on(listed, drives, c.grid)) <= tight);
        }
    }
    // The last row of elements may be short.
    Array array = grid_array(8, 8);
    array.elements.resize(59);
    const Record drives = random_drives(array);
    const Grid grid{axis(-0.05, 1e-3, 100), axis(-0.05, 1e-3, 60), {0.1}};
    REQUIRE(find_shifts(array, grid));
    REQUIRE(error(array, drives, points_of(grid), pressure_on(array, drives, grid)) <= tight);
}

TEST_CASE("kernel: the mean square over a sequence", "[kernel]") {
    CAPTURE(reseed());
    Array array = grid_array(5, 4);
    const Grid grid{axis(-0.03, 2e-3, 31), axis(-0.03, 1.7e-3, 37), {0.0005, 0.1}};
    for (const std::size_t records : {1U, 2U, 7U, 200U}) {
        std::vector<Record> drives;
        std::vector<WeightedDrives> sequence;
        for (std::size_t i = 0; i < records; ++i) drives.push_back(random_drives(array));
        double total = 0.0;
        for (const Record& record : drives) {
            sequence.push_back({sequence.size() == 1 ? 0.0 : random(0.1, 3.0), record});
            total += sequence.back().weight;
        }
        const auto found = mean_square_pressure(array, sequence, grid);
        REQUIRE(found.size() == grid.size());
        for (std::size_t i = 0; i < grid.size(); i += 13) {
            double sum = 0.0, most = 0.0;
            for (const WeightedDrives& entry : sequence) {
                sum += entry.weight / total / 2.0 * std::norm(pressure(array, entry.drives, grid.point(i)));
                double can = 0.0;
                for (std::size_t m = 0; m < array.elements.size(); ++m)
                    can += std::abs(entry.drives[m] * propagation(array, array.elements[m], grid.point(i)));
                most += entry.weight / total / 2.0 * can * can;
            }
            CAPTURE(records, i);
            REQUIRE(std::abs(static_cast<double>(found[i]) - sum) <= tight * most);
        }
    }
    const Record drives = random_drives(array);
    const WeightedDrives silent{0.0, drives};
    REQUIRE(mean_square_pressure(array, {&silent, 1}, grid) == std::vector<float>(grid.size(), 0.0F));
}

TEST_CASE("kernel: the mean square at points in any order and plane", "[kernel]") {
    CAPTURE(reseed());
    const Array upright = grid_array(5, 4), tilted = joined(random_rig());
    const Grid grid{axis(-0.03, 2e-3, 31), axis(-0.03, 1.7e-3, 37), {0.0505, 0.1}};
    for (const Array& array : {upright, tilted}) {
        std::vector<Record> drives;
        std::vector<WeightedDrives> sequence;
        for (int i = 0; i < 5; ++i) drives.push_back(random_drives(array));
        for (const Record& record : drives) sequence.push_back({random(0.1, 3.0), record});
        double total = 0.0;
        for (const WeightedDrives& entry : sequence) total += entry.weight;

        const Pose oblique = pose_of({0.01, -0.02, 0.12}, {random(-80, 80), random(-80, 80), 30.0});
        std::vector<Vec3> points;
        for (const Vec3& p : points_of({axis(-0.1, 7e-3, 30), axis(-0.1, 5e-3, 41), {0.0}}))
            points.push_back(oblique.outwards(p));
        points.push_back(array.elements[3].position + Vec3{1e-5, 2e-5, 0.0});  // in double precision
        const auto found = mean_square_pressure_at(array, sequence, points);
        REQUIRE(found.size() == points.size());
        double worst = 0.0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            double sum = 0.0, most = 0.0;
            for (const WeightedDrives& entry : sequence) {
                double can = 0.0;
                for (std::size_t m = 0; m < array.elements.size(); ++m)
                    can += std::abs(entry.drives[m] * propagation(array, array.elements[m], points[i]));
                most += entry.weight / total / 2.0 * can * can;
                sum += entry.weight / total / 2.0 * std::norm(pressure(array, entry.drives, points[i]));
            }
            worst = std::max(worst, std::abs(static_cast<double>(found[i]) - sum) / most);
        }
        REQUIRE(worst <= tight);
        REQUIRE(same_bytes(mean_square_pressure(array, sequence, grid),
                           mean_square_pressure_at(array, sequence, points_of(grid))));
        REQUIRE(mean_square_pressure_at(array, sequence, {}).empty());
        REQUIRE(mean_square_pressure_at(array, {}, points) == std::vector<float>(points.size(), 0.0F));
        points[17] = array.elements[2].position;
        REQUIRE_REFUSED(mean_square_pressure_at(array, sequence, points));
    }
}

TEST_CASE("kernel: the same bytes for any number of threads", "[kernel]") {
    CAPTURE(reseed());
    // A process may allow itself more threads than it has processors. Here it does, so that they really run.
    const tbb::global_control allowed(tbb::global_control::max_allowed_parallelism, 16);
    const Array array = grid_array(10, 10);
    Array listed = array;
    listed.columns = 0;
    const Record drives = random_drives(array), others = random_drives(array);
    const std::vector<WeightedDrives> sequence{{1.0, drives}, {2.0, others}, {0.5, drives}};
    const Grid grid{axis(-0.05, 1e-3, 100), axis(-0.05, 1e-3, 40), axis(0.05, 0.01, 7)};
    // Its lattice is larger than the grid itself: several of them need more memory than threads may take.
    const Grid fine{axis(-0.01003, 1e-4, 200), axis(-0.01003, 1e-4, 200), {0.1, 0.11}};
    const auto points = random_points(9001, 0.1, 0.0, 0.2);
    const Field at = pressure_at(array, drives, points), on = pressure_on(array, drives, grid);
    const Field direct = pressure_on(listed, drives, grid), shifted = pressure_on(array, drives, fine);
    const auto mean = mean_square_pressure(array, sequence, grid);
    const auto mean_at = mean_square_pressure_at(array, sequence, points);
    REQUIRE_FALSE(same_bytes(shifted, pressure_on(listed, drives, fine)));  // it does take the shifts
    for (const unsigned threads : {0U, 2U, 3U, 16U}) {
        const FieldOptions options{.threads = threads};
        REQUIRE(same_bytes(at, pressure_at(array, drives, points, options)));
        REQUIRE(same_bytes(on, pressure_on(array, drives, grid, options)));
        REQUIRE(same_bytes(direct, pressure_on(listed, drives, grid, options)));
        REQUIRE(same_bytes(shifted, pressure_on(array, drives, fine, options)));
        REQUIRE(same_bytes(mean, mean_square_pressure(array, sequence, grid, options)));
        REQUIRE(same_bytes(mean_at, mean_square_pressure_at(array, sequence, points, options)));
    }
}

TEST_CASE("kernel: calls at the same time do not limit each other's threads", "[kernel]") {
    CAPTURE(reseed());
    const tbb::global_control allowed(tbb::global_control::max_allowed_parallelism, 4);
    const auto limit = [] { return tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism); };
    const Array array = grid_array(10, 10);
    const Record drives = random_drives(array);
    const auto points = random_points(60'000, 0.1, 0.05, 0.2);
    const Field expected = pressure_at(array, drives, points);
    // Each call waits, in its first report, until the other one has begun. So they do run at the same time.
    std::atomic<int> begun = 0, wrong_limit = 0, wrong_bytes = 0;
    const auto call = [&](unsigned threads) {
        bool first = true;
        const Progress progress = [&](double, std::string_view) {
            if (first) {
                ++begun;
                while (begun < 2) std::this_thread::yield();
            }
            first = false;
            if (limit() != 4) ++wrong_limit;
            return true;
        };
        if (!same_bytes(expected, pressure_at(array, drives, points, {threads, progress}))) ++wrong_bytes;
    };
    std::thread other(call, 1U);
    call(3U);
    other.join();
    REQUIRE(begun == 2);
    REQUIRE(wrong_limit == 0);
    REQUIRE(wrong_bytes == 0);
}

namespace {

/// The four ways to ask for a field, each as a call with options whose result is a list of numbers.
struct EveryField {
    Array array = grid_array(10, 10), listed = array;
    Record drives = random_drives(array), others = random_drives(array);
    std::vector<WeightedDrives> sequence{{1.0, drives}, {2.0, others}};
    Grid grid{axis(-0.05, 1e-3, 100), axis(-0.05, 1e-3, 40), axis(0.05, 0.01, 12)};
    std::vector<Vec3> points = random_points(20'000, 0.1, 0.05, 0.2);
    std::vector<std::function<std::vector<float>(const FieldOptions&)>> calls{
        [&](const FieldOptions& o) { return numbers(pressure_at(array, drives, points, o)); },
        [&](const FieldOptions& o) { return numbers(pressure_on(array, drives, grid, o)); },  // by shifts
        [&](const FieldOptions& o) { return numbers(pressure_on(listed, drives, grid, o)); },
        [&](const FieldOptions& o) { return mean_square_pressure(array, sequence, grid, o); },
        [&](const FieldOptions& o) { return mean_square_pressure_at(array, sequence, points, o); },
    };

    EveryField() { listed.columns = 0; }
    EveryField(const EveryField&) = delete;

    static std::vector<float> numbers(const Field& field) {
        std::vector<float> found;
        for (const auto& p : field) found.insert(found.end(), {p.real(), p.imag()});
        return found;
    }
};

}  // namespace

TEST_CASE("kernel: progress comes from the calling thread, grows and ends at 1", "[kernel]") {
    CAPTURE(reseed());
    const tbb::global_control allowed(tbb::global_control::max_allowed_parallelism, 4);
    const EveryField every;
    const auto caller = std::this_thread::get_id();
    for (std::size_t i = 0; i < every.calls.size(); ++i)
        for (const unsigned threads : {1U, 3U}) {
            CAPTURE(i, threads);
            std::atomic<int> elsewhere = 0;
            std::vector<double> told;
            (void)every.calls[i]({threads, [&](double part, std::string_view) {
                                      if (std::this_thread::get_id() != caller) ++elsewhere;
                                      told.push_back(part);
                                      return true;
                                  }});
            REQUIRE(elsewhere == 0);
            REQUIRE(told.size() >= 2);
            REQUIRE(std::is_sorted(told.begin(), told.end()));
            REQUIRE(told.back() == 1.0);
        }
}

TEST_CASE("kernel: cancelling ends the work at once and leaves none behind", "[kernel]") {
    CAPTURE(reseed());
    const tbb::global_control allowed(tbb::global_control::max_allowed_parallelism, 4);
    const EveryField every;
    for (std::size_t i = 0; i < every.calls.size(); ++i)
        for (const unsigned threads : {1U, 3U})
            for (const int last : {1, 2}) {
                CAPTURE(i, threads, last);
                std::atomic<int> told = 0;
                double fraction = 0.0;
                const FieldOptions stops{threads, [&](double part, std::string_view) {
                                             fraction = part;
                                             return ++told < last;
                                         }};
                try {
                    (void)every.calls[i](stops);
                    FAIL("not cancelled");
                } catch (const Error& error) {
                    REQUIRE(error.code() == ErrorCode::cancelled);
                }
                REQUIRE(told == last);
                if (threads == 1) REQUIRE(fraction < 0.5);  // others may have finished theirs meanwhile
                std::this_thread::sleep_for(std::chrono::milliseconds(5));
                REQUIRE(told == last);
                REQUIRE(same_bytes(every.calls[i]({}), every.calls[i]({threads, {}})));
            }
}

TEST_CASE("kernel: moving everything changes nothing", "[kernel]") {
    CAPTURE(reseed());
    const Array array = random_array(20);
    const Record drives = random_drives(array);
    auto points = random_points(1500, 0.1, 0.05, 0.2);
    const Field before = pressure_at(array, drives, points);
    float peak = 0.0F;
    for (const auto& p : before) peak = std::max(peak, std::abs(p));
    const auto unchanged = [&](const Array& changed, float factor) {
        const Field after = pressure_at(changed, drives, points);
        for (std::size_t i = 0; i < after.size(); ++i) REQUIRE(std::abs(after[i] * factor - before[i]) <= 1e-4F * peak);
    };
    SECTION("translated") {
        Array moved = array;
        const Vec3 move{0.37, -1.2, 0.05};
        for (Element& e : moved.elements) e.position = e.position + move;
        for (Vec3& p : points) p = p + move;
        unchanged(moved, 1.0F);
    }
    SECTION("rotated by 90° about z") {
        Array turned = array;
        for (Element& e : turned.elements) e.position = {-e.position.y, e.position.x, e.position.z};
        for (Vec3& p : points) p = {-p.y, p.x, p.z};
        unchanged(turned, 1.0F);
    }
    SECTION("mirrored") {
        Array mirrored = array;
        for (Element& e : mirrored.elements) e.position.x = -e.position.x;
        for (Vec3& p : points) p.x = -p.x;
        unchanged(mirrored, 1.0F);
    }
    SECTION("twice as large at half the frequency is half as loud") {
        Array large = array;
        large.carrier_hz /= 2.0;
        large.transducer.radius_m *= 2.0;
        for (Element& e : large.elements) e.position = e.position * 2.0;
        for (Vec3& p : points) p = p * 2.0;
        unchanged(large, 2.0F);
    }
}

TEST_CASE("kernel: a grid turned by 90° with its array, through the shifts", "[kernel]") {
    CAPTURE(reseed());
    const Array array = grid_array(6, 4);
    const Record drives = random_drives(array);
    const Grid grid{axis(-0.031, 1e-3, 50), axis(-0.02, 1e-3, 34), {0.08}};
    Array turned = grid_array(4, 6);  // (x, y) → (−y, x): its row is the old column, its column the old row from behind
    Record turned_drives(24);
    for (std::size_t m = 0; m < 24; ++m) turned_drives[(m % 6) * 4 + (3 - m / 6)] = drives[m];
    Grid turned_grid{{}, grid.x, grid.z};
    for (auto y = grid.y.rbegin(); y != grid.y.rend(); ++y) turned_grid.x.push_back(-*y);
    const Field before = pressure_on(array, drives, grid), after = pressure_on(turned, turned_drives, turned_grid);
    float peak = 0.0F;
    for (const auto& p : before) peak = std::max(peak, std::abs(p));
    for (std::size_t row = 0; row < 34; ++row)
        for (std::size_t column = 0; column < 50; ++column)
            REQUIRE(std::abs(before[row * 50 + column] - after[column * 34 + 33 - row]) <= 1e-5F * peak);
}

TEST_CASE("kernel: patterns are fitted to 2e-6", "[kernel]") {
    for (const double ka : {1e-5, 0.1, 1.0, 3.295, 5.9, 12.0, 18.0, 19.0, 60.0}) {
        Transducer transducer;
        transducer.radius_m = ka;  // k = 1 rad/m
        const FittedPattern fit = fit_pattern(transducer, 1.0);
        CAPTURE(ka, fit.values.size());
        const std::vector<double> values(fit.values.begin(), fit.values.end());
        for (int i = 0; i <= 1000; ++i) {
            const double angle = i * std::numbers::pi / 2000.0;
            double found = 0.0;
            if (fit.kind == FittedPattern::Kind::polynomial) {
                for (std::size_t n = values.size(); n-- > 0;) found = found * std::cos(2.0 * angle) + values[n];
            } else {
                const double place = i / 1000.0 * static_cast<double>(values.size() - 1);
                const auto low = std::min(static_cast<std::size_t>(place), values.size() - 2);
                found = std::lerp(values[low], values[low + 1], place - static_cast<double>(low));
            }
            REQUIRE(std::abs(found - piston_directivity(ka * std::sin(angle))) <= 2e-6);
        }
    }
}
