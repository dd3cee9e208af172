// SPDX-License-Identifier: Apache-2.0
// The checks of the self-test, each a function; self_test.cpp calls them in their order.
#pragma once
#include <span>

#include "haptogram/format/image.hpp"
#include "haptogram/link/transport.hpp"
#include "haptogram/verbs/self_test.hpp"

namespace haptogram::link {

// What a program can judge.
[[nodiscard]] Finding check_link(Commands& device, const SelfTestSettings& settings);
[[nodiscard]] Finding check_memories(Commands& device, const SelfTestSettings& settings);
[[nodiscard]] Finding check_clock(Commands& device, const SelfTestSettings& settings);
[[nodiscard]] Finding check_sync(Commands& device, const SelfTestSettings& settings);
[[nodiscard]] Finding check_outputs(Commands& device, const SelfTestSettings& settings);
[[nodiscard]] Finding check_watchdog(Commands& device, const SelfTestSettings& settings);

// What only a person can judge.
[[nodiscard]] Finding check_stop_switch(Commands& device, const SelfTestSettings& settings);
[[nodiscard]] Finding check_channels(Commands& device, const SelfTestSettings& settings);
[[nodiscard]] Finding check_point(Commands& device, const SelfTestSettings& settings);

/// A check that was interrupted ends the whole test.
inline void heed(bool interrupted) {
    if (interrupted) throw Interrupted();
}

/// An image of one record, which plays 200 times a second for half of the time: what skin feels best, and an ear hears.
/// @param timings  of its channels; interface::silent_timing for those that are silent
[[nodiscard]] Image pulsing_image(const Identity& identity, const Array& array, std::span<const std::uint16_t> timings);

}  // namespace haptogram::link
