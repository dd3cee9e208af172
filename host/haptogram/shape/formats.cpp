// SPDX-License-Identifier: Apache-2.0
#include "haptogram/shape/formats.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "haptogram/base/error.hpp"
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

namespace {

double triangle_area(Vec3 a, Vec3 b, Vec3 c) { return 0.5 * norm(cross(b - a, c - a)); }

/// Cuts one face into triangles by clipping ears (Meisters 1975), seen along the mean normal of the face. An ear is a
/// corner that points outwards and whose triangle with its two neighbours holds no other corner of the face.
class EarClipper {
public:
    EarClipper(const std::vector<Vec3>& vertices, std::span<const std::uint32_t> face)
        : vertices_(vertices), left_(face.begin(), face.end()) {
        for (std::size_t k = 2; k < face.size(); ++k)
            normal_ = normal_ + cross(at(face[k - 1]) - at(face[0]), at(face[k]) - at(face[0]));
        for (std::size_t k = 0; k < left_.size(); ++k)
            if (turn(at(before(k)), at(left_[k]), at(after(k))) < 0.0) inward_.push_back(left_[k]);
    }

    /// @return the area of the triangles that lie upside down, which happens only in a face that crosses itself
    double cut(std::vector<std::array<std::uint32_t, 3>>& triangles) {
        std::size_t k = 1;
        for (std::size_t failures = 0; !inward_.empty() && left_.size() > 3 && failures < left_.size();) {
            k %= left_.size();
            if (is_ear(k)) {
                triangles.push_back({before(k), left_[k], after(k)});
                if (const auto found = std::find(inward_.begin(), inward_.end(), left_[k]); found != inward_.end())
                    inward_.erase(found);
                left_.erase(left_.begin() + static_cast<std::ptrdiff_t>(k));
                failures = 0;
            } else {
                ++k;
                ++failures;
            }
        }
        double upside_down = 0.0;  // what is left is convex, or crosses itself
        for (std::size_t i = 2; i < left_.size(); ++i) {
            triangles.push_back({left_[0], left_[i - 1], left_[i]});
            if (turn(at(left_[0]), at(left_[i - 1]), at(left_[i])) <= 0.0)
                upside_down += triangle_area(at(left_[0]), at(left_[i - 1]), at(left_[i]));
        }
        return upside_down;
    }

private:
    [[nodiscard]] Vec3 at(std::uint32_t vertex) const { return vertices_[vertex]; }
    [[nodiscard]] std::uint32_t before(std::size_t k) const { return left_[k == 0 ? left_.size() - 1 : k - 1]; }
    [[nodiscard]] std::uint32_t after(std::size_t k) const { return left_[k + 1 == left_.size() ? 0 : k + 1]; }

    /// Positive when a, b and c turn the way the face turns.
    [[nodiscard]] double turn(Vec3 a, Vec3 b, Vec3 c) const { return dot(cross(b - a, c - b), normal_); }

    [[nodiscard]] bool is_ear(std::size_t k) const {
        const Vec3 a = at(before(k));
        const Vec3 b = at(left_[k]);
        const Vec3 c = at(after(k));
        const double area = turn(a, b, c);
        if (area < 0.0) return false;
        // A corner on a straight side can always go: its triangle is empty.
        if (triangle_area(a, b, c) == 0.0) return true;
        if (area == 0.0) return false;
        // The outermost of the corners inside always points inwards, so only those need a look.
        return std::none_of(inward_.begin(), inward_.end(), [&](std::uint32_t vertex) {
            const Vec3 p = at(vertex);
            if (p == a || p == b || p == c) return false;
            return turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0;
        });
    }

    const std::vector<Vec3>& vertices_;
    std::vector<std::uint32_t> left_;    ///< corners that are not clipped yet
    std::vector<std::uint32_t> inward_;  ///< corners that pointed inwards at the beginning
    Vec3 normal_{};
};

}  // namespace

