// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>

#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/picture.hpp"
#include "haptogram/scattering/scatter.hpp"
#include "haptogram/verbs/level.hpp"

namespace haptogram::scattering {
namespace {

using nlohmann::ordered_json;

ordered_json numbers_of(Vec3 p) { return {p.x / millimetre, p.y / millimetre, p.z / millimetre}; }

ordered_json newtons(Vec3 f) { return {f.x * 1e3, f.y * 1e3, f.z * 1e3}; }

/// What the picture needs beside the report.
std::string surface_json(const Scattered& scattered) {
    ordered_json json = {{"title", scattered.title},
                         {"vertices_mm", ordered_json::array()},
                         {"triangles", scattered.body.mesh.triangles},
                         {"radiation_pa", scattered.radiation},
                         {"foci_mm", ordered_json::array()},
                         {"force_mn", newtons(scattered.force_n)}};
    for (const Vec3& vertex : scattered.body.mesh.vertices) json["vertices_mm"].push_back(numbers_of(vertex));
    for (const ScatteredStep& step : scattered.steps)
        for (const Focus& focus : step.foci) json["foci_mm"].push_back(numbers_of(focus.position));
    return json.dump();
}

/// The estimate by flat skin beside the boundary elements.
ordered_json flat_json(const Scattered& s) {
    Vec3 force;
    double apart = 0.0, whole = 0.0;
    for (std::size_t i = 0; i < s.flat.size(); ++i) {
        const Panel& panel = s.body.panels[i];
        const auto flat = static_cast<double>(s.flat[i]), found = static_cast<double>(s.radiation[i]);
        force = force - flat * panel.area * panel.normal;
        apart += panel.area * (flat - found) * (flat - found);
        whole += panel.area * found * found;
    }
    return {{"highest_radiation_pa", *std::max_element(s.flat.begin(), s.flat.end())},
            {"force_mn", newtons(force)},
            {"difference", std::sqrt(apart / whole)}};
}

}  // namespace

std::string to_json_text(const Scattered& s) {
    const ErrorRange error = mesh_error(s.elements_per_wavelength());
    ordered_json json = {{"title", s.title},
                         {"array", s.array.name},
                         {"body", s.body.name},
                         {"triangles", s.body.panels.size()},
                         {"area_mm2", s.body.area * 1e6},
                         {"volume_mm3", s.body.volume * 1e9},
                         {"wavelength_mm", s.array.wavelength_m() / millimetre},
                         {"elements_per_wavelength", s.elements_per_wavelength()},
                         {"least_elements_per_wavelength", s.array.wavelength_m() / s.body.longest_edge()},
                         {"rounds", s.rounds},
                         {"residual", s.residual},
                         {"pressure_error", {{"low", error.low}, {"high", error.high}}},
                         {"pattern_error", s.pattern_error},
                         {"highest_radiation_pa", s.radiation[s.highest]},
                         {"highest_at_mm", numbers_of(s.body.panels[s.highest].centre)},
                         {"force_mn", newtons(s.force_n)},
                         {"resting", s.resting},
                         {"steps", ordered_json::array()}};
    if (!s.is_plane_wave) json["level"] = level_json(s.array.transducer);
    if (s.ring)
        json["ring"] = {
            {"foci", s.ring->foci}, {"uneven", s.ring->uneven}, {"farthest_mm", s.ring->farthest_m / millimetre}};
    if (!s.flat.empty()) json["flat_estimate"] = flat_json(s);
    for (const ScatteredStep& step : s.steps) {
        ordered_json foci = ordered_json::array();
        for (const Focus& focus : step.foci)
            foci.push_back({{"position_mm", numbers_of(focus.position)}, {"amplitude", focus.amplitude}});
        json["steps"].push_back({{"foci", foci},
                                 {"share", step.share},
                                 {"highest_radiation_pa", step.highest_pa},
                                 {"highest_at_mm", numbers_of(step.highest_at)},
                                 {"force_mn", newtons(step.force_n)}});
    }
    return json.dump(1) + "\n";
}

std::string to_csv(const Scattered& s) {
    fmt::memory_buffer text;
    auto out = std::back_inserter(text);
    fmt::format_to(out, "x_mm,y_mm,z_mm,normal_x,normal_y,normal_z,area_mm2,rms_pressure_pa,radiation_pressure_pa\n");
    for (std::size_t i = 0; i < s.body.panels.size(); ++i) {
        const Panel& p = s.body.panels[i];
        fmt::format_to(out, "{:.4f},{:.4f},{:.4f},{:.6f},{:.6f},{:.6f},{:.6g},{:.6g},{:.6g}\n", p.centre.x / millimetre,
                       p.centre.y / millimetre, p.centre.z / millimetre, p.normal.x, p.normal.y, p.normal.z,
                       p.area * 1e6, s.rms_pressure[i], s.radiation[i]);
    }
    return fmt::to_string(text);
}

std::string to_vtp(const Scattered& s) {
    const Mesh& mesh = s.body.mesh;
    fmt::memory_buffer text;
    auto out = std::back_inserter(text);
    fmt::format_to(out,
                   "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\">\n<PolyData>\n"
                   "<Piece NumberOfPoints=\"{}\" NumberOfPolys=\"{}\">\n<Points>\n<DataArray type=\"Float32\" "
                   "NumberOfComponents=\"3\" format=\"ascii\">\n",
                   mesh.vertices.size(), mesh.triangles.size());
    for (const Vec3& v : mesh.vertices)
        fmt::format_to(out, "{:.5f} {:.5f} {:.5f}\n", v.x / millimetre, v.y / millimetre, v.z / millimetre);
    fmt::format_to(out,
                   "</DataArray>\n</Points>\n<Polys>\n<DataArray type=\"Int32\" Name=\"connectivity\" "
                   "format=\"ascii\">\n");
    for (const auto& [a, b, c] : mesh.triangles) fmt::format_to(out, "{} {} {}\n", a, b, c);
    fmt::format_to(out, "</DataArray>\n<DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">\n");
    for (std::size_t i = 1; i <= mesh.triangles.size(); ++i) fmt::format_to(out, "{}\n", 3 * i);
    fmt::format_to(out, "</DataArray>\n</Polys>\n<CellData Scalars=\"radiation_pressure_pa\">\n");
    for (const auto& [name, values] :
         {std::pair("radiation_pressure_pa", &s.radiation), std::pair("rms_pressure_pa", &s.rms_pressure)}) {
        fmt::format_to(out, "<DataArray type=\"Float32\" Name=\"{}\" format=\"ascii\">\n", name);
        for (const float value : *values) fmt::format_to(out, "{:.6g}\n", value);
        fmt::format_to(out, "</DataArray>\n");
    }
    fmt::format_to(out, "</CellData>\n</Piece>\n</PolyData>\n</VTKFile>\n");
    return fmt::to_string(text);
}

void check_scattered_path(const std::string& path) {
    const std::string kind = ending_of(path);
    if (path != "-" && kind != ".csv" && kind != ".vtp" && kind != ".png")
        throw bad_argument("output", fmt::format("'{}' is no ending that is known; .csv, .vtp and .png are", kind));
}

void write_scattered(const std::string& path, const Scattered& scattered) {
    check_scattered_path(path);
    if (ending_of(path) == ".png") {
        Picture picture("shipped:tools/plot_scatter.py");
        picture.add("surface.json", surface_json(scattered));
        picture.draw(path, ".csv and .vtp");
    } else
        write_file(path, ending_of(path) == ".vtp" ? to_vtp(scattered) : to_csv(scattered));
}

}  // namespace haptogram::scattering
