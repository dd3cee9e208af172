// SPDX-License-Identifier: Apache-2.0
#include "played_frames.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "progress_line.hpp"

namespace haptogram::cli {
namespace {

using nlohmann::ordered_json;

/// How far the pins may be from what was asked: a burst begins on a whole carrier period, and a pulse has whole ticks.
constexpr double most_frequency_off = 0.005, most_ticks_off = 0.6;

bool good(const PinsOfFrame& pins, const fusion::Frame& frame) {
    return pins.violations.empty() && pins.points.size() == frame.points.size() &&
           std::abs(pins.frequency_hz - frame.frequency_hz) <= most_frequency_off * frame.frequency_hz &&
           std::all_of(pins.points.begin(), pins.points.end(),
                       [](const auto& point) { return std::abs(point.ticks_off) <= most_ticks_off; });
}

}  // namespace

std::vector<PlayedFrame> play_some(const std::vector<const fusion::Frame*>& frames, std::uint64_t count,
                                   const ProjectInstrument& instrument, const perception::Tables& tables) {
    std::vector<std::size_t> felt;
    for (std::size_t i = 0; i < frames.size(); ++i)
        if (!frames[i]->points.empty()) felt.push_back(i);
    const std::size_t wanted = std::min<std::size_t>(count, felt.size());
    std::vector<PlayedFrame> played;
    ProgressLine progress("board");
    for (std::size_t k = 0; k < wanted; ++k) {
        const std::size_t number = felt[wanted == 1 ? 0 : k * (felt.size() - 1) / (wanted - 1)];
        PinsOfFrame pins = pins_of(*frames[number], instrument.array, instrument.core, tables);
        const bool as_asked = good(pins, *frames[number]);
        played.push_back({number, std::move(pins), as_asked});
        progress.callback()(static_cast<double>(k + 1) / static_cast<double>(wanted), "board");
    }
    return played;
}

ordered_json to_json(const PlayedFrame& played, const fusion::Frame& frame, double time_s) {
    ordered_json points = ordered_json::array();
    for (const PinsOfFrame::Point& point : played.pins.points)
        points.push_back(
            {{"position_mm",
              {point.position.x / millimetre, point.position.y / millimetre, point.position.z / millimetre}},
             {"command", point.asked},
             {"command_at_pins", point.measured},
             {"ticks_off", point.ticks_off},
             {"magnitude_at_pins", point.magnitude}});
    return {{"time_s", time_s},
            {"frequency_hz", frame.frequency_hz},
            {"frequency_hz_at_pins", played.pins.frequency_hz},
            {"magnitude", frame.magnitude},
            {"points", points},
            {"pulses", played.pins.pulses},
            {"violations", played.pins.violations},
            {"good", played.good}};
}

void tell(Report& report, const PlayedFrame& played, const fusion::Frame& frame, double time_s) {
    double asked = 0.0, measured = 0.0, felt = 0.0;
    for (const PinsOfFrame::Point& point : played.pins.points) {
        asked += point.asked / static_cast<double>(played.pins.points.size());
        measured += point.measured / static_cast<double>(played.pins.points.size());
        felt += point.magnitude / static_cast<double>(played.pins.points.size());
    }
    report.tell(
        fmt::format("{:8.3f} s  {:.1f} Hz asked, {:.1f} at the pins; command {:.4f} asked, {:.4f} at the "
                    "pins; magnitude {:.2f} asked, {:.2f} by the pins{}",
                    time_s, frame.frequency_hz, played.pins.frequency_hz, asked, measured, frame.magnitude, felt,
                    played.good ? "" : "  NOT AS ASKED"));
    for (const std::string& violation : played.pins.violations) report.tell("          " + violation);
}

}  // namespace haptogram::cli
