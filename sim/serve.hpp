// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "board.hpp"
#include "haptogram/format/core.hpp"
#include "haptogram/link/frame.hpp"
#include "host_line.hpp"
#include "pace.hpp"

namespace haptogram::sim {

/// Counts what goes over a board's line, from outside the board. A frame that the board does not answer was damaged or
/// cut off.
class LinkCounters {
public:
    /// @param header  bytes before each frame from the board that are not part of it: those of a chain
    explicit LinkCounters(std::size_t header = 0) : header_(header) {}
    void in(std::span<const std::uint8_t> bytes);
    void out(std::span<const std::uint8_t> bytes);

    std::uint64_t bytes_in = 0, bytes_out = 0;
    std::uint64_t frames = 0;                              ///< that came in
    std::uint64_t applied = 0, repeated = 0, refused = 0;  ///< those that were answered

private:
    std::size_t header_, place_ = 0;
    bool in_frame_ = false;
    link::ReplyDecoder decoder_;
};

inline constexpr double most_behind_s = 0.1;  ///< that a served board makes up for

struct ServeOptions {
    bool real_time = true;  ///< run no faster than a real board; otherwise as fast as this machine can
    double seconds = 0.0;   ///< end after so much simulated time; 0: no limit
};

/// What a simulated board was asked and did while it was served.
struct Served {
    LinkCounters link;
    double simulated_s = 0.0;
    double wall_s = 0.0;               ///< time that passed meanwhile
    std::uint64_t playing_clocks = 0;  ///< simulated while it played
    double playing_s = 0.0;            ///< that simulating these took, without waiting for real time
    std::uint16_t index = 0;           ///< the record at the pins
    bool enabled = false;              ///< its outputs
};

/// Runs a simulated board behind a line that others can reach: what they write reaches it, and the other way round.
/// @param watch  told many times a second what was done so far; false ends the serving
Served serve(Board& board, HostLine& line, const ServeOptions& options,
             const std::function<bool(const Served&)>& watch);

/// The first of these configurations with this many channels, by its name.
/// @throws Error{bad_argument} for "channels" when there is none; the message lists those that there are
[[nodiscard]] std::string_view model_with_channels(
    std::uint32_t channels, std::span<const interface::CoreConfiguration> models = available_models());

/// Those of these configurations whose boards have a network port, or have a serial line.
[[nodiscard]] std::vector<interface::CoreConfiguration> models_of(bool network,
                                                                  std::span<const interface::CoreConfiguration> models);

/// The first of these configurations that can stand for a core: as many channels at the same clock, and all that it has
/// of memory and features.
/// @throws Error{bad_argument} for "board" when there is none; the message lists those that there are
[[nodiscard]] std::string_view model_like(const Core& core,
                                          std::span<const interface::CoreConfiguration> models = available_models());

}  // namespace haptogram::sim
