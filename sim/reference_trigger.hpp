// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>

#include "clock.hpp"
#include "haptogram/format/interface.hpp"

namespace haptogram::sim {

/// The trigger pins and the test output (rtl/time/trigger.v). What is asked of it in a clock is as that clock finds it;
/// edge(), to be called last in each clock in which anything happens, is what the clock changes.
class TriggerPins {
public:
    explicit TriggerPins(const interface::CoreParameters& p);

    void write(std::uint32_t address, std::uint16_t word) { written_ = {address, word}; }
    /// The level at the input, before this clock.
    void drive(Clock clock, bool level);
    /// The reset input is high in these clocks.
    void reset(Clock first, Clock last) { reset_from_ = first, reset_to_ = last; }

    /// What is at the board's other ports after a clock.
    struct Ports {
        bool enabled = false, playing = false;
        bool starts = false;  ///< a cycle
        bool mark = false, pass = false;
        bool samples = false;  ///< the modulation takes its first sample
        std::uint16_t index = 0;
    };
    void edge(Clock clock, const Ports& ports);
    [[nodiscard]] Clock next() const;

    [[nodiscard]] bool mute() const { return mute_; }
    /// Whether what waits for the trigger begins.
    [[nodiscard]] bool comes(Clock clock) const;
    /// A reply begins, and tells of now.
    void answer(Clock clock);
    [[nodiscard]] std::uint16_t word(std::uint32_t address) const;
    /// The output after the last clock.
    [[nodiscard]] bool level() const { return level_; }
    /// The test output after this clock, which is the last.
    [[nodiscard]] bool test(Clock last, const std::function<bool(std::uint32_t)>& pin) const;
    void on_change(std::function<void(Clock, bool)> callback) { on_change_ = std::move(callback); }

private:
    struct Change {
        Clock clock;
        bool level;
    };

    void output(Clock clock, bool resets);
    void input(Clock clock, bool resets);
    void settle(Clock clock);
    void look_at_input(Clock clock, bool resets, bool turned);
    void look_at_ports(Clock clock, const Ports& ports);
    void set_level(Clock clock, bool level);
    [[nodiscard]] std::uint32_t get(const interface::BitField& field) const { return field.get(words_); }

    std::array<std::uint16_t, interface::trigger_words> words_{};  // of which the host has written the first
    std::array<std::uint16_t, interface::trigger_words> masks_{};
    struct Written {
        std::uint32_t address;
        std::uint16_t word;
    };
    std::optional<Written> written_;  // in this clock
    Clock last_ = 0, reset_from_ = never, reset_to_ = 0;

    // Out.
    Ports ports_;
    Clock happens_at_ = never, starts_at_ = never, falls_at_ = never;
    std::uint32_t left_ = 0;  // periods before the next one that is an event
    Clock samples_from_ = never;
    std::uint64_t out_clock_ = 0, out_count_ = 0;
    bool level_ = false;
    std::function<void(Clock, bool)> on_change_;

    // In.
    std::deque<Change> changes_;  // of the pin, with the clock that finds them
    bool pin_ = false, active_ = false, mute_ = false;
    Clock differs_from_ = never, turns_at_ = never, wake_to_ = 0;
    std::deque<Change> fires_{{0, false}};  // what waits may begin, two clocks later
    std::uint64_t in_clock_ = 0, in_count_ = 0;

    // Test.
    bool cycles_ = false, changes_of_index_ = false;
    Clock cycle_at_ = never, index_at_ = never;
};

}  // namespace haptogram::sim
