// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <functional>
#include <string>

#include "haptogram/link/commands.hpp"

namespace haptogram::link {

/// Told, in words for the user, of trouble that does not end the work.
using Warning = std::function<void(const std::string& message)>;

/// The outputs are on while this lives, and off when it goes, whatever ended the playing. If the whole program dies,
/// the device's watchdog does that.
class Outputs {
public:
    /// @param watchdog_ms  after how long without a frame the outputs go off; 0: never
    /// @param warn         told when the outputs could not be turned off
    Outputs(Commands& device, std::uint16_t watchdog_ms, Warning warn = {});
    Outputs(const Outputs&) = delete;
    Outputs& operator=(const Outputs&) = delete;
    ~Outputs() { end(); }

private:
    void end() noexcept;

    Commands& device_;
    std::uint16_t watchdog_ms_;
    Warning warn_;
};

/// @throws Error{device} when the device has turned its outputs off by itself
void require_on(const Status& status);

}  // namespace haptogram::link
