// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <utility>

#include "haptogram/base/text.hpp"
#include "haptogram/shape/formats.hpp"

namespace haptogram {
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

}  // namespace haptogram
