// SPDX-License-Identifier: Apache-2.0
#include "haptogram/robot/robot_file.hpp"

#include <fmt/format.h>

#include <iterator>
#include <vector>

#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/picture.hpp"

namespace haptogram::robot {
namespace {

/// Has the shipped script draw a CSV. @param words  what else the script takes
void draw(const std::string& path, const std::string& kind, const std::string& csv,
          const std::vector<std::string>& words) {
    Picture picture("shipped:tools/plot_robot.py");
    picture.add("table.csv", csv);
    picture.add("words.txt", fmt::format("{}\n{}\n", kind, fmt::join(words, "\n")));
    picture.draw(path, ".csv files");
}

}  // namespace

std::string to_csv(const Workspace& workspace) {
    fmt::memory_buffer text;
    auto out = std::back_inserter(text);
    fmt::format_to(out, "x_mm,y_mm,z_mm,useful\n");
    std::size_t i = 0;
    for (const double z : workspace.axis[2])
        for (const double y : workspace.axis[1])
            for (const double x : workspace.axis[0])
                fmt::format_to(out, "{:.4f},{:.4f},{:.4f},{:d}\n", x * 1e3, y * 1e3, z * 1e3,
                               workspace.useful[i++] ? 1 : 0);
    return fmt::to_string(text);
}

std::string to_csv(const Simulation& simulation) {
    fmt::memory_buffer text;
    auto out = std::back_inserter(text);
    fmt::format_to(out, "time_s");
    for (const char* what : {"", "wanted_"}) fmt::format_to(out, ",{0}x_mm,{0}y_mm,{0}z_mm", what);
    for (const char* what : {"user", "measured"}) fmt::format_to(out, ",{0}_x_n,{0}_y_n,{0}_z_n", what);
    for (int i = 1; i <= cable_count; ++i) fmt::format_to(out, ",tension_{}_n", i);
    fmt::format_to(out, "\n");
    for (const TraceRow& row : simulation.rows) {
        fmt::format_to(out, "{:.4f}", row.time_s);
        for (const Vector3& place : {row.position, row.wanted})
            for (int k = 0; k < 3; ++k) fmt::format_to(out, ",{:.4f}", place[k] * 1e3);
        for (const Vector3& force : {row.user, row.measured})
            for (int k = 0; k < 3; ++k) fmt::format_to(out, ",{:.4f}", force[k]);
        for (int i = 0; i < cable_count; ++i) fmt::format_to(out, ",{:.4f}", row.tensions[i]);
        fmt::format_to(out, "\n");
    }
    return fmt::to_string(text);
}

void check_output_path(const std::string& path) {
    const std::string kind = ending_of(path);
    if (!kind.empty() && kind != ".csv" && kind != ".png")
        throw bad_argument("output",
                           fmt::format("'{}' is no ending that is known; .csv and .png are, and none means CSV", kind));
}

void write_workspace(const std::string& path, const Workspace& workspace, const std::string& title) {
    check_output_path(path);
    if (ending_of(path) == ".png")
        draw(path, "workspace", to_csv(workspace), {title});
    else
        write_file(path, to_csv(workspace));
}

void write_trace(const std::string& path, const Simulation& simulation, const Zones& zones) {
    check_output_path(path);
    if (ending_of(path) != ".png") {
        write_file(path, to_csv(simulation));
        return;
    }
    std::vector<std::string> words = {
        fmt::format("{:g},{:g},{:g}", zones.inner_m * 1e3, zones.middle_m * 1e3, zones.outer_m * 1e3)};
    for (const Event& event : simulation.events)
        words.push_back(fmt::format("{:.3f}:{}", event.time_s, name_of(event.kind)));
    draw(path, "trace", to_csv(simulation), words);
}

}  // namespace haptogram::robot
