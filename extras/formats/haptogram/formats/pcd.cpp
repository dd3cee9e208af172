// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "haptogram/formats/parts.hpp"

namespace haptogram::formats {
namespace {

struct Field {
    std::string name;
    std::size_t size = 4, count = 1;
    char type = 'F';
};
using Decode = double (*)(const char*);

/// @return nothing for a type that PCD does not have
Decode decoder_of(const Field& field) {
    const std::string kind = field.type + std::to_string(field.size);
    constexpr std::array<std::pair<std::string_view, Decode>, 8> known{{{"F4", number_at<float>},
                                                                        {"F8", number_at<double>},
                                                                        {"I1", number_at<std::int8_t>},
                                                                        {"I2", number_at<std::int16_t>},
                                                                        {"I4", number_at<std::int32_t>},
                                                                        {"U1", number_at<std::uint8_t>},
                                                                        {"U2", number_at<std::uint16_t>},
                                                                        {"U4", number_at<std::uint32_t>}}};
    const auto found = std::ranges::find(known, kind, &std::pair<std::string_view, Decode>::first);
    return found == known.end() || field.count != 1 ? nullptr : found->second;
}

struct Header {
    std::vector<Field> fields;
    std::array<std::size_t, 3> axes{};  ///< which fields are x, y and z
    std::size_t points = 0;
    std::string data;

    [[nodiscard]] std::size_t bytes_before(std::size_t field) const {
        std::size_t sum = 0;
        for (std::size_t i = 0; i < field; ++i) sum += fields[i].size * fields[i].count;
        return sum;
    }
};

class PcdReader {
public:
    explicit PcdReader(const ShapeFile& file) : file_(file), lines_(file.content) { read_header(); }

    Polygons read() {
        if (header_.data == "ascii")
            read_text();
        else
            read_bytes();
        return std::move(cloud_);
    }

private:
    [[nodiscard]] std::string place() const { return at_line(file_.name, lines_.number()); }

    /// Moves to the next line that has words.
    bool next() {
        while (lines_.next()) {
            rest_ = lines_.line().substr(0, lines_.line().find('#'));
            if (rest_.find_first_not_of(" \t\r") != std::string_view::npos) return true;
        }
        return false;
    }

    std::size_t whole(std::size_t least, const std::string& what) {
        const std::string_view word = take_word(rest_);
        const double value = parse_number(word).value_or(-1.0);
        constexpr double most = 4294967295.0;
        if (!(value >= static_cast<double>(least) && value <= most) || value != std::floor(value))
            throw bad_input(place(), fmt::format("found {}, expected {}; export the cloud again",
                                                 word.empty() ? "the end of the line" : shown(word), what));
        return static_cast<std::size_t>(value);
    }

    void read_header() {
        std::size_t width = 0, height = 1;
        std::optional<std::size_t> points;
        while (header_.data.empty()) {
            if (!next())
                throw bad_input(file_.name, "the PCD header has no line DATA; the file is cut short or damaged");
            const std::string_view key = take_word(rest_);
            if (key == "FIELDS" || key == "COLUMNS") {
                header_.fields.clear();
                for (std::string_view word = take_word(rest_); !word.empty(); word = take_word(rest_))
                    header_.fields.push_back({std::string(word)});
            } else if (key == "SIZE") {
                for (Field& field : header_.fields) field.size = whole(1, "the bytes of each of its FIELDS");
            } else if (key == "COUNT") {
                for (Field& field : header_.fields) field.count = whole(1, "how many each of its FIELDS has");
            } else if (key == "TYPE") {
                for (Field& field : header_.fields) {
                    const std::string_view word = take_word(rest_);
                    if (word != "F" && word != "I" && word != "U")
                        throw bad_input(place(),
                                        fmt::format("found {}, expected F, I or U for each of its FIELDS; export the "
                                                    "cloud again",
                                                    word.empty() ? "the end of the line" : shown(word)));
                    field.type = word[0];
                }
            } else if (key == "WIDTH" || key == "HEIGHT") {
                (key == "WIDTH" ? width : height) = whole(0, "a whole number");
            } else if (key == "POINTS") {
                points = whole(0, "a number of points");
            } else if (key == "DATA") {
                header_.data = take_word(rest_);
                if (header_.data != "ascii" && header_.data != "binary" && header_.data != "binary_compressed")
                    throw bad_input(place(), fmt::format("found {}, expected ascii, binary or binary_compressed",
                                                         shown(header_.data)));
            } else if (key != "VERSION" && key != "VIEWPOINT") {
                throw bad_input(place(), fmt::format("found {}, expected a line of a PCD header, such as FIELDS or "
                                                     "DATA; export the cloud again",
                                                     shown(key)));
            }
        }
        if (points && *points != width * height)
            throw bad_input(file_.name, fmt::format("its header has {} x {} points and says {}; export the cloud again",
                                                    width, height, *points));
        header_.points = width * height;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::string name(1, "xyz"[axis]);
            if (std::ranges::count(header_.fields, name, &Field::name) != 1)
                throw bad_input(file_.name,
                                fmt::format("its FIELDS have not one {}; export the cloud with x, y and z", name));
            const auto found = std::ranges::find(header_.fields, name, &Field::name);
            if (decoder_of(*found) == nullptr)
                throw bad_input(file_.name,
                                fmt::format("its field {} is {} numbers {} of {} bytes, expected one float of 4 or 8 "
                                            "bytes, or a whole number of 1, 2 or 4; export the cloud again",
                                            name, found->count, found->type, found->size));
            header_.axes.at(axis) = static_cast<std::size_t>(found - header_.fields.begin());
        }
    }