Piece as_piece(Polygons polygons, const std::string& name) {
    if (polygons.vertices.empty())
        throw bad_input(name, "found no points, expected at least one; export the shape again");
    if (polygons.vertices.size() > std::numeric_limits<std::uint32_t>::max())
        throw bad_input(name, fmt::format("found {} vertices, expected at most {}; export the shape with fewer",
                                          polygons.vertices.size(), std::numeric_limits<std::uint32_t>::max()));
    if (polygons.face_ends.empty()) return Cloud{std::move(polygons.vertices)};

    Mesh mesh{std::move(polygons.vertices), {}};
    mesh.triangles.reserve(polygons.corners.size() - 2 * polygons.face_ends.size());
    double crossed_area = 0.0;
    std::vector<std::size_t> crossed;  // numbers of faces
    std::size_t begin = 0;
    for (std::size_t i = 0; i < polygons.face_ends.size(); ++i) {
        const auto face = std::span(polygons.corners).subspan(begin, polygons.face_ends[i] - begin);
        begin = polygons.face_ends[i];
        if (face.size() == 3) {
            mesh.triangles.push_back({face[0], face[1], face[2]});
            continue;
        }
        const double upside_down = EarClipper(mesh.vertices, face).cut(mesh.triangles);
        crossed_area += upside_down;
        if (upside_down > 0.0) crossed.push_back(i + 1);
    }
    double area = 0.0;
    for (const auto& [a, b, c] : mesh.triangles)
        area += triangle_area(mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]);
    if (area == 0.0)
        throw bad_input(
            name,
            fmt::format(
                "all {} faces together have zero area, expected a surface; export the shape as points or with faces "
                "that are not flat to a line",
                polygons.face_ends.size()));
    constexpr double rounding = 1e-6;  // corners rounded by the exporting program may cross by this much
    if (crossed_area > rounding * area)
        mesh.flaw = fmt::format(
            "{} of its {} faces cross themselves, face {} first, and were cut into triangles as they "
            "are, {:.3g} % of the area upside down; export the shape as triangles",
            crossed.size(), polygons.face_ends.size(), crossed.front(), 100.0 * crossed_area / area);
    return mesh;
}

namespace {

void split_words(std::string_view line, Fields& fields) {
    fields.clear();
    for (std::string_view word = take_word(line); !word.empty(); word = take_word(line)) fields.push_back(word);
}

/// The row from its first field to its last; it has some.
std::string_view whole(const Fields& fields) {
    const char* const begin = fields.front().data();
    return {begin, static_cast<std::size_t>(fields.back().data() + fields.back().size() - begin)};
}

using Columns = std::array<std::size_t, 3>;  ///< which fields are x, y and z

/// Nothing when the first row holds numbers, not names.
std::optional<Columns> named_columns(const Fields& fields, const std::string& where) {
    if (std::any_of(fields.begin(), fields.end(), [](auto field) { return parse_number(field).has_value(); }))
        return std::nullopt;
    Columns columns{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::string name(1, "xyz"[axis]);
        const auto is_name = [&](auto field) { return lower_case(field) == name; };
        const auto found = std::find_if(fields.begin(), fields.end(), is_name);
        if (found == fields.end() || std::any_of(found + 1, fields.end(), is_name))
            throw bad_input(
                where,
                fmt::format("found a first row {} with {} \"{}\", expected three numbers, or a header that names x, y "
                            "and z once each; correct the row",
                            fields.empty() ? "\"\"" : shown(whole(fields)),
                            found == fields.end() ? "no" : "more than one", name));
        columns.at(axis) = static_cast<std::size_t>(found - fields.begin());
    }
    return columns;
}

/// Turns rows into points. Every row must be as long as the first, or a row cut short would pass for a point.
class Rows {
public:
    explicit Rows(const std::string& name) : name_(name) {}

    void choose(const Columns& columns, std::size_t width) {
        columns_ = columns;
        width_ = width;
    }

