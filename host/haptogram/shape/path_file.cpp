// SPDX-License-Identifier: Apache-2.0
#include "haptogram/shape/path_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "haptogram/array/millimetres.hpp"
#include "haptogram/base/depth.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/json_member.hpp"
#include "haptogram/base/text.hpp"
#include "haptogram/shape/draw.hpp"

namespace haptogram {
namespace {

using nlohmann::ordered_json;
constexpr std::string_view format_name = "haptogram-path-1";
constexpr double carrier_tolerance = 1e-3;

ordered_json to_json(const PathStep& step) {
    ordered_json json = {{"periods", step.periods}, {"foci", ordered_json::array()}};
    if (step.mark) json["mark"] = true;
    for (const Focus& focus : step.foci) {
        const Vec3 p = focus.position;
        json["foci"].push_back(
            {{"position_mm", {exact_mm(p.x), exact_mm(p.y), exact_mm(p.z)}}, {"amplitude", focus.amplitude}});
    }
    return json;
}

std::uint32_t whole_periods(const JsonMember& member) {
    const double value = member.number(1.0, 4294967295.0);
    if (value != std::floor(value)) throw member.wrong("a whole number of carrier periods");
    return static_cast<std::uint32_t>(value);
}

Focus focus_from_json(const JsonMember& json) {
    json.only({"position_mm", "amplitude"});
    Focus focus;
    const std::vector<JsonMember> position = json.at("position_mm").list();
    if (position.size() != 3) throw json.at("position_mm").wrong("three coordinates in mm");
    constexpr double farthest_mm = 1e6;
    const auto coordinate = [&](std::size_t i) { return position[i].number(-farthest_mm, farthest_mm); };
    focus.position = from_mm(coordinate(0), coordinate(1), coordinate(2));
    if (const auto amplitude = json.find("amplitude")) focus.amplitude = amplitude->number(0.0, 1.0);
    return focus;
}

/// Which field of a row is what.
struct PathColumns {
    std::array<std::size_t, 4> numbers{};  ///< time, x, y, z
    std::optional<std::size_t> intensity, mark;
    double seconds = 1.0;  ///< a unit of the time
    std::size_t width = 0;
};

PathColumns columns_of(const Fields& fields, const std::string& where) {
    PathColumns columns;
    columns.width = fields.size();
    std::array<bool, 4> found{};
    const auto expected = [&](const std::string& what) {
        return bad_input(where,
                         fmt::format("{}; expected a first row that names time_s or time_ms, x_mm, y_mm, z_mm "
                                     "and, where they are wanted, intensity (0 to 1) and mark (0 or 1), each once",
                                     what));
    };
    for (std::size_t i = 0; i < fields.size(); ++i) {
        const std::string name = lower_case(fields[i]);
        constexpr std::array<std::string_view, 4> names{"time_s", "x_mm", "y_mm", "z_mm"};
        auto place = static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
        if (name == "time_ms") {
            place = 0;
            columns.seconds = 1e-3;
        }
        std::optional<std::size_t>* const optional = name == "intensity" ? &columns.intensity
                                                     : name == "mark"    ? &columns.mark
                                                                         : nullptr;
        const bool again = place < 4 ? found.at(place) : optional != nullptr && optional->has_value();
        if ((place == 4 && optional == nullptr) || again)
            throw expected(fmt::format("found {}{}", shown(fields[i]), again ? " a second time" : ""));
        if (place == 4)
            *optional = i;
        else
            columns.numbers.at(place) = i;
        if (place < 4) found.at(place) = true;
    }
    if (std::find(found.begin(), found.end(), false) != found.end()) throw expected("a column is missing");
    return columns;
}

}  // namespace

std::string to_json_text(const Path& path, double carrier_hz) {
    ordered_json json = {{"format", format_name}, {"carrier_hz", carrier_hz}, {"steps", ordered_json::array()}};
    for (const PathStep& step : path.steps) json["steps"].push_back(to_json(step));
    if (!path.modulation.samples.empty())
        json["modulation"] = {{"periods_a_sample", path.modulation.periods_a_sample},
                              {"samples", path.modulation.samples}};
    return json.dump(1) + "\n";
}

Path path_from_json(std::string_view text, const std::string& where, double carrier_hz) {
    const ordered_json document = parse_json(text, where);
    const JsonMember json(document, where);
    json.only({"format", "carrier_hz", "steps", "modulation"});
    if (json.at("format").text() != format_name)
        throw json.at("format").wrong(fmt::format("\"{}\" for this version", format_name));
    const double counted_hz = json.at("carrier_hz").number(1.0, 1e9);
    if (std::abs(counted_hz / carrier_hz - 1.0) > carrier_tolerance)
        throw bad_input(where, fmt::format("it counts in periods of a {} Hz carrier, but the carrier is {:.6g} Hz; "
                                           "write the path for this array",
                                           counted_hz, carrier_hz));
    Path path;
    for (const JsonMember& step : json.at("steps").list()) {
        step.only({"periods", "foci", "mark"});
        PathStep& added = path.steps.emplace_back();
        added.periods = whole_periods(step.at("periods"));
        if (const auto mark = step.find("mark")) {
            if (!mark->value().is_boolean()) throw mark->wrong("true or false");
            added.mark = mark->value().get<bool>();
        }
        for (const JsonMember& focus : step.at("foci").list()) added.foci.push_back(focus_from_json(focus));
    }
    if (path.steps.empty()) throw json.at("steps").wrong("a list of at least one step");
    if (const auto modulation = json.find("modulation")) {
        modulation->only({"periods_a_sample", "samples"});
        path.modulation.periods_a_sample = whole_periods(modulation->at("periods_a_sample"));
        for (const JsonMember& sample : modulation->at("samples").list())
            path.modulation.samples.push_back(sample.number(0.0, 1.0));
    }
    return path;
}

Path path_from_csv(std::string_view text, const std::string& where, double carrier_hz) {
    std::optional<PathColumns> columns;
    char separator = ',';
    Fields fields;
    std::vector<Stretch> stretches;
    std::optional<double> last_s;
    for (Lines lines(without_byte_order_mark(text)); lines.next();) {
        std::string_view rest = lines.line();
        if (const auto word = take_word(rest); word.empty() || word.starts_with('#')) continue;
        const std::string line = at_line(where, lines.number());
        if (!columns) separator = separator_of(lines.line());
        split_at(separator, lines.line(), fields);
        if (!columns) {
            columns = columns_of(fields, line);
            continue;
        }
        if (fields.size() != columns->width)
            throw bad_input(
                line, fmt::format("found {} columns, expected {} as in the first row", fields.size(), columns->width));
        const auto number = [&](std::size_t field) {
            const auto value = parse_number(fields[field]);
            if (!value || !is_coordinate(*value)) throw bad_coordinate(line, fields[field]);
            return *value;
        };
        const auto& at = columns->numbers;
        const auto time = parse_number(fields[at[0]]);
        if (!time || !std::isfinite(*time)) throw bad_coordinate(line, fields[at[0]]);
        const double time_s = *time * columns->seconds;
        const double amplitude = columns->intensity ? number(*columns->intensity) : 1.0;
        if (!(amplitude >= 0.0 && amplitude <= 1.0))
            throw bad_input(line, fmt::format("an intensity of {}; expected 0 to 1", amplitude));
        constexpr double year_5000_s = 1e11;  // after 1970
        if (std::abs(time_s) >= year_5000_s)
            throw bad_input(line,
                            fmt::format("found the time {}, expected {}; milliseconds or microseconds since 1970 "
                                        "are so large: name the column time_ms, or convert it",
                                        shown(fields[at[0]]), columns->seconds == 1.0 ? "seconds" : "milliseconds"));
        if (last_s) {
            const double periods = (time_s - *last_s) * carrier_hz;
            if (!(periods >= 1.0 - 1e-6))
                throw bad_input(line, fmt::format("{:.6g} s after the row before it; expected at least a carrier "
                                                  "period, {:.6g} s",
                                                  time_s - *last_s, 1.0 / carrier_hz));
            stretches.back().periods = periods;
        }
        last_s = time_s;
        Stretch& added = stretches.emplace_back();
        const double mark = columns->mark ? number(*columns->mark) : 0.0;
        if (mark != 0.0 && mark != 1.0) throw bad_input(line, fmt::format("a mark of {}; expected 0 or 1", mark));
        added.mark = mark != 0.0;
        if (amplitude > 0.0) added.foci = {{from_mm(number(at[1]), number(at[2]), number(at[3])), amplitude}};
    }
    if (stretches.size() < 2)
        throw bad_input(where, fmt::format("found {} rows of a focus, expected at least two, whose times tell how long "
                                           "they last",
                                           stretches.size()));
    stretches.back().periods = stretches[stretches.size() - 2].periods;
    return path_of(stretches);
}

bool is_path_json(std::string_view text) {
    if (!is_shallow(text)) return false;
    const ordered_json json = ordered_json::parse(text, nullptr, false);
    return json.is_object() && json.value("format", ordered_json()) == format_name;
}

bool is_path_csv(std::string_view text) {
    Fields fields;
    for (Lines lines(without_byte_order_mark(text)); lines.next();) {
        std::string_view rest = lines.line();
        if (const auto word = take_word(rest); word.empty() || word.starts_with('#')) continue;
        split_at(separator_of(lines.line()), lines.line(), fields);
        return std::any_of(fields.begin(), fields.end(), [](std::string_view field) {
            return lower_case(field) == "t" || lower_case(field).starts_with("time");
        });
    }
    return false;
}

Path path_of_file(std::string_view text, const std::string& name, double carrier_hz) {
    const std::string ending = ending_of(name);
    if (ending == ".json") return path_from_json(text, name, carrier_hz);
    if (ending == ".csv") return path_from_csv(text, name, carrier_hz);
    throw bad_input(name, "the name of a path ends in .json, .csv or .adaptics; rename or convert it");
}

}  // namespace haptogram
