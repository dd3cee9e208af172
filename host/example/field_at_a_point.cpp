// SPDX-License-Identifier: Apache-2.0
// From a shape to the pressure that a hand would feel, with the library alone: a circle becomes focal points, each
// focal point one emission time per transducer, these an image and its manifest, and the image's drives a pressure in
// the air.
//
//     haptogram_field_example [ARRAY]        ARRAY: a file or a shipped array; default tile-10x10
#include <complex>
#include <cstdio>
#include <vector>

#include "haptogram/acoustics/field.hpp"
#include "haptogram/analysis/measure.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/image/image.hpp"
#include "haptogram/image/manifest.hpp"
#include "haptogram/model/array.hpp"
#include "haptogram/shape/place.hpp"
#include "haptogram/shape/primitives.hpp"
#include "haptogram/shape/sample.hpp"
#include "haptogram/solve/focal_law.hpp"
#include "haptogram/solve/timer.hpp"

int main(int argc, char** argv) try {
    using namespace haptogram;
    const Array array = find_array(argc > 1 ? argv[1] : "tile-10x10");

    // The shape, 12 cm above the array, and the order in which its points are played.
    Placement placement;
    placement.center = Vec3{0.0, 0.0, 0.12};
    const Shape circle = place(make_primitive({.kind = "circle", .diameter = 0.04}), placement);
    const std::vector<Vec3> foci = sample(circle, 40, 1).points;

    // The drives: for each focal point, when each element emits.
    const Timer timer = choose_timer(array);
    const std::vector<std::uint16_t> ticks = focal_law(array, timer, foci);

    // The image that a board plays, and the manifest that says what it means.
    const std::size_t channels = array.elements.size();
    Image image;
    image.channels = static_cast<std::uint32_t>(channels);
    for (std::size_t i = 0; i < foci.size(); ++i) {
        Record record;
        record.cycle_length = timer.cycle_ticks;
        record.prescaler = timer.prescaler;
        record.pulse_length = static_cast<std::uint8_t>(timer.pulse_ticks);
        const auto first = ticks.begin() + static_cast<std::ptrdiff_t>(i * channels);
        record.timings.assign(first, first + static_cast<std::ptrdiff_t>(channels));
        image.records.push_back(record);
        image.sequence.push_back({.index = static_cast<std::uint16_t>(i + 1), .dwell = 100});
    }
    Manifest manifest;
    manifest.array = array;
    manifest.timer = timer;
    manifest.foci = foci;

    // The field of the first record, at its focal point and a centimetre beside it.
    const std::vector<std::complex<double>> drives = drives_of(manifest, image.records.front());
    const std::vector<Vec3> points = {foci.front(), foci.front() + Vec3{0.01, 0.0, 0.0}};
    const std::vector<std::complex<float>> pressure = pressure_at(array, drives, points);
    std::printf("%zu records of %zu channels\n", image.records.size(), channels);
    std::printf("at the focal point   %.0f Pa\n", static_cast<double>(std::abs(pressure[0])));
    std::printf("10 mm beside it      %.0f Pa\n", static_cast<double>(std::abs(pressure[1])));
    return 0;
} catch (const haptogram::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
