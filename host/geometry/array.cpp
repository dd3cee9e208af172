// SPDX-License-Identifier: Apache-2.0
#include "geometry/array.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <initializer_list>
#include <numbers>
#include <optional>
#include <sstream>
#include <string_view>

#include "base/error.hpp"
#include "base/file.hpp"

namespace haptogram {
namespace {

constexpr double degree = std::numbers::pi / 180.0;

std::string place(const std::string& file, const toml::node& node) {
    return fmt::format("{}:{}", file, node.source().begin.line);
}

/// The value as the file has it.
std::string found(const toml::node& node) {
    std::ostringstream text;
    node.visit([&text](const auto& value) { text << value; });
    return text.str();
}

/// One table of the file: typed, range-checked, and it knows which keys nobody asked for.
class Section {
public:
    Section(const std::string& file, const toml::table& root, std::string_view name) : file_(file), name_(name) {
        const toml::node* node = root.get(name);
        if (node == nullptr) return;
        table_ = node->as_table();
        if (table_ == nullptr)
            throw bad_input(place(file, *node), fmt::format("'{}' must be a table, [{}]", name, name));
    }

    [[nodiscard]] const toml::node* find(std::string_view key) const {
        return table_ == nullptr ? nullptr : table_->get(key);
    }

    [[nodiscard]] std::optional<double> number(std::string_view key, double low, double high) const {
        const toml::node* node = find(key);
        if (node == nullptr) return {};
        const std::optional<double> value = node->value<double>();
        if (!value || !std::isfinite(*value) || *value < low || *value > high)
            throw bad_input(place(file_, *node), fmt::format("{}.{} must be a number from {} to {}, found {}", name_,
                                                             key, low, high, found(*node)));
        return value;
    }

    [[nodiscard]] std::optional<std::uint32_t> whole(std::string_view key, std::uint32_t low,
                                                     std::uint32_t high) const {
        const toml::node* node = find(key);
        if (node == nullptr) return {};
        const auto value = node->as_integer() == nullptr ? std::optional<std::int64_t>{} : node->value<std::int64_t>();
        if (!value || *value < low || *value > high)
            throw bad_input(place(file_, *node), fmt::format("{}.{} must be a whole number from {} to {}, found {}",
                                                             name_, key, low, high, found(*node)));
        return static_cast<std::uint32_t>(*value);
    }

    [[nodiscard]] std::optional<std::string> text(std::string_view key) const {
        const toml::node* node = find(key);
        if (node == nullptr) return {};
        auto value = node->value<std::string>();
        if (!value)
            throw bad_input(place(file_, *node),
                            fmt::format("{}.{} must be a text in quotes, found {}", name_, key, found(*node)));
        return value;
    }

