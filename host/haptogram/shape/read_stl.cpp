// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include <array>
#include <cstdint>

#include "haptogram/base/text.hpp"
#include "haptogram/shape/formats.hpp"

namespace haptogram {
namespace {

constexpr std::size_t binary_header = 84;
constexpr std::size_t binary_triangle = 50;

/// Makes a triangle of the three vertices that were added last.
void end_triangle(Polygons& polygons) {
    const auto end = static_cast<std::uint32_t>(polygons.vertices.size());
    polygons.add_triangle(end - 3, end - 2, end - 1);
}

Polygons read_binary(std::string_view content, const std::string& name) {
    if (content.size() < binary_header)
        throw bad_input(
            name,
            fmt::format("found {} bytes, expected \"solid\" or the {} bytes of a binary STL header; the file is cut "
                        "short or is no STL file",
                        content.size(), binary_header));
    const std::size_t triangles = load_number<std::uint32_t>(&content[binary_header - 4], std::endian::little);
    const std::size_t size = binary_header + binary_triangle * triangles;
    if (content.size() != size)
        throw bad_input(
            name,
            fmt::format("found {} bytes, which end in triangle {}, expected {} bytes for the {} triangles that the "
                        "header promises; the file is cut short or is no STL file",
                        content.size(), (content.size() - binary_header) / binary_triangle + 1, size, triangles));
    Polygons polygons;
    polygons.vertices.reserve(3 * triangles);
    for (std::size_t triangle = 0; triangle < triangles; ++triangle) {
        std::array<double, 9> numbers{};  // three corners, behind the three numbers of the normal
        for (std::size_t i = 0; i < numbers.size(); ++i) {
            const char* const bytes = &content[binary_header + binary_triangle * triangle + 4 * (i + 3)];
            numbers.at(i) = static_cast<double>(load_number<float>(bytes, std::endian::little));
            if (!is_coordinate(numbers.at(i)))
                throw bad_coordinate(fmt::format("{}, triangle {} of {}", name, triangle + 1, triangles),
                                     fmt::format("{}", numbers.at(i)));
        }
        for (std::size_t i = 0; i < numbers.size(); i += 3)
            polygons.vertices.push_back({numbers.at(i), numbers.at(i + 1), numbers.at(i + 2)});
        end_triangle(polygons);
    }
    return polygons;
}

/// A text STL is one fixed row of lines, repeated for each triangle. Nobody needs the normals, so they are not read.
Polygons read_text(std::string_view content, const std::string& name) {
    constexpr std::array<std::string_view, 7> row{"facet",  "outer",   "vertex",  "vertex",
                                                  "vertex", "endloop", "endfacet"};
    Polygons polygons;
    bool in_solid = false;
    std::size_t step = 0;
    Lines lines(content);
    while (lines.next()) {
        std::string_view rest = lines.line();
        const std::string_view word = take_word(rest);
        if (word.empty()) continue;
        if (in_solid && step == 0 && word == "endsolid") {
            in_solid = false;
            continue;
        }
        const auto require = [&](std::string_view found, std::string_view wanted) {
            if (found != wanted)
                throw bad_input(
                    at_line(name, lines.number()),
                    fmt::format("found {}, expected \"{}\"; export the shape again", shown(lines.line()), wanted));
        };
        require(word, in_solid ? row.at(step) : "solid");
        if (!in_solid) {
            in_solid = true;
            continue;
        }
        if (word == "facet") require(take_word(rest), "normal");
        if (word == "outer") require(take_word(rest), "loop");
        if (word == "vertex") {
            std::array<double, 3> vertex{};
            for (double& coordinate : vertex) {
                const std::string_view number = take_word(rest);
                const auto value = parse_number(number);
                if (!value || !is_coordinate(*value)) throw bad_coordinate(at_line(name, lines.number()), number);
                coordinate = *value;
            }
            polygons.vertices.push_back({vertex[0], vertex[1], vertex[2]});
        }
        step = (step + 1) % row.size();
        if (step == 0) end_triangle(polygons);
    }
    if (in_solid)
        throw bad_input(at_line(name, lines.number()),
                        fmt::format("found the end of the file, expected \"{}\"; the file is cut short",
                                    step == 0 ? "endsolid" : row.at(step)));
    return polygons;
}

}  // namespace

Polygons read_stl(std::string_view content, const std::string& name) {
    // Some programs begin binary files with "solid", too, but only binary files hold zero bytes.
    std::string_view rest = content;
    const bool text = lower_case(take_word(rest)) == "solid" && content.find('\0') == std::string_view::npos;
    return text ? read_text(lower_case(content), name) : read_binary(content, name);
}

}  // namespace haptogram
