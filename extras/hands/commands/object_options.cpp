// SPDX-License-Identifier: Apache-2.0
#include "object_options.hpp"

#include <fmt/format.h>

#include "command.hpp"
#include "haptogram/base/error.hpp"

namespace haptogram::cli {

void add_mm(CLI::App& command, const std::string& name, double& metres, const std::string& about) {
    command
        .add_option_function<double>(
            name, [&metres](double mm) { metres = mm * millimetre; }, about)
        ->check(positive())
        ->default_str(fmt::format("{:g}", metres / millimetre));
}

std::string object_words() {
    return fmt::format("{}, or a mesh file (PLY, OBJ, STL, OFF, 3MF, glTF) of a closed surface",
                       fmt::join(object_kinds(), ", "));
}

ObjectSource object_of(const ObjectArguments& object) {
    ObjectSource source;
    source.name = object.name;
    source.readers = path_makers().readers;
    object.given.require_effect(source, "the object is " + (names_mesh(source) ? "a mesh file" : source.name));
    object.given.put(source);
    return source;
}

}  // namespace haptogram::cli
