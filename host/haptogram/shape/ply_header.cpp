// SPDX-License-Identifier: Apache-2.0
#include "haptogram/shape/ply_header.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>

#include "haptogram/base/text.hpp"

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
        if (!property.count_type) return std::nullopt;
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

/// Gives `role` to the one property of `element` that `is_it` finds.
/// @param wanted  what to call the property in a message
template <class IsIt>
void assign(PlyElement& element, PlyRole role, const IsIt& is_it, std::string_view wanted, const std::string& name) {
    const auto found = std::find_if(element.properties.begin(), element.properties.end(), is_it);
    if (found == element.properties.end() || std::any_of(found + 1, element.properties.end(), is_it))
        throw bad_input(
            name, fmt::format("the PLY header gives the element {} not exactly one property {}; export the shape again",
                              shown(element.name), wanted));
    found->role = role;
}

void assign_roles(PlyElement& element, const std::string& name) {
    if (element.name == "vertex")
        for (const auto& [axis, role] : {std::pair{"x", PlyRole::x}, {"y", PlyRole::y}, {"z", PlyRole::z}})
            assign(
                element, role, [axis = axis](const PlyProperty& p) { return p.name == axis && !p.count_type; }, axis,
                name);
    if ((element.name == "face" || element.name == "tristrips") && element.count > 0)
        assign(
            element, element.name == "face" ? PlyRole::face : PlyRole::strips,
            [](const PlyProperty& p) {
                return (p.name == "vertex_indices" || p.name == "vertex_index") && p.count_type;
            },
            "list ... vertex_indices", name);
}

void check_elements(PlyHeader& header, const std::string& name) {
    for (auto element = header.elements.begin(); element != header.elements.end(); ++element) {
        if (element->properties.empty() && element->count > 0)
            throw bad_input(name, fmt::format("the PLY header gives its {} elements {} no property; export the shape "
                                              "again",
                                              element->count, shown(element->name)));
        if (std::any_of(header.elements.begin(), element,
                        [&](const PlyElement& other) { return other.name == element->name; }))
            throw bad_input(name, fmt::format("the PLY header names the element {} twice; export the shape again",
                                              shown(element->name)));
        assign_roles(*element, name);
        if (element->name == "vertex") header.vertices = element->count;
    }
}

}  // namespace

PlyHeader parse_ply_header(std::string_view content, const std::string& name) {
    PlyHeader header;
    // The format's author speaks of lines that end with a carriage return; today's programs write LF or CRLF.
    if (content.starts_with("ply\r") && !content.starts_with("ply\r\n")) header.line_end = '\r';
    Lines lines(content, 0, header.line_end);
    const auto line = [&lines] { return lines.line().substr(0, lines.line().find_last_not_of(" \t") + 1); };
    if (!lines.next() || line() != "ply")
        throw bad_input(at_line(name, 1),
                        fmt::format("found {}, expected \"ply\"; this is no PLY file", shown(lines.line())));
    bool has_format = false;
    bool ended = false;
    while (!ended && lines.next()) {
        ended = line() == "end_header";
        // A zero byte is a sign of damage; other programs take it for the end of a name.
        if (lines.line().find('\0') != std::string_view::npos)
            throw bad_input(
                at_line(name, lines.number()),
                fmt::format("found {}, expected text without zero bytes; the header is damaged", shown(lines.line())));
        if (!ended && !take_line(line(), has_format, header))
            throw bad_input(
                at_line(name, lines.number()),
                fmt::format("found {}, expected a line of a PLY header; export the shape again", shown(lines.line())));
    }
    if (!ended || !has_format)
        throw bad_input(at_line(name, lines.number()),
                        fmt::format("the PLY header has no {}; the file is cut short or damaged",
                                    ended ? "format line" : "end_header line"));
    check_elements(header, name);
    header.lines = lines.number();
    header.bytes = content.size() - lines.rest().size();
    return header;
}

}  // namespace haptogram
