// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/outputs.hpp"

#include <fmt/core.h>

#include <exception>
#include <utility>

#include "haptogram/base/error.hpp"

namespace haptogram::link {

Outputs::Outputs(Commands& device, std::uint16_t watchdog_ms, Warning warn)
    : device_(device), watchdog_ms_(watchdog_ms), warn_(std::move(warn)) {
    device_.set_watchdog(watchdog_ms);
    try {
        device_.enable();
    } catch (const Error&) {
        end();  // the outputs may be on: perhaps only the answer was lost
        throw;
    }
}

void Outputs::end() noexcept {
    try {
        device_.disable();
        device_.stop();
    } catch (const Error& error) {
        if (error.code() == ErrorCode::cancelled || !warn_) return;  // DeviceThread has turned them off already
        try {
            warn_(fmt::format("{}; {}", error.what(),
                              watchdog_ms_ != 0 ? "the watchdog turns the outputs off"
                                                : "the outputs may still be on: switch the power off"));
        } catch (const std::exception&) {
            // A warning that cannot be given must not end the program while it cleans up.
        }
    }
}

void require_on(const Status& status) {
    if (!status.enabled)
        throw Error(ErrorCode::device, "board", "it has turned its outputs off: its watchdog or guard tripped");
}

bool is_over(const Status& status) {
    return status.present_index == 0 && status.live_level == 0 &&
           (status.mode == Mode::idle || status.mode == Mode::live);
}

Status sure_status(Commands& device) {
    const Status status = device.status();
    return is_over(status) ? device.status() : status;
}

}  // namespace haptogram::link