    void only(std::initializer_list<std::string_view> keys) const {
        if (table_ == nullptr) return;
        for (const auto& [key, node] : *table_)
            if (std::find(keys.begin(), keys.end(), key.str()) == keys.end())
                throw bad_input(place(file_, node), fmt::format("unknown key {}.{}; known are {}", name_, key.str(),
                                                                fmt::join(keys, ", ")));
    }

private:
    std::string file_;
    std::string name_;
    const toml::table* table_ = nullptr;
};

template <class T, class U>
void assign(T& target, const std::optional<U>& value, double factor = 1.0) {
    if (!value) return;
    if constexpr (std::is_same_v<T, double>)
        target = *value * factor;
    else
        target = *value;
}

std::vector<Vec3> grid(std::uint32_t rows, std::uint32_t columns, double pitch_m) {
    std::vector<Vec3> elements;
    for (std::uint32_t r = 0; r < rows; ++r)
        for (std::uint32_t q = 0; q < columns; ++q)
            elements.push_back({(q - (columns - 1) / 2.0) * pitch_m, (r - (rows - 1) / 2.0) * pitch_m, 0.0});
    return elements;
}

std::vector<Vec3> listed_elements(const std::string& file, const toml::node& node) {
    const auto fail = [&](const toml::node& at) {
        return bad_input(place(file, at),
                         "elements_mm must be a list of [x, y] pairs of numbers, in channel order, found " + found(at));
    };
    const toml::array* list = node.as_array();
    if (list == nullptr || list->empty()) throw fail(node);
    std::vector<Vec3> elements;
    for (const toml::node& entry : *list) {
        const toml::array* pair = entry.as_array();
        if (pair == nullptr || pair->size() != 2) throw fail(entry);
        const auto x = (*pair)[0].value<double>();
        const auto y = (*pair)[1].value<double>();
        if (!x || !y || !std::isfinite(*x) || !std::isfinite(*y)) throw fail(entry);
        elements.push_back(from_mm(*x, *y, 0.0));
    }
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
    assign(array.carrier_hz, section.number("carrier_hz", 1e3, 1e6));
    assign(array.duty, section.number("duty", 1e-3, 0.5));
    assign(array.reach_angle_rad, section.number("reach_angle_deg", 1.0, 89.0), degree);
    const auto nearest = section.number("nearest_mm", 0.0, 1e4);
    const double diameter = 2.0 * array.transducer.radius_m;
    array.nearest_m = nearest ? *nearest * millimetre : 10.0 * diameter * diameter / (4.0 * array.wavelength_m());
}

void read_medium(Medium& medium, const std::string& file, const toml::table& root) {
    const Section section(file, root, "medium");
    section.only({"speed_m_s", "temperature_c", "density_kg_m3"});
    const auto speed = section.number("speed_m_s", 100.0, 2000.0);
    const auto temperature = section.number("temperature_c", -50.0, 100.0);
    if (speed && temperature) throw bad_input(file, "[medium] must have speed_m_s or temperature_c, not both");
    if (temperature) medium.speed_m_s = speed_of_sound(*temperature);
    assign(medium.speed_m_s, speed);
    assign(medium.density_kg_m3, section.number("density_kg_m3", 0.1, 10.0));
}

void read_transducer(Transducer& transducer, const std::string& file, const toml::table& root) {
    const Section section(file, root, "transducer");
    section.only({"name", "radius_mm", "source_pa_m", "bandwidth_hz"});
    assign(transducer.name, section.text("name"));
    assign(transducer.radius_m, section.number("radius_mm", 0.1, 100.0), millimetre);
    assign(transducer.source_pa_m, section.number("source_pa_m", 1e-3, 1e3));
    assign(transducer.bandwidth_hz, section.number("bandwidth_hz", 1.0, 1e5));
}

void read_board(BoardSpec& board, const std::string& file, const toml::table& root) {
    const Section section(file, root, "board");
    section.only({"name", "clock_hz", "baud", "channels", "records", "sequence_depth", "timing_bits", "pulse_bits"});
    assign(board.name, section.text("name"));
    assign(board.clock_hz, section.whole("clock_hz", 1'000'000, 1'000'000'000));
    assign(board.baud, section.whole("baud", 1200, 20'000'000));
    assign(board.channels, section.whole("channels", 2, 1000));
    assign(board.records, section.whole("records", 1, 65535));
    assign(board.sequence_depth, section.whole("sequence_depth", 2, 32768));
    assign(board.timing_bits, section.whole("timing_bits", 4, 16));
    assign(board.pulse_bits, section.whole("pulse_bits", 1, 8));
}

}  // namespace

double speed_of_sound(double temperature_c) { return 331.3 * std::sqrt(1.0 + temperature_c / 273.15); }

std::string Array::unreachable(Vec3 focus) const {
    if (focus.z <= 0.0) return "on or behind the array";
    for (std::size_t m = 0; m < elements.size(); ++m) {
        const double range = distance(focus, elements[m]);
        if (range < nearest_m)
            return fmt::format("{:.2f} mm from element {}, nearer than {:.2f} mm", range / millimetre, m,
                               nearest_m / millimetre);
    }
    const double angle = std::atan2(std::hypot(focus.x, focus.y), focus.z);
    if (angle > reach_angle_rad)
        return fmt::format("{:.1f}° off the axis, beyond {:.1f}°", angle / degree, reach_angle_rad / degree);
    return {};
}

Array load_array(const std::filesystem::path& path, const std::optional<BoardSpec>& board) {
    const std::string file = path.string();
    const std::string text = read_file(path);
    toml::table root;
    try {
        root = toml::parse(text);
    } catch (const toml::parse_error& error) {
        throw bad_input(fmt::format("{}:{}", file, error.source().begin.line),
                        fmt::format("not valid TOML: {}", error.description()));
    }
    for (const auto& [key, node] : root)
        if (key != "name" && key != "array" && key != "medium" && key != "transducer" && key != "board")
            throw bad_input(
                place(file, node),
                fmt::format("unknown key '{}'; known are name, array, medium, transducer, board", key.str()));
    Array array;
    array.file = file;
    array.name = path.stem().string();
    if (const toml::node* name = root.get("name")) {
        if (!name->is_string())
            throw bad_input(place(file, *name), "name must be a text in quotes, found " + found(*name));
        array.name = name->value_or(array.name);
    }
    read_medium(array.medium, file, root);
    read_transducer(array.transducer, file, root);
    read_board(array.board, file, root);
    if (board) array.board = *board;
    read_geometry(array, file, root);
    if (array.elements.size() > array.board.channels)
        throw bad_input(
            file, fmt::format("{} elements but the board has {} channels ({}); use a larger board or fewer elements",
                              array.elements.size(), array.board.channels, array.board.name));
    for (std::size_t a = 0; a < array.elements.size(); ++a)
        for (std::size_t b = 0; b < a; ++b)
            if (array.elements[a] == array.elements[b])
                throw bad_input(
                    file, fmt::format(
                              "elements_mm: elements {} and {} are at the same place, ({}, {}) mm; each needs its own",
                              b, a, array.elements[a].x / millimetre, array.elements[a].y / millimetre));
    return array;
}

Array find_array(const std::string& name, const std::optional<BoardSpec>& board) {
    if (name.find('/') != std::string::npos || name.ends_with(".toml")) return load_array(name, board);
    std::error_code error;
    const auto program = std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
    for (const auto& folder : {program / HAPTOGRAM_INSTALLED_ARRAYS, std::filesystem::path(HAPTOGRAM_SOURCE_ARRAYS)}) {
        const auto path = folder / (name + ".toml");
        if (std::filesystem::exists(path)) return load_array(path, board);
    }
    throw bad_input(name,
                    "no shipped array has this name (shipped are tile-10x10, tile-7x8 and hoshi-18x18); give the path "
                    "of a .toml file");
}

}  // namespace haptogram
