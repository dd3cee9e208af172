// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "command.hpp"
#include "haptogram/verbs/level.hpp"

namespace haptogram::cli {

/// What was measured of a steady focus: a balance's reading, or a microphone's with its sensitivity.
struct LevelOptions {
    std::optional<double> measured_mn, measured_mv, sensitivity;

    [[nodiscard]] bool given() const { return measured_mn || measured_mv; }
    /// @throws Error{bad_argument} when a value is not positive
    [[nodiscard]] LevelReading reading() const {
        if (measured_mn) return {*measured_mn * 1e-3, {}};
        return {{}, microphone_pa(*measured_mv, *sensitivity)};
    }
};

/// Adds --measured-mn, and --measured-mv with --sensitivity; `lead` begins their help. --focus must be there already.
inline void add_level_options(CLI::App& sub, LevelOptions& level, const std::string& lead) {
    auto* force = sub.add_option("--measured-mn", level.measured_mn,
                                 lead +
                                     "from a balance's reading at --focus, on a flat disc of 20 mm, at full steady "
                                     "drive, mN");
    auto* volts =
        sub.add_option("--measured-mv", level.measured_mv,
                       lead + "from a calibrated microphone's rms voltage at --focus, at full steady drive, mV");
    auto* sensitivity = sub.add_option("--sensitivity", level.sensitivity,
                                       "The microphone's sensitivity at the carrier, with its amplifier, mV/Pa");
    force->check(positive())->excludes(volts)->needs(sub.get_option("--focus"));
    volts->check(positive())->needs(sensitivity)->needs(sub.get_option("--focus"));
    sensitivity->check(positive())->needs(volts);
}

}  // namespace haptogram::cli
