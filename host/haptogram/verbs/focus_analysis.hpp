// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <complex>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "haptogram/acoustics/field.hpp"
#include "haptogram/array/array.hpp"
#include "haptogram/format/pulses.hpp"
#include "haptogram/format/schedule.hpp"

namespace haptogram {

/// What a focal point is like while it plays alone.
struct FocusAnalysis {
    Vec3 focus;
    Formation formation;        ///< flight-time spread, β, T_f, ring-up (Haptogram III-G)
    double pressure_pa = 0.0;   ///< amplitude at the asked point
    double radiation_pa = 0.0;  ///< radiation pressure on skin there (Hoshi et al. 2010, eq. 1)
    double width_m = 0.0;       ///< full width at half maximum of the radiation pressure, the wider of x and y
    double depth_m =
        0.0;  ///< the same along z, within what is looked at: from λ above the array to three times the height
    double side_lobe = 0.0;  ///< highest radiation pressure beside the main lobe, along x and y, over that at the peak
    double force_n = 0.0;    ///< on a disc around it, by steady_force() (acoustics/skin_force.hpp)
    std::uint32_t dwell_cycles = 0;  ///< carrier periods until 90 % of the pressure is there: spread, load and ring-up
};

[[nodiscard]] FocusAnalysis analyze(const Array& array, const Core& core, Drives drives, Vec3 focus);

/// The pressure amplitude at a point when the array focuses on it with exact phases, Pa: Σ source·D(θ)/R·e^{−αR}.
/// NaN where no focal point may lie (Array::unreachable).
[[nodiscard]] double reachable_pressure(const Array& array, Vec3 point);
/// The same at every point of a grid.
[[nodiscard]] std::vector<float> workspace(const Array& array, const Grid& grid);

/// The points of a grid where a focus that plays alone, with exact phases, has at least this force on a disc
/// (acoustics/skin_force.hpp).
[[nodiscard]] std::vector<Vec3> felt_places(const Array& array, const Grid& grid, double least_force_n);

/// How loud a sequence is for an ear, averaged over time, in dB SPL: at the loudest place of the axis farther than λ
/// from the array, and at 300 mm.
struct Loudness {
    double highest_db = 0.0;
    double highest_at_m = 0.0;
    double at_300_mm_db = 0.0;
    double intensity_w_m2 = 0.0;  ///< p_rms²/(ρc) where it is highest
};
[[nodiscard]] Loudness loudness(const Array& array, std::span<const WeightedDrives> sequence);

/// What makes a sound field: sets of drives, each for its share of the time.
struct Excitation {
    Array array;
    std::vector<std::vector<std::complex<double>>> drives;  ///< one an element, Pa·m
    std::vector<double> weights;                            ///< of each set; only their ratios matter
    std::vector<Vec3> foci;                                 ///< that were asked for, metres
    std::string title;                                      ///< in words, for pictures

    /// The same in the form that the functions of acoustics/field.hpp take. It refers to this object, and is valid as
    /// long as this object is.
    [[nodiscard]] std::vector<WeightedDrives> sequence() const;
};

/// Multiplies every drive. With the root of a modulation's mean square, mean squares and radiation pressures become
/// those of the modulated sound.
void weaken(Excitation& excitation, double factor);

/// One focal point, exact phases, full strength.
/// @throws Error{bad_argument} when the array cannot reach it
[[nodiscard]] Excitation excitation_of(const Array& array, Vec3 focus);

/// One of the sets of drives, as if it played alone.
/// @param place  counted from 0
/// @throws Error{bad_argument} when there is no such set
[[nodiscard]] Excitation only(const Excitation& excitation, std::size_t place);

/// A square modulation, as bursts of pulses at the pins show it.
struct Envelope {
    std::size_t bursts = 0;     ///< with silence before them
    double frequency_hz = 0.0;  ///< from the first of these to the last; 0 when there are not two
};

/// Finds the bursts of the channel that has the most pulses. Between two pulses of a burst there is one carrier period,
/// give or take half of one, by which a change of record may move a pulse.
/// @param pulses         in the order of time in each channel, as PulseRecorder has them
/// @param cycle_clocks   of the carrier
/// @param silent_before  whether the pins were silent before the first pulse because nothing played yet, so that the
/// first burst may be the rest of a longer one, and is not counted
[[nodiscard]] Envelope envelope_of(std::span<const Pulse> pulses, double clock_hz, std::uint64_t cycle_clocks,
                                   bool silent_before = true);

/// The pressure amplitude that drives make at a focus, over that of exact phases at full drive: 0…1.
/// @param drives  one an element, Pa·m, as measure() has them
[[nodiscard]] double share_of_full_drive(const Array& array, std::span<const std::complex<double>> drives, Vec3 focus);

}  // namespace haptogram
