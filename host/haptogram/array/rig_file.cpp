// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "haptogram/array/rig.hpp"
#include "haptogram/base/shipped.hpp"
#include "haptogram/base/toml_section.hpp"

namespace haptogram {
namespace {

using section::place;
using section::Section;

constexpr std::string_view format = "haptogram-rig-1";

/// A shipped array's name, or a path relative to the rig's file.
Array array_of(const std::string& name, const std::filesystem::path& rig) {
    const std::filesystem::path path(name);
    if (!name.ends_with(".toml") || path.is_absolute()) return find_array(name);
    return load_array(rig.parent_path() / path);
}

PosedArray read_unit(const std::string& file, const toml::table& table) {
    const Section unit(file, table);
    unit.only({"array", "origin_mm", "turn_deg", "board", "port"});
    const std::string name = unit.required(unit.text("array"), "array", "the name of a shipped array or a path");
    const auto origin = unit.required(unit.numbers("origin_mm", 3), "origin_mm", "where its centre is: [x, y, z]");
    const auto turn = unit.numbers("turn_deg", 3).value_or(std::vector{0.0, 0.0, 0.0});
    try {
        return {array_of(name, file), pose_of(from_mm(origin[0], origin[1], origin[2]), {turn[0], turn[1], turn[2]})};
    } catch (const Error& error) {
        throw bad_input(unit.at("array"), error.what());
    }
}

RigBoard read_board(const std::string& file, const toml::table& table) {
    const Section unit(file, table);
    constexpr auto named = [](const std::string& text) { return !text.empty(); };
    return {unit.text("board", "the name of a board or of a configuration of the core", named).value_or(""),
            unit.text("port", "the name of a port, such as /dev/ttyUSB0", named).value_or("")};
}

/// @throws Error{bad_input} when two units are behind one port
void require_own_ports(const Rig& rig, const std::string& file, const toml::array& units) {
    for (std::size_t a = 0; a < rig.boards.size(); ++a)
        for (std::size_t b = 0; b < a; ++b)
            if (!rig.boards[a].port.empty() && rig.boards[a].port == rig.boards[b].port)
                throw bad_input(place(file, units[a]),
                                fmt::format("its port is {}, and so is that of unit {}; each board has a port of its "
                                            "own",
                                            rig.boards[a].port, b + 1));
}

/// @throws Error when two transducers of different units are nearer than they are wide
void require_apart(const Rig& rig, const std::string& file, const toml::array& units) {
    constexpr double rounding_m = 1e-9;
    for (std::size_t a = 0; a < rig.arrays.size(); ++a)
        for (std::size_t b = 0; b < a; ++b)
            for (const Element& one : rig.arrays[a].array.elements)
                for (const Element& other : rig.arrays[b].array.elements) {
                    const double apart = distance(rig.arrays[a].pose.outwards(one.position),
                                                  rig.arrays[b].pose.outwards(other.position));
                    const double width = 2.0 * rig.arrays[a].array.transducer.radius_m;
                    if (apart < width - rounding_m)  // transducers may touch
                        throw bad_input(place(file, units[a]),
                                        fmt::format("this unit stands in unit {}: two of their transducers are {:.2f} "
                                                    "mm apart, and {:g} mm wide; move or turn it",
                                                    b + 1, apart / millimetre, width / millimetre));
                }
}

}  // namespace

Rig load_rig(const std::filesystem::path& path) {
    const std::string file = path.string();
    const toml::table root = section::parse(path);
    const Section whole(file, root);
    whole.only({"format", "name", "unit"});
    if (whole.required(whole.text("format"), "format", fmt::format("\"{}\"", format)) != format)
        throw whole.wrong(*whole.find("format"), "format", fmt::format("\"{}\"", format));
    Rig rig{whole.text("name").value_or(path.stem().string()), {}, file};
    const toml::array* units = root["unit"].as_array();
    if (units == nullptr || units->empty() || !units->is_array_of_tables())
        throw bad_input(whole.at("unit"), "expected at least one unit, each a table that begins with [[unit]]");
    for (const toml::node& unit : *units) {
        rig.arrays.push_back(read_unit(file, *unit.as_table()));
        rig.boards.push_back(read_board(file, *unit.as_table()));
    }
    require_own_ports(rig, file, *units);
    try {
        static_cast<void>(joined(rig));
    } catch (const Error& error) {
        throw bad_input(file, error.message());
    }
    require_apart(rig, file, *units);
    return rig;
}

Rig find_rig(const std::string& name) { return load_rig(path_or_shipped(name, "rigs", ".toml", "rig")); }

std::vector<std::string> shipped_rigs() { return shipped_names("rigs", ".toml"); }

}  // namespace haptogram
