// SPDX-License-Identifier: Apache-2.0
#include "haptogram/shape/formats.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/base/text.hpp"
#include "haptogram/shape/draw.hpp"

namespace haptogram {
namespace {

enum class PlyType { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

/// What a property means for the shape.
enum class PlyRole { none, x, y, z, face, strips };

struct PlyProperty {
    std::string name;
    PlyType type{};
    std::optional<PlyType> count_type{};  ///< set when the property is a list
    PlyRole role = PlyRole::none;
};

struct PlyElement {
    std::string name;
    std::size_t count = 0;
    std::vector<PlyProperty> properties;
};

/// What stands before the data of a PLY file.
struct PlyHeader {
    std::optional<std::endian> binary;  ///< byte order; nothing when the data are text
    std::vector<PlyElement> elements;   ///< in the order of the data
    std::size_t vertices = 0;           ///< how many the data hold
    bool is_cloud = true;               ///< there are no faces
    char line_end = '\n';
    std::size_t lines = 0;
    std::size_t bytes = 0;
};

/// The number whose bytes start at `bytes`.
template <class Number>
Number load_number(const char* bytes, std::endian order) {
    std::array<char, sizeof(Number)> raw{};
    std::memcpy(raw.data(), bytes, raw.size());
    if (order != std::endian::native) std::reverse(raw.begin(), raw.end());
    return std::bit_cast<Number>(raw);
}

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
        if ((element->name == "face" || element->name == "tristrips") && element->count > 0) header.is_cloud = false;
    }
}

/// Reads the header and finds the properties that make the shape: x, y and z of `vertex`, and the list
/// `vertex_indices` or `vertex_index` of `face` and `tristrips`.
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

bool before(Vec3 a, Vec3 b) { return std::array{a.x, a.y, a.z} < std::array{b.x, b.y, b.z}; }

/// Leaves out three or more equal points that stand apart from all others, when each of those is there once.
/// @return a sentence on them; empty when there are none
std::string leave_out_heap(std::vector<Vec3>& points) {
    std::vector<Vec3> sorted = points;
    std::sort(sorted.begin(), sorted.end(), before);
    std::size_t most = 0, places = 0;
    Vec3 heap{};
    for (std::size_t i = 0, next = 0; i < sorted.size(); i = next, ++places) {
        while (next < sorted.size() && sorted[next] == sorted[i]) ++next;
        if (next - i > most) heap = sorted[i];
        most = std::max(most, next - i);
    }
    const std::size_t others = points.size() - most;
    if (most < 3 || others < 10 || others - (places - 1) > others / 100) return {};
    Vec3 low = sorted.front() == heap ? sorted.back() : sorted.front(), high = low;
    double nearest = std::numeric_limits<double>::infinity();
    for (const Vec3& p : points) {
        if (p == heap) continue;
        low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
        nearest = std::min(nearest, distance(p, heap));
    }
    constexpr double apart = 0.05;  // of the others' extent
    if (nearest < apart * distance(low, high)) return {};
    std::erase(points, heap);
    return fmt::format(
        "{} of its {} points lie in one place apart from the others, ({:.6g}, {:.6g}, {:.6g}) mm, as a depth "
        "camera writes pixels that it has not seen, and are left out; to keep the place, have it in the "
        "file once",
        most, points.size() + most, heap.x / millimetre, heap.y / millimetre, heap.z / millimetre);
}

}  // namespace

