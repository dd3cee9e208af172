// SPDX-License-Identifier: Apache-2.0
#include "haptogram/hand/open.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <variant>

#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/hand/mounting.hpp"
#include "haptogram/hand/synthetic.hpp"
#include "haptogram/shape/import.hpp"
#include "haptogram/shape/place.hpp"
#include "haptogram/verbs/compile.hpp"
#include "haptogram/verbs/iso_surface.hpp"

namespace haptogram {
namespace {

/// The mesh of a file at its place.
Mesh mesh_of(const ObjectSource& source, const FileReader& read) {
    if (!names_mesh(source))
        throw bad_argument("object", fmt::format("found \"{}\", expected {} or a mesh file", source.name,
                                                 fmt::join(object_kinds(), ", ")));
    if (source.height_m) throw bad_argument("height", "is of built-in objects; a mesh is scaled by its size");
    const double metres = metres_per_unit(source.unit);
    Placement placement;
    placement.size_m = source.size_m;
    placement.rotate_deg = {source.angles_deg.x, source.angles_deg.y, source.angles_deg.z};
    placement.center = source.centre;
    const ShapeFormat format = shape_format(source.name);
    Shape shape = placed_at(load_shape(read ? read(source.name) : read_file(source.name), format, source.name, metres),
                            placement);
    if (shape.pieces.size() != 1 || !std::holds_alternative<Mesh>(shape.pieces.front()))
        throw bad_input(source.name, "it has points without faces, and so no volume; give a closed mesh");
    if (const std::string& flaw = std::get<Mesh>(shape.pieces.front()).flaw; !flaw.empty())
        throw bad_input(source.name, flaw);
    return std::get<Mesh>(std::move(shape.pieces.front()));
}

/// Points from low to high, one beyond at either end.
std::vector<double> points_over(double low, double high, double step) {
    std::vector<double> points;
    const auto count = static_cast<int>(std::ceil((high - low) / step));
    for (int i = -1; i <= count + 1; ++i) points.push_back(low + i * step);
    return points;
}

}  // namespace

TouchObject open_object(const ObjectSource& source, const FileReader& read) {
    if (is_built_in(source)) {
        ObjectMeasures measures;
        measures.size = source.size_m.value_or(measures.size);
        measures.height = source.height_m.value_or(measures.size);
        measures.centre = source.centre;
        measures.angles_deg = source.angles_deg;
        return built_in_object(source.name, measures);
    }
    const Mesh mesh = mesh_of(source, read);
    try {
        return mesh_object(source.name, mesh.vertices, mesh.triangles);
    } catch (const Error& error) {
        throw Error(error.code(), source.name, error.message());
    }
}

Mesh surface_of(const ObjectSource& source, const FileReader& read) {
    if (!is_built_in(source)) return mesh_of(source, read);
    constexpr double cells = 48.0;
    const TouchObject object = open_object(source);
    const Vec3 extent = object.high - object.low;
    const double step = std::max({extent.x, extent.y, extent.z}) / cells;
    Field field;
    Grid& grid = field.region.grid;
    grid.x = points_over(object.low.x, object.high.x, step);
    grid.y = points_over(object.low.y, object.high.y, step);
    grid.z = points_over(object.low.z, object.high.z, step);
    std::vector<float>& depths = field.parts.emplace_back();
    for (std::size_t i = 0; i < grid.size(); ++i)
        depths.push_back(static_cast<float>(-object.solid.distance(grid.point(i))));
    Mesh mesh;
    for (const std::array<Vec3, 3>& triangle : iso_surface(field, 0.0).triangles) {
        const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
        mesh.vertices.insert(mesh.vertices.end(), triangle.begin(), triangle.end());
        mesh.triangles.push_back({first, first + 1, first + 2});
    }
    return mesh;
}

HandRecording open_hands(const std::string& name, const std::string& model, double rate_hz, const FileReader& read) {
    if (!name.starts_with(synthetic_prefix)) {
        const auto [file, mounting] = without_mounting(name);
        HandRecording recording = load_hands(file, model, rate_hz, read);
        if (mounting.empty()) return recording;
        const Pose pose = mounting_from_toml(read ? read(mounting) : read_file(mounting), mounting);
        for (HandFrame& frame : recording.frames) frame = mounted(std::move(frame), pose);
        return recording;
    }
    const std::string text = name.substr(synthetic_prefix.size());
    const std::size_t colon = std::min(text.find(':'), text.size());
    const HandScript script = hand_script(text.substr(0, colon));
    double height_mm = 200.0;
    if (colon < text.size()) {
        const char* const begin = text.data() + colon + 1;
        const char* const end = text.data() + text.size();
        const auto [next, error] = std::from_chars(begin, end, height_mm);
        if (error != std::errc() || next != end || !(height_mm > 0.0 && height_mm < 1e4))
            throw bad_argument("hand",
                               fmt::format("the height in mm after {} is \"{}\"; expected a positive number",
                                           name.substr(0, synthetic_prefix.size() + colon), std::string(begin, end)));
    }
    constexpr double frames_hz = 100.0;
    HandRecording recording;
    const auto count = static_cast<std::size_t>(std::lround(seconds_of(script) * frames_hz));
    for (std::size_t i = 0; i < count; ++i) {
        const double time_s = static_cast<double>(i) / frames_hz;
        recording.frames.push_back({time_s, {synthetic_hand(script, time_s, height_mm * millimetre)}});
    }
    return recording;
}

}  // namespace haptogram