    void add(const Fields& fields, std::size_t line) {
        if (width_ == 0) width_ = std::max<std::size_t>(fields.size(), 3);
        if (fields.size() != width_)
            throw bad_input(at_line(name_, line),
                            fmt::format("found {} columns, expected {} as in the rows before (at least x, y, z); "
                                        "the row is damaged or the file was cut short",
                                        fields.size(), width_));
        std::array<double, 3> point{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::string_view field = fields[columns_.at(axis)];
            const auto value = parse_number(field);
            if (!value || !is_coordinate(*value)) throw bad_coordinate(at_line(name_, line), field);
            point.at(axis) = *value;
        }
        cloud_.points.push_back({point[0], point[1], point[2]});
    }

    Cloud finish() {
        if (cloud_.points.empty())
            throw bad_input(name_, "found no points, expected one row with x, y, z per point; export the shape again");
        return std::move(cloud_);
    }

private:
    const std::string& name_;
    Columns columns_{0, 1, 2};
    std::size_t width_ = 0;
    Cloud cloud_;
};

}  // namespace

Cloud read_xyz(std::string_view content, const std::string& name) {
    Rows rows(name);
    Fields fields;
    for (Lines lines(without_byte_order_mark(content)); lines.next();) {
        split_words(lines.line().substr(0, lines.line().find('#')), fields);
        if (!fields.empty()) rows.add(fields, lines.number());
    }
    return rows.finish();
}

Cloud read_csv(std::string_view content, const std::string& name) {
    Rows rows(name);
    Fields fields;
    char separator = 0;
    for (Lines lines(without_byte_order_mark(content)); lines.next();) {
        std::string_view rest = lines.line();
        if (const auto word = take_word(rest); word.empty() || word.starts_with('#')) continue;
        const bool first = separator == 0;
        if (first) separator = separator_of(lines.line());
        split_at(separator, lines.line(), fields);
        if (const auto columns = first ? named_columns(fields, at_line(name, lines.number())) : std::nullopt)
            rows.choose(*columns, fields.size());
        else
            rows.add(fields, lines.number());
    }
    return rows.finish();
}

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

namespace {

/// The data of a text PLY. Most files have one element a line. A line may also hold several whole elements, and an
/// element may fill several whole lines. What begins within a line must end on that line, and what goes beyond its
/// first line must end where a line ends: otherwise one lost number would shift all that follow it.
class TextBody {
public:
    TextBody(std::string_view text, const PlyHeader& header) : lines_(text, header.lines, header.line_end) {}

    /// False at the end of the file.
    bool begin_element() {
        within_line_ = has_words();
        several_lines_ = false;
        if (!find_words()) return false;
        line_ = lines_.number();
        std::string_view rest = words_;
        first_word_ = take_word(rest);
        return true;
    }
    /// The next number of the element; nothing when there is none.
    std::optional<double> read(PlyType /*type*/) {
        if (!within_line_ && !has_words()) several_lines_ = find_words();
        word_ = take_word(words_);
        return parse_number(word_);
    }
    /// The word that should not have followed the element before, when that is why `read` failed.
    [[nodiscard]] std::string_view surplus() const { return within_line_ ? first_word_ : std::string_view{}; }
    /// Why `read` failed, otherwise.
    [[nodiscard]] std::string problem() const {
        return word_.empty()
                   ? "found the end of the file, expected a further number; the file is cut short"
                   : fmt::format("found {}, expected a number with a decimal point; correct it", shown(word_));
    }
    /// What stands in the last line of an element of several lines, behind the element.
    std::string_view end_element() {
        std::string_view rest = words_;
        return several_lines_ ? take_word(rest) : std::string_view{};
    }
    bool at_end() { return !find_words(); }
    /// Where the element begins.
    [[nodiscard]] std::string place() const { return fmt::format(" (line {})", line_); }
    [[nodiscard]] std::string end_place() const { return fmt::format(" (line {})", lines_.number()); }

private:
    [[nodiscard]] bool has_words() const { return words_.find_first_not_of(" \t\r\v\f") != std::string_view::npos; }
    bool find_words() {
        while (!has_words()) {
            if (!lines_.next()) return false;
            words_ = lines_.line();
        }
        return true;
    }

