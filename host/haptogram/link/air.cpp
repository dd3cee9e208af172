// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/air.hpp"

#include <fmt/format.h>

#include <array>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/format/focus_engine.hpp"

namespace haptogram::link {
namespace {

namespace air_field = interface::parameters_field;

}  // namespace

AirOn::AirOn(Commands& device, double speed_m_s, Warning warn) : device_(device), warn_(std::move(warn)) {
    const Identity& identity = device.identity();
    const char* const records = "records were computed for one air; compile them for this one, or an image of foci";
    if (!interface::has(identity.features, interface::Feature::foci))
        throw Error(ErrorCode::device, "board", fmt::format("it computes no foci, and {}", records));
    const Bytes block =
        device.read(interface::parameters_base, static_cast<std::uint16_t>(2 * interface::parameters_words));
    own_ = air_field::wave_number.get(block);
    const std::uint32_t clocks = air_field::foci_cycle.get(block);
    if (own_ == 0 || clocks == 0 || air_field::foci_count.get(block) == 0)
        throw Error(ErrorCode::device, "board", fmt::format("it holds no image of foci, and {}", records));
    carrier_hz_ = identity.clock_hz / static_cast<double>(clocks);
    own_speed_m_s_ = carrier_hz_ * focus_unit_m * 0x1p27 / own_;
    set(speed_m_s);
}

void AirOn::set(double speed_m_s) { write(wave_number_word(speed_m_s / carrier_hz_)); }

AirOn::~AirOn() {
    try {
        write(own_);
    } catch (const Error& error) {
        if (error.code() == ErrorCode::cancelled || !warn_) return;
        try {
            warn_(fmt::format("{}; the board computes foci for another air until the next upload", error.what()));
        } catch (const std::exception&) {
            // A warning that cannot be given must not end the program while it cleans up.
        }
    }
}

void AirOn::write(std::uint32_t wave_number) {
    const std::array<std::uint16_t, 2> words = {static_cast<std::uint16_t>(wave_number),
                                                static_cast<std::uint16_t>(wave_number >> 16)};
    device_.request(write_request(
        interface::parameters_base + 2 * (air_field::wave_number.offset / interface::parameters_word_bits), words));
}

}  // namespace haptogram::link
