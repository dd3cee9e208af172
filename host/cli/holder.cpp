// SPDX-License-Identifier: Apache-2.0
// `board holder`: the plate that an array's transducers stand in, for a laser cutter or a drill.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <tuple>

#include "command.hpp"
#include "haptogram/array/array.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"

namespace haptogram::cli {
namespace {

struct HolderOptions {
    std::string array;
    std::string output = "-";
    double body_mm = 10.0, legs_mm = 5.08, hole_mm = 1.2, margin_mm = 12.0, screw_mm = 3.2;
};

void require(double value, double least, double most, const char* setting) {
    if (!(value >= least && value <= most))
        throw bad_argument(setting, fmt::format("expected {:g} to {:g} mm, found {:g}", least, most, value));
}

/// Holes of legs stand apart, and bodies do not overlap.
void require_room(const Array& array, const HolderOptions& options) {
    for (std::size_t m = 0; m < array.elements.size(); ++m) {
        const Element& one = array.elements[m];
        if (std::abs(one.position.z) > 1e-6 || one.normal.z < 1.0 - 1e-9)
            throw Error(ErrorCode::bad_input, array.name,
                        fmt::format("element {} stands {:g} mm above the plate's plane or is tilted; a plate is for "
                                    "arrays that are flat; make one for each face",
                                    m, 1e3 * one.position.z));
        for (std::size_t k = 0; k < m; ++k)
            if (const double apart_mm = 1e3 * distance(one, array.elements[k].position);
                apart_mm < options.body_mm - 1e-6)
                throw bad_argument("body", fmt::format("elements {} and {} are {:.2f} mm apart, so bodies of {:g} "
                                                       "mm overlap; give the diameter of yours",
                                                       k, m, apart_mm, options.body_mm));
    }
}

std::string circle(Vec3 at_mm, double diameter_mm, const char* kind) {
    return fmt::format("<circle class=\"{}\" cx=\"{:.3f}\" cy=\"{:.3f}\" r=\"{:.3f}\"/>\n", kind, at_mm.x, at_mm.y,
                       diameter_mm / 2);
}

/// In millimetres, seen from the hand's side: x to the right, y up, which an SVG counts down. What is cut is red, what
/// is engraved is black. The leg that belongs to the driver's output is the left one, with the engraved mark.
std::string drawing(const Array& array, const HolderOptions& options) {
    double half_x = 0.0, half_y = 0.0;
    for (const Element& element : array.elements) {
        half_x = std::max(half_x, 1e3 * std::abs(element.position.x));
        half_y = std::max(half_y, 1e3 * std::abs(element.position.y));
    }
    const double beside = options.body_mm / 2 + options.margin_mm;
    half_x += beside;
    half_y += beside;
    std::string svg = fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.3f}mm\" height=\"{1:.3f}mm\" viewBox=\"{2:.3f} {3:.3f} "
        "{0:.3f} {1:.3f}\">\n"
        "<title>Holder of {4} transducers, from the side of the hand, in mm</title>\n"
        "<style>.cut{{fill:none;stroke:#f00;stroke-width:.1}}.mark{{fill:none;stroke:#000;stroke-width:.1}}"
        "text{{font:{5:.2f}px sans-serif;text-anchor:middle}}</style>\n"
        "<rect class=\"cut\" x=\"{2:.3f}\" y=\"{3:.3f}\" width=\"{0:.3f}\" height=\"{1:.3f}\" rx=\"3\"/>\n",
        2 * half_x, 2 * half_y, -half_x, -half_y, array.elements.size(), 0.22 * options.body_mm);
    const double corner = options.margin_mm / 2;
    for (const double x : {-half_x + corner, half_x - corner})
        for (const double y : {-half_y + corner, half_y - corner}) svg += circle({x, y, 0}, options.screw_mm, "cut");
    for (std::size_t m = 0; m < array.elements.size(); ++m) {
        const Vec3 at{1e3 * array.elements[m].position.x, -1e3 * array.elements[m].position.y, 0};
        svg += circle(at, options.body_mm, "mark");
        for (const double side : {-0.5, 0.5})
            svg += circle({at.x + side * options.legs_mm, at.y, 0}, options.hole_mm, "cut");
        const double dot = options.hole_mm;
        svg += fmt::format("<path class=\"mark\" d=\"M{0:.3f} {1:.3f}h{2:.3f}m{3:.3f} {3:.3f}v{2:.3f}\"/>\n",
                           at.x - options.legs_mm / 2 - dot / 2, at.y - 1.5 * dot, dot, -dot / 2);
        svg += fmt::format("<text x=\"{:.3f}\" y=\"{:.3f}\">{}</text>\n", at.x, at.y + 0.38 * options.body_mm, m);
    }
    return svg + "</svg>\n";
}

int write_holder(const HolderOptions& options) {
    require(options.body_mm, 1.0, 100.0, "body");
    require(options.hole_mm, 0.1, 10.0, "hole");
    require(options.legs_mm, options.hole_mm, options.body_mm - options.hole_mm, "legs");
    require(options.screw_mm, 0.5, 20.0, "screw");
    require(options.margin_mm, 2 * options.screw_mm, 200.0, "margin");
    require_distinct({{"the array", options.array}}, {{"--output", options.output}});
    const Array array = find_array(options.array);
    require_room(array, options);
    write_file(options.output, drawing(array, options));
    return 0;
}

}  // namespace

void add_holder(CLI::App& board, Action& action) {
    auto options = std::make_shared<HolderOptions>();
    CLI::App* sub =
        board.add_subcommand("holder", "Draw the plate that an array's transducers stand in, as SVG in millimetres");
    sub->add_option("array", options->array, "Array file (TOML) or shipped array")->required();
    const std::tuple<const char*, double*, const char*> lengths[] = {
        {"--body", &options->body_mm, "Diameter of a transducer, which is engraved, mm"},
        {"--legs", &options->legs_mm, "Between the middles of its two legs, mm"},
        {"--hole", &options->hole_mm, "Diameter of a leg's hole, mm"},
        {"--margin", &options->margin_mm, "Between the outermost transducers and the plate's edge, mm"},
        {"--screw", &options->screw_mm, "Diameter of the screw holes in the corners, mm"},
    };
    for (const auto& [name, value, help] : lengths) sub->add_option(name, *value, help)->capture_default_str();
    sub->add_option("-o,--output", options->output, "SVG file; - is standard output")->capture_default_str();
    sub->callback([options, &action] { action = [options] { return write_holder(*options); }; });
}

}  // namespace haptogram::cli