    Lines lines_;
    std::string_view words_;       ///< what is left of the line
    std::string_view first_word_;  ///< of the element
    std::string_view word_;        ///< that was read last
    std::size_t line_ = 0;         ///< where the element begins
    bool within_line_ = false;     ///< another element comes before, in the same line
    bool several_lines_ = false;
};

class BinaryBody {
public:
    BinaryBody(std::string_view bytes, std::endian order) : bytes_(bytes), order_(order) {}

    [[nodiscard]] bool begin_element() const { return !bytes_.empty(); }
    std::optional<double> read(PlyType type) {
        switch (type) {
            case PlyType::int8: return take<std::int8_t>();
            case PlyType::uint8: return take<std::uint8_t>();
            case PlyType::int16: return take<std::int16_t>();
            case PlyType::uint16: return take<std::uint16_t>();
            case PlyType::int32: return take<std::int32_t>();
            case PlyType::uint32: return take<std::uint32_t>();
            case PlyType::float32: return take<float>();
            case PlyType::float64: return take<double>();
        }
        return std::nullopt;
    }
    static std::string_view surplus() { return {}; }
    [[nodiscard]] static std::string problem() {
        return "found the end of the file, expected further bytes; the file is cut short";
    }
    static std::string_view end_element() { return {}; }
    [[nodiscard]] bool at_end() const { return bytes_.empty(); }
    [[nodiscard]] static std::string place() { return {}; }
    [[nodiscard]] static std::string end_place() { return {}; }

private:
    template <class Number>
    std::optional<double> take() {
        if (bytes_.size() < sizeof(Number)) return std::nullopt;
        const auto number = load_number<Number>(bytes_.data(), order_);
        bytes_.remove_prefix(sizeof(Number));
        return static_cast<double>(number);
    }

    std::string_view bytes_;
    std::endian order_;
};

bool is_whole(double value, double end) { return value >= 0.0 && value < end && value == std::floor(value); }

/// Reads all elements of a file into polygons.
template <class Body>
class Reader {
public:
    Reader(const PlyHeader& header, Body body, const std::string& name) : header_(header), body_(body), name_(name) {}

    Polygons read(std::size_t bytes) {
        polygons_.vertices.reserve(std::min(header_.vertices, bytes));  // a vertex takes a byte or more
        for (const PlyElement& element : header_.elements) {
            element_ = &element;
            for (index_ = 0; index_ < element.count; ++index_) {
                read_element();
                element_before_ = element_;
                index_before_ = index_;
            }
        }
        if (!body_.at_end())
            throw bad_input(
                name_ + body_.end_place(),
                "found more data than the header promises; its numbers of elements are wrong or the file is damaged");
        return std::move(polygons_);
    }

private:
    [[nodiscard]] Error error(const PlyElement& element, std::size_t index, const std::string& message) const {
        return bad_input(fmt::format("{}, {} {} of {}{}", name_, element.name, index + 1, element.count, body_.place()),
                         message);
    }
    [[nodiscard]] Error error(const std::string& message) const { return error(*element_, index_, message); }

    double number(PlyType type) {
        if (const auto value = body_.read(type)) return *value;
        if (const auto word = body_.surplus(); !word.empty())
            throw error(*element_before_, index_before_,
                        fmt::format("found {} after all {} properties that the header promises; correct the line",
                                    shown(word), element_before_->properties.size()));
        throw error(body_.problem());
    }

