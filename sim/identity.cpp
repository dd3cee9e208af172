// SPDX-License-Identifier: Apache-2.0
#include "identity.hpp"

#include <algorithm>

#include "reference_board.hpp"

namespace haptogram::sim {

std::array<std::uint16_t, interface::identity_words> identity_block(const interface::CoreParameters& p) {
    std::array<std::uint16_t, interface::identity_words> identity{};
    for (std::size_t i = 0; i < interface::name.size(); ++i)
        identity[i / 2] =
            static_cast<std::uint16_t>(identity[i / 2] | static_cast<unsigned char>(interface::name[i]) << i % 2 * 8);
    namespace field = interface::identity_field;
    using interface::Feature;
    std::uint32_t features = 0;
    const auto has = [&features](Feature feature, bool is_there = true) {
        if (is_there) features |= 1U << static_cast<unsigned>(feature);
    };
    has(Feature::sequence);
    has(Feature::live);
    has(Feature::watchdog);
    has(Feature::guard);
    has(Feature::amplitude, p.width_bits != 0);
    has(Feature::slew, p.slew != 0);
    has(Feature::modulation, p.modulation_depth != 0);
    has(Feature::foci, p.foci != 0);
    has(Feature::live_foci, p.foci != 0);
    has(Feature::sync, p.sync != 0);
    has(Feature::schedule, p.schedule != 0);
    has(Feature::chain, p.chain != 0);
    has(Feature::net, p.net != 0);
    has(Feature::stream, p.stream != 0);
    has(Feature::trigger, p.trigger != 0);
    field::version_minor.set(identity, interface::version_minor);
    field::version_major.set(identity, interface::version_major);
    field::channels.set(identity, p.channels);
    field::records.set(identity, p.records);
    field::sequence_depth.set(identity, p.sequence_depth);
    field::live_depth.set(identity, p.live_depth);
    field::timing_bits.set(identity, p.timing_bits);
    field::pulse_bits.set(identity, p.pulse_bits);
    field::clock_hz.set(identity, p.clock_hz);
    field::features.set(identity, features);
    field::frame_bytes.set(identity, longest_frame(p));
    field::min_pulse_clocks.set(identity, p.min_pulse_clocks);
    // More than the field holds is said as its largest value: what a host then keeps to, the board plays.
    field::max_pulse_clocks.set(identity, std::min(longest_pulse_clocks(p), field::max_pulse_clocks.most()));
    field::max_duty_256.set(identity, p.max_duty_256);
    field::max_cycle_clocks.set(identity, p.clock_hz);
    field::width_bits.set(identity, p.width_bits);
    field::foci.set(identity, p.foci);
    field::modulation_words.set(identity, p.modulation_depth / 2);
    return identity;
}

std::vector<std::uint8_t> identity_bytes(const interface::CoreParameters& p) {
    std::vector<std::uint8_t> bytes;
    for (const std::uint16_t word : identity_block(p)) {
        bytes.push_back(static_cast<std::uint8_t>(word));
        bytes.push_back(static_cast<std::uint8_t>(word >> 8));
    }
    return bytes;
}

}  // namespace haptogram::sim
