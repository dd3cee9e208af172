// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "clock.hpp"
#include "haptogram/format/interface.hpp"

namespace haptogram::sim {

/// The parameters block: what a host writes in a clock is there from the next one on
/// (rtl/amplitudes/parameter_registers.v). Its registers have fewer bits than a word, and no reset.
class Settings {
public:
    explicit Settings(std::uint32_t period_clocks) {
        namespace field = interface::parameters_field;
        field::foci_cycle.set(words_, period_clocks & field::foci_cycle.most());
        field::phase_rate.set(words_, field::phase_rate.most());
        field::amplitude_rate.set(words_, field::amplitude_rate.most());
        field::arrival.set(words_, 1);
    }

    void write(Clock clock, std::uint32_t address, std::uint16_t word) {
        static_cast<void>(at(clock));
        written_ = {clock, address, static_cast<std::uint16_t>(word & mask(address))};
    }
    /// As this clock finds them; clocks must be asked for in their order.
    [[nodiscard]] std::span<const std::uint16_t> at(Clock clock) {
        if (written_ && written_->clock < clock) {
            words_[written_->address] = written_->word;
            written_.reset();
        }
        return words_;
    }

private:
    using Words = std::array<std::uint16_t, interface::parameters_words>;

    [[nodiscard]] static std::uint16_t mask(std::uint32_t address) {
        static const Words masks = [] {
            namespace field = interface::parameters_field;
            Words all{};
            for (const auto& f : {field::foci_base, field::foci_count, field::foci_last, field::foci_whole,
                                  field::foci_cycle, field::wave_number, field::gain, field::slew, field::phase_rate,
                                  field::amplitude_rate, field::arrival})
                f.set(all, f.most());
            return all;
        }();
        return masks[address];
    }

    struct Written {
        Clock clock;
        std::uint32_t address;
        std::uint16_t word;
    };
    Words words_{};
    std::optional<Written> written_;
};

}  // namespace haptogram::sim
