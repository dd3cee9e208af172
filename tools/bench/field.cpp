// SPDX-License-Identifier: Apache-2.0
// The field kernels' times for tools/bench.py; prints one JSON object of milliseconds, each the least of several runs,
// as other programs only add to them.
#include "haptogram/acoustics/field.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/acoustics/wave.hpp"
#include "haptogram/array/rig.hpp"

namespace {

using namespace haptogram;

template <class Call>
double least_ms(int repeats, Call call) {
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i <= repeats; ++i) {
        const auto begun = std::chrono::steady_clock::now();
        call();
        const std::chrono::duration<double, std::milli> taken = std::chrono::steady_clock::now() - begun;
        least = std::min(least, taken.count());
    }
    return least;
}

std::vector<double> axis(double from, double step, std::size_t count) {
    std::vector<double> found(count);
    for (std::size_t i = 0; i < count; ++i) found[i] = from + step * static_cast<double>(i);
    return found;
}

Array square_array(std::uint32_t side) {
    Array array = find_array("tile-10x10");
    array.elements.clear();
    array.columns = side;
    const double centre = (side - 1) / 2.0;
    for (std::uint32_t row = 0; row < side; ++row)
        for (std::uint32_t column = 0; column < side; ++column)
            array.elements.push_back({(column - centre) * 0.01, (row - centre) * 0.01, 0.0});
    return array;
}

/// Largest |difference| over largest |value|.
double apart(const std::vector<std::complex<float>>& a, const std::vector<std::complex<float>>& b) {
    float most = 0.0F, peak = 0.0F;
    for (std::size_t i = 0; i < a.size(); ++i) {
        most = std::max(most, std::abs(a[i] - b[i]));
        peak = std::max(peak, std::abs(a[i]));
    }
    return most / peak;
}

/// The most memory that this program has had so far; getrusage() would count its parent's, too.
double most_bytes() {
    std::ifstream status("/proc/self/status");
    std::string key;
    double kib = 0.0;
    while (status >> key && key != "VmHWM:") status.ignore(1000, '\n');
    status >> kib;
    return 1024.0 * kib;
}

nlohmann::ordered_json measure() {
    nlohmann::ordered_json json;
    json["target"] = wave_target();
    const Array array = square_array(10);
    const auto drives = ideal_drives(array, {0.0, 0.0, 0.13});
    {
        const Array large = square_array(32);
        const auto large_drives = ideal_drives(large, {0.0, 0.0, 0.2});
        const Grid grid{axis(-0.0995, 1e-3, 200), axis(-0.0995, 1e-3, 200), axis(0.1, 1e-3, 200)};
        const double before = most_bytes();
        json["large_shifted_2_threads_ms"] =
            least_ms(1, [&] { (void)pressure_on(large, large_drives, grid, {.threads = 2}); });
        json["large_memory_over_output"] =
            (most_bytes() - before) / static_cast<double>(grid.size() * sizeof(std::complex<float>));
    }
    const FieldOptions sums{.interpolation_error = 0.0};
    const auto points_of = [](const Grid& grid) {
        std::vector<Vec3> points;
        for (std::size_t i = 0; i < grid.size(); ++i) points.push_back(grid.point(i));
        return points;
    };
    // A field by the quickest method, its distance from the sums at the same points, and what it states itself.
    const auto put = [&](const std::string& name, int repeats, const Array& of, const Grid& grid,
                         const FieldOptions& options = {}) {
        const auto played = ideal_drives(of, {0.0, 0.0, of.elements[0].normal.z == 1.0 ? 0.13 : 0.0});
        const PressureField field = pressure_field(of, played, grid, options);
        json[name + "_ms"] = least_ms(repeats, [&] { (void)pressure_field(of, played, grid, options); });
        json[name + "_apart"] = apart(pressure_at(of, played, points_of(grid)), field.values);
        json[name + "_error"] = field.error + field.pattern_error;
    };
    const double odd_step = 0.2 / 199;  // does not divide the pitch
    const Grid plane{axis(-0.1, odd_step, 200), axis(-0.1, odd_step, 200), {0.13}};
    const Grid near{plane.x, plane.y, {3.0 * array.wavelength_m()}};
    const Grid own{axis(-0.1, odd_step, 200), axis(-0.1, odd_step, 200), {0.0}};  // of an oblique plane
    const Pose oblique = pose_of({0.0, 0.0, 0.13}, {20.0, 30.0, 10.0});
    const auto points = points_of(plane);
    json["points_ms"] = least_ms(31, [&] { (void)pressure_at(array, drives, points); });
    put("plane", 51, array, plane);
    put("near_plane", 51, array, near);
    put("oblique_plane", 31, seen_from(array, oblique), own);
    Array measured = find_array("hoshi-18x18");
    measured.transducer = find_transducer("T4010A1");
    put("measured", 31, measured, plane);
    put("measured_oblique", 15, seen_from(measured, oblique), own);
    put("fitted_oblique", 15, seen_from(measured, oblique), own, {.pattern_error = 0.015});

    const Grid volume{axis(-0.05, 1e-3, 100), axis(-0.05, 1e-3, 100), axis(0.05, 1e-3, 100)};
    Array listed = array;
    listed.columns = 0;  // a list of elements, which hides the structure
    json["volume_points_ms"] = least_ms(5, [&] { (void)pressure_on(listed, drives, volume, sums); });
    put("volume_listed", 7, listed, volume);
    put("volume", 9, array, volume);

    std::vector<std::vector<std::complex<double>>> records;
    records.reserve(200);
    for (int i = 0; i < 200; ++i)
        records.push_back(
            ideal_drives(array, {0.035 * std::cos(i * 0.0314159), 0.035 * std::sin(i * 0.0314159), 0.13}));
    std::vector<WeightedDrives> sequence;
    sequence.reserve(records.size());
    for (const auto& record : records) sequence.push_back({1.0, record});
    const Grid average{axis(-0.05, 1e-3, 100), axis(-0.05, 1e-3, 100), {0.13}};
    json["mean_square_ms"] = least_ms(9, [&] { (void)mean_square_pressure(array, sequence, average); });
    return json;
}

}  // namespace

int main() try {
    fmt::print("{}\n", measure().dump());
    return 0;
} catch (const std::exception& error) {
    fmt::print(stderr, "measure: {}\n", error.what());
    return 1;
}
