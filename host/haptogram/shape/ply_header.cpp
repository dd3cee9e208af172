// SPDX-License-Identifier: Apache-2.0
#include "haptogram/shape/ply_header.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <charconv>

#include "haptogram/shape/text.hpp"

namespace haptogram {
namespace {

std::optional<PlyType> type_named(std::string_view name) {
    struct Names {
        std::string_view first, second;
    };
    constexpr std::array<Names, 8> names{{{"char", "int8"},
                                          {"uchar", "uint8"},
                                          {"short", "int16"},
                                          {"ushort", "uint16"},
                                          {"int", "int32"},
                                          {"uint", "uint32"},
                                          {"float", "float32"},
                                          {"double", "float64"}}};
    for (std::size_t i = 0; i < names.size(); ++i)
        if (name == names.at(i).first || name == names.at(i).second) return static_cast<PlyType>(i);
    return std::nullopt;
}

std::optional<PlyElement> parse_element(std::string_view rest) {
    PlyElement element{std::string(take_word(rest)), 0, {}};
    const std::string_view count = take_word(rest);
    const auto [end, error] = std::from_chars(count.data(), count.data() + count.size(), element.count);
    if (count.empty() || error != std::errc{} || end != count.data() + count.size()) return std::nullopt;
    return element;
}

std::optional<PlyProperty> parse_property(std::string_view rest) {
    PlyProperty property;
    std::string_view word = take_word(rest);
    if (word == "list") {
        property.count_type = type_named(take_word(rest));
        if (!property.count_type || *property.count_type >= PlyType::float32) return std::nullopt;
        word = take_word(rest);
    }
    const auto type = type_named(word);
    property.name = take_word(rest);
    if (!type || property.name.empty()) return std::nullopt;
    property.type = *type;
    return property;
}

/// Takes one line between "ply" and "end_header"; false when it belongs to no PLY header.
bool take_line(std::string_view line, bool& has_format, PlyHeader& header) {
    const std::string_view keyword = take_word(line);
    if (keyword == "comment" || keyword == "obj_info") return true;
    if (keyword == "format") {
        const std::string_view format = take_word(line);
        if (format == "binary_little_endian") header.binary = std::endian::little;
        if (format == "binary_big_endian") header.binary = std::endian::big;
        has_format = header.binary || format == "ascii";
        return has_format;
    }
    if (keyword == "element") {
        const auto element = parse_element(line);
        if (element) header.elements.push_back(*element);
        return element.has_value();
    }
    if (keyword != "property" || header.elements.empty()) return false;
    const auto property = parse_property(line);
    if (property) header.elements.back().properties.push_back(*property);
    return property.has_value();
}

}  // namespace

std::size_t PlyHeader::count(std::string_view name) const {
    std::size_t total = 0;
    for (const PlyElement& element : elements)
        if (element.name == name) total += element.count;
    return total;
}

PlyHeader parse_ply_header(std::string_view content, const std::string& file) {
    PlyHeader header;
    Lines lines(content);
    if (!lines.next() || lines.line() != "ply")
        throw bad_input(at_line(file, 1),
                        fmt::format("found {}, expected \"ply\"; this is no PLY file", shown(lines.line())));
    bool has_format = false;
    bool ended = false;
    while (!ended && lines.next()) {
        ended = lines.line() == "end_header";
        // The importer library would take a zero for the end of a name, and so another property for this one.
        if (lines.line().find('\0') != std::string_view::npos)
            throw bad_input(
                at_line(file, lines.number()),
                fmt::format("found {}, expected text without zero bytes; the header is damaged", shown(lines.line())));
        if (!ended && !take_line(lines.line(), has_format, header))
            throw bad_input(
                at_line(file, lines.number()),
                fmt::format("found {}, expected a line of a PLY header; export the shape again", shown(lines.line())));
    }
    if (!ended || !has_format)
        throw bad_input(at_line(file, lines.number()),
                        fmt::format("the PLY header has no {}; the file is cut short or damaged",
                                    ended ? "format line" : "end_header line"));
    for (const PlyElement& element : header.elements) {
        if (element.properties.empty() && element.count > 0)
            throw bad_input(file, fmt::format("the PLY header gives its {} elements {} no property; export the shape "
                                              "again",
                                              element.count, shown(element.name)));
        if (element.name == "tristrips")
            throw bad_input(file, "found triangle strips, expected faces; export the shape with faces");
        for (const std::string_view axis : {"x", "y", "z"}) {
            const auto is_axis = [&](const PlyProperty& property) {
                return property.name == axis && !property.count_type;
            };
            if (element.name == "vertex" &&
                std::count_if(element.properties.begin(), element.properties.end(), is_axis) != 1)
                throw bad_input(
                    file,
                    fmt::format("the PLY header gives its vertices not exactly one property {}; export the shape again",
                                axis));
        }
    }
    header.lines = lines.number();
    header.bytes = content.size() - lines.rest().size();
    return header;
}

}  // namespace haptogram
