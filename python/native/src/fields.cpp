// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include <cmath>

#include "haptogram/acoustics/field.hpp"
#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/array/rig.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/verbs/focus_analysis.hpp"
#include "haptogram/verbs/level.hpp"
#include "native.hpp"

namespace haptogram::python {
namespace {

/// A read-only view of all elements' positions or normals, which keeps the array alive.
py::array_t<double> view_of(const py::object& self, Vec3 Element::*part) {
    const auto& array = self.cast<const Array&>();
    const auto count = static_cast<py::ssize_t>(array.elements.size());
    const double* first = count == 0 ? nullptr : &(array.elements.front().*part).x;
    py::array_t<double> view({count, py::ssize_t{3}},
                             {static_cast<py::ssize_t>(sizeof(Element)), static_cast<py::ssize_t>(sizeof(double))},
                             first, self);
    view.attr("flags").attr("writeable") = false;
    return view;
}

Array with_elements(const Array& like, const Doubles& positions, const std::optional<Doubles>& normals) {
    Array array = like;
    array.columns = 0;
    array.elements.clear();
    for (const Vec3& p : points_of(positions, "positions_m")) array.elements.push_back({p});
    if (normals) {
        const auto given = points_of(*normals, "normals");
        if (given.size() != array.elements.size())
            throw bad_argument(
                "normals", fmt::format("found {} for {} elements; give one each", given.size(), array.elements.size()));
        for (std::size_t m = 0; m < given.size(); ++m) array.elements[m].normal = given[m];
    }
    for (std::size_t m = 0; m < array.elements.size(); ++m) {
        const Element& e = array.elements[m];
        if (!is_finite(e.position))
            throw bad_argument("positions_m", fmt::format("element {} is not at a finite place", m));
        if (!(std::abs(norm(e.normal) - 1.0) < 1e-9))
            throw bad_argument(
                "normals", fmt::format("that of element {} has the length {}; divide it by that", m, norm(e.normal)));
    }
    return array;
}

FieldOptions options_of(unsigned threads, double interpolation_error, double pattern_error) {
    FieldOptions options;
    options.threads = threads;
    options.progress = interruptible();
    options.interpolation_error = interpolation_error;
    options.pattern_error = pattern_error;
    return options;
}

std::vector<double> axis_of(const Doubles& array, const char* setting) {
    const auto row = row_of(array, setting);
    return {row.begin(), row.end()};
}

py::array_t<std::complex<float>> pressure_py(const Array& array, const Complexes& drives, const Doubles& points_m,
                                             unsigned threads, double pattern_error) {
    const auto played = row_of(drives, "drives");
    const auto points = points_of(points_m, "points_m");
    std::vector<std::complex<float>> found;
    {
        const py::gil_scoped_release unlocked;
        found = pressure_at(array, played, points, options_of(threads, 0.0, pattern_error));
    }
    return owned(std::move(found));
}

/// z × y × x.
std::vector<py::ssize_t> shape_of(const Grid& grid) {
    std::vector<py::ssize_t> shape;
    for (const auto* axis : {&grid.z, &grid.y, &grid.x}) shape.push_back(static_cast<py::ssize_t>(axis->size()));
    return shape;
}

struct PressureOnGrid {
    py::array_t<std::complex<float>> values;
    const char* method;
    double error, pattern_error;
};

PressureOnGrid pressure_on_py(const Array& array, const Complexes& drives, const Doubles& x_m, const Doubles& y_m,
                              const Doubles& z_m, unsigned threads, double interpolation_error, double pattern_error) {
    const auto played = row_of(drives, "drives");
    const Grid grid{axis_of(x_m, "x_m"), axis_of(y_m, "y_m"), axis_of(z_m, "z_m")};
    PressureField found;
    {
        const py::gil_scoped_release unlocked;
        found = pressure_field(array, played, grid, options_of(threads, interpolation_error, pattern_error));
    }
    return {owned<std::complex<float>>(std::move(found.values), shape_of(grid)), name_of(found.method), found.error,
            found.pattern_error};
}

py::array_t<std::complex<float>> gradient_py(const Array& array, const Complexes& drives, const Doubles& points_m,
                                             unsigned threads, double pattern_error) {
    static_assert(sizeof(PressureGradient) == 3 * sizeof(std::complex<float>));
    const auto played = row_of(drives, "drives");
    const auto points = points_of(points_m, "points_m");
    std::vector<PressureGradient> found;
    {
        const py::gil_scoped_release unlocked;
        found = pressure_gradient_at(array, played, points, options_of(threads, 0.0, pattern_error));
    }
    return owned<std::complex<float>>(std::move(found), {points_m.shape(0), 3});
}

std::vector<WeightedDrives> sequence_of(const Complexes& drives, const Doubles& weights) {
    const auto shares = row_of(weights, "weights");
    if (drives.ndim() != 2 || static_cast<std::size_t>(drives.shape(0)) != shares.size())
        throw bad_argument("drives",
                           fmt::format("expected an array of {} × elements, a row for each weight", shares.size()));
    const auto elements = static_cast<std::size_t>(drives.shape(1));
    std::vector<WeightedDrives> sequence;
    for (std::size_t r = 0; r < shares.size(); ++r)
        sequence.push_back({shares[r], {drives.data() + r * elements, elements}});
    return sequence;
}

py::array_t<float> mean_square_py(const Array& array, const Complexes& drives, const Doubles& weights,
                                  const Doubles& points_m, unsigned threads) {
    const auto sequence = sequence_of(drives, weights);
    const auto points = points_of(points_m, "points_m");
    std::vector<float> found;
    {
        const py::gil_scoped_release unlocked;
        found = mean_square_pressure_at(array, sequence, points, options_of(threads, 0.0, 0.0));
    }
    return owned(std::move(found));
}

struct MeanSquareOnGrid {
    py::array_t<float> values;
    const char* method;
    double error;
};

MeanSquareOnGrid mean_square_on_py(const Array& array, const Complexes& drives, const Doubles& weights,
                                   const Doubles& x_m, const Doubles& y_m, const Doubles& z_m, unsigned threads,
                                   double interpolation_error) {
    const auto sequence = sequence_of(drives, weights);
    const Grid grid{axis_of(x_m, "x_m"), axis_of(y_m, "y_m"), axis_of(z_m, "z_m")};
    MeanSquareField found;
    {
        const py::gil_scoped_release unlocked;
        found = mean_square_field(array, sequence, grid, options_of(threads, interpolation_error, 0.0));
    }
    return {owned<float>(std::move(found.values), shape_of(grid)), name_of(found.method), found.error};
}

py::array_t<float> workspace_py(const Array& array, const Doubles& x_m, const Doubles& y_m, const Doubles& z_m) {
    const Grid grid{axis_of(x_m, "x_m"), axis_of(y_m, "y_m"), axis_of(z_m, "z_m")};
    std::vector<float> found;
    {
        const py::gil_scoped_release unlocked;
        found = workspace(array, grid);
    }
    return owned<float>(std::move(found), shape_of(grid));
}

Vec3 vec3_of(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }

}  // namespace

void require_reach(const Array& array, std::span<const Vec3> foci, const std::string& setting) {
    constexpr double farthest_m = 5.0;  // nothing can be felt beyond
    const auto told = [](Vec3 p) { return fmt::format("({:g}, {:g}, {:g})", p.x, p.y, p.z); };
    for (std::size_t i = 0; i < foci.size(); ++i) {
        const Vec3 p = foci[i];
        const std::string where = foci.size() == 1 ? setting : fmt::format("{}[{}]", setting, i);
        if (const double away = norm(p); away > farthest_m)
            throw bad_argument(where, fmt::format("{} m is {:g} m away; lengths are metres: did you mean {}?", told(p),
                                                  away, told(0.001 * p)));
        if (const std::string why = array.unreachable(p); !why.empty())
            throw bad_argument(where, fmt::format("{} m is out of the array's reach: {}", told(p), why));
    }
}

void add_fields(py::module_& module) {
    py::class_<Pose>(module, "Pose", "Where something is and how it is turned: an origin and three axes.")
        .def(py::init([](const std::array<double, 3>& origin, const std::array<double, 3>& angles) {
                 return pose_of(vec3_of(origin), vec3_of(angles));
             }),
             py::arg("origin_m"), py::arg("angles_deg") = std::array<double, 3>{},
             "Turned by degrees about the fixed x, then y, then z axis, and then moved to origin_m.")
        .def(
            "outwards",
            [](const Pose& pose, const Doubles& points_m) {
                std::vector<Vec3> found;
                for (const Vec3& p : points_of(points_m, "points_m")) found.push_back(pose.outwards(p));
                return owned(std::move(found));
            },
            py::arg("points_m"), "Points (n × 3) in the pose's own coordinates, in the surrounding ones.");

    py::class_<Array>(module, "Array", "Transducers that play together, and the air in front of them. Never changes.")
        .def_static("find", &find_array, py::arg("name"), "Reads an array file (TOML), or a shipped array.")
        .def_property_readonly(
            "positions_m", [](const py::object& self) { return view_of(self, &Element::position); },
            "Elements × 3: a read-only view.")
        .def_property_readonly(
            "normals", [](const py::object& self) { return view_of(self, &Element::normal); },
            "Elements × 3, of length 1: a read-only view.")
        .def("with_elements", &with_elements, py::arg("positions_m"), py::arg("normals") = py::none(),
             "The same transducers and air with other elements; without normals they all face +z.")
        .def(
            "with_transducer",
            [](Array array, const std::string& name) {
                array.transducer = find_transducer(name);
                return array;
            },
            py::arg("name"), "The same elements of another kind: a transducer file (TOML), or a shipped transducer.")
        .def("seen_from", &seen_from, py::arg("pose"),
             "The array in the coordinates of a pose. An oblique plane is an even one there.")
        .def_readonly("name", &Array::name)
        .def_readonly("carrier_hz", &Array::carrier_hz)
        .def_property_readonly("wavelength_m", &Array::wavelength_m)
        .def_property_readonly("transducer", [](const Array& array) { return array.transducer.name; })
        .def_property_readonly(
            "level", [](const Array& array) { return level_text(array.transducer); },
            "What pressures and forces rest on, in a sentence that begins with nominal or calibrated.")
        .def(
            "unreachable",
            [](const Array& array, const std::array<double, 3>& focus) { return array.unreachable(vec3_of(focus)); },
            py::arg("focus_m"), "Why a focal point cannot be reached, in words; empty when it can.")
        .def("__len__", [](const Array& array) { return array.elements.size(); })
        .def("__repr__", [](const Array& array) {
            return fmt::format("<Array {}: {} × {}>", array.name, array.elements.size(), array.transducer.name);
        });

    py::class_<PressureOnGrid>(module, "PressureField", "Complex pressures on a grid, and how far they may be off.")
        .def_readonly("values", &PressureOnGrid::values, "complex64, z × y × x.")
        .def_readonly("method", &PressureOnGrid::method, "sums, shifts or interpolated.")
        .def_readonly("error", &PressureOnGrid::error,
                      "Of the largest |p| that the drives, with any phases, could make at any of the points.")
        .def_readonly("pattern_error", &PressureOnGrid::pattern_error,
                      "Of the directivity, relative to the amplitude on the axis.");

    py::class_<MeanSquareOnGrid>(module, "MeanSquareField", "Mean squares on a grid, and how far they may be off.")
        .def_readonly("values", &MeanSquareOnGrid::values, "float32, z × y × x, Pa².")
        .def_readonly("method", &MeanSquareOnGrid::method, "sums, shifts or interpolated.")
        .def_readonly("error", &MeanSquareOnGrid::error,
                      "Of the rms pressure: of the largest that the drives, with any phases, could make.");

    module.def("array_names", &shipped_arrays, "The shipped arrays.");
    module.def(
        "join",
        [](const std::vector<std::pair<Array, Pose>>& arrays, const std::string& name) {
            Rig rig{name, {}};
            for (const auto& [array, pose] : arrays) rig.arrays.push_back({array, pose});
            return joined(rig);
        },
        py::arg("arrays"), py::arg("name") = "rig", "Several arrays, each in its pose, as one array.");
    module.def(
        "ideal_drives",
        [](const Array& array, const std::array<double, 3>& focus) {
            const Vec3 at = vec3_of(focus);
            require_reach(array, {&at, 1}, "focus_m");
            return owned(ideal_drives(array, at));
        },
        py::arg("array"), py::arg("focus_m"), "Drives (complex128, one an element) that focus with full strength.");
    module.def("pressure", &pressure_py, py::arg("array"), py::arg("drives"), py::arg("points_m"), py::kw_only(),
               py::arg("threads") = 0U, py::arg("pattern_error") = 0.0,
               "Complex pressure (complex64) at points (n × 3).");
    module.def("pressure_on", &pressure_on_py, py::arg("array"), py::arg("drives"), py::arg("x_m"), py::arg("y_m"),
               py::arg("z_m"), py::kw_only(), py::arg("threads") = 0U, py::arg("interpolation_error") = 1e-4,
               py::arg("pattern_error") = 0.0, "Complex pressure on straight axes, by the quickest method.");
    module.def("gradient", &gradient_py, py::arg("array"), py::arg("drives"), py::arg("points_m"), py::kw_only(),
               py::arg("threads") = 0U, py::arg("pattern_error") = 0.0,
               "Gradient of the complex pressure (complex64, n × 3), Pa/m.");
    module.def("mean_square", &mean_square_py, py::arg("array"), py::arg("drives"), py::arg("weights"),
               py::arg("points_m"), py::kw_only(), py::arg("threads") = 0U,
               "Mean square of the pressure (float32), Pa²: drives are sets × elements, with a weight each.");
    module.def("mean_square_on", &mean_square_on_py, py::arg("array"), py::arg("drives"), py::arg("weights"),
               py::arg("x_m"), py::arg("y_m"), py::arg("z_m"), py::kw_only(), py::arg("threads") = 0U,
               py::arg("interpolation_error") = 1e-4,
               "The same on straight axes: a line, a plane or a volume; oblique ones by Array.seen_from().");
    module.def("workspace", &workspace_py, py::arg("array"), py::arg("x_m"), py::arg("y_m"), py::arg("z_m"),
               "Pressure amplitude (float32, z × y × x) that a lone focus has at each point; NaN out of reach.");
}

}  // namespace haptogram::python