Shape as_shape(Polygons polygons, const std::string& name) {
    if (polygons.vertices.empty())
        throw bad_input(name, fmt::format("found no points{}, expected at least one; export the shape again",
                                          polygons.unseen > 0 ? " but such of NaN" : ""));
    if (polygons.vertices.size() > std::numeric_limits<std::uint32_t>::max())
        throw bad_input(name, fmt::format("found {} vertices, expected at most {}; export the shape with fewer",
                                          polygons.vertices.size(), std::numeric_limits<std::uint32_t>::max()));
    Shape shape{{}, std::move(polygons.remarks), polygons.own_unit_m.has_value(), std::move(polygons.beside)};
    std::vector<std::string>& remarks = shape.remarks;
    if (polygons.face_ends.empty() && !polygons.curves.empty()) {
        for (const std::vector<std::uint32_t>& curve : polygons.curves) {
            std::vector<Vec3> corners;
            for (const std::uint32_t corner : curve) corners.push_back(polygons.vertices[corner]);
            if (std::adjacent_find(corners.begin(), corners.end(), std::not_equal_to<>()) == corners.end())
                throw bad_input(
                    name, fmt::format("found a line from ({:.6g}, {:.6g}, {:.6g}) mm to the same place, expected "
                                      "two places; remove it",
                                      corners[0].x / millimetre, corners[0].y / millimetre, corners[0].z / millimetre));
            shape.pieces.emplace_back(polyline(corners, corners.front() == corners.back()));
        }
        return shape;
    }
    if (!polygons.curves.empty())
        remarks.push_back(
            fmt::format("lines beside its faces ({}) are left out; a file of lines alone is drawn as curves",
                        polygons.curves.size()));
    if (polygons.face_ends.empty()) {
        if (polygons.unseen > 0)
            remarks.push_back(
                fmt::format("{} points of NaN, as a depth camera writes pixels that it has not seen, are "
                            "left out of {}",
                            polygons.unseen, polygons.unseen + polygons.vertices.size()));
        if (std::string heap = leave_out_heap(polygons.vertices); !heap.empty()) remarks.push_back(std::move(heap));
        shape.pieces.emplace_back(Cloud{std::move(polygons.vertices)});
        return shape;
    }

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
    shape.pieces.emplace_back(std::move(mesh));
    return shape;
}

Vec3 take_point(std::string_view& rest, const std::string& where) {
    std::array<double, 3> point{};
    for (double& coordinate : point) {
        const std::string_view word = take_word(rest);
        const auto value = parse_number(word);
        if (!value || !is_coordinate(*value)) throw bad_coordinate(where, word);
        coordinate = *value;
    }
    return {point[0], point[1], point[2]};
}

namespace {

/// Turns rows into points. Every row must be as long as the first, or a row cut short would pass for a point.
class Rows {
public:
    /// @param tabs  part columns even when one is empty; otherwise any white space does
    Rows(const std::string& name, bool tabs) : name_(name), tabs_(tabs) {}

    void add(std::string_view line, std::size_t number) {
        std::string_view rest = line;
        const std::string_view word = take_word(rest);
        if (word.empty() || word.starts_with('#')) return;
        line_ = number;
        if (width_ == 0) {
            if (word.size() == 5 && lower_case(word).starts_with("sep=")) {
                given_separator_ = word[4];
                return;
            }
            const bool blanks = tabs_ ? line.find_first_of(",;\t") == std::string_view::npos
                                      : word.find_first_of(",;") == std::string_view::npos;
            separator_ = given_separator_ != 0 ? given_separator_ : blanks ? ' ' : separator_of(line);
            const bool slashes = word.starts_with("//");
            if (slashes) line.remove_prefix(line.find("//") + 2);
            split(line);
            if (begin(slashes)) return;
        } else {
            split(line);
        }
        take();
    }

    Polygons finish() {
        if (promised_ && *promised_ != static_cast<double>(rows_))
            throw bad_input(name_,
                            fmt::format("found {} rows, expected {}, as the first line counts them; the file was "
                                        "cut short or is damaged",
                                        rows_, *promised_));
        if (counts_ && rows_ > 2 && width_ > 3)
            cloud_.remarks.push_back(
                fmt::format("the first column counts {0}, {1}, {2} and so on, and is taken for x; if "
                            "it numbers the points, name the columns in a first row such as n x y z",
                            first_, first_ + 1.0, first_ + 2.0));
        return std::move(cloud_);
    }

private:
    [[nodiscard]] std::string where() const { return at_line(name_, line_); }

    void split(std::string_view line) {
        if (separator_ != ' ') return split_at(separator_, line, fields_);
        line = line.substr(0, line.find('#'));
        fields_.clear();
        for (std::string_view word = take_word(line); !word.empty(); word = take_word(line)) fields_.push_back(word);
    }

