// SPDX-License-Identifier: Apache-2.0
// A shape, the path of a focus over it, the image that plays the path, and the pressure that the image makes at a
// point.
#include <cstdio>
#include <haptogram/acoustics/field.hpp>
#include <haptogram/base/error.hpp>
#include <haptogram/base/file.hpp>
#include <haptogram/verbs/compile.hpp>
#include <haptogram/verbs/timeline.hpp>

int main() {
    try {
        haptogram::Project project;
        haptogram::ShapeSource circle;
        circle.primitive.kind = "circle";
        circle.primitive.diameter = 0.06;  // metres
        project.shapes = {circle};
        project.points = 40;
        project.rate_hz = 100.0;

        const haptogram::Compiled compiled = haptogram::compile(project, "circle.hex");
        haptogram::write_files(
            {{"circle.hex", compiled.bundle.hex}, {"circle.json", haptogram::to_text(compiled.bundle.manifest)}});

        // The pulses of the image's first record: the pressure where they should meet, and a centimetre beside it.
        const haptogram::Excitation first = haptogram::excitation_of(haptogram::timeline_of(compiled.bundle), 1);
        const haptogram::Vec3 points[] = {first.foci.front(), first.foci.front() + haptogram::Vec3{0.01, 0.0, 0.0}};
        const auto pressure = haptogram::pressure_at(first.array, first.drives.front(), points);
        std::printf("%zu records of %u channels\n", compiled.bundle.image.records.size(),
                    compiled.bundle.image.channels);
        std::printf("at the focal point   %.0f Pa\n", static_cast<double>(std::abs(pressure[0])));
        std::printf("10 mm beside it      %.0f Pa\n", static_cast<double>(std::abs(pressure[1])));
        return 0;
    } catch (const haptogram::Error& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
}
