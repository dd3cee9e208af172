// SPDX-License-Identifier: Apache-2.0
// The field kernels' times for tools/bench.py; prints one JSON object of median milliseconds.
#include "haptogram/acoustics/field.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/acoustics/wave.hpp"

namespace {

using namespace haptogram;

/// Median time of one call in milliseconds, after one that is not counted.
template <class Call>
double median_ms(int repeats, Call call) {
    std::vector<double> times;
    for (int i = 0; i <= repeats; ++i) {
        const auto begun = std::chrono::steady_clock::now();
        call();
        times.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begun).count());
    }
    times.erase(times.begin());
    std::nth_element(times.begin(), times.begin() + repeats / 2, times.end());
    return times[static_cast<std::size_t>(repeats / 2)];
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
            median_ms(1, [&] { (void)pressure_on(large, large_drives, grid, {.threads = 2}); });
        json["large_memory_over_output"] =
            (most_bytes() - before) / static_cast<double>(grid.size() * sizeof(std::complex<float>));
    }
    const Grid plane{axis(-0.1, 1e-3, 200), axis(-0.1, 1e-3, 200), {0.13}};
    std::vector<Vec3> points;
    for (std::size_t i = 0; i < plane.size(); ++i) points.push_back(plane.point(i));
    json["plane_ms"] = median_ms(51, [&] { (void)pressure_at(array, drives, points); });
    json["plane_shifted_ms"] = median_ms(15, [&] { (void)pressure_on(array, drives, plane); });

    const Grid volume{axis(-0.05, 1e-3, 100), axis(-0.05, 1e-3, 100), axis(0.05, 1e-3, 100)};
    Array listed = array;
    listed.columns = 0;  // a list of elements, which hides the structure
    json["volume_ms"] = median_ms(7, [&] { (void)pressure_on(listed, drives, volume); });
    json["volume_shifted_ms"] = median_ms(9, [&] { (void)pressure_on(array, drives, volume); });
    json["volume_shifted_apart"] = apart(pressure_on(listed, drives, volume), pressure_on(array, drives, volume));

    std::vector<std::vector<std::complex<double>>> records;
    records.reserve(200);
    for (int i = 0; i < 200; ++i)
        records.push_back(
            ideal_drives(array, {0.035 * std::cos(i * 0.0314159), 0.035 * std::sin(i * 0.0314159), 0.13}));
    std::vector<WeightedDrives> sequence;
    sequence.reserve(records.size());
    for (const auto& record : records) sequence.push_back({1.0, record});
    const Grid average{axis(-0.05, 1e-3, 100), axis(-0.05, 1e-3, 100), {0.13}};
    json["mean_square_ms"] = median_ms(9, [&] { (void)mean_square_pressure(array, sequence, average); });
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
