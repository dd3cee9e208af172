// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/field.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <thread>
#include <utility>

#include "haptogram/acoustics/quantities.hpp"
#include "haptogram/array/rig.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/picture.hpp"
#include "haptogram/verbs/focus_analysis.hpp"
#include "haptogram/verbs/iso_surface.hpp"

namespace haptogram {
namespace {

/// Rms particle velocity, m/s, by Euler's equation: |∇p|/(ωρ√2).
/// @param array  as the grid's own coordinates have it
std::vector<float> rms_velocity(const Array& array, const Excitation& excitation, const Grid& grid,
                                const FieldOptions& options) {
    double total = 0.0;
    for (const double weight : excitation.weights) total += weight;
    std::vector<Vec3> points;
    points.reserve(grid.size());
    for (std::size_t i = 0; i < grid.size(); ++i) points.push_back(grid.point(i));
    std::vector<double> square(points.size());
    const auto records = static_cast<double>(excitation.drives.size());
    for (std::size_t r = 0; r < excitation.drives.size(); ++r) {
        FieldOptions part = options;
        part.progress =
            options.progress.between(static_cast<double>(r) / records, static_cast<double>(r + 1) / records);
        const auto slopes = pressure_gradient_at(array, excitation.drives[r], points, part);
        for (std::size_t i = 0; i < points.size(); ++i) {
            const double here = static_cast<double>(std::norm(slopes[i].x)) +
                                static_cast<double>(std::norm(slopes[i].y)) +
                                static_cast<double>(std::norm(slopes[i].z));
            square[i] += excitation.weights[r] / total * here / 2.0;
        }
    }
    const double per_slope = 1.0 / (2.0 * std::numbers::pi * array.carrier_hz * array.medium.density_kg_m3);
    std::vector<float> found;
    found.reserve(points.size());
    for (const double one : square) found.push_back(static_cast<float>(per_slope * std::sqrt(one)));
    return found;
}

}  // namespace

Quantity quantity_of(std::string_view name) {
    std::string known;
    for (const QuantityName& one : quantity_names) {
        if (one.name == name) return one.quantity;
        known += fmt::format("{}{}", known.empty() ? "" : ", ", one.name);
    }
    throw bad_argument("quantity", fmt::format("must be one of {}, found '{}'", known, name));
}

Field field(const Excitation& excitation, const Region& region, Quantity quantity, unsigned threads,
            const Progress& progress) {
    Field found{region, {}, {}, {}, excitation.foci, excitation.title, FieldMethod::sums, 0.0, quantity};
    const Array array = region.pose ? seen_from(excitation.array, *region.pose) : excitation.array;
    FieldOptions options;
    options.threads = threads == 0 ? std::max(1U, std::thread::hardware_concurrency()) : threads;
    options.progress = progress;
    if (quantity == Quantity::complex) {
        if (excitation.drives.size() != 1)
            throw bad_argument("quantity",
                               fmt::format("complex is of one set of phases, and this plays {}; choose one record",
                                           excitation.drives.size()),
                               {"record"});
        found.quantity = "pressure_pa";
        found.parts.resize(2);
        found.names = {"real", "imag"};
        const PressureField pressure = pressure_field(array, excitation.drives.front(), region.grid, options);
        found.method = pressure.method;
        found.error = pressure.error;
        for (const std::complex<float> value : pressure.values) {
            found.parts[0].push_back(value.real());
            found.parts[1].push_back(value.imag());
        }
        return found;
    }
    if (quantity == Quantity::velocity) {
        found.quantity = "rms_velocity_m_s";
        found.label = "rms particle velocity / (m/s)";
        found.parts = {rms_velocity(array, excitation, region.grid, options)};
        found.error = gradient_error;
        return found;
    }
    MeanSquareField mean = mean_square_field(array, excitation.sequence(), region.grid, options);
    found.method = mean.method;
    found.error = mean.error;
    found.parts = {std::move(mean.values)};
    const Medium& medium = array.medium;
    const auto each = [&](const char* name, const char* label, auto make) {
        found.quantity = name;
        found.label = label;
        for (float& value : found.parts.front()) value = static_cast<float>(make(static_cast<double>(value)));
    };
    if (quantity == Quantity::radiation)
        each("radiation_pressure_pa", "time-averaged radiation pressure / Pa",
             [&](double square) { return radiation_pressure(std::sqrt(2.0 * square), medium); });
    else if (quantity == Quantity::rms)
        each("rms_pressure_pa", "rms sound pressure / Pa", [](double square) { return std::sqrt(square); });
    else
        each("spl_db", "sound pressure level / dB re 20 µPa",
             [](double square) { return sound_level_db(std::sqrt(2.0 * square)); });
    return found;
}

Field workspace_field(const Array& array, const Region& region) {
    return {region,
            "reachable_pressure_pa",
            "pressure amplitude that a focus can have / Pa",
            {workspace(array, region.grid)},
            {},
            array.name + ", focused on each point",
            FieldMethod::sums,
            0.0};
}

namespace {

static_assert(std::endian::native == std::endian::little, "the files say little-endian");

const std::vector<double>& axis_of(const Grid& grid, char axis) {
    return axis == 'x' || axis == 'u' ? grid.x : axis == 'y' || axis == 'v' ? grid.y : grid.z;
}

double along(Vec3 point, char axis) {
    return axis == 'x' || axis == 'u' ? point.x : axis == 'y' || axis == 'v' ? point.y : point.z;
}

/// VTK's attribute for images that are turned: a matrix row by row, whose columns are the image's axes.
std::string direction_of(const Pose& pose) {
    const auto& [o, x, y, z] = pose;
    return fmt::format(" Direction=\"{:.12g} {:.12g} {:.12g} {:.12g} {:.12g} {:.12g} {:.12g} {:.12g} {:.12g}\"", x.x,
                       y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z);
}

std::string name_of(const Field& field, std::size_t part) {
    return field.names.empty() ? field.quantity : fmt::format("{}_{}", field.quantity, field.names[part]);
}

/// The one value of a point that a picture or a surface shows: of several readings the greatest.
Field shown(Field field) {
    if (field.parts.size() > 1) field.parts = {field.parts.back()};
    return field;
}

template <class Value>
void append(std::string& bytes, const Value& value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

}  // namespace

std::string to_csv(const Field& field) {
    fmt::memory_buffer text;
    for (const char axis : field.region.axes) fmt::format_to(std::back_inserter(text), "{}_mm,", axis);
    if (field.region.pose) fmt::format_to(std::back_inserter(text), "x_mm,y_mm,z_mm,");
    for (std::size_t part = 0; part < field.parts.size(); ++part)
        fmt::format_to(std::back_inserter(text), "{}{}", part == 0 ? "" : ",", name_of(field, part));
    text.push_back('\n');
    for (std::size_t i = 0; i < field.region.grid.size(); ++i) {
        for (const char axis : field.region.axes)
            fmt::format_to(std::back_inserter(text), "{:.4f},", along(field.region.grid.point(i), axis) / millimetre);
        if (field.region.pose) {
            const Vec3 p = field.region.point(i);
            fmt::format_to(std::back_inserter(text), "{:.4f},{:.4f},{:.4f},", p.x / millimetre, p.y / millimetre,
                           p.z / millimetre);
        }
        for (std::size_t part = 0; part < field.parts.size(); ++part)
            fmt::format_to(std::back_inserter(text), "{}{:.6g}", part == 0 ? "" : ",", field.parts[part][i]);
        text.push_back('\n');
    }
    return fmt::to_string(text);
}

std::string to_npy(const Field& field) {
    std::string shape;
    for (auto axis = field.region.axes.rbegin(); axis != field.region.axes.rend(); ++axis)
        shape += fmt::format("{},", axis_of(field.region.grid, *axis).size());
    if (field.parts.size() > 2) shape += fmt::format("{},", field.parts.size());
    std::string header = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': ({}), }}",
                                     field.parts.size() == 2 ? "<c8" : "<f4", shape);
    constexpr std::size_t before = 10;
    header.append(63 - (before + header.size()) % 64, ' ');
    header += '\n';
    std::string bytes("\x93NUMPY\x01\x00", 8);
    append(bytes, static_cast<std::uint16_t>(header.size()));
    bytes += header;
    bytes.reserve(bytes.size() + field.parts.size() * field.parts.front().size() * sizeof(float));
    for (std::size_t i = 0; i < field.parts.front().size(); ++i)
        for (const auto& part : field.parts) append(bytes, part[i]);
    return bytes;
}

std::string to_vti(const Field& field) {
    const Grid& grid = field.region.grid;
    const auto spacing = [](const std::vector<double>& axis) {
        return axis.size() < 2 ? 1.0 : (axis.back() - axis.front()) / static_cast<double>(axis.size() - 1) / millimetre;
    };
    const std::string extent = fmt::format("0 {} 0 {} 0 {}", grid.x.size() - 1, grid.y.size() - 1, grid.z.size() - 1);
    const Vec3 origin = field.region.point(0);
    std::string text = fmt::format(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" "
        "header_type=\"UInt64\">\n<ImageData WholeExtent=\"{0}\" Origin=\"{1:.9g} {2:.9g} {3:.9g}\" "
        "Spacing=\"{4:.9g} {5:.9g} {6:.9g}\"{8}>\n<Piece Extent=\"{0}\">\n<PointData Scalars=\"{7}\">\n",
        extent, origin.x / millimetre, origin.y / millimetre, origin.z / millimetre, spacing(grid.x), spacing(grid.y),
        spacing(grid.z), field.quantity, field.region.pose ? direction_of(*field.region.pose) : std::string());
    const std::uint64_t bytes = field.parts.front().size() * sizeof(float);
    for (std::size_t part = 0; part < field.parts.size(); ++part)
        text += fmt::format("<DataArray type=\"Float32\" Name=\"{}\" format=\"appended\" offset=\"{}\"/>\n",
                            name_of(field, part), part * (bytes + sizeof bytes));
    text += "</PointData>\n</Piece>\n</ImageData>\n<AppendedData encoding=\"raw\">\n_";
    for (const auto& part : field.parts) {
        append(text, bytes);
        text.append(reinterpret_cast<const char*>(part.data()), bytes);
    }
    return text + "\n</AppendedData>\n</VTKFile>\n";
}

std::string about(const Field& field) {
    nlohmann::json about = {{"axes", field.region.axes},
                            {"region", field.region.text},
                            {"label", field.label},
                            {"title", field.title},
                            {"marks_mm", nlohmann::json::array()}};
    for (const char axis : field.region.axes) {
        auto& values = about[fmt::format("{}_mm", axis)];
        for (const double value : axis_of(field.region.grid, axis)) values.push_back(value / millimetre);
    }
    for (const Vec3& mark : field.marks) {
        const Vec3 p = field.region.pose ? field.region.pose->inwards(mark) : mark;
        about["marks_mm"].push_back({p.x / millimetre, p.y / millimetre, p.z / millimetre});
    }
    return about.dump();
}

namespace {

void draw(const std::string& path, const Field& field) {
    Picture picture("shipped:tools/plot_field.py");
    picture.add("field.npy", to_npy(field));
    picture.add("about.json", about(field));
    picture.draw(path, ".csv, .npy and .vti");
}

}  // namespace

void check_field_path(const std::string& path, const Region& region, Quantity quantity) {
    const std::string kind = ending_of(path);
    if (!kind.empty() && kind != ".csv" && kind != ".npy" && kind != ".vti" && kind != ".png" && kind != ".stl")
        throw bad_argument(
            "output",
            fmt::format("'{}' is no ending that is known; .csv, .npy, .vti, .png and .stl are, and none means CSV",
                        kind));
    if (kind == ".stl" && (region.axes.size() != 3 || quantity == Quantity::complex))
        throw bad_argument("output",
                           "a .stl file holds the surface of one value in a volume; take a volume and a real quantity");
    if (kind == ".png" && (region.axes.size() == 3 || (quantity == Quantity::complex)))
        throw bad_argument(
            "output",
            fmt::format("{} has no picture; take a plane or a line and a real quantity, or a .vti file for ParaView",
                        (quantity == Quantity::complex) ? "a complex field" : "a volume"));
}

std::string description_of(const Field& field) {
    return fmt::format("{} points by {}, off by at most {:.1g} of the largest {} that the drives could make",
                       field.region.grid.size(),
                       field.method == FieldMethod::interpolated ? "interpolation"
                       : field.method == FieldMethod::shifts     ? "shifted copies of one element's field"
                                                                 : "sums of all waves",
                       field.error, field.kind == Quantity::velocity ? "velocity" : "pressure");
}

std::string write_field(const std::string& path, const Field& field, double below_db) {
    const std::string kind = ending_of(path);
    if (kind == ".png") {
        draw(path, shown(field));
    } else if (kind == ".stl") {
        const IsoSurface surface = surface_below(shown(field), below_db);
        write_file(path, to_stl(surface));
        return description_of(surface);
    } else {
        write_file(path, kind == ".npy" ? to_npy(field) : kind == ".vti" ? to_vti(field) : to_csv(field));
    }
    return {};
}

namespace {

void require_few_terms(std::size_t points, std::size_t elements, std::size_t sets) {
    const double terms = static_cast<double>(points) * static_cast<double>(elements) * static_cast<double>(sets);
    if (terms > most_slice_terms)
        throw bad_argument("slice", fmt::format("{} points of {} elements with {} sets of drives are too many; take "
                                                "fewer points",
                                                points, elements, sets));
}

void require_sound(const Slice& slice, std::size_t elements, std::size_t sets) {
    if (std::min(slice.width, slice.height) < 2 || std::max(slice.width, slice.height) > most_slice_points)
        throw bad_argument("slice", fmt::format("has {} × {} points; take 2 to {} along each edge", slice.width,
                                                slice.height, most_slice_points));
    for (const Vec3& each : {slice.origin, slice.u, slice.v})
        if (!std::isfinite(each.x) || !std::isfinite(each.y) || !std::isfinite(each.z))
            throw bad_argument("slice", "its corner and its edges must be finite numbers");
    require_few_terms(slice.size(), elements, sets);
}

std::vector<double> spread(double from, double length, std::uint32_t count) {
    std::vector<double> found;
    for (std::uint32_t i = 0; i < count; ++i) found.push_back(from + length * i / (count - 1));
    return found;
}

/// The axis that an edge lies along, 0 to 2; none for other directions.
std::optional<int> axis_of(Vec3 edge) {
    if (edge.y == 0.0 && edge.z == 0.0) return 0;
    if (edge.x == 0.0 && edge.z == 0.0) return 1;
    if (edge.x == 0.0 && edge.y == 0.0) return 2;
    return {};
}

/// The same points as a grid, which has x fastest and z slowest; none when the slice has another order or lies askew.
std::optional<Grid> grid_of(const Slice& slice) {
    const auto along_u = axis_of(slice.u), along_v = axis_of(slice.v);
    if (!along_u || !along_v || *along_u >= *along_v) return {};
    Grid grid{{slice.origin.x}, {slice.origin.y}, {slice.origin.z}};
    if (*along_u == 0) grid.x = spread(slice.origin.x, slice.u.x, slice.width);
    if (*along_u == 1) grid.y = spread(slice.origin.y, slice.u.y, slice.width);
    if (*along_v == 1) grid.y = spread(slice.origin.y, slice.v.y, slice.height);
    if (*along_v == 2) grid.z = spread(slice.origin.z, slice.v.z, slice.height);
    return grid;
}

std::vector<Vec3> points_of(const Slice& slice) {
    std::vector<Vec3> points;
    points.reserve(slice.size());
    for (std::uint32_t j = 0; j < slice.height; ++j)
        for (std::uint32_t i = 0; i < slice.width; ++i)
            points.push_back(slice.origin + (static_cast<double>(i) / (slice.width - 1)) * slice.u +
                             (static_cast<double>(j) / (slice.height - 1)) * slice.v);
    return points;
}

}  // namespace

std::vector<float> mean_square_on(const Excitation& excitation, const Slice& slice, unsigned threads,
                                  const Progress& progress) {
    require_sound(slice, excitation.array.elements.size(), excitation.drives.size());
    const FieldOptions options{threads, progress};
    if (const std::optional<Grid> grid = grid_of(slice))
        return mean_square_pressure(excitation.array, excitation.sequence(), *grid, options);
    return mean_square_pressure_at(excitation.array, excitation.sequence(), points_of(slice), options);
}

std::vector<float> mean_square_at(const Excitation& excitation, std::span<const Vec3> points) {
    if (points.empty() || points.size() > most_skin_points)
        throw bad_argument("points", fmt::format("found {}, expected 1 to {}", points.size(), most_skin_points));
    require_few_terms(points.size(), excitation.array.elements.size(), excitation.drives.size());
    return mean_square_pressure_at(excitation.array, excitation.sequence(), points);
}

std::vector<float> reachable_on(const Array& array, const Slice& slice) {
    require_sound(slice, array.elements.size(), 1);
    std::vector<float> found;
    found.reserve(slice.size());
    for (const Vec3& point : points_of(slice)) {
        const double amplitude_pa = reachable_pressure(array, point);
        found.push_back(std::isnan(amplitude_pa) ? 0.0F : static_cast<float>(0.5 * amplitude_pa * amplitude_pa));
    }
    return found;
}

}  // namespace haptogram
