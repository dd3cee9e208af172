// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "haptogram/array/vec3.hpp"
#include "haptogram/format/board.hpp"
#include "haptogram/format/image.hpp"
#include "haptogram/format/triggered_part.hpp"

namespace haptogram {

/// What starts a part of what is played: a table under [[trigger]] of a project.
struct Trigger {
    enum class On { pin, key, line, region };
    On on = On::pin;
    std::string word;              ///< the key, or the line
    Vec3 centre{};                 ///< of a region, a ball in the array frame
    double diameter_m = 0.0;       ///< of it
    double from_s = 0.0;           ///< the part's beginning in the pass
    std::optional<double> to_s{};  ///< and its end; none: the pass's
    std::uint16_t loops = 1;       ///< 0: until another trigger
    friend bool operator==(const Trigger&, const Trigger&) = default;
};

/// "pin", "key:WORD", "line:WORD" or "region".
[[nodiscard]] std::string name_of(const Trigger& trigger);

/// Those of a project file's text. @param where  names the text in messages
/// @throws Error{bad_input} naming the line and the key, also for two that would be the same
[[nodiscard]] std::vector<Trigger> triggers_from_toml(std::string_view text, const std::string& where);

/// The text of their tables; empty for none.
[[nodiscard]] std::string to_toml(std::span<const Trigger> triggers);

/// The parts of a sequence that they start, in their order.
/// @throws Error{bad_input} naming the "trigger" that begins or ends after the pass, or between two of its entries
[[nodiscard]] std::vector<TriggeredPart> parts_of(std::span<const Trigger> triggers,
                                                  std::span<const SequenceEntry> sequence, double carrier_hz);

/// @throws Error{bad_input} for one of the pin, on a board without it
void require_pin(std::span<const Trigger> triggers, const Core& core);

}  // namespace haptogram
