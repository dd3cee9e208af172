// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <span>

namespace haptogram::link {

/// A clock of a device that was told between two moments of the host.
struct ClockSample {
    double asked_s = 0, answered_s = 0;  ///< by the host's own clock
    std::uint64_t clock = 0;
};

/// Host time as a line over a device's clock. The moment of a sample is somewhere between its question and its answer,
/// so samples count by how short that was, and the line is the one through the middles.
struct ClockFit {
    std::uint64_t origin = 0;  ///< of the device's clock
    double origin_s = 0;       ///< host time of it
    double s_per_clock = 0;
    double error_s = 0;   ///< the line can be off by this much at the samples' middle, if questions and answers take
                          ///< between nothing and all of their time
    double spread_s = 0;  ///< how far the middles lie from the line, root mean square by their weights

    [[nodiscard]] double host_s(std::uint64_t clock) const {
        return origin_s + s_per_clock * static_cast<double>(static_cast<std::int64_t>(clock - origin));
    }
};

/// @throws Error{bad_input} when there are fewer than two different clocks, an answer is before its question, or the
/// device's clock goes back while the host's goes on
[[nodiscard]] ClockFit fit_clocks(std::span<const ClockSample> samples);

}  // namespace haptogram::link
