// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/focus_ring.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "haptogram/base/error.hpp"
#include "haptogram/format/image.hpp"

namespace haptogram::link {
namespace {

namespace field = interface::parameters_field;
constexpr std::uint32_t last_index = 65535;

Error ring_error(const std::string& message) { return {ErrorCode::device, "board", message}; }

FocusRing ring_on_board(Commands& device, std::uint32_t each) {
    namespace ring = interface::ring_field;
    const Bytes block = device.read(interface::ring_base, 2 * interface::ring_words);
    const auto word = [&block](const interface::BitField& f) { return static_cast<std::uint16_t>(f.get(block)); };
    return {word(ring::base), word(ring::first), word(ring::count), each};
}

}  // namespace

FocusRing make_ring(Commands& device) {
    const Identity& identity = device.identity();
    if (!interface::has(identity.features, interface::Feature::live_foci))
        throw ring_error("it takes no foci while it plays; that takes a board with the parameter FOCI");
    const Bytes parameters =
        device.read(interface::parameters_base, static_cast<std::uint16_t>(2 * interface::parameters_words));
    const std::uint32_t gain = field::gain.get(parameters), stored = field::foci_count.get(parameters);
    const std::uint32_t each = field::foci_last.get(parameters) + 1, base = field::foci_base.get(parameters);
    if (gain == 0 || stored == 0)
        throw ring_error("it holds no image of foci, which says where its channels are; upload one first");
    const std::uint32_t fours = identity.records * static_cast<std::uint32_t>(record_words(identity.channels)) / 4;
    const std::uint32_t room = base < fours ? (fours - base) / each : 0;
    const std::uint32_t all = std::min(room, last_index - identity.records);
    const std::uint32_t count = identity.live_depth + 1;
    const std::uint32_t before = all > count ? all - count : 0;
    const FocusRing ring{static_cast<std::uint16_t>(base + before * each),
                         static_cast<std::uint16_t>(identity.records + 1 + before), static_cast<std::uint16_t>(count),
                         each};
    const bool is_there = stored == all && ring_on_board(device, each) == ring;
    if (all <= count || (stored > before && !is_there))
        throw ring_error(fmt::format(
            "its memory has room for {} focus records behind the image's other records, and the image has {}; {} more "
            "are needed for the ring of those that wait; upload a smaller image",
            all, stored, count));
    const std::uint16_t records = static_cast<std::uint16_t>(all), place[] = {ring.base, ring.first, ring.count};
    device.request(write_request(
        interface::parameters_base + 2 * static_cast<std::uint32_t>(interface::ParametersWord::foci_count),
        {&records, 1}));
    device.request(write_request(interface::ring_base, place));
    return ring;
}

void add_record(std::vector<std::uint16_t>& words, FocusWords focus, std::size_t each) {
    words.insert(words.end(), focus.begin(), focus.end());
    focus[3] &= 0x003fU;
    for (std::size_t i = 1; i < each; ++i) words.insert(words.end(), focus.begin(), focus.end());
}

}  // namespace haptogram::link