    /// Spreadsheets of many languages write a decimal comma, and semicolons between columns.
    [[nodiscard]] std::optional<double> number(std::string_view field) const {
        if (separator_ != ';' || field.find(',') == std::string_view::npos) return parse_number(field);
        std::string text(field);
        for (char& c : text) c = c == ',' ? '.' : c == '.' ? ',' : c;
        return parse_number(text);
    }

    /// Whether the first row is something else than a point: the names of columns, or how many rows follow.
    /// @param slashes  stood in front of it, as of a comment
    bool begin(bool slashes) {
        if (fields_.size() == 1 && !promised_ && (promised_ = number(fields_[0]))) return true;
        if (std::any_of(fields_.begin(), fields_.end(), [&](auto field) { return number(field).has_value(); })) {
            width_ = std::max<std::size_t>(fields_.size(), 3);
            return slashes;
        }
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::string name(1, "xyz"[axis]);
            const auto is_name = [&](auto field) {
                const std::string found = lower_case(field);
                return found == name || found == name + "_mm" || found == fmt::format("points:{}", axis);
            };
            const auto found = std::find_if(fields_.begin(), fields_.end(), is_name);
            if (found == fields_.end() && slashes) return true;
            if (found == fields_.end() || std::any_of(found + 1, fields_.end(), is_name))
                throw bad_input(where(),
                                fmt::format("found a first row {} with {} \"{}\", expected three numbers, or a header "
                                            "that names x, y and z once each; correct the row",
                                            fields_.empty() ? "\"\"" : shown(whole()),
                                            found == fields_.end() ? "no" : "more than one", name));
            columns_.at(axis) = static_cast<std::size_t>(found - fields_.begin());
            if (lower_case(*found).ends_with("_mm")) cloud_.own_unit_m = millimetre;
        }
        width_ = fields_.size();
        counts_ = false;
        return true;
    }

    /// The row from its first field to its last; it has some.
    [[nodiscard]] std::string_view whole() const {
        const char* const begin = fields_.front().data();
        return {begin, static_cast<std::size_t>(fields_.back().data() + fields_.back().size() - begin)};
    }

    void take() {
        if (fields_.size() != width_)
            throw bad_input(where(),
                            fmt::format("found {} columns, expected {} as in the rows before (at least x, y, z); "
                                        "the row is damaged or the file was cut short",
                                        fields_.size(), width_));
        std::array<double, 3> point{};
        std::size_t unseen = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto value = number(fields_[columns_.at(axis)]);
            point.at(axis) = value.value_or(std::numeric_limits<double>::infinity());
            if (std::isnan(point.at(axis))) ++unseen;
        }
        for (std::size_t axis = 0; axis < 3 && unseen < 3; ++axis)
            if (!is_coordinate(point.at(axis))) throw bad_coordinate(where(), fields_[columns_.at(axis)]);
        if (rows_ == 0) first_ = point[0];
        counts_ = counts_ && point[0] == first_ + static_cast<double>(rows_) && (first_ == 0.0 || first_ == 1.0);
        ++rows_;
        if (unseen == 3)
            ++cloud_.unseen;
        else
            cloud_.vertices.push_back({point[0], point[1], point[2]});
    }

    const std::string& name_;
    bool tabs_;
    char separator_ = ',', given_separator_ = 0;
    Fields fields_;
    std::array<std::size_t, 3> columns_{0, 1, 2};  ///< which fields are x, y and z
    std::size_t width_ = 0, rows_ = 0, line_ = 0;
    std::optional<double> promised_;  ///< rows
    bool counts_ = true;              ///< the first column, from `first_` on
    double first_ = 0.0;
    Polygons cloud_;
};

}  // namespace

Polygons read_rows(std::string_view content, const std::string& name, bool tabs) {
    Rows rows(name, tabs);
    for (Lines lines(content); lines.next();) rows.add(lines.line(), lines.number());
    return rows.finish();
}

