// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "child.hpp"
#include "haptogram/format/core.hpp"
#include "haptogram/link/transport.hpp"

namespace haptogram::studio {

/// Where a board is.
struct BoardPort {
    std::string name;
    std::optional<std::uint32_t> baud;  ///< none: it is found
};

/// A simulated board in a process of its own: this program as 'board run'.
class VirtualBoard {
public:
    /// Starts it and returns at once.
    /// @param core   what it is to be like; of one whose name 'board run --board' does not know, the channels count
    /// @param model  as 'board run --model' takes it: "reference" keeps real time, "rtl" is the FPGA's own Verilog
    /// @throws Error{failed} when no process can be started
    VirtualBoard(const Core& core, const std::string& model);

    /// Opens the board's port. Waits at most so long for the board to name it; it can be called again.
    /// @throws Error{device} when it has not yet, or with the board's own words when it has none
    [[nodiscard]] std::unique_ptr<link::Transport> open(
        std::chrono::milliseconds patience = std::chrono::milliseconds(200));

    /// Where it is; none while it is still starting.
    [[nodiscard]] std::optional<BoardPort> port() const;

private:
    Child child_;
    mutable std::mutex mutex_;
    std::optional<BoardPort> port_;
    std::string text_;
};

}  // namespace haptogram::studio
