// SPDX-License-Identifier: Apache-2.0
#include "field_request.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <optional>

#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/process.hpp"
#include "haptogram/verbs/field.hpp"
#include "served.hpp"

namespace haptogram::studio {
namespace {

template <class Number>
std::optional<Number> number_of(const std::string& text) {
    Number value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc() && end == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

double millimetres_of(const char* name, const std::string& text) {
    const std::optional<double> value = number_of<double>(text);
    if (!value || !(*value > 0.0) || !std::isfinite(*value))
        throw bad_argument(name, fmt::format("found '{}', expected a length in mm above 0", text));
    return *value * millimetre;
}

double decibels_of(const char* name, const std::string& text) {
    const std::optional<double> value = number_of<double>(text);
    if (!value || !(*value > 0.0) || !std::isfinite(*value))
        throw bad_argument(name, fmt::format("found '{}', expected decibels above 0", text));
    return *value;
}

std::uint32_t record_of(const std::string& text, std::size_t records) {
    const std::optional<std::uint32_t> value = number_of<std::uint32_t>(text);
    if (!value || *value < 1 || *value > records)
        throw bad_argument("record", fmt::format("found '{}', expected a record of the scene, 1 to {}", text, records));
    return *value;
}

}  // namespace

FieldRequest field_request(std::string_view query, Scenes& scenes) {
    const auto value = [&](const char* name) {
        const std::optional<std::string> found = query_value(query, name);
        if (!found) throw bad_argument(name, "is missing in the query");
        return *found;
    };
    FieldRequest request;
    request.scene = scenes.find(value("scene"));
    const Excitation& excitation = request.scene->excitation;
    if (const auto record = query_value(query, "record"))
        request.record = record_of(*record, request.scene->compiled.bundle.manifest.records.size());
    Reach reach;
    reach.step_m = millimetres_of("step", value("step"));
    for (const auto& [axis, range] : {std::pair{"x", &reach.x}, {"y", &reach.y}, {"z", &reach.z}})
        if (const auto given = query_value(query, axis)) *range = parse_range(axis, *given);
    const std::string as = value("as");
    if (as != "png" && as != "csv" && as != "npy" && as != "vti" && as != "stl")
        throw bad_argument("as", fmt::format("found '{}', expected png, csv, npy, vti or stl", as));
    request.region = as == "stl" ? parse_region("volume", "xyz", reach) : parse_region("plane", value("plane"), reach);
    request.quantity = quantity_of(value("quantity"));
    if (as == "stl") request.below_db = decibels_of("below", value("below"));
    request.name = "field." + as;
    check_field_path(request.name, request.region, request.quantity);
    if (as != "stl" && request.region.axes.size() != 2)
        throw bad_argument("plane", "the studio gives planes, such as xy@z=130");
    const double terms = static_cast<double>(request.region.grid.size() * excitation.array.elements.size() *
                                             (request.record == 0 ? excitation.drives.size() : 1));
    if (terms > most_slice_terms)
        throw bad_argument("step",
                           "asks for more points than the studio computes; take a larger one, or 'haptogram field'");
    return request;
}

std::string field_file(const FieldRequest& request, const Progress& progress) {
    const Scene& scene = *request.scene;
    const Excitation played =
        request.record == 0 ? scene.excitation : excitation_of(timeline_of(scene.compiled.bundle), request.record);
    const TemporaryFolder folder;
    write_field((folder.path() / request.name).string(), field(played, request.region, request.quantity, 1, progress),
                request.below_db);
    return read_file(folder.path() / request.name);
}

}  // namespace haptogram::studio
