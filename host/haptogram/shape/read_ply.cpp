// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include "haptogram/base/error.hpp"
#include "haptogram/base/text.hpp"
#include "haptogram/shape/formats.hpp"
#include "haptogram/shape/ply_header.hpp"

namespace haptogram {
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

}  // namespace haptogram
