// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <iterator>
#include <memory>

#include "acoustics/plane.hpp"
#include "base/error.hpp"
#include "base/file.hpp"
#include "command.hpp"

namespace haptogram::cli {
namespace {

struct FieldOptions {
    std::string pulses;
    std::string manifest;
    std::string plane = "xy@z=130";
    double extent_mm = 80.0;
    double step_mm = 1.0;
    std::string output = "-";
};

int field(const FieldOptions& options) {
    const Plane plane = parse_plane(options.plane, options.extent_mm * millimetre, options.step_mm * millimetre);
    require_distinct({{"--pulses", options.pulses}, {"--manifest", options.manifest}}, {{"--output", options.output}});
    const Manifest manifest = manifest_from_json(read_file(options.manifest), options.manifest);
    const std::vector<Pulse> pulses = pulses_from_csv(read_file(options.pulses), options.pulses);
    if (pulses.empty()) throw bad_input(options.pulses, "no pulses in it; expected what simulate --pulses wrote");
    const auto records = measure(manifest, pulses, options.pulses);
    const std::vector<double> mean = mean_radiation_pressure(manifest, records, plane);
    fmt::memory_buffer text;
    fmt::format_to(std::back_inserter(text), "{}_mm,{}_mm,radiation_pressure_pa\n", plane.u_axis, plane.v_axis);
    for (std::size_t row = 0; row < plane.v.size(); ++row)
        for (std::size_t column = 0; column < plane.u.size(); ++column)
            fmt::format_to(std::back_inserter(text), "{:.4f},{:.4f},{:.6g}\n", plane.u[column] / millimetre,
                           plane.v[row] / millimetre, mean[row * plane.u.size() + column]);
    write_file(options.output, fmt::to_string(text));
    return 0;
}

}  // namespace

void add_field(CLI::App& app, Action& action) {
    auto options = std::make_shared<FieldOptions>();
    CLI::App* sub =
        app.add_subcommand("field", "Time-averaged radiation pressure that measured pulses make in a plane, as CSV");
    sub->add_option("--pulses", options->pulses, "Pulse file from simulate")->required();
    sub->add_option("--manifest", options->manifest, "Manifest of the image that was played")->required();
    sub->add_option("--plane", options->plane, "xy@z=MM, xz@y=MM or yz@x=MM")->capture_default_str();
    sub->add_option("--extent", options->extent_mm,
                    "Half-width of the square, mm; along z twice this from the array on")
        ->check(positive())
        ->capture_default_str();
    sub->add_option("--step", options->step_mm, "Between points, mm")->check(positive())->capture_default_str();
    sub->add_option("-o,--output", options->output, "CSV file; - is standard output")->capture_default_str();
    sub->callback([options, &action] { action = [options] { return field(*options); }; });
}

}  // namespace haptogram::cli
