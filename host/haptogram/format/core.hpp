// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "haptogram/array/array.hpp"
#include "haptogram/format/interface.hpp"

namespace haptogram {

/// The core that an image is made for: the parameters with which it is built into an FPGA.
struct Core {
    std::string name;  ///< of the board, or of the configuration (tools/interface.toml)
    interface::CoreParameters parameters;

    /// The most focal points that one image can play. Each takes a record and an entry of the sequence memory, whose
    /// first word is the header and no entry.
    [[nodiscard]] std::uint32_t most_points() const {
        return std::min(parameters.records, parameters.sequence_depth - 1);
    }
    /// The most focus records of this many foci that primary memory holds, with nothing else in it. An index has 16
    /// bits, and the first of them is for records.
    [[nodiscard]] std::uint32_t most_focus_records(std::uint32_t foci = 1) const {
        const std::uint64_t words =
            std::uint64_t{parameters.records} * (parameters.channels + interface::record_header_words);
        return static_cast<std::uint32_t>(std::min<std::uint64_t>(words / (4ULL * foci), 65535 - parameters.records));
    }
    friend bool operator==(const Core&, const Core&) = default;
};

/// The longest pulse of a record that the core plays, in clocks. Pulses that merge at changes of focus last up to five
/// times as long, and the guard takes half of max_high_clocks for good.
[[nodiscard]] constexpr std::uint32_t max_pulse_clocks(const interface::CoreParameters& core) {
    return (core.max_high_clocks / 2 - 2) / 5;
}

/// The smallest max_high_clocks of a core with this max_pulse_clocks().
[[nodiscard]] constexpr std::uint32_t max_high_clocks(std::uint32_t max_pulse_clocks) {
    return 2 * (5 * max_pulse_clocks + 2);
}

/// Clocks of the shortest cycle of timings that a board with amplitudes plays.
inline constexpr std::uint32_t least_timed_cycle = 8;

/// The shortest and the longest cycle of a record with amplitudes that a core plays, in clocks (rtl/README.md, "The
/// second instrument"). The core must have amplitudes.
[[nodiscard]] constexpr std::uint32_t least_amplitude_cycle(const interface::CoreParameters& core) {
    return 2 * (core.channels + 44);
}
[[nodiscard]] constexpr std::uint32_t most_amplitude_cycle(const interface::CoreParameters& core) {
    return 2 * std::min((1U << core.width_bits) - 1U, max_pulse_clocks(core));
}

/// Clocks from when an index is known until its record is loaded (rtl/README.md, "Switch"): C in Haptogram eq. 12.
/// @param foci  of a record whose foci the core computes; 0 for records of each channel's words
[[nodiscard]] constexpr std::uint32_t load_clocks(const interface::CoreParameters& core, std::uint32_t foci = 0) {
    if (foci != 0) return std::max(4 * foci + 7, 29U) + foci * core.channels + 35;
    return std::max(core.channels + (core.width_bits != 0 ? 8 : 7), 33U);
}

/// A named configuration of the core, such as "tile-100".
/// @throws Error{bad_input} naming those that there are
[[nodiscard]] Core find_configuration(const std::string& name);

/// Those of all configurations, with commas between.
[[nodiscard]] std::string configuration_names();

/// A board by the name or path that load_board() takes, or a configuration.
[[nodiscard]] Core find_core(const std::string& name);

/// The core that an array file's table [board] describes; "tile-100" where the file has none.
/// @param name  path or shipped array, as find_array() takes it
/// @throws Error{bad_input} naming the file, the line and the key
[[nodiscard]] Core core_of_array(const std::string& name);

/// The array that a board drives unless told otherwise.
/// @throws Error{bad_argument} for a configuration, which is for no particular array
[[nodiscard]] std::string array_of_board(const std::string& name);

/// @throws Error{bad_input} when the array has more elements than the core has channels
void require_channels(const Array& array, const Core& core);

}  // namespace haptogram