    template <class Place>
    void add(const std::array<double, 3>& point, Place where) {
        if (std::ranges::all_of(point, [](double x) { return std::isnan(x); })) {
            ++cloud_.unseen;
            return;
        }
        for (const double coordinate : point)
            if (!is_coordinate(coordinate)) throw bad_coordinate(where(), fmt::format("{}", coordinate));
        cloud_.vertices.push_back({point[0], point[1], point[2]});
    }

    void read_text() {
        std::vector<double> row;
        for (std::size_t i = 0; i < header_.points; ++i) {
            if (!next())
                throw bad_input(file_.name,
                                fmt::format("found {} points, expected {}; the file is cut short", i, header_.points));
            row.clear();
            std::array<double, 3> point{};
            for (std::size_t k = 0; k < header_.fields.size(); ++k)
                for (std::size_t left = header_.fields[k].count; left > 0; --left) {
                    const std::string_view word = take_word(rest_);
                    const auto value = parse_number(word);
                    if (!value) throw bad_coordinate(place(), word);
                    if (const auto axis = std::ranges::find(header_.axes, k); axis != header_.axes.end())
                        point.at(static_cast<std::size_t>(axis - header_.axes.begin())) = *value;
                }
            if (const std::string_view more = take_word(rest_); !more.empty())
                throw bad_input(
                    place(), fmt::format("found {} behind what its FIELDS have; export the cloud again", shown(more)));
            add(point, [this] { return place(); });
        }
        if (next())
            throw bad_input(place(), fmt::format("found {} behind all {} points of its header; the header is wrong or "
                                                 "the file damaged",
                                                 shown(lines_.line()), header_.points));
    }

    /// What Marc Lehmann's LibLZF has packed: bytes as they are, or copies of what came before.
    /// @return nothing unless it comes to `size` bytes
    static std::optional<std::string> unpacked(std::string_view packed, std::size_t size) {
        std::string out;
        std::size_t at = 0;
        const auto take = [&] {
            return std::size_t{at < packed.size() ? static_cast<std::uint8_t>(packed[at++]) : 0U};
        };
        while (at < packed.size()) {
            const std::size_t control = take();
            if (control < 32) {
                if (control + 1 > packed.size() - at) return {};
                out.append(packed, at, control + 1);
                at += control + 1;
            } else {
                std::size_t length = (control >> 5U) + 2;
                if (length == 9) length += take();
                const std::size_t back = ((control & 31U) << 8U) + take() + 1;
                if (back > out.size()) return {};
                for (; length > 0; --length) out.push_back(out[out.size() - back]);
            }
            if (out.size() > size) return {};
        }
        return out.size() == size ? std::optional(std::move(out)) : std::nullopt;
    }

    void read_bytes() {
        const std::size_t each = header_.bytes_before(header_.fields.size()), points = header_.points;
        const std::size_t size = points == 0 || each <= SIZE_MAX / points ? each * points : SIZE_MAX;
        std::string_view body = lines_.rest();
        std::string whole;
        const bool packed = header_.data == "binary_compressed";
        if (packed) {
            constexpr std::size_t sizes = 8;
            std::optional<std::string> made;
            if (body.size() >= sizes && number_at<std::uint32_t>(&body[4]) == static_cast<double>(size)) {
                const auto bytes = static_cast<std::size_t>(number_at<std::uint32_t>(body.data()));
                if (bytes <= body.size() - sizes) made = unpacked(body.substr(sizes, bytes), size);
            }
            if (!made)
                throw bad_input(file_.name,
                                fmt::format("its compressed data do not come to the {} bytes of {} points; the file is "
                                            "cut short or damaged",
                                            size, points));
            whole = *std::move(made);
            body = whole;
        }
        if (body.size() != size)
            throw bad_input(file_.name,
                            fmt::format("found {} bytes of data, expected {} for {} points; the file is cut "
                                        "short or damaged",
                                        body.size(), size, points));
        cloud_.vertices.reserve(points);
        for (std::size_t i = 0; i < points; ++i) {
            std::array<double, 3> point{};
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const Field& field = header_.fields[header_.axes.at(axis)];
                const std::size_t before = header_.bytes_before(header_.axes.at(axis));
                // Compressed data have one field of all points after the other.
                point.at(axis) =
                    decoder_of(field)(&body[packed ? before * points + i * field.size : i * each + before]);
            }
            add(point, [&] { return fmt::format("{}, point {}", file_.name, i + 1); });
        }
    }

    const ShapeFile& file_;
    Lines lines_;
    std::string_view rest_;  ///< of the line
    Header header_;
    Polygons cloud_;
};

}  // namespace

Polygons read_pcd(const ShapeFile& file) { return PcdReader(file).read(); }

}  // namespace haptogram::formats
