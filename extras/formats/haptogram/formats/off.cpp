// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>

#include "haptogram/base/error.hpp"
#include "haptogram/base/text.hpp"
#include "haptogram/formats/parts.hpp"

namespace haptogram::formats {
namespace {

/// The words of a text line by line, without comments.
class LineWords {
public:
    LineWords(std::string_view content, const std::string& name) : lines_(content), name_(name) {}

    /// Moves to the next line that has words; false at the end of the file.
    bool next() {
        while (lines_.next()) {
            rest = lines_.line().substr(0, lines_.line().find('#'));
            if (rest.find_first_not_of(" \t") != std::string_view::npos) return true;
        }
        return false;
    }
    void require_next(const std::string& what) {
        if (!next())
            throw bad_input(place(),
                            fmt::format("found the end of the file, expected {}; the file is cut short", what));
    }
    /// A whole number off the front of the line.
    std::size_t whole(double least, double end, const std::string& what) {
        const std::string_view word = take_word(rest);
        const double value = parse_number(word).value_or(-1.0);
        if (!(value >= least && value < end && value == std::floor(value)))
            throw bad_input(place(), fmt::format("found {}, expected {}; export the shape again",
                                                 word.empty() ? "the end of the line" : shown(word), what));
        return static_cast<std::size_t>(value);
    }
    [[nodiscard]] std::string place() const { return at_line(name_, lines_.number()); }

    std::string_view rest;  ///< of the line

private:
    Lines lines_;
    const std::string& name_;
};

constexpr double most_counted = 4294967296.0;

}  // namespace

Polygons read_off(const ShapeFile& file) {
    LineWords lines(file.content, file.name);
    lines.require_next("\"OFF\"");
    if (const std::string_view word = take_word(lines.rest); word != "OFF" && word != "COFF")
        throw bad_input(lines.place(), fmt::format("found {}, expected \"OFF\" or \"COFF\"; export the shape again, as "
                                                   "text with three coordinates a vertex",
                                                   shown(word)));
    if (lines.rest.find_first_not_of(" \t") == std::string_view::npos)
        lines.require_next("numbers of vertices and faces");
    const std::size_t vertices = lines.whole(1.0, most_counted, "a number of vertices");
    const std::size_t faces = lines.whole(0.0, most_counted, "a number of faces");
    Polygons polygons;
    for (std::size_t i = 0; i < vertices; ++i) {
        lines.require_next(fmt::format("vertex {} of {}", i + 1, vertices));
        polygons.vertices.push_back(take_point(lines.rest, lines.place()));
    }
    for (std::size_t i = 0; i < faces; ++i) {
        lines.require_next(fmt::format("face {} of {}", i + 1, faces));
        for (std::size_t left = lines.whole(3.0, most_counted, "3 or more corners"); left > 0; --left)
            polygons.corners.push_back(static_cast<std::uint32_t>(lines.whole(
                0.0, static_cast<double>(vertices), fmt::format("one of the {} vertices, from 0", vertices))));
        polygons.end_face();
    }
    if (lines.next())
        throw bad_input(lines.place(),
                        fmt::format("found {} behind all {} faces that the file promises; its numbers are "
                                    "wrong or it is damaged",
                                    shown(lines.rest), faces));
    return polygons;
}

}  // namespace haptogram::formats
