// SPDX-License-Identifier: Apache-2.0
#include "pins.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "child.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/process.hpp"

namespace haptogram::studio {

using nlohmann::ordered_json;

Pins simulate_pins(const Scene& scene, const Progress& progress) {
    const Bundle& bundle = scene.compiled.bundle;
    const TemporaryFolder folder;
    const auto file = [&](const char* name) { return (folder.path() / name).string(); };
    write_file(file("image.hex"), bundle.hex);
    write_file(file("image.json"), to_text(bundle.manifest));
    std::string said;
    {
        const Child child("simulation", {"simulate", file("image.hex"), "--load", "direct", "--report",
                                         file("report.json"), "--pulses", file("pulses.csv")});
        while (child.hear(said, std::chrono::milliseconds(100)) != Child::Heard::end) progress(0.0, "simulate");
    }
    // A simulation that finds something wrong reports it, too; one that could not begin leaves no report.
    if (!std::filesystem::exists(file("report.json"))) {
        for (std::size_t at; (at = said.find(folder.path().string() + "/")) != std::string::npos;)
            said.erase(at, folder.path().string().size() + 1);
        throw Error(ErrorCode::failed, "simulation", said.empty() ? "it ended without a word" : said);
    }
    Pins pins;
    pins.report = ordered_json::parse(read_file(file("report.json")));
    pins.report.erase("records");
    pins.pulses = pulses_from_csv(read_file(file("pulses.csv")), "pulses.csv");
    std::stable_sort(pins.pulses.begin(), pins.pulses.end(),
                     [](const Pulse& a, const Pulse& b) { return a.rise < b.rise; });
    pins.clock_hz = bundle.image.clock_hz;
    pins.carrier_hz = bundle.manifest.timer.carrier_hz();
    return pins;
}

ordered_json pulses_json(const Pins& pins, std::uint32_t index, std::uint32_t periods) {
    if (periods < 1 || periods > most_pulse_periods)
        throw bad_argument("periods", fmt::format("found {}, expected 1 to {}", periods, most_pulse_periods));
    const auto first =
        std::find_if(pins.pulses.begin(), pins.pulses.end(), [&](const Pulse& each) { return each.index == index; });
    if (first == pins.pulses.end())
        throw bad_argument("index", fmt::format("record {} had no pulse at the pins", index));
    const std::uint64_t until =
        first->rise + static_cast<std::uint64_t>(std::llround(periods * pins.clock_hz / pins.carrier_hz));
    ordered_json pulses = ordered_json::array();
    for (auto pulse = first; pulse != pins.pulses.end() && pulse->rise < until; ++pulse)
        pulses.push_back({pulse->channel, pulse->rise, pulse->fall, pulse->index});
    return {{"index", index},
            {"clock_hz", pins.clock_hz},
            {"from_clk", first->rise},
            {"to_clk", until},
            {"pulses", pulses}};
}

}  // namespace haptogram::studio
