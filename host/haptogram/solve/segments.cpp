// SPDX-License-Identifier: Apache-2.0
#include "haptogram/solve/segments.hpp"

#include <fmt/core.h>

#include <cmath>
#include <numbers>

#include "haptogram/base/error.hpp"

namespace haptogram {
namespace {

constexpr double pi = std::numbers::pi;

/// A number of whole segments, 0 to count − 1, from any real number of them.
std::uint32_t wrapped(double segments, std::uint32_t count) {
    const double nearest = std::floor(segments + 0.5);
    return static_cast<std::uint32_t>(nearest - count * std::floor(nearest / count));
}

/// The tick nearest to a border of segments.
std::uint32_t tick_of(std::uint32_t segment, std::uint32_t cycle_ticks, std::uint32_t count) {
    return static_cast<std::uint32_t>((2ULL * segment * cycle_ticks + count) / (2ULL * count));
}

/// The segment's border nearest to a tick.
std::uint32_t segment_of(std::uint32_t tick, std::uint32_t cycle_ticks, std::uint32_t count) {
    return static_cast<std::uint32_t>((2ULL * tick * count + cycle_ticks) / (2ULL * cycle_ticks));
}

}  // namespace

Segments segments_of(const std::string& name, const std::string& setting) {
    if (name == hoshi_segments.name) return hoshi_segments;
    throw bad_argument(setting, fmt::format("found \"{}\", expected \"{}\"", name, hoshi_segments.name));
}

SegmentPulse segment_pulse(std::complex<double> drive, const Segments& segments) {
    const double amplitude = std::abs(drive);
    constexpr double rounding = 1e-9;
    if (!(amplitude <= 1.0 + rounding))
        throw bad_argument("drive", fmt::format("an amplitude of {}; expected 0 to 1", amplitude));
    const double length = std::round(segments.count / pi * std::asin(std::min(1.0, amplitude)));
    if (length == 0.0) return {};
    // A shorter pulse starts later, so that its middle stays where that of the full one is.
    const double later = segments.count / 4.0 - length / 2.0;
    const double start = -std::arg(drive) / (2.0 * pi) * segments.count + later;
    return {wrapped(start, segments.count), static_cast<std::uint32_t>(length)};
}

std::complex<double> drive_of(const SegmentPulse& pulse, const Segments& segments) {
    if (pulse.length == 0) return 0.0;
    const double middle = pulse.start + pulse.length / 2.0 - segments.count / 4.0;
    return std::polar(std::sin(pi * pulse.length / segments.count), -2.0 * pi * middle / segments.count);
}

std::vector<std::complex<double>> in_segments(std::span<const std::complex<double>> drives, const Segments& segments) {
    std::vector<std::complex<double>> made;
    made.reserve(drives.size());
    for (const std::complex<double>& drive : drives) made.push_back(drive_of(segment_pulse(drive, segments), segments));
    return made;
}

std::uint32_t length_in_segments(std::uint32_t ticks, const Timer& timer, const Segments& segments) {
    return tick_of(segment_of(ticks, timer.cycle_ticks, segments.count), timer.cycle_ticks, segments.count);
}

Record in_segments(const Record& record, const Timer& timer, const Segments& segments) {
    Record made = record;
    made.pulse_length = static_cast<std::uint8_t>(length_in_segments(record.pulse_length, timer, segments));
    for (std::size_t m = 0; m < made.timings.size(); ++m) {
        if (!record.fires(m)) continue;
        const std::uint32_t segment = segment_of(record.timings[m], timer.cycle_ticks, segments.count) % segments.count;
        made.timings[m] = static_cast<std::uint16_t>(tick_of(segment, timer.cycle_ticks, segments.count));
    }
    return made;
}

}  // namespace haptogram
