// SPDX-License-Identifier: Apache-2.0
#include "haptogram/array/array.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <tuple>

#include "haptogram/array/calibration.hpp"
#include "haptogram/array/transducer_keys.hpp"
#include "haptogram/base/shipped.hpp"

namespace haptogram {
namespace {

using section::assign;
using section::found;
using section::place;
using section::Section;

constexpr double degree = std::numbers::pi / 180.0;

std::vector<Element> grid(std::uint32_t rows, std::uint32_t columns, double pitch_m) {
    std::vector<Element> elements;
    for (std::uint32_t r = 0; r < rows; ++r)
        for (std::uint32_t q = 0; q < columns; ++q)
            elements.push_back({{(q - (columns - 1) / 2.0) * pitch_m, (r - (rows - 1) / 2.0) * pitch_m, 0.0}});
    return elements;
}

void refuse_coincident(const std::vector<Element>& elements, const std::string& file, const toml::array& list) {
    const auto key = [&](std::size_t i) {
        const Vec3 p = elements[i].position;
        return std::tuple(p.x, p.y, p.z);
    };
    std::vector<std::size_t> order(elements.size());  // by place, so that elements at the same one are neighbours
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::stable_sort(order, {}, key);
    const auto twice =
        std::ranges::adjacent_find(order, [&](std::size_t one, std::size_t next) { return key(one) == key(next); });
    if (twice == order.end()) return;
    throw bad_input(
        place(file, list[twice[1]]),
        fmt::format("elements_mm: elements {} and {} are at the same place; each needs its own", twice[0], twice[1]));
}

/// [x, y], [x, y, z], or [x, y, z, nx, ny, nz], where (nx, ny, nz) is the way the element faces, of any length.
std::vector<Element> listed_elements(const std::string& file, const toml::node& node) {
    const auto fail = [&](const toml::node& at) {
        return bad_input(place(file, at),
                         "elements_mm must be a list, in channel order, of [x, y], [x, y, z] or [x, y, z, nx, ny, nz], "
                         "all numbers, found " +
                             found(at));
    };
    const toml::array* list = node.as_array();
    if (list == nullptr || list->empty()) throw fail(node);
    std::vector<Element> elements;
    for (const toml::node& entry : *list) {
        const toml::array* row = entry.as_array();
        if (row == nullptr || (row->size() != 2 && row->size() != 3 && row->size() != 6)) throw fail(entry);
        double values[6] = {0.0, 0.0, 0.0, 0.0, 0.0, 1.0};
        for (std::size_t i = 0; i < row->size(); ++i) {
            const auto value = (*row)[i].value<double>();
            if (!value || !std::isfinite(*value)) throw fail(entry);
            values[i] = *value;
        }
        const Vec3 normal{values[3], values[4], values[5]};
        if (!(norm(normal) > 1e-9) || !std::isfinite(norm(normal)))
            throw bad_input(place(file, entry), "the element faces nowhere: (nx, ny, nz) must not be zero");
        elements.push_back(
            {from_mm(values[0], values[1], values[2]), row->size() == 6 ? normal * (1.0 / norm(normal)) : normal});
    }
    refuse_coincident(elements, file, *list);
    return elements;
}

void read_geometry(Array& array, const std::string& file, const toml::table& root) {
    const Section section(file, root, "array");
    section.only({"rows", "columns", "pitch_mm", "elements_mm", "carrier_hz", "duty", "reach_angle_deg", "nearest_mm"});
    const auto rows = section.whole("rows", 1, 1000);
    const auto columns = section.whole("columns", 1, 1000);
    const auto pitch = section.number("pitch_mm", 0.1, 1000.0);
    if (const toml::node* list = section.find("elements_mm")) {
        if (rows || columns || pitch)
            throw bad_input(place(file, *list), "give either elements_mm or rows, columns and pitch_mm, not both");
        array.elements = listed_elements(file, *list);
    } else {
        if (!rows || !columns || !pitch)
            throw bad_input(file, "[array] must have rows, columns and pitch_mm, or elements_mm");
        array.elements = grid(*rows, *columns, *pitch * millimetre);
        array.columns = *columns;
    }
    assign(array.duty, section.number("duty", 1e-3, 0.5));
    assign(array.reach_angle_rad, section.number("reach_angle_deg", 1.0, 89.0), degree);
    const auto nearest = section.number("nearest_mm", 0.0, 1e4);
    const double diameter = 2.0 * array.transducer.radius_m;
    array.nearest_m = nearest ? *nearest * millimetre : 10.0 * diameter * diameter / (4.0 * array.wavelength_m());
}

void read_medium(Medium& medium, double carrier_hz, const std::string& file, const toml::table& root) {
    const Section section(file, root, "medium");
    section.only(
        {"speed_m_s", "temperature_c", "density_kg_m3", "humidity_percent", "pressure_kpa", "absorption_db_m"});
    const auto speed = section.number("speed_m_s", 100.0, 2000.0);
    const auto temperature = section.number("temperature_c", -50.0, 100.0);
    const auto humidity = section.number("humidity_percent", 0.0, 100.0);
    const auto pressure = section.number("pressure_kpa", 10.0, 200.0);
    const auto absorption = section.number("absorption_db_m", 0.0, 100.0);
    if (speed && temperature) throw bad_input(file, "[medium] must have speed_m_s or temperature_c, not both");
    for (const char* key : {"humidity_percent", "pressure_kpa"})
        if (section.find(key) != nullptr && !temperature)
            throw bad_input(section.at(key), fmt::format("medium.{} says nothing without temperature_c", key));
    if (humidity && absorption)
        throw bad_input(section.at("absorption_db_m"),
                        "[medium] must have absorption_db_m or humidity_percent, which gives it, not both");
    if (temperature) {
        const double pressure_pa = pressure.value_or(standard_pressure_pa * 1e-3) * 1e3;
        medium.speed_m_s = speed_of_sound(*temperature);
        medium.density_kg_m3 = air_density(*temperature, pressure_pa, humidity.value_or(0.0));
        if (humidity) medium.absorption_np_m = absorption_np_m(carrier_hz, *temperature, *humidity, pressure_pa);
    }
    assign(medium.speed_m_s, speed);
    assign(medium.density_kg_m3, section.number("density_kg_m3", 0.1, 10.0));
    if (absorption) medium.absorption_np_m = db_to_np(*absorption);
}

void read_transducer(Transducer& transducer, const std::string& file, const toml::table& root) {
    const Section section(file, root, "transducer");
    section.only({"file", "name", "radius_mm", "source_pa_m", "measured", "bandwidth_hz", "directivity"});
    if (const auto from = section.text("file")) {
        try {
            transducer = find_transducer(*from, std::filesystem::path(file).parent_path());
        } catch (const Error& error) {
            throw bad_input(section.at("file"), error.what());
        }
    }
    read_transducer_keys(transducer, section);
    if (!transducer.measured.empty() && section.find("source_pa_m") == nullptr)
        throw bad_input(section.at("measured"),
                        "transducer.measured says how source_pa_m was measured; give that, too");
}

}  // namespace

void Array::require_one_weight() const {
    if (std::ranges::any_of(elements, [](const Element& element) { return element.weight != 1.0; }))
        throw bad_input(file,
                        "its elements have weights, but all pulses of a record of timings have one length; take "
                        "a board that computes foci, or drive = \"full\" in the calibration");
}

std::string Array::unreachable(Vec3 focus) const {
    if (faces.empty() && focus.z <= 0.0) return "on or behind the array";
    for (std::size_t m = 0; m < elements.size(); ++m) {
        const double range = distance(focus, elements[m].position);
        if (range < nearest_m)
            return fmt::format("{:.2f} mm from element {}, nearer than {:.2f} mm", range / millimetre, m,
                               nearest_m / millimetre);
    }
    const auto from = [this](Vec3 seen) -> std::string {
        if (seen.z <= 0.0) return "on or behind the array";
        const double angle = std::atan2(std::hypot(seen.x, seen.y), seen.z);
        if (angle > reach_angle_rad)
            return fmt::format("{:.1f}° off the axis, beyond {:.1f}°", angle / degree, reach_angle_rad / degree);
        return {};
    };
    if (faces.empty()) return from(focus);
    std::string reasons;
    for (std::size_t i = 0; i < faces.size(); ++i) {
        const std::string reason = from(faces[i].inwards(focus));
        if (reason.empty()) return {};
        reasons += faces.size() == 1 ? reason : fmt::format("{}unit {}: {}", i == 0 ? "" : "; ", i + 1, reason);
    }
    return reasons;
}

Array load_array(const std::filesystem::path& path) {
    const std::string file = path.string();
    const toml::table root = section::parse(path);
    if (root["format"].value<std::string>() == calibration_format)
        return calibrated(load_array(array_file_of(path)), load_calibration(path), file);
    const Section whole(file, root);
    whole.only({"name", "array", "medium", "transducer", "board"});
    Array array;
    array.file = file;
    array.name = path.stem().string();
    assign(array.name, whole.text("name"));
    assign(array.carrier_hz, Section(file, root, "array").number("carrier_hz", 1e3, 1e6));
    read_medium(array.medium, array.carrier_hz, file, root);
    read_transducer(array.transducer, file, root);
    read_geometry(array, file, root);
    return array;
}

Array find_array(const std::string& name) { return load_array(path_or_shipped(name, "arrays", ".toml", "array")); }

std::vector<std::string> shipped_arrays() { return shipped_names("arrays", ".toml"); }

}  // namespace haptogram
