// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "haptogram/robot/simulate.hpp"
#include "haptogram/robot/workspace.hpp"

namespace haptogram::robot {

/// A workspace as CSV: x_mm,y_mm,z_mm,useful, a row a cube, x fastest; useful is 0 or 1.
[[nodiscard]] std::string to_csv(const Workspace& workspace);
/// A trace as CSV: a row a time with the handle's place, the virtual body's, both forces and the tensions; mm, N, s.
[[nodiscard]] std::string to_csv(const Simulation& simulation);

/// @throws Error{bad_argument} naming "output" unless the path ends in .csv or .png, or has no ending, which means CSV
void check_output_path(const std::string& path);

/// Writes a workspace or a trace as CSV, or draws it as .png with the shipped script and Python's matplotlib.
/// @throws Error{bad_input} naming the path when it cannot be written or drawn
void write_workspace(const std::string& path, const Workspace& workspace, const std::string& title);
/// The same. @param zones  whose balls the trace's picture shows
void write_trace(const std::string& path, const Simulation& simulation, const Zones& zones);

}  // namespace haptogram::robot
