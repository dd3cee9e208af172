// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/outputs.hpp"

#include <fmt/core.h>

#include <exception>

#include "haptogram/base/error.hpp"
#include "haptogram/link/transport.hpp"

namespace haptogram::link {

std::string not_confirmed(std::optional<std::uint16_t> watchdog_ms) {
    const std::string found = "it does not confirm that its outputs are off";
    if (!watchdog_ms) return found + "; its watchdog turns them off if it is on: switch its power off to be sure";
    if (*watchdog_ms == 0) return found + ", and its watchdog is off: switch its power off";
    return fmt::format("{}; its watchdog turns them off {} ms after the last command that reached it", found,
                       *watchdog_ms);
}

bool then_off(const std::function<void()>& work, const std::function<std::string()>& off) {
    bool interrupted = false;
    try {
        work();
    } catch (const Interrupted&) {
        interrupted = true;
    } catch (const std::exception& error) {
        if (const std::string trouble = off(); !trouble.empty())
            throw Error(ErrorCode::device, "", fmt::format("{}; {}", error.what(), trouble));
        throw;
    } catch (...) {
        static_cast<void>(off());
        throw;
    }
    if (const std::string trouble = off(); !trouble.empty()) throw Error(ErrorCode::device, "board", trouble);
    return interrupted;
}

bool while_on(Commands& device, std::uint16_t watchdog_ms, const std::function<void()>& work) {
    device.set_watchdog(watchdog_ms);
    const auto on = [&] {
        device.keep_alive_every(keep_alive_pause(watchdog_ms));
        device.enable();
        work();
    };
    const auto off = [&] {
        device.keep_alive_every({});
        return device.turn_off() ? std::string() : not_confirmed(watchdog_ms);
    };
    return then_off(on, off);
}

void require_on(const Status& status, const Status* before) {
    if (status.enabled) return;
    std::string why = "its watchdog or guard tripped";
    if (before != nullptr && status.watchdog_trips != before->watchdog_trips)
        why = fmt::format("its watchdog heard nothing from this host for {} ms", status.watchdog_ms);
    else if (before != nullptr && status.guard_trips != before->guard_trips)
        why = "its guard found a pin high for too long; nothing that was sent may do that: reset the board";
    else if (status.stopped)
        why = "its stop input is active";
    throw Error(ErrorCode::device, "board", "it has turned its outputs off: " + why);
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
