// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <charconv>

#include "haptogram/base/text.hpp"
#include "haptogram/shape/formats.hpp"

namespace haptogram {
namespace {

/// Statements that add nothing to the surface and change nothing about it.
constexpr std::array<std::string_view, 9> without_surface{"vt", "vn", "vp", "g", "o", "s", "usemtl", "mtllib", "mg"};

/// Walks over the statements of a file. A statement is one line, or several when each but the last ends with a
/// backslash. A comment runs from "#" to the end of its line, whatever it ends with.
class Statements {
public:
    Statements(std::string_view content, const std::string& name) : lines_(content), name_(name) {}

    /// Moves to the next statement; false at the end of the file.
    bool next() {
        if (!lines_.next()) return false;
        first_line_ = lines_.number();
        text_ = without_comment();
        if (!text_.ends_with('\\')) return true;
        joined_.clear();
        while (text_.ends_with('\\')) {
            text_.remove_suffix(1);
            joined_.append(text_).append(" ");
            if (!lines_.next())
                throw bad_input(
                    at_line(name_, lines_.number()),
                    "found the end of the file after a line that ends with \"\\\", expected the rest of the "
                    "line; the file is cut short");
            text_ = without_comment();
            require_rest_of_statement();
        }
        joined_.append(text_);
        text_ = joined_;
        return true;
    }
    [[nodiscard]] std::string_view text() const { return text_; }
    /// The line that the statement begins on, for messages.
    [[nodiscard]] std::string place() const { return at_line(name_, first_line_); }

private:
    [[nodiscard]] std::string_view without_comment() const { return lines_.line().substr(0, lines_.line().find('#')); }

    /// A name such as "C:\" ends with a backslash by mistake; the vertex or face in the next line must not get lost.
    void require_rest_of_statement() const {
        std::string_view rest = text_;
        const std::string_view word = take_word(rest);
        if (word == "v" || word == "f")
            throw bad_input(at_line(name_, lines_.number()),
                            fmt::format("found {} after a line that ends with \"\\\", expected the rest of that line; "
                                        "remove the \"\\\"",
                                        shown(lines_.line())));
    }

    Lines lines_;
    const std::string& name_;
    std::size_t first_line_ = 0;
    std::string_view text_;
    std::string joined_;
};

/// @param rest  what follows the word "v"
Vec3 parse_vertex(std::string_view rest, const Statements& statements) {
    std::array<double, 3> vertex{};
    for (double& coordinate : vertex) {
        const std::string_view word = take_word(rest);
        const auto value = parse_number(word);
        if (!value || !is_coordinate(*value)) throw bad_coordinate(statements.place(), word);
        coordinate = *value;
    }
    return {vertex[0], vertex[1], vertex[2]};
}

/// Corners are "vertex", "vertex/texture", "vertex//normal" or "vertex/texture/normal"; vertices count from 1, or back
/// from the latest with -1.
/// @param rest  what follows the word "f"
void add_face(std::string_view rest, const Statements& statements, Polygons& polygons) {
    const auto vertices = static_cast<long long>(polygons.vertices.size());
    int corners = 0;
    for (std::string_view word = take_word(rest); !word.empty(); word = take_word(rest), ++corners) {
        long long index = 0;
        const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), index);
        const bool number = error == std::errc{} && (end == word.data() + word.size() || *end == '/');
        if (index < 0) index += vertices + 1;
        if (!number || index < 1 || index > vertices)
            throw bad_input(
                statements.place(),
                fmt::format("found the corner {}, expected the number of one of the {} vertices above; export the "
                            "shape again",
                            shown(word), vertices));
        polygons.corners.push_back(static_cast<std::uint32_t>(index - 1));
    }
    if (corners < 3)
        throw bad_input(
            statements.place(),
            fmt::format("found a face with {} corners, expected 3 or more; the file may be cut short", corners));
    polygons.end_face();
}

}  // namespace

Polygons read_obj(std::string_view content, const std::string& name) {
    Polygons polygons;
    for (Statements statements(content, name); statements.next();) {
        std::string_view rest = statements.text();
        const std::string_view statement = take_word(rest);
        if (statement == "v") {
            polygons.vertices.push_back(parse_vertex(rest, statements));
        } else if (statement == "f") {
            add_face(rest, statements, polygons);
        } else if (!statement.empty() &&
                   std::find(without_surface.begin(), without_surface.end(), statement) == without_surface.end()) {
            throw bad_input(statements.place(),
                            fmt::format("found {}, expected a statement of a Wavefront OBJ file with v or f "
                                        "(points, lines and free-form surfaces are not taken); export the "
                                        "shape as a mesh",
                                        shown(statements.text())));
        }
    }
    return polygons;
}

}  // namespace haptogram
