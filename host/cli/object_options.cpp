// SPDX-License-Identifier: Apache-2.0
#include "object_options.hpp"

#include <fmt/format.h>

#include "command.hpp"
#include "haptogram/verbs/source.hpp"

namespace haptogram::cli {

void add_mm(CLI::App& command, const std::string& name, double& metres, const std::string& about) {
    command
        .add_option_function<double>(
            name, [&metres](double mm) { metres = mm * millimetre; }, about)
        ->check(positive())
        ->default_str(fmt::format("{:g}", metres / millimetre));
}

std::string object_words() {
    return fmt::format("{}, or a mesh file (PLY, OBJ, STL) of a closed surface", fmt::join(object_kinds(), ", "));
}

void add_object_options(CLI::App& sub, ObjectArguments& object) {
    sub.add_option("--size", object.size_mm,
                   "Edge or diameter of the object, largest extent of a mesh, mm (default: 100, a mesh as it is)")
        ->check(positive());
    sub.add_option("--height", object.height_mm, "Height of a cone, pyramid or cylinder, mm (default: the size)")
        ->check(positive());
    sub.add_option("--center", object.center, "Center of the object: x,y,z mm")->capture_default_str();
    sub.add_option("--rotate", object.rotate, "Turns of the object: degrees about x, then y, then z")
        ->capture_default_str();
    sub.add_option("--unit", object.unit, "Unit of a mesh file's coordinates")
        ->check(CLI::IsMember({"mm", "cm", "m"}))
        ->capture_default_str();
}

ObjectSource object_of(const ObjectArguments& object, const std::vector<std::string>& given) {
    ObjectSource source;
    source.name = object.name;
    if (object.size_mm) source.size_m = *object.size_mm * millimetre;
    if (object.height_mm) source.height_m = *object.height_mm * millimetre;
    source.centre = parse_point_mm("center", object.center);
    source.angles_deg = parse_three("rotate", object.rotate, "degrees");
    source.unit = object.unit;
    require_effect(given, {{"--height", {"cone", "pyramid", "cylinder"}}, {"--unit", {"a mesh file"}}},
                   names_mesh(source) ? "a mesh file" : source.name, "the object");
    return source;
}

}  // namespace haptogram::cli
