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

/// Whether nothing plays and nothing is to come.
[[nodiscard]] bool is_over(const Status& status);

/// The status; when it says that all is over, it is asked for a second time. For between the clock in which a record of
/// amplitudes is taken and its first pulse passes up to one carrier period, which is less than a status takes on the
/// line.
[[nodiscard]] Status sure_status(Commands& device);

}  // namespace haptogram::link
