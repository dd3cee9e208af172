// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "haptogram/link/commands.hpp"

namespace haptogram::link {

/// Told, in words for the user, of trouble that does not end the work.
using Warning = std::function<void(const std::string& message)>;

/// Turns the outputs on, does some work, and turns them off again, whatever became of it. If the whole program dies,
/// the device's watchdog does that.
/// @param watchdog_ms  after how long without a frame the outputs go off; 0: never
/// @return whether the work, or the turning on, was Interrupted
/// @throws what the work does, Error{device} when the device does not confirm that its outputs are off
bool while_on(Commands& device, std::uint16_t watchdog_ms, const std::function<void()>& work);

/// Does some work, and then shuts off what it has turned on, whatever became of it. Everything that enables outputs
/// goes through here.
/// @param off  shuts off; says in words who has not confirmed it, and nothing when all have
bool then_off(const std::function<void()>& work, const std::function<std::string()>& off);

/// In words, that a device does not confirm that its outputs are off, and what will turn them off.
/// @param watchdog_ms  its watchdog's time, if it is known
[[nodiscard]] std::string not_confirmed(std::optional<std::uint16_t> watchdog_ms);

/// @param before  a status of when the outputs were on, if there is one: its counters tell what turned them off
/// @throws Error{device} when the device has turned its outputs off by itself
void require_on(const Status& status, const Status* before = nullptr);

/// Whether nothing plays and nothing is to come.
[[nodiscard]] bool is_over(const Status& status);

/// The status; when it says that all is over, it is asked for a second time. For between the clock in which a record of
/// amplitudes is taken and its first pulse passes up to one carrier period, which is less than a status takes on the
/// line.
[[nodiscard]] Status sure_status(Commands& device);

}  // namespace haptogram::link
