// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <charconv>

#include "haptogram/shape/formats.hpp"
#include "haptogram/shape/text.hpp"

namespace haptogram {
namespace {

/// Statements that neither add to the surface nor change it.
constexpr std::array<std::string_view, 9> without_surface{"vt", "vn", "vp", "g", "o", "s", "usemtl", "mtllib", "mg"};

void append_vertex(std::string_view rest, const std::string& where, std::string& out) {
    out += 'v';
    for (int axis = 0; axis < 3; ++axis) {
        std::string_view word = take_word(rest);
        const auto value = parse_number(word);
        if (!value || !is_coordinate(*value)) throw bad_coordinate(where, word);
        if (word.starts_with('+')) word.remove_prefix(1);
        out += word.starts_with('.') ? " 0" : " ";
        out += word;
    }
    out += '\n';
}

/// Corners are "vertex", "vertex/texture", "vertex//normal" or "vertex/texture/normal"; vertices count from 1, or back
/// from the latest with -1.
void append_face(std::string_view rest, std::size_t vertices, const std::string& where, std::string& out) {
    out += 'f';
    int corners = 0;
    for (std::string_view word = take_word(rest); !word.empty(); word = take_word(rest), ++corners) {
        long long index = 0;
        const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), index);
        const bool number = error == std::errc{} && (end == word.data() + word.size() || *end == '/');
        if (index < 0) index += static_cast<long long>(vertices) + 1;
        if (!number || index < 1 || index > static_cast<long long>(vertices))
            throw bad_input(
                where,
                fmt::format("found the corner {}, expected the number of one of the {} vertices above; export the "
                            "shape again",
                            shown(word), vertices));
        out += fmt::format(" {}", index);
    }
    if (corners < 3)
        throw bad_input(
            where, fmt::format("found a face with {} corners, expected 3 or more; the file may be cut short", corners));
    out += '\n';
}

}  // namespace

Checked check_obj(const std::string& content, const std::string& file) {
    // Assimp 5.2 takes neither ".5" nor a tab after "v" nor an object without faces nor a file of 15 bytes, so it is
    // given the same vertices and faces in the plainest spelling.
    Checked checked{"# vertices and faces\n", 0, 0};
    checked.content.reserve(content.size());
    for (Lines lines(content); lines.next();) {
        std::string_view rest = lines.line().substr(0, lines.line().find('#'));
        const std::string_view statement = take_word(rest);
        if (statement == "v") {
            append_vertex(rest, at_line(file, lines.number()), checked.content);
            ++checked.points;
        } else if (statement == "f") {
            append_face(rest, checked.points, at_line(file, lines.number()), checked.content);
            ++checked.faces;
        } else if (!statement.empty() &&
                   std::find(without_surface.begin(), without_surface.end(), statement) == without_surface.end()) {
            throw bad_input(at_line(file, lines.number()),
                            fmt::format("found {}, expected a statement of a Wavefront OBJ file with v or f "
                                        "(points, lines and free-form surfaces are not taken); export the "
                                        "shape as a mesh",
                                        shown(lines.line())));
        }
    }
    return checked;
}

}  // namespace haptogram
