// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "haptogram/link/client.hpp"
#include "haptogram/link/clock.hpp"

namespace haptogram::cli {

/// A board that a loop plays on, and the clock that it keeps.
class LiveBoard {
public:
    LiveBoard() = default;
    LiveBoard(const LiveBoard&) = delete;
    LiveBoard& operator=(const LiveBoard&) = delete;
    virtual ~LiveBoard() = default;
    [[nodiscard]] virtual link::Client& client() = 0;
    [[nodiscard]] virtual link::HostClock clock() = 0;
    /// Changes of the record at the pins, by the clock; empty when nobody can see the pins.
    [[nodiscard]] virtual std::vector<std::pair<double, std::uint16_t>> starts() const { return {}; }
};

/// The reference board of a configuration in this process. The loop's time is the board's.
/// @throws Error{bad_argument} in a build without simulation, or for no configuration
[[nodiscard]] std::unique_ptr<LiveBoard> reference_board(const std::string& configuration);

}  // namespace haptogram::cli
