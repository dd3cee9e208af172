// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include <cmath>
#include <cstdint>
#include <utility>

#include "haptogram/shape/formats.hpp"
#include "haptogram/shape/ply_header.hpp"
#include "haptogram/shape/text.hpp"

namespace haptogram {
namespace {

/// The data of a text PLY: a line an element.
class TextBody {
public:
    TextBody(std::string_view text, std::size_t lines_before) : lines_(text, lines_before) {}

    bool begin_element() {
        do {
            if (!lines_.next()) return false;
            words_ = lines_.line();
        } while (words_.find_first_not_of(" \t") == std::string_view::npos);
        return true;
    }
    std::optional<double> read(PlyType /*type*/) {
        word_ = take_word(words_);
        return parse_number(word_);
    }
    /// Why `read` failed.
    [[nodiscard]] std::string problem() const {
        return word_.empty()
                   ? "found the end of the line, expected a further number; the line is damaged or the file is cut "
                     "short"
                   : fmt::format("found {}, expected a number with a decimal point; correct it", shown(word_));
    }
    /// What is left of the element, which should be nothing.
    std::string_view end_element() { return take_word(words_); }
    std::string_view end() { return begin_element() ? words_ : ""; }
    [[nodiscard]] std::string place() const { return fmt::format(" (line {})", lines_.number()); }

private:
    Lines lines_;
    std::string_view words_;
    std::string_view word_;
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
    [[nodiscard]] static std::string problem() {
        return "found the end of the file, expected further bytes; the file is cut short";
    }
    static std::string_view end_element() { return {}; }
    [[nodiscard]] std::string_view end() const { return bytes_; }
    [[nodiscard]] static std::string place() { return {}; }

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

/// Reads one element: what a vertex or a face must hold, and for the rest that it is there.
/// @param fail  makes the error of this element from a message
template <class Body, class Fail>
void check_element(const PlyElement& element, std::size_t vertices, Body& body, const Fail& fail) {
    const auto read = [&](PlyType type) {
        const auto value = body.read(type);
        if (!value) throw fail(body.problem());
        return *value;
    };
    constexpr double longest_list = 4294967296.0;
    if (!body.begin_element())
        throw fail("found the end of the file; the header promises more than there is, the file is cut short");
    for (const PlyProperty& property : element.properties) {
        const bool is_corners =
            element.name == "face" && (property.name == "vertex_indices" || property.name == "vertex_index");
        const bool is_axis =
            element.name == "vertex" && (property.name == "x" || property.name == "y" || property.name == "z");
        const double count = property.count_type ? read(*property.count_type) : 1.0;
        if (!is_whole(count, longest_list) || (is_corners && count < 3.0))
            throw fail(fmt::format("found a list of {} values, expected {}; export the shape again", count,
                                   is_corners ? "3 or more corners" : "a whole number of them"));
        for (auto left = static_cast<std::uint64_t>(count); left > 0; --left) {
            const double value = read(property.type);
            if (is_axis && !is_coordinate(value))
                throw fail(bad_coordinate(property.name, fmt::format("{}", value)).what());
            if (is_corners && !is_whole(value, static_cast<double>(vertices)))
                throw fail(
                    fmt::format("found the corner {}, expected the number of one of the {} vertices, from 0; export "
                                "the shape again",
                                value, vertices));
        }
    }
    if (const auto left = body.end_element(); !left.empty())
        throw fail(fmt::format("found {} after all {} properties that the header promises; correct the line",
                               shown(left), element.properties.size()));
}

/// Reads every element that the header promises, after which nothing may be left.
template <class Body>
void check_body(const PlyHeader& header, Body body, const std::string& file) {
    for (const PlyElement& element : header.elements) {
        for (std::size_t i = 0; i < element.count; ++i) {
            check_element(element, header.count("vertex"), body, [&](const std::string& message) {
                return bad_input(
                    fmt::format("{}, {} {} of {}{}", file, element.name, i + 1, element.count, body.place()), message);
            });
        }
    }
    if (const auto left = body.end(); !left.empty())
        throw bad_input(
            file + body.place(),
            "found more data than the header promises; its numbers of elements are wrong or the file is damaged");
}

/// The header as Assimp 5.2 understands it. It loses the properties after a comment that follows an element, and takes
/// a line feed that begins binary data for part of the header, so that it reads all numbers from the wrong place; not
/// so after a carriage return.
std::string respelled_header(std::string_view content, const PlyHeader& header) {
    std::string text;
    for (Lines lines(content.substr(0, header.bytes)); lines.next();) {
        std::string_view rest = lines.line();
        const std::string_view keyword = take_word(rest);
        if (keyword != "comment" && keyword != "obj_info") text.append(lines.line()).append("\r\n");
    }
    return text;
}

}  // namespace

Checked check_ply(const std::string& content, const std::string& file) {
    const PlyHeader header = parse_ply_header(content, file);
    const std::string_view body = std::string_view(content).substr(header.bytes);
    if (header.binary)
        check_body(header, BinaryBody(body, *header.binary), file);
    else
        check_body(header, TextBody(body, header.lines), file);
    return {respelled_header(content, header).append(body), header.count("vertex"), header.count("face")};
}

}  // namespace haptogram