namespace {

/// Statements that add nothing to the surface and change nothing about it.
constexpr std::array<std::string_view, 18> without_surface{
    "vt", "vn",  "vp",    "g",        "o",        "s",      "usemtl", "mtllib",     "mg",
    "p",  "lod", "bevel", "c_interp", "d_interp", "usemap", "maplib", "shadow_obj", "trace_obj"};

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

/// Corners are "vertex", "vertex/texture", "vertex//normal" or "vertex/texture/normal"; vertices count from 1, or back
/// from the latest with -1.
/// @param rest   what follows the word "f" or "l" @param above  how many vertices stand above @param least  corners
/// @param polygons  have all vertices
std::vector<std::uint32_t> corners_of(std::string_view rest, const Statements& statements, long long above,
                                      std::size_t least, const Polygons& polygons) {
    const auto vertices = static_cast<long long>(polygons.vertices.size());
    std::vector<std::uint32_t> corners;
    for (std::string_view word = take_word(rest); !word.empty(); word = take_word(rest)) {
        long long index = 0;
        const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), index);
        const bool number = error == std::errc{} && (end == word.data() + word.size() || *end == '/');
        if (index < 0) index += above + 1;
        if (!number || index < 1 || index > vertices)
            throw bad_input(statements.place(), fmt::format("found the corner {}, expected the number of one of the {} "
                                                            "vertices; export the shape again",
                                                            shown(word), vertices));
        corners.push_back(static_cast<std::uint32_t>(index - 1));
    }
    if (corners.size() < least)
        throw bad_input(statements.place(),
                        fmt::format("found a {} with {} corners, expected {} or more; the file may be cut short",
                                    least == 2 ? "line" : "face", corners.size(), least));
    return corners;
}

}  // namespace

Polygons read_obj(std::string_view content, const std::string& name) {
    Polygons polygons;
    for (Statements statements(content, name); statements.next();) {
        std::string_view rest = statements.text();
        const std::string_view word = take_word(rest);
        if (word == "v")
            polygons.vertices.push_back(take_point(rest, statements.place()));
        else if (!word.empty() && word != "f" && word != "l" &&
                 std::find(without_surface.begin(), without_surface.end(), word) == without_surface.end())
            throw bad_input(statements.place(),
                            fmt::format("found {}, expected a statement of a Wavefront OBJ file with "
                                        "v, f or l (free-form surfaces are not taken); export the "
                                        "shape as a mesh",
                                        shown(statements.text())));
    }
    long long above = 0;
    for (Statements statements(content, name); statements.next();) {  // faces may stand before their vertices
        std::string_view rest = statements.text();
        const std::string_view word = take_word(rest);
        if (word == "v") ++above;
        if (word == "l") polygons.curves.push_back(corners_of(rest, statements, above, 2, polygons));
        if (word != "f") continue;
        const std::vector<std::uint32_t> face = corners_of(rest, statements, above, 3, polygons);
        polygons.corners.insert(polygons.corners.end(), face.begin(), face.end());
        polygons.end_face();
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
                case PlyRole::x: vertex.x = number(property.type); break;
                case PlyRole::y: vertex.y = number(property.type); break;
                case PlyRole::z: vertex.z = number(property.type); break;
                case PlyRole::face: read_face(property); break;
                case PlyRole::strips: read_strips(property); break;
            }
        }
        if (element_->name == "vertex") add_vertex(vertex);
        if (const auto word = body_.end_element(); !word.empty())
            throw error(
                fmt::format("found {} in the line that the element ends in, expected nothing behind an element of "
                            "several lines; a number is absent or there is one too many",
                            shown(word)));
    }

    void add_vertex(Vec3 vertex) {
        const std::array<double, 3> numbers{vertex.x, vertex.y, vertex.z};
        const bool unseen = std::all_of(numbers.begin(), numbers.end(), [](double n) { return std::isnan(n); });
        if (unseen && header_.is_cloud) {
            ++polygons_.unseen;
            return;
        }
        for (std::size_t i = 0; i < 3; ++i)
            if (!is_coordinate(numbers.at(i)))
                throw error(bad_coordinate(std::string(1, "xyz"[i]), fmt::format("{}", numbers.at(i))).what());
        polygons_.vertices.push_back(vertex);
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
        if (word == "vertex") polygons.vertices.push_back(take_point(rest, at_line(name, lines.number())));
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
