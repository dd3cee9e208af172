// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "haptogram/base/progress.hpp"
#include "haptogram/format/image.hpp"
#include "haptogram/format/pulses.hpp"
#include "haptogram/link/client.hpp"
#include "pulse_check.hpp"

namespace haptogram::sim {

struct PlaybackOptions {
    bool load_by_uart = true;          ///< otherwise straight into the memories
    std::uint32_t passes = 1;          ///< over the sequence
    std::optional<double> duration_s;  ///< instead of passes: play for this long, repeating the sequence
    std::filesystem::path trace;       ///< FST file when not empty
    Progress progress{};
};

/// What happened when an image was played on the simulated board.
struct Playback {
    std::vector<Pulse> pulses;
    std::vector<Dwell> dwells;
    PulseReport pulse_report;
    link::Status status;
    std::vector<std::string> violations;  ///< broken contracts in words; empty when all is well
    std::uint64_t violation_count = 0;
    std::uint64_t clocks = 0;  ///< simulated, loading included
    std::uint64_t playing_clocks = 0;
    double seconds = 0.0;  ///< of wall time, for `clocks`
    double playing_seconds = 0.0;
};

/// The first of these configurations that can play an image, by its name.
/// @param where  names the image in messages
/// @throws Error{bad_input} when there is none
[[nodiscard]] std::string_view model_for(const Image& image, const std::string& where,
                                         std::span<const interface::CoreConfiguration> models = available_models());

/// Puts an image straight into a board's memories, as a bitstream does. What it has of parameters, geometry and
/// modulation goes over the link, and a reset follows, after which the board is as if new.
void load_directly(Board& board, const Image& image);

/// Loads an image into a simulated board, enables the outputs, plays the sequence, stops, and checks at the pins what
/// the contracts promise: every pulse equal to the image, every record for its dwell and in order, nothing refused,
/// late, damaged or tripped, silence at the end.
/// @param where  names the image in messages
/// @throws Error{bad_input} when no Verilated core can play the image, Error{device} when the board does not answer
[[nodiscard]] Playback play(const Image& image, const PlaybackOptions& options, const std::string& where);

}  // namespace haptogram::sim
