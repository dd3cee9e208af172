// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "haptogram/format/emission.hpp"
#include "haptogram/format/focus_engine.hpp"
#include "reference_modulation.hpp"
#include "reference_player.hpp"
#include "reference_settings.hpp"

namespace haptogram::sim {

/// Records of timings, amplitudes and foci, for channels that each have an amplitude (rtl/amplitudes/drive_player.v;
/// rtl/README.md, contracts 8 to 10). Once a record its words become drives, one emission a channel; once a carrier
/// period these become pulses, by modulation and slew limit.
///
/// Geometry, and the settings of foci but for their place and number, must not change while a focus record is loaded.
class DrivePlayer final : public Player {
public:
    DrivePlayer(const interface::CoreParameters& p, const std::vector<std::uint16_t>& primary, EntrySource& source,
                PulseTrain& train);

    void reset(Clock first, Clock last) override;
    [[nodiscard]] Clock next(bool waits) const override;
    [[nodiscard]] Counted at(Clock clock, const Now& now) override;

    Settings settings;
    Modulation modulation;
    std::vector<GeometryWords> geometry;

private:
    // ---- Once a record (rtl/amplitudes/drive_loader.v)

    struct Loaded {
        bool silent = true, amplitudes = false;
        CarrierCycle::Lengths lengths{};
        std::uint32_t pulse = 0;
        std::vector<Emission> drives;  // one a channel
    };
    [[nodiscard]] bool is_focus(const EntrySource::Entry& entry) const {
        return p_.foci != 0 && entry.index > p_.records;
    }
    void go_on_loading(Clock clock, bool common, Counted& counted);
    void place(Clock clock);
    [[nodiscard]] bool finish(Clock clock, bool common);
    void load_words(std::span<const std::uint16_t> words, bool common);
    void load_foci(std::span<const std::uint16_t> words, bool common);
    [[nodiscard]] bool compute_foci(Clock clock);
    [[nodiscard]] bool has_room(std::uint32_t cycle) const;
    void free_loader(Clock clock);

    std::uint32_t lead_;  // clocks that a period's words take
    Loaded next_;
    Clock loaded_ = never;  // from which clock on it can be taken over
    Clock idle_ = 0;        // and an entry can be taken
    std::uint32_t base_ = 0, foci_cycle_ = 0;
    std::vector<FocusWords> foci_;  // of which next_ is to be computed
    /// What the engine made of a focus record; used again while memory holds the same words, and it is set up alike.
    struct Computed {
        std::vector<FocusWords> foci;
        bool far = false;
        std::vector<Emission> drives;
    };
    std::vector<Computed> computed_;  // by number
    std::array<std::uint16_t, interface::parameters_words> computed_by_{};
    std::vector<GeometryWords> computed_for_;

    // ---- Once a carrier period (rtl/amplitudes/period_controller.v)

    struct Sweep {
        Clock begins = 0;    // in which the slew limiter begins it
        Clock first = 0;     // in which channel 0's word is begun
        Clock prepared = 0;  // from which on all words are there
        EmissionPeriod period;
    };
    void take_over(Clock clock);
    void begin_sweep(Clock clock, bool new_target);
    void end_sweep(Clock clock);
    [[nodiscard]] std::vector<EmissionWord> words_of(const Sweep& sweep);

    std::optional<std::uint16_t> fade_;  // of a stream that has ended
    Clock go_ = never;                   // the go point of the present cycle
    Clock wait_ticks_ = 0;               // from the cycle's start to it
    bool given_ = false;                 // the modulation has been told of the next period
    bool owed_ = false;                  // or must be, late, of the present one
    Clock quiet_from_ = 0;               // it can take another period from here on
    bool busy_ = false;                  // words are being made, or wait to be put to use
    bool taken_ = false;                 // they are of a record that was taken over
    bool plays_ = false;                 // the record at the pins has amplitudes, or is the silence after one
    bool again_ = false;                 // a change that was asked for meanwhile is asked for once more
    Clock changed_ = never;              // the last clock in which words were put to use
    Clock missed_ = never;               // a period without words of its own is counted
    // What was taken over last.
    bool raw_ = true;     // a record of timings
    bool silent_ = true;  // nothing, after one of timings
    bool mute_ = false;   // silence
    EntrySource::Entry entry_;
    CarrierCycle::Lengths lengths_{0, 1};
    std::uint32_t raw_pulse_ = 0;
    std::vector<Emission> drives_;
    // Its words.
    std::optional<Sweep> sweep_;
    Clock prepared_ = never;  // from which clock on the words can be put to use
    std::shared_ptr<Firing> firing_;
    Clock bent_ = never;      // a bent period is counted
    bool quiet_pins_ = true;  // outputs have been off since the slew limiter began its last period
    EmissionModel model_;

    Clock seen_ = 0;      // the last clock that was worked out
    bool moved_ = false;  // something changed in it, so the next one must be, too
};

}  // namespace haptogram::sim
