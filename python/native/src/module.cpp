// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include "haptogram/base/error.hpp"
#include "native.hpp"

namespace haptogram::python {
namespace {

std::string shape_of(const py::array& array) {
    std::string text;
    for (py::ssize_t i = 0; i < array.ndim(); ++i) text += fmt::format("{}{}", i == 0 ? "" : " × ", array.shape(i));
    return array.ndim() == 0 ? "a single number" : text;
}

void require_row(const py::array& array, const char* setting) {
    if (array.ndim() != 1)
        throw bad_argument(setting, fmt::format("expected an array of one dimension, found {}", shape_of(array)));
}

/// Raises the Python exception that an Error is.
void raise(const Error& error) {
    if (error.code() == ErrorCode::cancelled && PyErr_Occurred() != nullptr) return;  // KeyboardInterrupt
    const auto [name, code] = [&]() -> std::pair<const char*, int> {
        switch (error.code()) {
            case ErrorCode::bad_argument: return {"BadArgument", 2};
            case ErrorCode::bad_input: return {"BadInput", 3};
            case ErrorCode::device: return {"DeviceError", 4};
            default: return {"Failed", 1};
        }
    }();
    const py::object type = py::module_::import("haptogram_native.errors").attr(name);
    const py::object made = type(code, error.where(), error.message(), py::tuple(py::cast(error.remedies())));
    PyErr_SetObject(type.ptr(), made.ptr());
}

}  // namespace

std::span<const Vec3> points_of(const Doubles& array, const char* setting) {
    static_assert(sizeof(Vec3) == 3 * sizeof(double));
    if (array.ndim() != 2 || array.shape(1) != 3)
        throw bad_argument(setting, fmt::format("expected an array of points × 3, found {}", shape_of(array)));
    return {reinterpret_cast<const Vec3*>(array.data()), static_cast<std::size_t>(array.shape(0))};
}

std::span<const double> row_of(const Doubles& array, const char* setting) {
    require_row(array, setting);
    return {array.data(), static_cast<std::size_t>(array.size())};
}

std::span<const std::complex<double>> row_of(const Complexes& array, const char* setting) {
    require_row(array, setting);
    return {array.data(), static_cast<std::size_t>(array.size())};
}

py::array_t<double> owned(std::vector<Vec3>&& points) {
    const auto size = static_cast<py::ssize_t>(points.size());
    return owned<double>(std::move(points), {size, 3});
}

Progress interruptible() {
    return Progress([](double, std::string_view) {
        const py::gil_scoped_acquire lock;
        return PyErr_CheckSignals() == 0;
    });
}

}  // namespace haptogram::python

PYBIND11_MODULE(_native, module) {
    module.doc() = "The C++ libraries of Haptogram; import haptogram_native instead.";
    pybind11::register_exception_translator([](std::exception_ptr pointer) {
        try {
            if (pointer) std::rethrow_exception(pointer);
        } catch (const haptogram::Error& error) {
            haptogram::python::raise(error);
        }
    });
    haptogram::python::add_fields(module);
    haptogram::python::add_verbs(module);
}
