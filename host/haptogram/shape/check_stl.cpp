// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include <array>
#include <utility>

#include "haptogram/shape/formats.hpp"
#include "haptogram/shape/text.hpp"

namespace haptogram {
namespace {

constexpr std::size_t binary_header = 84;
constexpr std::size_t binary_triangle = 50;

Checked check_binary(std::string content, const std::string& file) {
    if (content.size() < binary_header)
        throw bad_input(
            file,
            fmt::format("found {} bytes, expected \"solid\" or the {} bytes of a binary STL header; the file is cut "
                        "short or is no STL file",
                        content.size(), binary_header));
    const std::size_t triangles = load_number<std::uint32_t>(&content[binary_header - 4], std::endian::little);
    const std::size_t size = binary_header + binary_triangle * triangles;
    if (content.size() != size)
        throw bad_input(
            file,
            fmt::format("found {} bytes, which end in triangle {}, expected {} bytes for the {} triangles that the "
                        "header promises; the file is cut short or is no STL file",
                        content.size(), (content.size() - binary_header) / binary_triangle + 1, size, triangles));
    for (std::size_t triangle = 0; triangle < triangles; ++triangle) {
        for (std::size_t number = 3; number < 12; ++number) {  // the first three are the normal
            const auto value = load_number<float>(&content[binary_header + binary_triangle * triangle + 4 * number],
                                                  std::endian::little);
            if (!is_coordinate(static_cast<double>(value)))
                throw bad_coordinate(fmt::format("{}, triangle {} of {}", file, triangle + 1, triangles),
                                     fmt::format("{}", value));
        }
    }
    return {std::move(content), 3 * triangles, triangles};
}

/// A text STL is one fixed row of lines over and over. They are spelled anew, without the normals, of which nobody
/// makes use.
Checked check_text(const std::string& content, const std::string& file) {
    constexpr std::array<std::string_view, 7> row{"facet",  "outer",   "vertex",  "vertex",
                                                  "vertex", "endloop", "endfacet"};
    Checked checked;
    std::string& spelled = checked.content;
    bool in_solid = false;
    std::size_t step = 0;
    Lines lines(content);
    while (lines.next()) {
        std::string_view rest = lines.line();
        const std::string_view word = take_word(rest);
        if (word.empty()) continue;
        const std::string_view expected = in_solid ? row.at(step) : "solid";
        if (in_solid && step == 0 && word == "endsolid") {
            in_solid = false;
            spelled += "endsolid\n";
            continue;
        }
        const auto require = [&](std::string_view found, std::string_view wanted) {
            if (found != wanted)
                throw bad_input(
                    at_line(file, lines.number()),
                    fmt::format("found {}, expected \"{}\"; export the shape again", shown(lines.line()), wanted));
        };
        require(word, expected);
        if (!in_solid) {
            in_solid = true;
            spelled += "solid\n";
            continue;
        }
        if (word == "facet") require(take_word(rest), "normal");
        if (word == "outer") require(take_word(rest), "loop");
        spelled += word == "facet" ? "facet normal 0 0 0" : word == "outer" ? "outer loop" : word;
        if (word == "vertex") {
            for (int axis = 0; axis < 3; ++axis) {
                const std::string_view number = take_word(rest);
                const auto value = parse_number(number);
                if (!value || !is_coordinate(*value)) throw bad_coordinate(at_line(file, lines.number()), number);
                spelled += ' ';
                spelled += number;
            }
            ++checked.points;
        }
        spelled += '\n';
        step = (step + 1) % row.size();
        if (step == 0) ++checked.faces;
    }
    if (in_solid)
        throw bad_input(at_line(file, lines.number()),
                        fmt::format("found the end of the file, expected \"{}\"; the file is cut short",
                                    step == 0 ? "endsolid" : row.at(step)));
    return checked;
}

}  // namespace

Checked check_stl(std::string content, const std::string& file) {
    // Some programs begin binary files with "solid" too, but only those hold zero bytes.
    std::string_view rest = content;
    const bool text = lower_case(take_word(rest)) == "solid" && content.find('\0') == std::string::npos;
    return text ? check_text(lower_case(content), file) : check_binary(std::move(content), file);
}

}  // namespace haptogram
