// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace haptogram::cli {

/// What `board run --tiles` was asked.
struct RunTilesOptions {
    std::size_t count = 0;  ///< 0: a single board
    double drift_ppm = 50.0;
    std::uint32_t seed = 1;
    std::vector<std::string> faults;
    bool reference = false;  ///< reference boards, instead of Verilated cores
    std::uint32_t channels = 100;
    bool chain = false;  ///< one serial line for all
    std::string pty;
    bool real_time = true;
    double seconds = 0.0;
    bool json = false;
};

/// A line on standard output at once: the report as JSON, or the sentence.
void tell_line(const nlohmann::ordered_json& report, bool as_json, const std::string& sentence);

/// Runs the boards until an interrupt, or the end of their time. @return the exit code
int run_boards(const RunTilesOptions& options);

}  // namespace haptogram::cli
