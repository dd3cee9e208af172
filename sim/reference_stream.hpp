// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "clock.hpp"
#include "haptogram/format/interface.hpp"

namespace haptogram::sim {

/// A pattern for each carrier period (rtl/time/pattern_stream.v, rtl/time/pattern_slots.v): which wait, what becomes of
/// one that comes, and what a period plays. Clocks must be asked for in their order.
class PatternStream {
public:
    using Words = std::array<std::uint16_t, interface::stream_words>;

    explicit PatternStream(const interface::CoreParameters& p)
        : p_(p), record_words_(p.channels + interface::record_header_words), waits_(p.stream, false) {}

    // ---- Settings

    void set(Clock clock, std::uint32_t address, std::uint16_t word);  ///< which makes it forget, too
    [[nodiscard]] const Words& words() const { return words_; }
    /// @param parameters  the parameters block, as in all of these
    [[nodiscard]] bool usable(std::span<const std::uint16_t> parameters, std::uint32_t top_index) const;
    [[nodiscard]] std::uint16_t fade() const;

    // ---- Patterns that come

    /// A frame's arguments are there.
    void begin(Clock clock, std::uint64_t period);
    /// Whether its next word is taken in this clock, when the memory has time; it judges the pattern before.
    [[nodiscard]] bool ready(Clock clock);
    /// Where that word goes; nowhere when the pattern is not kept.
    [[nodiscard]] std::optional<std::uint32_t> place(std::span<const std::uint16_t> parameters) const;
    struct Counted {
        bool late = false, early = false, repeated = false;
    };
    [[nodiscard]] Counted take(Clock clock, std::span<const std::uint16_t> parameters);
    [[nodiscard]] bool split() const { return word_ != 0; }

    // ---- What plays

    /// The go point of a period, which has this number.
    void go(Clock clock, std::uint64_t count);
    /// What is known at a clock's end: in the next one all patterns are forgotten, and in those after it as long as it
    /// is held.
    void end(Clock clock, bool forgets, bool held);
    [[nodiscard]] bool forgets(Clock clock) const { return held_ || clock == forget_at_; }
    struct Turn {
        bool lost = false, ends = false;
        std::optional<std::uint16_t> index;
    };
    [[nodiscard]] Turn turn(Clock clock, bool plays);
    [[nodiscard]] Clock next() const { return turn_at_; }

private:
    void forget(Clock clock);
    void pass(Clock clock);
    [[nodiscard]] std::uint64_t slots() const {
        return std::uint64_t{1} << interface::stream_field::slot_bits.get(words_);
    }
    [[nodiscard]] std::size_t slot(std::uint64_t period) const { return period % slots() % waits_.size(); }
    [[nodiscard]] std::uint16_t index(std::uint64_t period) const {
        return static_cast<std::uint16_t>(words_[0] + period % slots());
    }
    [[nodiscard]] bool foci() const { return p_.foci != 0 && words_[0] > p_.records; }
    /// How far a period is ahead of the last one that was decided; as the board counts, in 48 bits.
    [[nodiscard]] std::uint64_t ahead(std::uint64_t period) const { return (period - decided_) & all; }
    [[nodiscard]] static bool late(std::uint64_t ahead) { return ahead == 0 || (ahead >> 47 & 1U) != 0; }

    static constexpr std::uint64_t all = (std::uint64_t{1} << 48) - 1;

    const interface::CoreParameters& p_;
    const std::uint32_t record_words_;
    Words words_{};
    std::vector<bool> waits_;
    std::uint64_t decided_ = all;

    std::uint64_t period_ = 0;
    std::uint32_t word_ = 0;
    Clock look_ = never;  // in which the slot of the pattern that comes is looked at
    bool judged_ = false, keeps_ = false;
    Counted refused_;

    Clock forget_at_ = never, swept_from_ = 0, turn_at_ = never;
    bool held_ = false, forgotten_ = true;  // forgotten: what was to be forgotten is
    std::uint32_t missed_ = 0;
};

}  // namespace haptogram::sim
