// SPDX-License-Identifier: Apache-2.0
#include "haptogram/array/rig.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "haptogram/base/error.hpp"
#include "haptogram/base/shipped.hpp"
#include "haptogram/base/toml_section.hpp"

namespace haptogram {

Array joined(const Rig& rig) {
    if (rig.arrays.empty()) throw bad_argument("rig", fmt::format("'{}' has no arrays; give at least one", rig.name));
    Array whole = rig.arrays.front().array;
    whole.name = rig.name;
    whole.elements.clear();
    if (rig.arrays.size() > 1) whole.columns = 0;
    whole.file = rig.file;
    for (const auto& [array, pose] : rig.arrays) {
        if (array.carrier_hz != whole.carrier_hz || array.duty != whole.duty || array.medium != whole.medium ||
            array.transducer != whole.transducer || array.reach_angle_rad != whole.reach_angle_rad ||
            array.nearest_m != whole.nearest_m)
            throw bad_argument("rig", fmt::format("'{}': its arrays must have the same carrier, duty, medium, "
                                                  "transducer and reach; {} differs from {}",
                                                  rig.name, array.name, rig.arrays.front().array.name));
        whole.faces.push_back(pose);
        for (const Element& element : array.elements)
            whole.elements.push_back(
                {pose.outwards(element.position), pose.turned(element.normal), element.response, element.weight});
    }
    return whole;
}

Array seen_from(Array array, const Pose& pose) {
    const Pose straight;
    if (pose.x != straight.x || pose.y != straight.y || pose.z != straight.z) array.columns = 0;
    if (array.faces.empty()) array.faces.emplace_back();
    for (Pose& face : array.faces) {
        const auto turned = [&pose](Vec3 d) { return Vec3{dot(d, pose.x), dot(d, pose.y), dot(d, pose.z)}; };
        face = {pose.inwards(face.origin), turned(face.x), turned(face.y), turned(face.z)};
    }
    for (Element& element : array.elements) {
        const Vec3 n = element.normal;
        element.position = pose.inwards(element.position);
        element.normal = {dot(n, pose.x), dot(n, pose.y), dot(n, pose.z)};
    }
    return array;
}

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
