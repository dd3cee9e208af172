// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "clock.hpp"
#include "haptogram/format/interface.hpp"
#include "reference_cycle.hpp"
#include "reference_pulses.hpp"
#include "reference_reader.hpp"
#include "reference_source.hpp"

namespace haptogram::sim {

/// From the next entry to the pulse train: loads records and puts them to use at the ends of cycles.
class Player {
public:
    Player(const interface::CoreParameters& p, const std::vector<std::uint16_t>& primary, EntrySource& source,
           PulseTrain& train)
        : p_(p), source_(source), reader_(p, primary), cycle_(p, train) {}
    Player(const Player&) = delete;
    Player& operator=(const Player&) = delete;
    virtual ~Player() = default;

    /// Resets in clock `first`, as until `last`.
    virtual void reset(Clock first, Clock last) = 0;

    /// @param waits  whether changes wait for the end of a cycle, as while pulses may reach the pins
    [[nodiscard]] virtual Clock next(bool waits) const = 0;
    /// What else is known in a clock.
    struct Now {
        bool waits;
        bool off;                           ///< the pins are cleared
        bool hold;                          ///< the cycle does not end in this clock; its last one is repeated
        bool common;                        ///< cycles have one length, a carrier period's; other records are refused
        bool streams = false;               ///< a stream plays
        std::optional<std::uint16_t> fade;  ///< one has ended: amplitudes change by at most this a period
    };
    /// What is to be counted of a clock.
    struct Counted {
        bool refused = false, underrun = false, bent = false, far = false;
        bool samples = false;  ///< the modulation takes its first sample
        bool goes = false;     ///< the go point of boards with amplitudes (rtl/amplitudes/period_controller.v)
    };
    /// To be called in each clock that next() says, and in which something is changed from outside.
    [[nodiscard]] virtual Counted at(Clock clock, const Now& now) = 0;

    [[nodiscard]] RecordReader& reader() { return reader_; }
    [[nodiscard]] const RecordReader& reader() const { return reader_; }
    [[nodiscard]] CarrierCycle& cycle() { return cycle_; }
    [[nodiscard]] const CarrierCycle& cycle() const { return cycle_; }

protected:
    const interface::CoreParameters p_;
    EntrySource& source_;
    RecordReader reader_;
    CarrierCycle cycle_;
};

/// Records of timings alone (rtl/player.v; rtl/README.md, contracts 2, 3 and 7).
class RecordPlayer final : public Player {
public:
    RecordPlayer(const interface::CoreParameters& p, const std::vector<std::uint16_t>& primary, EntrySource& source,
                 PulseTrain& train)
        : Player(p, primary, source, train), known_(p.records + 1) {}

    void reset(Clock first, Clock last) override;
    [[nodiscard]] Clock next(bool waits) const override;
    [[nodiscard]] Counted at(Clock clock, const Now& now) override;

private:
    /// A record as it was found in memory.
    struct Loaded {
        std::vector<std::uint16_t> words;
        CarrierCycle::Lengths lengths{};
        bool playable = false;
        bool common = false;             // its cycle is a carrier period
        std::shared_ptr<Firing> firing;  // none without pulses
    };

    [[nodiscard]] bool finish(bool common);
    [[nodiscard]] std::shared_ptr<const Loaded> load(std::span<const std::uint16_t> words, std::size_t index);
    [[nodiscard]] Clock take_at() const;
    void commit(Clock clock);

    std::vector<std::shared_ptr<const Loaded>> known_;  // by index; used again while memory holds the same words
    std::shared_ptr<const Loaded> record_;              // that waits; none for silence
    Clock idle_ = 0;                                    // from which clock on an entry can be taken
    bool finished_ = false;                             // it is known whether what is held can be played
};

/// What a record's header says of its lengths, and whether they can be played (rtl/record_header.v).
struct Header {
    std::uint32_t cycle_length, prescaler, pulse, kind;
    [[nodiscard]] std::uint64_t cycle_clocks() const { return std::uint64_t{cycle_length} * prescaler; }
    [[nodiscard]] static Header of(std::span<const std::uint16_t> words);
    /// @return whether its cycle, its pulse and the part that this takes are in the board's bounds
    [[nodiscard]] bool in_bounds(const interface::CoreParameters& p) const;
};
/// A board with amplitudes takes up to eight clocks for each cycle (rtl/amplitudes/period_controller.v).
[[nodiscard]] constexpr std::uint32_t least_cycle_clocks(const interface::CoreParameters& p) {
    return p.width_bits != 0 ? 8 : 1;
}
/// A pin that stays high for so long may trip the guard when pulses merge.
[[nodiscard]] constexpr std::uint32_t longest_pulse_clocks(const interface::CoreParameters& p) {
    return (p.max_high_clocks / 2 - 2) / 5;
}

}  // namespace haptogram::sim
