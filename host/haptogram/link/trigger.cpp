// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/trigger.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "haptogram/base/error.hpp"

namespace haptogram::link {
namespace {

namespace trigger_bits = interface::trigger_field;
using Word = interface::TriggerWord;

void require_triggers(const Commands& device) {
    if (!interface::has(device.identity().features, interface::Feature::trigger))
        throw Error(ErrorCode::device, "trigger",
                    "this board has no trigger pins; that takes a core with the parameter TRIGGER");
}

/// So many clocks, which must be in the field's range.
std::uint32_t clocks(const char* name, double seconds, const Identity& identity, std::uint32_t most) {
    const double found = std::round(seconds * identity.clock_hz);
    if (!(found >= 0 && found <= most))
        throw Error(ErrorCode::bad_argument, name,
                    fmt::format("{:g} ms, expected 0 to {:g} ms: the board counts {} clocks at most", 1e3 * seconds,
                                1e3 * most / identity.clock_hz, most));
    return static_cast<std::uint32_t>(found);
}

/// Two reads, since the whole block can be longer than a record, and a read is not.
Bytes read_words(Commands& device, unsigned first, unsigned end) {
    require_triggers(device);
    return device.read(interface::trigger_base + 2 * first, static_cast<std::uint16_t>(2 * (end - first)));
}

}  // namespace

void set_trigger(Commands& device, const TriggerSettings& settings) {
    require_triggers(device);
    const Identity& identity = device.identity();
    if (settings.channel >= identity.channels)
        throw Error(
            ErrorCode::bad_argument, "channel",
            fmt::format("{}, expected 0 to {}, a channel of this board", settings.channel, identity.channels - 1));
    if (settings.every_periods == 0)
        throw Error(ErrorCode::bad_argument, "every_periods", "0, expected 1 to 65535 carrier periods");
    Bytes block(std::size_t{2} * interface::trigger_settings);
    trigger_bits::event.set(block, static_cast<unsigned>(settings.event));
    trigger_bits::out_periods.set(block, settings.every_periods);
    trigger_bits::out_length.set(block, clocks("pulse", settings.pulse_s, identity, trigger_bits::out_length.most()));
    trigger_bits::in_low.set(block, settings.active_low ? 1 : 0);
    trigger_bits::in_level.set(block, settings.by_level ? 1 : 0);
    trigger_bits::in_gates.set(block, settings.gates ? 1 : 0);
    trigger_bits::in_least.set(block, clocks("settle", settings.settle_s, identity, trigger_bits::in_least.most()));
    trigger_bits::test.set(block, static_cast<unsigned>(settings.test));
    block[2 * static_cast<unsigned>(Word::test_channel)] = static_cast<std::uint8_t>(settings.channel);
    block[2 * static_cast<unsigned>(Word::test_channel) + 1] = static_cast<std::uint8_t>(settings.channel >> 8);
    device.write(interface::trigger_base, block);
}

TriggerSettings trigger_settings(Commands& device) {
    const Bytes block = read_words(device, 0, interface::trigger_settings);
    const double clock_hz = device.identity().clock_hz;
    const std::uint32_t event = trigger_bits::event.get(block);
    if (event > static_cast<unsigned>(Event::samples))
        throw Error(ErrorCode::device, "trigger",
                    fmt::format("the board says that its event is {}, expected 0 to {}", event,
                                static_cast<unsigned>(Event::samples)));
    TriggerSettings settings;
    settings.event = static_cast<Event>(event);
    settings.every_periods = static_cast<std::uint16_t>(std::max(trigger_bits::out_periods.get(block), 1U));
    settings.pulse_s = std::max(trigger_bits::out_length.get(block), 1U) / clock_hz;
    settings.active_low = trigger_bits::in_low.get(block) != 0;
    settings.by_level = trigger_bits::in_level.get(block) != 0;
    settings.gates = trigger_bits::in_gates.get(block) != 0;
    settings.settle_s = trigger_bits::in_least.get(block) / clock_hz;
    settings.test = static_cast<Test>(trigger_bits::test.get(block));
    settings.channel = trigger_bits::test_channel.get(block);
    return settings;
}

TriggerTimes trigger_times(Commands& device) {
    constexpr unsigned first = interface::trigger_settings;
    const Bytes told = read_words(device, first, interface::trigger_words);
    Bytes block(std::size_t{2} * first);
    block.insert(block.end(), told.begin(), told.end());
    const auto whole = [&block](const interface::BitField& low, const interface::BitField& high) {
        return std::uint64_t{high.get(block)} << low.width | low.get(block);
    };
    TriggerTimes times;
    times.now = whole(trigger_bits::now, trigger_bits::now_high);
    times.out_count = static_cast<std::uint16_t>(trigger_bits::out_count.get(block));
    times.out = whole(trigger_bits::out, trigger_bits::out_high);
    times.in_count = static_cast<std::uint16_t>(trigger_bits::in_count.get(block));
    times.in = whole(trigger_bits::in, trigger_bits::in_high);
    return times;
}

}  // namespace haptogram::link
