// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/solve/solver.hpp"
#include "haptogram/verbs/analyze.hpp"
#include "haptogram/verbs/compile.hpp"
#include "haptogram/verbs/field.hpp"
#include "haptogram/verbs/level.hpp"
#include "haptogram/verbs/pattern.hpp"
#include "haptogram/verbs/source.hpp"
#include "native.hpp"
#ifdef HAPTOGRAM_HAS_FORMATS
#include "haptogram/formats/readers.hpp"
#endif
#ifdef HAPTOGRAM_HAS_HAND
#include "haptogram/hand/project.hpp"
#endif

namespace haptogram::python {
namespace {

using Point = std::array<double, 3>;
using Range = std::optional<std::pair<double, double>>;

PathMakers makers() {
    PathMakers made{.of_pattern = path_of_pattern};
#ifdef HAPTOGRAM_HAS_HAND
    made = path_makers();
#endif
#ifdef HAPTOGRAM_HAS_FORMATS
    made.readers = formats::readers();
#endif
    return made;
}

Compiled compile_in(Project project, const std::string& name) {
    project.makers = makers();
    const py::gil_scoped_release unlocked;
    return compile(project, name, interruptible());
}

Compiled compile_text(const std::string& toml, const std::filesystem::path& folder, const std::string& name) {
    Project project = project_from_toml(toml, name);
    project.folder = folder;
    return compile_in(project, name);
}

void save(const Compiled& compiled, const std::string& image) {
    write_files({{image, compiled.bundle.hex}, {manifest_path(image), to_text(compiled.bundle.manifest)}});
}

std::vector<Focus> foci_of(const Doubles& foci_m, const std::optional<Doubles>& amplitudes) {
    std::vector<Focus> foci;
    for (const Vec3& p : points_of(foci_m, "foci_m")) foci.push_back({p});
    if (!amplitudes) return foci;
    const auto given = row_of(*amplitudes, "amplitudes");
    if (given.size() != foci.size())
        throw bad_argument("amplitudes", fmt::format("found {} for {} foci; give one each", given.size(), foci.size()));
    for (std::size_t k = 0; k < foci.size(); ++k) foci[k].amplitude = given[k];
    return foci;
}

Level level_of(const std::string& name) {
    if (name == "reachable") return Level::reachable;
    if (name == "pressure") return Level::pressure;
    throw bad_argument("level", fmt::format("must be reachable or pressure, found '{}'", name));
}

py::array_t<std::complex<double>> solve_py(const Array& array, const Doubles& foci_m,
                                           const std::optional<Doubles>& amplitudes, const std::string& method,
                                           bool vary_amplitudes, const std::string& level,
                                           std::optional<unsigned> rounds, const std::optional<Complexes>& start) {
    require_reach(array, points_of(foci_m, "foci_m"), "foci_m");
    const auto foci = foci_of(foci_m, amplitudes);
    const SolveOptions options{method_of(method, "method"), vary_amplitudes, level_of(level), rounds};
    std::span<const std::complex<double>> begin;
    if (start) begin = row_of(*start, "start");
    std::vector<std::complex<double>> found;
    {
        const py::gil_scoped_release unlocked;
        found = solve(array, foci, options, begin);
    }
    return owned(std::move(found));
}

Quality quality_py(const Array& array, const Doubles& foci_m, const Complexes& drives,
                   const std::optional<Doubles>& amplitudes, const std::string& level) {
    return quality_of(array, foci_of(foci_m, amplitudes), row_of(drives, "drives"), level_of(level));
}

Field field_py(const Excitation& excitation, const std::optional<std::string>& plane,
               const std::optional<std::string>& line, bool volume, double extent_m, double step_m, const Range& x_m,
               const Range& y_m, const Range& z_m, const std::string& quantity, unsigned threads) {
    if ((plane ? 1 : 0) + (line ? 1 : 0) + (volume ? 1 : 0) > 1)
        throw bad_argument("plane", "found more than one of plane, line and volume; give one");
    const Reach reach{extent_m, step_m, x_m, y_m, z_m};
    const Region region = volume ? parse_region("volume", "xyz", reach)
                          : line ? parse_region("line", *line, reach)
                                 : parse_region("plane", plane.value_or("xy@z=130"), reach);
    const Quantity wanted = quantity_of(quantity);
    const py::gil_scoped_release unlocked;
    return field(excitation, region, wanted, threads, interruptible());
}

/// float32 or complex64, z × y × x.
py::array values_of(const Field& field) {
    const Grid& grid = field.region.grid;
    const std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(grid.z.size()),
                                         static_cast<py::ssize_t>(grid.y.size()),
                                         static_cast<py::ssize_t>(grid.x.size())};
    if (field.parts.size() == 1) return owned<float>(std::vector<float>(field.parts.front()), shape);
    std::vector<std::complex<float>> values(grid.size());
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = {field.parts[0][i], field.parts[1][i]};
    return owned<std::complex<float>>(std::move(values), shape);
}

ImageAnalysis analyze_py(const std::variant<std::string, Compiled*>& image, double least_force_n) {
    if (const auto* compiled = std::get_if<Compiled*>(&image)) {
        const py::gil_scoped_release unlocked;
        return analyze(timeline_of((*compiled)->bundle), least_force_n, interruptible());
    }
    const auto& path = std::get<std::string>(image);
    const py::gil_scoped_release unlocked;
    Source source;
    source.file = path;
    source.makers = makers();
    return analyze(open_timeline(source), least_force_n, interruptible());
}

/// One number of each point, as an array.
template <class Of>
auto of_points(Of of) {
    return [of](const ImageAnalysis& analysis) {
        std::vector<decltype(of(analysis.points.front()))> found;
        for (const PointAnalysis& point : analysis.points) found.push_back(of(point));
        return owned(std::move(found));
    };
}

Excitation excitation_of_drives(const Array& array, const Complexes& drives, const std::optional<Doubles>& weights,
                                const std::optional<Doubles>& foci_m) {
    if (drives.ndim() != 2 || static_cast<std::size_t>(drives.shape(1)) != array.elements.size())
        throw bad_argument("drives",
                           fmt::format("expected an array of sets × {}, the array's elements", array.elements.size()));
    Excitation found;
    found.array = array;
    found.title = "given drives";
    const auto sets = static_cast<std::size_t>(drives.shape(0)), elements = array.elements.size();
    for (std::size_t r = 0; r < sets; ++r)
        found.drives.emplace_back(drives.data() + r * elements, drives.data() + (r + 1) * elements);
    found.weights.assign(sets, 1.0);
    if (weights) {
        const auto given = row_of(*weights, "weights");
        if (given.size() != sets)
            throw bad_argument("weights",
                               fmt::format("found {} for {} sets of drives; give one each", given.size(), sets));
        found.weights.assign(given.begin(), given.end());
    }
    if (foci_m)
        for (const Vec3& p : points_of(*foci_m, "foci_m")) found.foci.push_back(p);
    return found;
}

Excitation excitation_in(Source source) {
    source.makers = makers();
    const py::gil_scoped_release unlocked;
    return excitation_of(open_timeline(source, interruptible()), source.record);
}

}  // namespace

