// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "report.hpp"
#include "simulate.hpp"

namespace haptogram::cli {

/// Adds what the checks of pulses and foci found, of one board or of a rig.
void add_checks(Report& report, const Manifest& manifest, const sim::Simulation& simulation);

/// Writes the pulses and the report to the files that were asked for, and prints the report unless one of them went to
/// standard output.
/// @param pulses, file  empty for none
/// @return the exit code
[[nodiscard]] int finish(const Report& report, const sim::Simulation& simulation, const std::string& pulses,
                         const std::string& file, bool json);

}  // namespace haptogram::cli