    void read_element() {
        if (!body_.begin_element())
            throw error("found the end of the file; the header promises more than there is, the file is cut short");
        Vec3 vertex{};
        for (const PlyProperty& property : element_->properties) {
            switch (property.role) {
                case PlyRole::none: skip(property); break;
                case PlyRole::x: vertex.x = coordinate(property); break;
                case PlyRole::y: vertex.y = coordinate(property); break;
                case PlyRole::z: vertex.z = coordinate(property); break;
                case PlyRole::face: read_face(property); break;
                case PlyRole::strips: read_strips(property); break;
            }
        }
        if (element_->name == "vertex") polygons_.vertices.push_back(vertex);
        if (const auto word = body_.end_element(); !word.empty())
            throw error(
                fmt::format("found {} in the line that the element ends in, expected nothing behind an element of "
                            "several lines; a number is absent or there is one too many",
                            shown(word)));
    }

    double coordinate(const PlyProperty& property) {
        const double value = number(property.type);
        if (!is_coordinate(value)) throw error(bad_coordinate(property.name, fmt::format("{}", value)).what());
        return value;
    }

    std::uint64_t list_size(const PlyProperty& property, double least, const char* expected) {
        constexpr double longest_list = 4294967296.0;
        const double count = number(*property.count_type);
        if (!is_whole(count, longest_list) || count < least)
            throw error(fmt::format("found a list of {} values, expected {}; export the shape again", count, expected));
        return static_cast<std::uint64_t>(count);
    }

    void skip(const PlyProperty& property) {
        for (auto left = property.count_type ? list_size(property, 0.0, "a whole number of them") : 1; left > 0; --left)
            number(property.type);
    }

    std::uint32_t as_vertex(double value) const {
        if (!is_whole(value, static_cast<double>(header_.vertices)))
            throw error(
                fmt::format("found the corner {}, expected the number of one of the {} vertices, from 0; export "
                            "the shape again",
                            value, header_.vertices));
        return static_cast<std::uint32_t>(value);
    }

    void read_face(const PlyProperty& property) {
        for (auto left = list_size(property, 3.0, "3 or more corners"); left > 0; --left)
            polygons_.corners.push_back(as_vertex(number(property.type)));
        polygons_.end_face();
    }

    /// Strips follow each other in one list, with -1 between them. Each vertex makes a triangle with the two before it,
    /// and every second triangle is wound the other way. Programs join strips by naming a vertex twice; the triangles
    /// without area that this makes are no part of the surface.
    void read_strips(const PlyProperty& property) {
        std::array<std::uint32_t, 2> before{};
        std::size_t length = 0;
        const auto end_strip = [&] {
            if (length == 1 || length == 2)
                throw error(
                    fmt::format("found a strip of {} corners, expected 3 or more; export the shape again", length));
            length = 0;
        };
        for (auto left = list_size(property, 0.0, "a whole number of them"); left > 0; --left) {
            const double value = number(property.type);
            if (value == -1.0) {
                end_strip();
                continue;
            }
            const std::uint32_t corner = as_vertex(value);
            const auto [a, b] = before;
            ++length;
            if (length >= 3 && a != b && b != corner && a != corner)
                length % 2 == 1 ? polygons_.add_triangle(a, b, corner) : polygons_.add_triangle(b, a, corner);
            before = {b, corner};
        }
        end_strip();
    }

    const PlyHeader& header_;
    Body body_;
    const std::string& name_;
    Polygons polygons_;
    const PlyElement* element_ = nullptr;
    std::size_t index_ = 0;
    const PlyElement* element_before_ = nullptr;
    std::size_t index_before_ = 0;
};

}  // namespace

Polygons read_ply(std::string_view content, const std::string& name) {
    const PlyHeader header = parse_ply_header(content, name);
    const std::string_view body = content.substr(header.bytes);
    return header.binary ? Reader(header, BinaryBody(body, *header.binary), name).read(body.size())
                         : Reader(header, TextBody(body, header), name).read(body.size());
}

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
