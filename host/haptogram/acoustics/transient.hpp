// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <complex>
#include <cstddef>
#include <span>
#include <vector>

#include "haptogram/acoustics/drive.hpp"
#include "haptogram/model/array.hpp"

namespace haptogram {

/// A transducer in time: a linear resonator, as the poles and residues of its transfer function
/// H(s) = Σ r/(s − λ) + r*/(s − λ*) over the complex pairs, and Σ r/(s − λ) over the real poles.
/// Its drive is 0 or 1, its output 1 in amplitude for a steady train of 50 % duty at `peak_hz`. It passes no direct
/// current, so a drive of ±½, or Hoshi's behind its high-pass filter, is the same after the first period.
struct Resonator {
    struct Mode {
        std::complex<double> pole;  ///< rad/s
        std::complex<double> residue;
    };
    std::vector<Mode> modes;  ///< one of each complex pair
    double peak_hz = 0.0;     ///< where the gain is normalised

    /// The amplitude and phase of a steady 50 % train of this frequency: 1 at `peak_hz`.
    [[nodiscard]] std::complex<double> response(double frequency_hz) const;
    /// Of the amplitude, the slowest mode's, s.
    [[nodiscard]] double time_constant_s() const;
};

/// Second order, band-pass: H(s) = 2γs/(s² + 2γs + ω₀²), with the half-power bandwidth B = γ/π exactly and the time
/// constant 1/(πB) (Hoshi 2.3: 2 kHz).
/// @throws Error{bad_input} unless 0 < bandwidth < 2·resonance
[[nodiscard]] Resonator second_order(double resonance_hz, double bandwidth_hz);

/// The array's own: at its carrier, with its transducer's bandwidth.
[[nodiscard]] Resonator second_order(const Array& array);

/// A piezoelectric transducer's equivalent circuit behind its driver's resistance: the branch L-C-R, whose current is
/// the output, with C_p across it. The defaults are those of AUTD3's emulator.
struct ButterworthVanDyke {
    double inductance_h = 80e-3;
    double capacitance_f = 200e-12;
    double resistance_ohm = 700.0;
    double parallel_f = 2.7e-9;
    double driver_ohm = 150.0;
};

/// Third order; `peak_hz` is the branch's series resonance 1/(2π√(LC)).
[[nodiscard]] Resonator butterworth_van_dyke(const ButterworthVanDyke& circuit = {});

/// Times start + i·step, i < count, s.
struct Sampling {
    double start_s = 0.0;
    double step_s = 0.0;
    std::size_t count = 0;
};

/// The resonator's output, at rest before the first pulse. The state goes from edge to edge and sample to sample by
/// e^{λt}, exactly, whatever the step.
/// @param pulses  in order, none overlapping another
[[nodiscard]] std::vector<double> output(const Resonator& resonator, std::span<const DrivePulse> pulses,
                                         const Sampling& sampling);

/// Sound pressure at a point over time, Pa: each element's output times source_pa_m·D(θ)·e^{−αR}/R, R/c later.
/// D and α are those at the carrier.
/// @param trains  one an element
/// @throws Error{bad_input} when the point coincides with an element or `trains` is of another length
[[nodiscard]] std::vector<double> pressure_over_time(const Array& array, const Resonator& resonator,
                                                     std::span<const std::vector<DrivePulse>> trains, Vec3 point,
                                                     const Sampling& sampling);

/// Complex envelope of a carrier in evenly sampled values: 2/T ∫ s(t)·e^{−jωt} dt over the period around each sample,
/// t = 0 at the first, so that s(t) = Re(envelope·e^{jωt}) for a steady carrier. Half a period at each end, where
/// there is no whole period, is 0.
/// @param samples_per_period  even
[[nodiscard]] std::vector<std::complex<double>> envelope(std::span<const double> samples,
                                                         std::size_t samples_per_period);

/// Pulses that focus on a point in the periods [first, first + periods) of the carrier: one a period an element, of the
/// array's duty, at the time in the period at which its wave arrives in phase with all others (exact, not in ticks).
[[nodiscard]] std::vector<std::vector<DrivePulse>> focal_trains(const Array& array, Vec3 focus, std::size_t first,
                                                                std::size_t periods);

/// How a focus forms from silence when every element starts in the same period.
struct RingUp {
    double first_arrival_s = 0.0;  ///< of the first pulse at the focus, after the start of the period
    double flight_spread_s = 0.0;  ///< to the farthest element's (Haptogram eq. 4)
    double rise_s = 0.0;           ///< from the first arrival to `fraction` of the steady amplitude at the focus
    double ring_up_s = 0.0;        ///< the same of one element alone
};
[[nodiscard]] RingUp ring_up(const Array& array, const Resonator& resonator, Vec3 focus, double fraction = 0.9);

/// What a focus keeps when the array alternates between it and another.
struct Alternation {
    double peak = 0.0;   ///< largest amplitude over that of the focus alone
    double power = 0.0;  ///< mean square over that of the focus alone; ½ without ring-up and cross-talk
};

/// Amplitude at `focus` while the array plays `periods` carrier periods of it, then as many of `other`, and so on, once
/// this has become periodic. The drive changes only between periods, as the core's does.
/// @throws Error{bad_input} when `periods` is 0
[[nodiscard]] Alternation alternate(const Array& array, const Resonator& resonator, Vec3 focus, Vec3 other,
                                    std::size_t periods);

}  // namespace haptogram
