// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace haptogram {

/// One pulse as measured at a pin, clocks counted from the first clock of the simulation.
struct Pulse {
    std::uint64_t rise;
    std::uint64_t fall;
    std::uint32_t channel;
    std::uint16_t index;  ///< the record that played when it rose
    friend bool operator==(const Pulse&, const Pulse&) = default;
};

/// CSV with the header `channel,rise_clk,fall_clk,index`, a line a pulse.
[[nodiscard]] std::string to_csv(const std::vector<Pulse>& pulses);

/// Whether a file's text begins with that header.
[[nodiscard]] bool is_pulses_csv(std::string_view text);

/// @param where  names the file in messages
/// @throws Error{bad_input} naming the line
[[nodiscard]] std::vector<Pulse> pulses_from_csv(std::string_view text, const std::string& where);

}  // namespace haptogram
