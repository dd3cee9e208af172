// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/self_test.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "haptogram/base/error.hpp"
#include "haptogram/format/timer.hpp"
#include "haptogram/verbs/self_test_checks.hpp"

namespace haptogram::link {
namespace {

struct Named {
    Check check;
    std::string_view name;
    Finding (*run)(Commands&, const SelfTestSettings&);
    bool needs_outputs;  ///< it cannot be done while the stop input is active
};

constexpr std::array<Named, all_checks.size()> checks = {{
    {Check::link, "link", check_link, false},
    {Check::memories, "memories", check_memories, false},
    {Check::clock, "clock", check_clock, true},
    {Check::sync, "sync", check_sync, false},
    {Check::outputs, "outputs", check_outputs, true},
    {Check::watchdog, "watchdog", check_watchdog, true},
    {Check::stop_switch, "stop-switch", check_stop_switch, true},
    {Check::channels, "channels", check_channels, true},
    {Check::point, "point", check_point, true},
}};

const Named& entry_of(Check check) { return *std::ranges::find(checks, check, &Named::check); }

void require_sense(const SelfTestSettings& settings, const Identity& identity) {
    if (settings.array.elements.size() != identity.channels)
        throw bad_argument("array", fmt::format("it has {} elements and the board {} channels; name the array that the "
                                                "board drives",
                                                settings.array.elements.size(), identity.channels));
    const std::uint32_t last = settings.last_channel.value_or(identity.channels - 1);
    if (last >= identity.channels || settings.first_channel > last)
        throw bad_argument("channels", fmt::format("expected two channels from 0 to {}, the lower one first, not {} "
                                                   "and {}",
                                                   identity.channels - 1, settings.first_channel, last));
    for (const double seconds : {settings.channel_s, settings.point_s})
        if (!(seconds > 0.0 && seconds <= 600.0))
            throw bad_argument("seconds", fmt::format("expected more than 0 and at most 600 s, not {}", seconds));
    const std::string why = settings.array.unreachable(settings.point);
    if (!why.empty()) throw bad_argument("height", why);
}

}  // namespace

std::string_view to_string(Check check) { return entry_of(check).name; }

std::optional<Check> check_named(std::string_view name) {
    const auto* found = std::ranges::find(checks, name, &Named::name);
    return found == checks.end() ? std::nullopt : std::optional(found->check);
}

std::string_view to_string(Outcome outcome) {
    switch (outcome) {
        case Outcome::passed: return "passed";
        case Outcome::failed: return "failed";
        case Outcome::unjudged: break;
    }
    return "unjudged";
}

Image pulsing_image(const Identity& identity, const Array& array, std::span<const std::uint16_t> timings) {
    constexpr double pulsing_hz = 200.0;
    const Timer timer = choose_timer(array, Core{identity.name, identity.core()});
    Image image;
    image.channels = identity.channels;
    image.clock_hz = identity.clock_hz;
    image.timing_bits = identity.timing_bits;
    image.pulse_bits = identity.pulse_bits;
    image.min_pulse_clocks = identity.min_pulse_clocks;
    image.records.push_back({timer.cycle_ticks,
                             timer.prescaler,
                             static_cast<std::uint8_t>(timer.pulse_ticks),
                             {timings.begin(), timings.end()}});
    const auto half = static_cast<std::uint16_t>(std::lround(timer.carrier_hz() / (2.0 * pulsing_hz)));
    image.sequence = {{1, half}, {0, half}};
    return image;
}

std::vector<Finding> self_test(Commands& device, const SelfTestSettings& settings) {
    require_sense(settings, device.identity());
    device.disable();
    device.stop();
    const std::uint16_t watchdog_ms = device.status().watchdog_ms;
    std::vector<Finding> findings;
    for (const Named& check : checks) {
        if (std::ranges::find(settings.checks, check.check) == settings.checks.end()) continue;
        if (check.needs_outputs && device.status().stopped)
            findings.push_back({check.check, Outcome::failed, "the stop input is active, so the outputs stay off",
                                "release the stop switch; without one, see the stop pin in the board's file in "
                                "constraints/"});
        else
            findings.push_back(check.run(device, settings));
        if (settings.tell) settings.tell(findings.back());
    }
    device.set_watchdog(watchdog_ms);
    return findings;
}

nlohmann::ordered_json to_json(const std::vector<Finding>& findings) {
    nlohmann::ordered_json json = nlohmann::ordered_json::array();
    for (const Finding& finding : findings) {
        json.push_back(
            {{"check", to_string(finding.check)}, {"outcome", to_string(finding.outcome)}, {"found", finding.found}});
        if (!finding.advice.empty()) json.back()["advice"] = finding.advice;
    }
    return json;
}

}  // namespace haptogram::link
