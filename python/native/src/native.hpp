// SPDX-License-Identifier: Apache-2.0
// What the parts of the Python module share: numpy arrays as the libraries take them, without copies.
#pragma once
#include <pybind11/complex.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <complex>
#include <span>
#include <string>
#include <vector>

#include "haptogram/array/array.hpp"
#include "haptogram/base/progress.hpp"

namespace haptogram::python {

namespace py = pybind11;

/// Arrays that are not of this type, or not one row behind the other, are copied by pybind11.
using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Complexes = py::array_t<std::complex<double>, py::array::c_style | py::array::forcecast>;

/// Points × 3 as points, in place.
/// @throws Error{bad_argument} naming `setting` for another shape
[[nodiscard]] std::span<const Vec3> points_of(const Doubles& array, const char* setting);
/// One row, in place. @throws Error{bad_argument} naming `setting` for another shape
[[nodiscard]] std::span<const double> row_of(const Doubles& array, const char* setting);
[[nodiscard]] std::span<const std::complex<double>> row_of(const Complexes& array, const char* setting);

/// @throws Error{bad_argument} naming `setting` and the focus that is out of the array's reach, or so far away that its
/// lengths must have been millimetres
void require_reach(const Array& array, std::span<const Vec3> foci, const std::string& setting);

/// A numpy array that owns the values from now on.
template <class To, class From>
py::array_t<To> owned(std::vector<From>&& values, std::vector<py::ssize_t> shape) {
    static_assert(sizeof(From) % sizeof(To) == 0 && std::is_trivially_copyable_v<From>);
    auto* kept = new std::vector<From>(std::move(values));
    const py::capsule release(kept, [](void* all) { delete static_cast<std::vector<From>*>(all); });
    return py::array_t<To>(std::move(shape), reinterpret_cast<const To*>(kept->data()), release);
}
template <class T>
py::array_t<T> owned(std::vector<T>&& values) {
    const auto size = static_cast<py::ssize_t>(values.size());
    return owned<T>(std::move(values), {size});
}
/// Points as an array of points × 3.
[[nodiscard]] py::array_t<double> owned(std::vector<Vec3>&& points);

/// Lets Ctrl-C end the work: the callback sees to Python's signals.
[[nodiscard]] Progress interruptible();

void add_fields(py::module_& module);
void add_verbs(py::module_& module);

}  // namespace haptogram::python
