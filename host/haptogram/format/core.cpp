// SPDX-License-Identifier: Apache-2.0
#include "haptogram/format/core.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "haptogram/array/calibration.hpp"
#include "haptogram/base/shipped.hpp"
#include "haptogram/base/toml_section.hpp"
#include "haptogram/format/board.hpp"
#include "haptogram/format/core_section.hpp"

namespace haptogram {
namespace {

using section::Section;

bool is_board(const std::string& name) {
    const std::vector<std::string> shipped = shipped_boards();
    return name.find('/') != std::string::npos || name.ends_with(".toml") ||
           std::find(shipped.begin(), shipped.end(), name) != shipped.end();
}

/// Those that are no board's: a board's has its name.
std::vector<std::string> boardless_configurations() {
    const std::vector<std::string> boards = shipped_boards();
    std::vector<std::string> names;
    for (const auto& one : interface::core_configurations)
        if (std::ranges::find(boards, one.name) == boards.end()) names.emplace_back(one.name);
    return names;
}

}  // namespace

std::string configuration_names() {
    std::string names;
    for (const auto& one : interface::core_configurations)
        names += fmt::format("{}{}", names.empty() ? "" : ", ", one.name);
    return names;
}

Core find_configuration(const std::string& name) {
    if (const auto* one = interface::find_configuration(name)) return {name, one->parameters};
    throw bad_input(name,
                    fmt::format("no configuration of the core has this name; there are {}", configuration_names()));
}

Core find_core(const std::string& name) {
    if (is_board(name)) return load_board(name).core();
    if (const auto* one = interface::find_configuration(name)) return {name, one->parameters};
    require_no_part(name, "boards", ".toml", "board");
    throw bad_input(name,
                    fmt::format("no shipped board has this name (`haptogram board list` has theirs), nor has another "
                                "configuration of the core ({}); give the path of a .toml file",
                                fmt::join(boardless_configurations(), ", ")));
}

Core core_of_array(const std::string& name) {
    const std::string path = array_file_of(path_or_shipped(name, "arrays", ".toml", "array"));
    const toml::table root = section::parse(path);
    const Section section(path, root, "board");
    section.only({"name",
                  "configuration",
                  "clock_hz",
                  "baud",
                  "channels",
                  "records",
                  "sequence_depth",
                  "live_depth",
                  "timing_bits",
                  "pulse_bits",
                  "watchdog_ms",
                  "max_high_clocks",
                  "min_pulse_clocks",
                  "max_duty_256",
                  "width_bits",
                  "modulation_depth",
                  "slew",
                  "foci",
                  "schedule",
                  "sync",
                  "chain",
                  "net"});
    Core core = find_configuration("tile-100");
    if (const auto configuration = section.text("configuration")) {
        try {
            core = find_configuration(*configuration);
        } catch (const Error& error) {
            throw bad_input(section.at("configuration"), error.what());
        }
    }
    section::assign(core.name, section.text("name"));
    read_parameters(core.parameters, section, KeyStyle::lower_case);
    return core;
}

std::string array_of_board(const std::string& name) {
    if (interface::find_configuration(name) != nullptr && !is_board(name))
        throw bad_argument("board",
                           fmt::format("{} is a configuration of the core and no board, and so has no array of "
                                       "its own; name the array",
                                       name),
                           {"array"});
    return load_board(name).array;
}

void require_channels(const Array& array, const Core& core) {
    if (array.elements.size() > core.parameters.channels)
        throw bad_input(array.file.empty() ? array.name : array.file,
                        fmt::format("{} elements but the board has {} channels ({}); use a larger board or fewer "
                                    "elements",
                                    array.elements.size(), core.parameters.channels, core.name),
                        {"board", "array"});
}

}  // namespace haptogram
