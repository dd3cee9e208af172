// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "clock.hpp"

namespace haptogram::sim {

/// Holds the samples by which all amplitudes are multiplied, and says which one belongs to a carrier period
/// (rtl/amplitudes/modulator.v and rtl/amplitudes/modulation.v; rtl/README.md, contract 9).
class Modulation {
public:
    /// @param depth  samples, 0 for a board without modulation
    explicit Modulation(std::uint32_t depth) : samples_(depth, 255) {}

    /// What a command asks for; it takes back what another one asked for and has not taken effect.
    void ask(Clock clock, std::uint16_t divider, std::uint16_t length, std::uint16_t form);
    /// It takes effect with the next period that begins after this clock.
    /// @param at_pass_end  or with the end of the samples' present pass
    void begin(Clock clock, bool at_pass_end);
    /// A period begins that is told with this clock.
    /// @return whether it takes the first sample, in each pass
    bool period(Clock clock);
    void reset();

    [[nodiscard]] std::uint32_t words() const { return static_cast<std::uint32_t>(samples_.size() / 2); }
    [[nodiscard]] std::uint16_t word(std::uint32_t address) const;
    void write(std::uint32_t address, std::uint16_t word);
    /// Whether a sample is being read in this clock.
    [[nodiscard]] bool fetching(Clock clock) const { return clock == told_ + 1; }

    /// As this clock found it, which may be some periods ago.
    [[nodiscard]] std::uint8_t sample(Clock clock) const { return shown(clock).sample; }
    [[nodiscard]] bool running(Clock clock) const { return shown(clock).running; }

private:
    struct Asked {
        std::uint32_t divider = 0, length = 0, first = 0;
        bool loops = false, at_pass_end = false;
        Clock from = 0, to = never;  // the clocks in which it can take effect
    };
    struct Shown {
        Clock from = 0;
        std::uint8_t sample = 255;
        bool running = false;
    };
    [[nodiscard]] const Shown& shown(Clock clock) const;

    std::vector<std::uint8_t> samples_;
    Asked asked_;                   // by the last command
    std::optional<Asked> waiting_;  // for its period
    std::optional<Asked> next_;     // will wait instead
    bool plays_ = false, ended_ = false, loops_ = false;
    std::uint32_t sample_ = 0, first_ = 0, last_ = 0, left_ = 0, divider_ = 0;
    Clock told_ = never - 1;       // the last period
    std::deque<Shown> shown_{{}};  // the latest one first, as far back as somebody may ask
};

}  // namespace haptogram::sim
