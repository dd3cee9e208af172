// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <CLI/CLI.hpp>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "haptogram/format/rig_bundle.hpp"
#include "haptogram/link/port.hpp"
#include "haptogram/link/rig.hpp"

namespace haptogram::cli {

/// One board behind a port, or a rig of several.
struct RigPorts {
    std::string rig;  ///< its manifest; empty: one board
    std::vector<std::string> ports;
    std::optional<std::uint32_t> baud;

    [[nodiscard]] bool is_rig() const { return !rig.empty(); }
    /// Of one board.
    /// @throws Error{bad_argument} unless there is one port
    [[nodiscard]] link::PortSettings one() const;
    /// Of a rig's tiles.
    [[nodiscard]] std::vector<link::PortSettings> of(const RigBundle& bundle) const;
};

/// Adds the options that say where the board is, or the boards of a rig are. @return the option --rig
CLI::Option* add_rig_port_options(CLI::App& sub, RigPorts& ports);
/// Adds the option that says what becomes of the others when a tile is lost.
void add_on_loss_option(CLI::App& sub, CLI::Option* rig, std::string& on_loss);
[[nodiscard]] link::OnLoss on_loss_of(const std::string& name);

/// What a rig has played, printed like what one board has.
void tell_rig(const link::RigPlayed& played, const nlohmann::ordered_json& json, bool as_json,
              const std::string& sentence);

/// What a rig that plays is doing, for a progress line.
[[nodiscard]] std::string words_of(const link::RigPlaying& now);

}  // namespace haptogram::cli