void add_verbs(py::module_& module) {
    py::class_<Compiled>(module, "Compiled", "An image with its manifest.")
        .def_property_readonly(
            "hex", [](const Compiled& c) { return py::bytes(c.bundle.hex); },
            "The image as Intel HEX: the bytes that the program writes.")
        .def_property_readonly(
            "manifest", [](const Compiled& c) { return to_text(c.bundle.manifest); },
            "The manifest as JSON text: what the program writes.")
        .def_property_readonly(
            "foci_m", [](const Compiled& c) { return owned(c.bundle.manifest.points()); },
            "Every focal point (n × 3), record by record.")
        .def_property_readonly("rate_hz", [](const Compiled& c) { return c.bundle.manifest.rate_hz; })
        .def_readonly("warnings", &Compiled::warnings)
        .def("save", &save, py::arg("image"), "Writes the image, and its manifest beside it.");
    module.def(
        "compile_project", [](const std::string& path) { return compile_in(load_project(path), path); },
        py::arg("path"), "Compiles a project file.");
    module.def("compile_text", &compile_text, py::arg("toml"), py::arg("folder") = std::filesystem::path(),
               py::arg("name") = "project",
               "Compiles the text of a project file. Relative paths in it start from folder; name is for messages.");

    py::class_<Quality>(module, "Quality", "How good the foci are that some drives make, by direct sums.")
        .def_property_readonly("pressure_pa",
                               [](const Quality& q) { return owned(std::vector<double>(q.pressure_pa)); })
        .def_readonly("spread", &Quality::spread)
        .def_readonly("least_over_mean", &Quality::least_over_mean)
        .def_readonly("efficiency", &Quality::efficiency)
        .def_readonly(
            "null_share", &Quality::null_share,
            "How much of what the array can make is left at foci of amplitude 0, the most; None without such.");
    module.def("solve", &solve_py, py::arg("array"), py::arg("foci_m"), py::arg("amplitudes") = py::none(),
               py::kw_only(), py::arg("method") = "gauss-newton", py::arg("vary_amplitudes") = false,
               py::arg("level") = "reachable", py::arg("rounds") = py::none(), py::arg("start") = py::none(),
               "Drives (complex128, 1 at full strength) that make several foci (n × 3) at the same time.");
    module.def("quality", &quality_py, py::arg("array"), py::arg("foci_m"), py::arg("drives"),
               py::arg("amplitudes") = py::none(), py::kw_only(), py::arg("level") = "reachable",
               "How good the foci are that some drives make.");

    py::class_<Excitation>(module, "Excitation",
                           "What makes a sound field: sets of drives, each for its share of the time.")
        .def_static(
            "of_image",
            [](const std::string& image, std::uint32_t record, const std::string& manifest) {
                Source source;
                source.file = image;
                source.record = record;
                source.manifest = manifest;
                return excitation_in(source);
            },
            py::arg("image"), py::arg("record") = 0U, py::arg("manifest") = "",
            "Of an image (.hex), a manifest (.json) or a project (.toml); record 0 is all in turn.")
        .def_static(
            "of_compiled",
            [](const Compiled& compiled, std::uint32_t record) {
                return excitation_of(timeline_of(compiled.bundle), record);
            },
            py::arg("compiled"), py::arg("record") = 0U, "Of an image that was just compiled.")
        .def_static(
            "of_focus",
            [](const Array& array, const Point& focus) {
                const Vec3 at{focus[0], focus[1], focus[2]};
                require_reach(array, {&at, 1}, "focus_m");
                return excitation_of(array, at);
            },
            py::arg("array"), py::arg("focus_m"), "Exact phases for one focal point, at full strength.")
        .def_static(
            "of_drives", &excitation_of_drives, py::arg("array"), py::arg("drives"), py::arg("weights") = py::none(),
            py::arg("foci_m") = py::none(),
            "Of sets × elements of drives (Pa m), each for its weight's share of the time; foci are for pictures.")
        .def_static(
            "of_pulses",
            [](const std::string& pulses, const std::string& manifest) {
                Source source;
                source.pulses = pulses;
                source.manifest = manifest;
                return excitation_in(source);
            },
            py::arg("pulses"), py::arg("manifest"), "Of pulses that were measured at the pins.")
        .def_readonly("array", &Excitation::array)
        .def_property_readonly(
            "drives",
            [](const Excitation& e) {
                std::vector<std::complex<double>> all;
                for (const auto& set : e.drives) all.insert(all.end(), set.begin(), set.end());
                return owned<std::complex<double>>(std::move(all), {static_cast<py::ssize_t>(e.drives.size()),
                                                                    static_cast<py::ssize_t>(e.array.elements.size())});
            },
            "Sets × elements (complex128), Pa m.")
        .def_property_readonly("weights", [](const Excitation& e) { return owned(std::vector<double>(e.weights)); });

    py::class_<Field>(module, "Field", "A quantity over a line, a plane or a volume.")
        .def_property_readonly("values", &values_of, "z × y × x: float32, or complex64 of a complex field.")
        .def_property_readonly("x_m", [](const Field& f) { return owned(std::vector<double>(f.region.grid.x)); })
        .def_property_readonly("y_m", [](const Field& f) { return owned(std::vector<double>(f.region.grid.y)); })
        .def_property_readonly("z_m", [](const Field& f) { return owned(std::vector<double>(f.region.grid.z)); })
        .def(
            "point_m",
            [](const Field& f, std::size_t index) {
                if (index >= f.region.grid.size())
                    throw bad_argument("index",
                                       fmt::format("found {}; the field has {} points", index, f.region.grid.size()));
                const Vec3 p = f.region.point(index);
                return owned(std::vector<double>{p.x, p.y, p.z});
            },
            py::arg("index"), "Where a point lies in the array's frame, counted as in values.ravel().")
        .def_readonly("quantity", &Field::quantity)
        .def_property_readonly(
            "method", [](const Field& f) { return name_of(f.method); }, "sums, shifts or interpolated.")
        .def_readonly("error", &Field::error,
                      "Of the largest pressure, or velocity, that the drives, with any phases, could make.")
        .def(
            "to_npy", [](const Field& f) { return py::bytes(to_npy(f)); }, "The bytes of the program's .npy file.")
        .def(
            "to_csv", [](const Field& f) { return to_csv(f); }, "The text of the program's .csv file.");
    module.def("field", &field_py, py::arg("excitation"), py::kw_only(), py::arg("plane") = py::none(),
               py::arg("line") = py::none(), py::arg("volume") = false, py::arg("extent_m") = 80e-3,
               py::arg("step_m") = 1e-3, py::arg("x_m") = py::none(), py::arg("y_m") = py::none(),
               py::arg("z_m") = py::none(), py::arg("quantity") = "radiation", py::arg("threads") = 0U,
               "The sound field of an excitation, as the program computes it. Regions are texts in mm: xy@z=130.");

    py::class_<FocusAnalysis>(module, "FocusAnalysis", "What a focal point is like while it plays alone.")
        .def_readonly("pressure_pa", &FocusAnalysis::pressure_pa, "Amplitude at the asked point.")
        .def_readonly("radiation_pa", &FocusAnalysis::radiation_pa)
        .def_readonly("width_m", &FocusAnalysis::width_m, "Full width at half of the radiation pressure.")
        .def_readonly("depth_m", &FocusAnalysis::depth_m)
        .def_readonly("side_lobe", &FocusAnalysis::side_lobe, "Highest radiation pressure beside it, over its peak.")
        .def_readonly("force_n", &FocusAnalysis::force_n)
        .def_property_readonly("formation_s", [](const FocusAnalysis& f) { return f.formation.formation_s; });
    module.def(
        "analyze_focus",
        [](const Array& array, const Complexes& drives, const Point& focus, const std::string& core) {
            const auto played = row_of(drives, "drives");
            const Vec3 at{focus[0], focus[1], focus[2]};
            require_reach(array, {&at, 1}, "focus_m");
            const py::gil_scoped_release unlocked;
            if (played.size() != array.elements.size())
                throw bad_argument("drives", fmt::format("found {} for {} elements; give one each", played.size(),
                                                         array.elements.size()));
            return analyze(array, find_core(core), played, at);
        },
        py::arg("array"), py::arg("drives"), py::arg("focus_m"), py::kw_only(), py::arg("core") = "tile-100",
        "What a focal point is like. The core, a board or a configuration, adds its time to load a record.");

    py::class_<ImageAnalysis>(module, "ImageAnalysis", "What each focus of an image is like, and how loud it is.")
        .def_property_readonly("foci_m",
                               [](const ImageAnalysis& a) {
                                   std::vector<Vec3> foci;
                                   for (const PointAnalysis& point : a.points) foci.push_back(point.focus.focus);
                                   return owned(std::move(foci));
                               })
        .def_property_readonly("pressure_pa", of_points([](const PointAnalysis& p) { return p.focus.pressure_pa; }))
        .def_property_readonly("radiation_pa", of_points([](const PointAnalysis& p) { return p.focus.radiation_pa; }))
        .def_property_readonly("width_m", of_points([](const PointAnalysis& p) { return p.focus.width_m; }))
        .def_property_readonly("depth_m", of_points([](const PointAnalysis& p) { return p.focus.depth_m; }))
        .def_property_readonly("side_lobe", of_points([](const PointAnalysis& p) { return p.focus.side_lobe; }))
        .def_property_readonly("force_n", of_points([](const PointAnalysis& p) { return p.focus.force_n; }))
        .def_property_readonly("formation_s",
                               of_points([](const PointAnalysis& p) { return p.focus.formation.formation_s; }))
        .def_property_readonly("dwell_cycles", of_points([](const PointAnalysis& p) { return p.dwell_cycles; }))
        .def_property_readonly("dwell_needed_cycles",
                               of_points([](const PointAnalysis& p) { return p.focus.dwell_cycles; }))
        .def_property_readonly(
            "highest_db", [](const ImageAnalysis& a) { return a.loudness.highest_db; },
            "Sound on the axis, averaged over the sequence, dB SPL: a model, no certification.")
        .def_property_readonly("pressure_left_least", [](const ImageAnalysis& a) { return a.pressure_left.least; })
        .def_property_readonly(
            "level", [](const ImageAnalysis& a) { return level_text(a.transducer); },
            "What pressures and forces rest on, as of an Array.")
        .def_readonly("warnings", &ImageAnalysis::warnings);
    module.def("analyze", &analyze_py, py::arg("image").none(false), py::arg("least_force_n") = least_felt_n,
               "Of an image's or a project's path, or of what was just compiled.");
}

}  // namespace haptogram::python
