// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>

#include "haptogram/link/commands.hpp"

namespace haptogram::link {

using interface::Event;
using interface::Test;

/// How a device's trigger pins and its test output are set up (the trigger block of rtl/INTERFACE.md). They stay so
/// over a reset.
struct TriggerSettings {
    Event event = Event::none;        ///< what makes a pulse at the trigger output
    std::uint16_t every_periods = 1;  ///< of Event::period
    double pulse_s = 1e-3;            ///< how long the output is high, from an event on
    bool active_low = false;          ///< the trigger input is active while it is low
    bool by_level = false;  ///< what waits for the trigger begins while it is active, too; not only when it becomes so
    bool gates = false;     ///< no pulse reaches the pins while the trigger input is not active
    double settle_s = 0;    ///< for which a change of the input must last before it counts
    Test test = Test::off;  ///< what is at the test output
    std::uint32_t channel = 0;  ///< of Test::carrier
    friend bool operator==(const TriggerSettings&, const TriggerSettings&) = default;
};

/// All of one moment. Clocks count from the device's power-up.
struct TriggerTimes {
    std::uint64_t now = 0;
    std::uint16_t out_count = 0, in_count = 0;  ///< events at the output, and at the input, modulo 65,536
    std::uint64_t out = 0, in = 0;              ///< the clock of the last of each; of no meaning when there was none
    friend bool operator==(const TriggerTimes&, const TriggerTimes&) = default;
};

/// @throws Error{bad_argument} when a time or channel is not one that the device can have
/// @throws Error{device} when it has no triggers; so do the others
void set_trigger(Commands& device, const TriggerSettings& settings);
[[nodiscard]] TriggerSettings trigger_settings(Commands& device);
[[nodiscard]] TriggerTimes trigger_times(Commands& device);

}  // namespace haptogram::link
