// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pseudo_terminal.hpp"
#include "serve.hpp"
#include "tiles.hpp"

namespace haptogram::sim {

/// Something that goes wrong with one of several boards, to see what a host makes of it.
struct TileFault {
    enum class Kind {
        silent,  ///< its serial line is cut: nothing gets in or out any more, and in a chain nothing to those behind it
        sync,    ///< its end of the wire SYNC is loose
    };
    Kind kind = Kind::silent;
    std::size_t tile = 0;  ///< counted from 0
    double at_s = 0.0;     ///< of the boards' time
};

/// Reads "silent:2@1.5" or "sync:3@0.2": what happens to which tile, counted from 1, after how many seconds.
/// @throws Error{bad_argument} naming "fault"
[[nodiscard]] TileFault parse_fault(const std::string& text, std::size_t tiles);

/// What several boards were asked and did while they were served.
struct ServedTiles {
    double simulated_s = 0.0;
    double wall_s = 0.0;  ///< time that passed meanwhile
    std::uint64_t frames = 0, applied = 0;
    std::vector<bool> enabled;  ///< outputs, one a tile, in the end
};

/// The first of these configurations with this many channels that can play together with others.
/// @throws Error{bad_argument} for "channels" when there is none
[[nodiscard]] std::string_view tile_model_with_channels(std::uint32_t channels,
                                                        std::span<const interface::CoreConfiguration> models);

/// Runs several boards, each behind a pseudo-terminal of its own, or all behind one when they are chained, in the time
/// that they share.
/// @param watch  told many times a second what was done so far; false ends the serving
ServedTiles serve(Tiles& tiles, std::span<const std::unique_ptr<PseudoTerminal>> terminals, const ServeOptions& options,
                  std::span<const TileFault> faults, const std::function<bool(const ServedTiles&)>& watch);

}  // namespace haptogram::sim
