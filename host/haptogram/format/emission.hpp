// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <span>
#include <vector>

namespace haptogram {

/// What a channel is to emit: a carrier of `amplitude` (65,535 is full) whose pulse has its middle at `phase`, in
/// 65,536ths of the cycle. For raw records, `phase` is the tick at which the pulse starts.
struct Emission {
    std::uint16_t amplitude = 0;
    std::uint16_t phase = 0;
    friend bool operator==(const Emission&, const Emission&) = default;
};

/// What a pulse generator is told: the ticks at which its pulse starts and ends, modulo the cycle, and whether the
/// pulse starts already in the cycle before. No pulse: width 0, and all bits of `rise` and `fall` set.
struct EmissionWord {
    bool early = false;
    std::uint32_t rise = 0;
    std::uint32_t fall = 0;
    std::uint32_t width = 0;  ///< ticks
    bool bent = false;        ///< the slew limiter keeps the channel from its target
    friend bool operator==(const EmissionWord&, const EmissionWord&) = default;
};

enum class Slew : std::uint8_t { none = 0, rate = 1, arrive = 2 };

/// How fast phase and amplitude may change. `rate`: at most this many units a carrier period. `arrive`: each channel
/// goes straight to its target, and is there after this many periods.
struct SlewLimit {
    Slew mode = Slew::none;
    std::uint16_t phase_rate = 65535;      ///< 65,536ths of the cycle a period, not 0
    std::uint16_t amplitude_rate = 65535;  ///< not 0
    std::uint16_t arrival_periods = 1;     ///< 1…4095
};

/// The settings of one carrier period.
struct EmissionPeriod {
    std::uint32_t cycle_ticks = 1250;
    std::uint8_t modulation = 255;  ///< sample by which all amplitudes are multiplied, 255 is full
    bool new_target = false;        ///< `arrive` counts from this period on
    bool raw = false;               ///< emissions are ticks, and all pulses are `raw_ticks` long
    std::uint32_t raw_ticks = 0;
    SlewLimit slew{};
};

/// The words that rtl/amplitudes/emission.v gives to the pulse generators, equal to the bit. It keeps each channel's
/// place for the slew limiter, so the periods must be computed in their order. At first, and behind a raw period, a
/// limit starts from silence: from amplitude 0, with every phase where it is to be.
class EmissionModel {
public:
    /// @param channels     at least 1
    /// @param timing_bits  4…16, of a tick in a word
    /// @param width_bits   1…timing_bits, of a pulse's width
    /// @param least_width  1…2^width_bits − 1, ticks of the shortest pulse: the board's MIN_PULSE_CLOCKS
    /// @throws Error{bad_argument} when one is out of its range
    explicit EmissionModel(std::uint32_t channels, std::uint32_t timing_bits = 11, std::uint32_t width_bits = 10,
                           std::uint32_t least_width = 1);

    /// The words of one carrier period, one a channel.
    ///
    /// The amplitude times the modulation, and the phase, are what the slew limiter aims at. What it lets through
    /// becomes a pulse of width = cycle·asin(amplitude)/π (Hoshi et al. 2010, eq. 7, solved for the pulse) by a table
    /// of 1,024 steps, rounded to ticks. Of one shorter than the shortest, none or the shortest is
    /// left, whichever is nearer. Its middle is within half a tick of the phase.
    /// @param emissions  one a channel
    /// @throws Error{bad_input} when the number of emissions is not that of the channels, or a setting cannot be
    /// played:
    ///   a cycle whose half does not fit the width's bits (raw: 2^timing_bits ticks to 2^timing_bits + 2^width_bits,
    ///   over whose end no pulse can run), a raw pulse that does not fit them or is not shorter than its cycle, a rate
    ///   of 0, an arrival in 0 or more than 4095 periods
    [[nodiscard]] std::vector<EmissionWord> period(std::span<const Emission> emissions, const EmissionPeriod& settings);

    /// The same for settings that a board bears, though they make no sense: a rate of 0, or a raw pulse as long as its
    /// cycle.
    [[nodiscard]] std::vector<EmissionWord> as_played(std::span<const Emission> emissions,
                                                      const EmissionPeriod& settings);

    /// What each channel emits in the last period, after the slew limiter.
    [[nodiscard]] const std::vector<Emission>& places() const { return places_; }
    /// The pins have been silent, because outputs were off: the next period starts from that.
    void start_from_silence() { starts_ = true; }

private:
    void check(std::span<const Emission> emissions, const EmissionPeriod& settings) const;

    std::uint32_t timing_bits_, width_bits_, least_width_;
    std::vector<Emission> places_;
    std::uint32_t periods_left_ = 0;
    bool starts_ = true;  // the next period starts from silence
};

/// The width in ticks of the pulse that the FPGA makes of an amplitude, 65,535 being full, in a cycle of this many
/// ticks. A pulse shorter than `least_width`, the board's shortest, becomes none or `least_width`, whichever is nearer.
[[nodiscard]] std::uint32_t emission_ticks(std::uint16_t amplitude, std::uint32_t cycle_ticks,
                                           std::uint32_t least_width);

/// Width, in 2^-17 of the cycle, of the pulse whose carrier has an amplitude of `step`/1024 to `step + 1`/1024 of full:
/// asin((step + 1/2)/1024)/π, with exactly nothing at the first step and full at the last.
/// @param step  0…1023
/// @throws Error{bad_argument} for a larger step
[[nodiscard]] std::uint32_t arcsine_step(std::uint32_t step);

}  // namespace haptogram
