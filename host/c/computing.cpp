// SPDX-License-Identifier: Apache-2.0
// The part of the C interface that computes on its caller's arrays of numbers.
#include <fmt/format.h>

#include <cmath>
#include <complex>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "haptogram/acoustics/field.hpp"
#include "haptogram/array/rig.hpp"
#include "haptogram/format/core.hpp"
#include "haptogram/solve/solver.hpp"
#include "haptogram/verbs/analyze.hpp"
#include "haptogram/verbs/field.hpp"
#include "haptogram/verbs/level.hpp"
#include "haptogram/verbs/source.hpp"
#include "inside.hpp"

using namespace haptogram::c;
using haptogram::bad_argument;

struct haptogram_array {
    haptogram::Array array;
    std::string about;
};

struct haptogram_result {
    std::string about;
    const void* numbers = nullptr;
    std::shared_ptr<const void> kept{};       ///< what the numbers are in
    std::optional<haptogram::Field> field{};  ///< of a region
};

namespace haptogram::c {
namespace {

using Json = nlohmann::ordered_json;
using Complex = std::complex<double>;

/// Names of files may be no UTF-8.
std::string text_of(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

/// Numbers, which the result keeps where they are. @param shape  without one they are a row
template <class Numbers>
haptogram_result* result_of(const char* type, Numbers numbers, std::vector<std::size_t> shape = {},
                            Json about = Json::object()) {
    about["type"] = type;
    about["shape"] = shape.empty() ? std::vector{numbers.size()} : std::move(shape);
    const auto kept = std::make_shared<const Numbers>(std::move(numbers));
    return new haptogram_result{text_of(about), kept->data(), kept};
}

haptogram_result* result_of(const Json& about) { return new haptogram_result{text_of(about)}; }

haptogram_array* array_of(Array array) {
    const Json about = {{"name", array.name},
                        {"elements", array.elements.size()},
                        {"carrier_hz", array.carrier_hz},
                        {"wavelength_m", array.wavelength_m()},
                        {"transducer", array.transducer.name},
                        {"level", level_text(array.transducer)}};
    return new haptogram_array{std::move(array), text_of(about)};
}

const Array& given(const haptogram_array* array) { return required(array, "array").array; }

Vec3 place_of(const double* focus_m) { return points_of(focus_m, 1, "focus_m").front(); }

Pose posed(const double* pose) {
    const std::span<const Vec3> both = points_of(pose, 2, "pose");
    return pose_of(both[0], both[1]);
}

std::span<const Complex> drives_of(const double* numbers, std::size_t count) {
    return {reinterpret_cast<const Complex*>(&required(numbers, "drives")), count};
}

/// @throws Error{bad_argument} naming `setting` and the focus that is out of the array's reach, or so far away that its
/// lengths must have been millimetres
void require_reach(const Array& array, std::span<const Focus> foci, const std::string& setting) {
    constexpr double farthest_m = 5.0;  // nothing can be felt beyond
    const auto told = [](Vec3 p) { return fmt::format("({:g}, {:g}, {:g})", p.x, p.y, p.z); };
    for (std::size_t i = 0; i < foci.size(); ++i) {
        const Vec3 p = foci[i].position;
        const std::string where = foci.size() == 1 ? setting : fmt::format("{}[{}]", setting, i);
        if (const double away = norm(p); away > farthest_m)
            throw bad_argument(where, fmt::format("{} m is {:g} m away; lengths are metres: did you mean {}?", told(p),
                                                  away, told(0.001 * p)));
        if (const std::string why = array.unreachable(p); !why.empty())
            throw bad_argument(where, fmt::format("{} m is out of the array's reach: {}", told(p), why));
    }
}

void give_elements(Array& array, const haptogram_array_source& source) {
    array.columns = 0;
    array.elements.clear();
    for (const Vec3& p : points_of(source.positions_m, source.elements, "positions_m")) array.elements.push_back({p});
    for (std::size_t m = 0; m < array.elements.size(); ++m) {
        Element& e = array.elements[m];
        if (source.normals != nullptr) e.normal = points_of(source.normals, source.elements, "normals")[m];
        if (!is_finite(e.position))
            throw bad_argument("positions_m", fmt::format("element {} is not at a finite place", m));
        if (!(std::abs(norm(e.normal) - 1.0) < 1e-9))
            throw bad_argument(
                "normals", fmt::format("that of element {} has the length {}; divide it by that", m, norm(e.normal)));
    }
}

Timeline timeline_for(const haptogram_source& from) {
    if (from.image != nullptr) return timeline_of(from.image->bundle);
    Source source;
    if (from.file != nullptr) source.file = from.file;
    if (from.manifest != nullptr) source.manifest = from.manifest;
    if (from.pulses != nullptr) source.pulses = from.pulses;
    source.record = from.record;
    source.makers = makers();
    return open_timeline(source, until(from.cancel));
}

Excitation excitation_for(const haptogram_source& from) {
    if (from.array == nullptr) return excitation_of(timeline_for(from), from.record);
    const Focus focus{place_of(from.focus_m)};
    require_reach(given(from.array), {&focus, 1}, "focus_m");
    return excitation_of(given(from.array), focus.position);
}

Json to_json(const FocusAnalysis& f) {
    return {{"pressure_pa", f.pressure_pa},
            {"radiation_pa", f.radiation_pa},
            {"width_m", f.width_m},
            {"depth_m", f.depth_m},
            {"side_lobe", f.side_lobe},
            {"force_n", f.force_n},
            {"formation_s", f.formation.formation_s}};
}

Json to_json(Vec3 p) { return {p.x, p.y, p.z}; }

Json to_json(const ImageAnalysis& analysis) {
    Json all = Json::object();
    for (const PointAnalysis& point : analysis.points) {
        Json row = to_json(point.focus);
        row["foci_m"] = to_json(point.focus.focus);
        row["dwell_cycles"] = point.dwell_cycles;
        row["dwell_needed_cycles"] = point.focus.dwell_cycles;
        for (const auto& [name, value] : row.items()) all[name].push_back(value);
    }
    all["highest_db"] = analysis.loudness.highest_db;
    all["pressure_left_least"] = analysis.pressure_left.least;
    all["level"] = level_text(analysis.transducer);
    all["warnings"] = analysis.warnings;
    return all;
}

FieldOptions options_of(const haptogram_field& asked) {
    return {asked.threads, until(asked.cancel), asked.interpolation_error, asked.pattern_error};
}

std::vector<WeightedDrives> sequence_of(const haptogram_field& asked) {
    const std::span<const Complex> all = drives_of(asked.drives, asked.sets * asked.elements);
    std::vector<WeightedDrives> sequence;
    for (std::size_t r = 0; r < asked.sets; ++r)
        sequence.push_back(
            {asked.weights != nullptr ? asked.weights[r] : 1.0, all.subspan(r * asked.elements, asked.elements)});
    return sequence;
}

Drives one_set(const haptogram_field& asked) {
    if (asked.sets != 1) throw bad_argument("drives", fmt::format("expected one set, found {}", asked.sets));
    return drives_of(asked.drives, asked.elements);
}

haptogram_result* at_points(const Array& array, const std::string& quantity, const haptogram_field& asked) {
    static_assert(sizeof(PressureGradient) == 3 * sizeof(std::complex<float>));
    const auto points = points_of(asked.points_m, asked.points, "points_m");
    const FieldOptions options = options_of(asked);
    if (quantity == "complex") return result_of("complex64", pressure_at(array, one_set(asked), points, options));
    if (quantity == "gradient")
        return result_of("complex64", pressure_gradient_at(array, one_set(asked), points, options), {points.size(), 3});
    if (quantity == "mean_square")
        return result_of("float32", mean_square_pressure_at(array, sequence_of(asked), points, options));
    throw bad_argument("quantity", fmt::format("expected complex, gradient or mean_square, found '{}'", quantity));
}

/// z × y × x.
std::vector<std::size_t> shape_of(const Grid& grid) { return {grid.z.size(), grid.y.size(), grid.x.size()}; }

haptogram_result* on_axes(const Array& array, const std::string& quantity, const haptogram_field& asked) {
    const auto axis = [](const double* numbers, std::size_t count, const char* name) {
        const double* const first = &required(numbers, name);
        return std::vector<double>(first, first + count);
    };
    const Grid grid{axis(asked.x_m, asked.x_count, "x_m"), axis(asked.y_m, asked.y_count, "y_m"),
                    axis(asked.z_m, asked.z_count, "z_m")};
    if (quantity == "workspace") return result_of("float32", workspace(array, grid), shape_of(grid));
    if (quantity == "complex") {
        PressureField found = pressure_field(array, one_set(asked), grid, options_of(asked));
        return result_of(
            "complex64", std::move(found.values), shape_of(grid),
            {{"method", name_of(found.method)}, {"error", found.error}, {"pattern_error", found.pattern_error}});
    }
    if (quantity == "mean_square") {
        MeanSquareField found = mean_square_field(array, sequence_of(asked), grid, options_of(asked));
        return result_of("float32", std::move(found.values), shape_of(grid),
                         {{"method", name_of(found.method)}, {"error", found.error}});
    }
    throw bad_argument("quantity", fmt::format("expected complex, mean_square or workspace, found '{}'", quantity));
}

std::optional<std::pair<double, double>> range_of(const double* both, std::size_t count, const char* name) {
    if (both == nullptr) return {};
    if (count != 2) throw bad_argument(name, fmt::format("expected from and to, found {} numbers", count));
    return {{both[0], both[1]}};
}

haptogram_result* in_region(const Array& array, const std::string& quantity, const haptogram_field& asked) {
    const Reach reach{asked.extent_m, asked.step_m, range_of(asked.x_m, asked.x_count, "x_m"),
                      range_of(asked.y_m, asked.y_count, "y_m"), range_of(asked.z_m, asked.z_count, "z_m")};
    const Region region =
        parse_region(asked.region_name != nullptr ? asked.region_name : "region", asked.region, reach);
    const Quantity wanted = quantity_of(quantity);
    Excitation played{array, {}, {}, {}, "given drives"};
    for (const WeightedDrives& set : sequence_of(asked)) {
        played.drives.emplace_back(set.drives.begin(), set.drives.end());
        played.weights.push_back(set.weight);
    }
    Field found = field(played, region, wanted, asked.threads, until(asked.cancel));
    const Grid& grid = found.region.grid;
    Json about = {{"method", name_of(found.method)},
                  {"error", found.error},
                  {"quantity", found.quantity},
                  {"x_m", grid.x},
                  {"y_m", grid.y},
                  {"z_m", grid.z}};
    if (const auto& pose = found.region.pose)
        about["pose"] = {to_json(pose->origin), to_json(pose->x), to_json(pose->y), to_json(pose->z)};
    std::vector<std::complex<float>> both;
    if (found.parts.size() == 2)
        for (std::size_t i = 0; i < grid.size(); ++i) both.emplace_back(found.parts[0][i], found.parts[1][i]);
    const char* const type = both.empty() ? "float32" : "complex64";
    std::unique_ptr<haptogram_result> result(result_of(type, std::move(both), shape_of(grid), std::move(about)));
    result->field = std::move(found);
    if (result->field->parts.size() == 1) result->numbers = result->field->parts.front().data();
    return result.release();
}

std::span<const Focus> foci_of(const haptogram_foci& asked, std::vector<Focus>& foci) {
    for (std::size_t i = 0; i < asked.count; ++i) foci.push_back(focus_of((&required(asked.foci, "foci"))[i]));
    return foci;
}

Level level_of(const haptogram_foci& asked) {
    const std::string name = asked.level != nullptr ? asked.level : "reachable";
    if (name == "reachable") return Level::reachable;
    if (name == "pressure") return Level::pressure;
    throw bad_argument("level", fmt::format("must be reachable or pressure, found '{}'", name));
}

}  // namespace
}  // namespace haptogram::c

extern "C" {

size_t haptogram_result_json(const haptogram_result* result, char* to, size_t room) {
    return result == nullptr ? 0 : copy(result->about, to, room);
}
const void* haptogram_result_numbers(const haptogram_result* result) {
    return result == nullptr ? nullptr : result->numbers;
}
void haptogram_free_result(haptogram_result* result) { delete result; }

size_t haptogram_array_names(char* to, size_t room) {
    std::string names;
    guarded([&] { names = fmt::format("{}\n", fmt::join(haptogram::shipped_arrays(), "\n")); });
    return copy(names, to, room);
}

haptogram_code haptogram_make_array(const haptogram_array_source* source, haptogram_array** array) {
    return guarded([&] {
        const haptogram_array_source from = known_part(source, "source");
        required(array, "array") = nullptr;
        haptogram::Array made =
            from.like != nullptr ? given(from.like) : haptogram::find_array(required_text(from.name, "name"));
        if (from.transducer != nullptr) made.transducer = haptogram::find_transducer(from.transducer);
        if (from.positions_m != nullptr) give_elements(made, from);
        if (from.seen_from != nullptr) made = seen_from(std::move(made), posed(from.seen_from));
        *array = array_of(std::move(made));
    });
}

haptogram_code haptogram_join(const haptogram_posed_array* arrays, size_t count, const char* name,
                              haptogram_array** joined) {
    return guarded([&] {
        required(joined, "joined") = nullptr;
        haptogram::Rig rig{required_text(name, "name"), {}};
        for (std::size_t i = 0; i < count; ++i) {
            const haptogram_posed_array& one = (&required(arrays, "arrays"))[i];
            rig.arrays.push_back({given(one.array), posed(one.pose)});
        }
        *joined = array_of(haptogram::joined(rig));
    });
}

size_t haptogram_array_json(const haptogram_array* array, char* to, size_t room) {
    return array == nullptr ? 0 : copy(array->about, to, room);
}
const void* haptogram_array_elements(const haptogram_array* array) {
    static_assert(sizeof(haptogram::Element) == 9 * sizeof(double));
    return array == nullptr ? nullptr : array->array.elements.data();
}
size_t haptogram_unreachable(const haptogram_array* array, const double* focus_m, char* to, size_t room) {
    std::string why;
    guarded([&] { why = given(array).unreachable(place_of(focus_m)); });
    return copy(why, to, room);
}
void haptogram_free_array(haptogram_array* array) { delete array; }

size_t haptogram_image_foci(const haptogram_image* image, double* to_m, size_t room) {
    if (image == nullptr) return 0;
    const std::vector<haptogram::Vec3> foci = image->bundle.manifest.points();
    if (to_m != nullptr) std::memcpy(to_m, foci.data(), std::min(room, 3 * foci.size()) * sizeof(double));
    return 3 * foci.size();
}

haptogram_code haptogram_drives(const haptogram_source* source, haptogram_array** array, haptogram_result** drives) {
    return guarded([&] {
        const haptogram_source from = known_part(source, "source");
        required(array, "array") = nullptr;
        required(drives, "drives") = nullptr;
        haptogram::Excitation played = excitation_for(from);
        std::vector<std::complex<double>> all;
        for (const auto& set : played.drives) all.insert(all.end(), set.begin(), set.end());
        *drives = result_of("complex128", std::move(all), {played.drives.size(), played.array.elements.size()},
                            {{"weights", played.weights}});
        *array = array_of(std::move(played.array));
    });
}

haptogram_code haptogram_analyze(const haptogram_source* source, double least_force_n, haptogram_result** analysis) {
    return guarded([&] {
        const haptogram_source from = known_part(source, "source");
        required(analysis, "analysis") = nullptr;
        *analysis = result_of(to_json(haptogram::analyze(timeline_for(from), least_force_n, until(from.cancel))));
    });
}

haptogram_code haptogram_analyze_focus(const haptogram_array* array, const double* drives, size_t elements,
                                       const double* focus_m, const char* core, haptogram_result** analysis) {
    return guarded([&] {
        required(analysis, "analysis") = nullptr;
        const haptogram::Focus focus{place_of(focus_m)};
        require_reach(given(array), {&focus, 1}, "focus_m");
        if (elements != given(array).elements.size())
            throw bad_argument("drives", fmt::format("found {} for {} elements; give one each", elements,
                                                     given(array).elements.size()));
        *analysis =
            result_of(to_json(haptogram::analyze(given(array), haptogram::find_core(required_text(core, "core")),
                                                 drives_of(drives, elements), focus.position)));
    });
}

haptogram_code haptogram_compute_field(const haptogram_field* field, haptogram_result** values) {
    return guarded([&] {
        const haptogram_field asked = known_part(field, "field");
        required(values, "values") = nullptr;
        const auto compute = asked.region != nullptr ? in_region : asked.points_m != nullptr ? at_points : on_axes;
        *values = compute(given(asked.array), required_text(asked.quantity, "quantity"), asked);
    });
}

haptogram_code haptogram_field_file(const haptogram_result* field, const char* format, haptogram_result** bytes) {
    return guarded([&] {
        required(bytes, "bytes") = nullptr;
        const std::string wanted = required_text(format, "format");
        if (!required(field, "field").field) throw bad_argument("field", "is not of a region");
        if (wanted != "npy" && wanted != "csv")
            throw bad_argument("format", fmt::format("expected npy or csv, found '{}'", wanted));
        *bytes = result_of("uint8", wanted == "npy" ? to_npy(*field->field) : to_csv(*field->field));
    });
}

haptogram_code haptogram_solve_foci(const haptogram_foci* foci, haptogram_result** drives) {
    return guarded([&] {
        const haptogram_foci asked = known_part(foci, "foci");
        required(drives, "drives") = nullptr;
        std::vector<haptogram::Focus> wanted;
        require_reach(given(asked.array), foci_of(asked, wanted), "foci_m");
        haptogram::SolveOptions options;
        if (asked.method != nullptr) options.method = haptogram::method_of(asked.method, "method");
        options.amplitudes = asked.vary_amplitudes != 0;
        options.level = level_of(asked);
        if (asked.rounds != 0) options.rounds = static_cast<unsigned>(std::max(0, asked.rounds));
        std::span<const std::complex<double>> start;
        if (asked.drives != nullptr) start = drives_of(asked.drives, asked.elements);
        *drives = result_of("complex128", solve(given(asked.array), wanted, options, start));
    });
}

haptogram_code haptogram_quality(const haptogram_foci* foci, haptogram_result** quality) {
    return guarded([&] {
        const haptogram_foci asked = known_part(foci, "foci");
        required(quality, "quality") = nullptr;
        std::vector<haptogram::Focus> wanted;
        const haptogram::Quality found = quality_of(given(asked.array), foci_of(asked, wanted),
                                                    drives_of(asked.drives, asked.elements), level_of(asked));
        *quality = result_of({{"pressure_pa", found.pressure_pa},
                              {"spread", found.spread},
                              {"least_over_mean", found.least_over_mean},
                              {"efficiency", found.efficiency},
                              {"null_share", found.null_share ? Json(*found.null_share) : Json()}});
    });
}

}  // extern "C"
