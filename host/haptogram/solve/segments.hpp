// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <complex>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "haptogram/format/image.hpp"
#include "haptogram/format/schedule.hpp"

namespace haptogram {

/// The grid of a device whose pulses start and end only at the borders of a few equal segments of the carrier period.
struct Segments {
    const char* name;     ///< on command lines and in files
    std::uint32_t count;  ///< of a carrier period, even
};

/// Hoshi et al. 2010 (section 3.1) divide a carrier period into 16 segments of 1.5625 µs. The place of the pulse gives
/// 16 phases, and its length of 0 to 8 segments gives the amplitude.
inline constexpr Segments hoshi_segments{"hoshi", 16};

/// The grid of a name: "hoshi".
/// @param setting  names it in messages
/// @throws Error{bad_argument} naming those that there are
[[nodiscard]] Segments segments_of(const std::string& name, const std::string& setting = "quantise");

/// A pulse on such a grid, in segments. A length of 0 is silence.
struct SegmentPulse {
    std::uint32_t start = 0;   ///< 0 to count − 1
    std::uint32_t length = 0;  ///< 0 to count/2, which is full strength
    friend bool operator==(const SegmentPulse&, const SegmentPulse&) = default;
};

/// The pulse that comes nearest to a drive. Its length is count/π·asin(amplitude), rounded (Hoshi et al. 2010, eq. 7,
/// solved for the pulse). Its middle is as near to the drive's phase as the grid allows, half a segment at most; where
/// a pulse of full strength begins is the phase of drives, as in quantise().
/// @param drive  of an amplitude from 0 to 1
/// @throws Error{bad_argument} for drives that are not finite or stronger than 1
[[nodiscard]] SegmentPulse segment_pulse(std::complex<double> drive, const Segments& segments);

/// The drive that a pulse makes: its amplitude is sin(π·length/count) (Hoshi et al. 2010, eq. 7).
[[nodiscard]] std::complex<double> drive_of(const SegmentPulse& pulse, const Segments& segments);

/// Drives as the device makes them, each by a pulse of its own.
[[nodiscard]] std::vector<std::complex<double>> in_segments(std::span<const std::complex<double>> drives,
                                                            const Segments& segments);

/// A length of a pulse in ticks, rounded to whole segments and back to ticks.
[[nodiscard]] std::uint32_t length_in_segments(std::uint32_t ticks, const Timer& timer, const Segments& segments);

/// A record as the device plays it: every start and the pulse length are rounded to borders of segments. Where a border
/// is no whole tick, as with 250 ticks and 16 segments, the nearest tick stands for it, half a tick off at most.
[[nodiscard]] Record in_segments(const Record& record, const Timer& timer, const Segments& segments);

}  // namespace haptogram
