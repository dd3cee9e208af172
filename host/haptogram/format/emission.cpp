// SPDX-License-Identifier: Apache-2.0
#include "haptogram/format/emission.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "haptogram/base/error.hpp"

namespace haptogram {
namespace {
constexpr std::uint32_t most_arrival_periods = 4095;

const std::array<std::uint32_t, 1024>& arcsine_table() {
    static const std::array<std::uint32_t, 1024> table = [] {
        std::array<std::uint32_t, 1024> steps{};
        for (std::uint32_t i = 0; i < steps.size(); ++i) steps[i] = arcsine_step(i);
        return steps;
    }();
    return table;
}

/// One step of a coordinate towards its target, `way` units away.
/// @param share  part of the way that arrival takes, in 2^-17
std::int32_t step(Slew mode, std::int32_t way, std::int32_t rate, std::int32_t share) {
    if (mode == Slew::rate) return std::abs(way) <= rate ? way : way < 0 ? -rate : rate;
    if (mode == Slew::arrive && share != 0) return static_cast<std::int32_t>((std::int64_t{way} * share) >> 17);
    return way;
}

}  // namespace

std::uint32_t arcsine_step(std::uint32_t step) {
    if (step > 1023)
        throw bad_argument("step", "amplitude step " + std::to_string(step) + "; the table has steps 0 to 1023");
    if (step == 0) return 0;
    if (step == 1023) return (1U << 16) - 1;
    return static_cast<std::uint32_t>(std::lround(std::asin((step + 0.5) / 1024) / std::numbers::pi * (1 << 17)));
}

std::uint32_t emission_ticks(std::uint16_t amplitude, std::uint32_t cycle_ticks, std::uint32_t least_width) {
    const std::uint64_t product = std::uint64_t{arcsine_table()[amplitude >> 6U]} * cycle_ticks;  // in 2^-17 ticks
    if (product >> 16U < least_width) return 0;
    return std::max(static_cast<std::uint32_t>((product + (1U << 16U)) >> 17U), least_width);
}

EmissionModel::EmissionModel(std::uint32_t channels, std::uint32_t timing_bits, std::uint32_t width_bits,
                             std::uint32_t least_width)
    : timing_bits_(timing_bits), width_bits_(width_bits), least_width_(least_width), places_(channels) {
    if (channels == 0) throw bad_argument("channels", "no channels; an emission model needs at least one");
    if (timing_bits < 4 || timing_bits > 16)
        throw bad_argument("timing_bits", std::to_string(timing_bits) + " bits for a tick; 4 to 16 are possible");
    if (width_bits < 1 || width_bits > timing_bits)
        throw bad_argument("width_bits", std::to_string(width_bits) + " bits for a pulse's width; 1 to " +
                                             std::to_string(timing_bits) + ", the bits of a tick, are possible");
    if (least_width < 1 || least_width >= 1U << width_bits)
        throw bad_argument("least_width", "a shortest pulse of " + std::to_string(least_width) + " ticks; 1 to " +
                                              std::to_string((1U << width_bits) - 1) + " are possible");
}

void EmissionModel::check(std::span<const Emission> emissions, const EmissionPeriod& settings) const {
    if (emissions.size() != places_.size())
        throw bad_input("emissions", std::to_string(emissions.size()) + " emissions for " +
                                         std::to_string(places_.size()) + " channels; give one a channel");
    const std::uint32_t ticks = 1U << timing_bits_;
    const std::uint32_t longest = (1U << width_bits_) - 1;
    const std::string cycle = "a cycle of " + std::to_string(settings.cycle_ticks) + " ticks";
    if (settings.raw) {
        if (settings.cycle_ticks > ticks && settings.cycle_ticks < ticks + longest + 1)
            throw bad_input("cycle_ticks", cycle + "; raw ones have up to " + std::to_string(ticks) + " ticks, or " +
                                               std::to_string(ticks + longest + 1) +
                                               " and more; take a larger or smaller prescaler");
        if (settings.raw_ticks > longest)
            throw bad_input("raw_ticks", "a pulse of " + std::to_string(settings.raw_ticks) + " ticks; at most " +
                                             std::to_string(longest) + " fit its " + std::to_string(width_bits_) +
                                             " bits; take a larger prescaler");
        if (settings.raw_ticks >= settings.cycle_ticks)
            throw bad_input("raw_ticks", "a pulse of " + std::to_string(settings.raw_ticks) + " ticks in " + cycle +
                                             "; a pulse must be shorter than its cycle");
    } else if (settings.cycle_ticks < 2 || settings.cycle_ticks > 2 * longest) {
        throw bad_input("cycle_ticks", cycle + "; 2 to " + std::to_string(2 * longest) + " are possible, of which " +
                                           "half fits the " + std::to_string(width_bits_) +
                                           " bits of a width; take another prescaler");
    }
    const SlewLimit& slew = settings.slew;
    if (slew.mode == Slew::rate && (slew.phase_rate == 0 || slew.amplitude_rate == 0))
        throw bad_input("slew", "a rate of 0 never arrives; give at least 1, or no limit");
    if (slew.arrival_periods == 0 || slew.arrival_periods > most_arrival_periods)
        throw bad_input("slew", "an arrival in " + std::to_string(slew.arrival_periods) + " periods; 1 to " +
                                    std::to_string(most_arrival_periods) + " are possible");
}

std::vector<EmissionWord> EmissionModel::period(std::span<const Emission> emissions, const EmissionPeriod& settings) {
    check(emissions, settings);
    return as_played(emissions, settings);
}

std::vector<EmissionWord> EmissionModel::as_played(std::span<const Emission> emissions,
                                                   const EmissionPeriod& settings) {
    const SlewLimit& slew = settings.slew;
    if (settings.new_target)
        periods_left_ = slew.arrival_periods;
    else if (periods_left_ > 1)
        --periods_left_;
    const std::int32_t share = periods_left_ > 1 ? static_cast<std::int32_t>((1U << 17) / periods_left_) : 0;

    const auto cycle = static_cast<std::int64_t>(settings.cycle_ticks);
    const std::uint32_t never = (1U << timing_bits_) - 1;
    const bool starts = std::exchange(starts_, settings.raw);
    std::vector<EmissionWord> words(emissions.size());
    for (std::size_t k = 0; k < words.size(); ++k) {
        std::int64_t width = 0;
        std::int64_t start = 0;
        EmissionWord& word = words[k];
        if (settings.raw) {
            start = emissions[k].phase;
            width = start < cycle ? settings.raw_ticks : 0;
        } else {
            Emission& place = places_[k];
            if (starts) place = {0, emissions[k].phase};
            const Emission target{
                static_cast<std::uint16_t>(emissions[k].amplitude * (257ULL * settings.modulation + 1) >> 16),
                emissions[k].phase};
            const std::int32_t amplitude_way = target.amplitude - place.amplitude;
            const auto phase_way = static_cast<std::int16_t>(target.phase - place.phase);  // the shorter way round
            place.amplitude = static_cast<std::uint16_t>(place.amplitude +
                                                         step(slew.mode, amplitude_way, slew.amplitude_rate, share));
            place.phase = static_cast<std::uint16_t>(place.phase + step(slew.mode, phase_way, slew.phase_rate, share));
            word.bent = place != target;
            width = emission_ticks(place.amplitude, settings.cycle_ticks, least_width_);
            const std::int64_t middle = place.phase * cycle >> 15;  // in half ticks
            start = (middle - width + 1) >> 1;
        }
        const std::int64_t rise = start < 0 ? start + cycle : start;
        if (width == 0 || rise >= never) {
            word.rise = word.fall = never;
        } else {
            word.early = start < 0;
            word.rise = static_cast<std::uint32_t>(rise);
            word.fall = static_cast<std::uint32_t>(rise + width >= cycle ? rise + width - cycle : rise + width) & never;
            word.width = static_cast<std::uint32_t>(width);
        }
    }
    return words;
}

}  // namespace haptogram
