// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "haptogram/base/error.hpp"
#include "haptogram/link/play.hpp"

namespace haptogram::link {

void require_parts(std::span<const TriggeredPart> parts, std::size_t length, const Identity& identity) {
    bool pin = false;
    for (std::size_t i = 0; i < parts.size(); ++i) {
        const TriggeredPart& part = parts[i];
        if (part.first == 0 || part.length == 0 || part.first - std::size_t{1} + part.length > length)
            throw bad_argument("trigger",
                               fmt::format("number {} plays {} entries from entry {} on; the sequence has {}", i + 1,
                                           part.length, part.first, length));
        if (part.by_pin && pin)
            throw bad_argument("trigger", fmt::format("number {} is a second one of the pin; keep one", i + 1));
        pin |= part.by_pin;
    }
    if (pin && !interface::has(identity.features, interface::Feature::trigger))
        throw Error(ErrorCode::device, "trigger",
                    "this board has no trigger pins; that takes a core with the parameter TRIGGER");
}

const TriggeredPart* part_of_pin(std::span<const TriggeredPart> parts) {
    const auto found = std::ranges::find_if(parts, &TriggeredPart::by_pin);
    return found == parts.end() ? nullptr : &*found;
}

}  // namespace haptogram::link
