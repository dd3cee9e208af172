// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "command.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/link/device.hpp"
#include "haptogram/link/to_json.hpp"
#include "haptogram/link/trigger.hpp"
#include "port.hpp"
#include "report.hpp"

namespace haptogram::cli {
namespace {

struct TriggerOptions {
    link::PortSettings port;
    std::string event, input, test;
    double pulse_ms = -1, settle_ms = -1;
    std::uint16_t every = 0;
    std::uint32_t channel = 0;
    bool level = false, gate = false;
    bool json = false;
};

/// The value of this name; the options' checks let no other pass.
template <class Value>
Value named(const std::string& name, unsigned last) {
    unsigned value = 0;
    while (value < last && to_string(static_cast<Value>(value)) != name) ++value;
    return static_cast<Value>(value);
}

template <class Value>
std::vector<std::string> names_up_to(Value last) {
    std::vector<std::string> names;
    for (unsigned value = 0; value <= static_cast<unsigned>(last); ++value)
        names.emplace_back(to_string(static_cast<Value>(value)));
    return names;
}

/// What was said changes, the rest stays. Prints all of it, and what the board has seen.
int trigger(const TriggerOptions& options) {
    link::Device device(options.port);
    const link::TriggerSettings before = trigger_settings(device);
    link::TriggerSettings settings = before;
    if (!options.event.empty())
        settings.event = named<link::Event>(options.event, static_cast<unsigned>(link::Event::samples));
    if (options.every != 0) settings.every_periods = options.every;
    if (options.pulse_ms >= 0) settings.pulse_s = 1e-3 * options.pulse_ms;
    if (!options.input.empty()) {
        settings.active_low = options.input == "low";
        settings.by_level = options.level;
        settings.gates = options.gate;
    }
    if (options.settle_ms >= 0) settings.settle_s = 1e-3 * options.settle_ms;
    if (!options.test.empty()) {
        settings.test = named<link::Test>(options.test, static_cast<unsigned>(link::Test::index));
        settings.channel = options.channel;
    }
    if (options.every != 0 && settings.event != link::Event::period)
        throw bad_argument("every", fmt::format("is of --out period; the event is {}", to_string(settings.event)));
    if (options.channel != 0 && settings.test != link::Test::carrier)
        throw bad_argument("channel",
                           fmt::format("is of --test carrier; the test output is {}", to_string(settings.test)));
    if (settings != before) set_trigger(device, settings);
    nlohmann::ordered_json told = to_json(trigger_settings(device));
    told.update(to_json(trigger_times(device), device.identity().clock_hz));
    tell(told, options.json);
    return 0;
}

}  // namespace

void add_device_trigger(CLI::App& device, Action& action) {
    auto options = std::make_shared<TriggerOptions>();
    CLI::App* pins = device.add_subcommand(
        "trigger",
        "Set up the trigger pins and the test output of a board that has them, and print how they "
        "are and when they changed last; settings that are not given stay as they are");
    add_port_options(*pins, options->port);
    pins->add_flag("--json", options->json, "As JSON");
    pins->callback([options, &action] { action = [options] { return trigger(*options); }; });
    pins->add_option("--out", options->event,
                     "What makes a pulse at the trigger output: start of playing, mark of an entry, pass of a "
                     "sequence, period of the carrier, or samples of the modulation from the first one")
        ->check(CLI::IsMember(names_up_to(link::Event::samples)));
    pins->add_option("--every", options->every, "With period: carrier periods from one pulse to the next")
        ->check(whole(1, 65535));
    pins->add_option("--pulse", options->pulse_ms, "How long the output is high, in ms")->check(CLI::Range(0.0, 1e4));
    auto* input =
        pins->add_option(
                "--in", options->input,
                "The level at which the trigger input is active; without --level and --gate, these are off then")
            ->check(CLI::IsMember(std::vector<std::string>{"high", "low"}));
    pins->add_flag("--level", options->level,
                   "What waits for the trigger begins while the input is active, not only when it becomes so")
        ->needs(input);
    pins->add_flag("--gate", options->gate, "No pulse reaches the transducers while the input is not active")
        ->needs(input);
    pins->add_option("--settle", options->settle_ms, "A change of the input counts when it has lasted so long, in ms")
        ->check(CLI::Range(0.0, 1e3));
    auto* test = pins->add_option("--test", options->test,
                                  "What an oscilloscope sees at the test output: the carrier of a channel, a change at "
                                  "each cycle, or with each new index")
                     ->check(CLI::IsMember(names_up_to(link::Test::index)));
    pins->add_option("--channel", options->channel, "With carrier: the channel")
        ->check(whole(0, 999))
        ->capture_default_str()
        ->needs(test);
}

}  // namespace haptogram::cli
