// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <complex>
#include <cstddef>
#include <span>
#include <vector>

#include "haptogram/acoustics/drive.hpp"
#include "haptogram/array/array.hpp"

namespace haptogram {

/// A transducer over time, as a linear resonator. It is described by the poles λ and residues r of its transfer
/// function H(s) = Σ r/(s − λ), in which complex poles come in conjugate pairs.
///
/// The drive is 0 or 1. A steady train of 50 % duty at `peak_hz` gives an output of amplitude 1. The resonator blocks
/// direct current, so that after the first periods only the changes of the drive matter: 0 and 1 act like −½ and +½.
struct Resonator {
    struct Mode {
        std::complex<double> pole;  ///< rad/s
        std::complex<double> residue;
    };
    std::vector<Mode> modes;  ///< every real pole, and one pole of each conjugate pair
    double peak_hz = 0.0;     ///< the frequency at which the output's amplitude is 1

    /// The output's complex amplitude for a steady train of 50 % duty at this frequency.
    [[nodiscard]] std::complex<double> response(double frequency_hz) const;
    /// In which the amplitude of the slowest mode falls to 1/e, s.
    [[nodiscard]] double time_constant_s() const;
};

/// A resonator of second order: H(s) = 2γs/(s² + 2γs + ω₀²). Its half-power bandwidth is exactly B = γ/π and its time
/// constant 1/(πB). Hoshi (section 2.3) gives a bandwidth of 2 kHz.
/// @throws Error{bad_input} unless 0 < bandwidth < 2·resonance
[[nodiscard]] Resonator second_order(double resonance_hz, double bandwidth_hz);

/// The resonator of an array's transducers: it resonates at the carrier and has the transducer's bandwidth.
[[nodiscard]] Resonator second_order(const Array& array);

/// The Butterworth–Van Dyke equivalent circuit of a piezoelectric transducer, fed through its driver's resistance: L, C
/// and R in series, and C_p in parallel to them. The output is the current through L, C and R. The defaults are those
/// of AUTD3's emulator.
struct ButterworthVanDyke {
    double inductance_h = 80e-3;
    double capacitance_f = 200e-12;
    double resistance_ohm = 700.0;
    double parallel_f = 2.7e-9;
    double driver_ohm = 150.0;
};

/// The circuit as a resonator of third order. `peak_hz` is the resonance of L and C, 1/(2π√(LC)).
[[nodiscard]] Resonator butterworth_van_dyke(const ButterworthVanDyke& circuit = {});

/// Evenly spaced times: start + i·step for i < count, seconds.
struct Sampling {
    double start_s = 0.0;
    double step_s = 0.0;
    std::size_t count = 0;
};

/// The resonator's output; it is at rest before the first pulse. Between edges of the pulses the state follows e^{λt},
/// which is computed exactly, so the result does not depend on the step between samples.
/// @param pulses  in ascending order and without overlap
[[nodiscard]] std::vector<double> output(const Resonator& resonator, std::span<const DrivePulse> pulses,
                                         const Sampling& sampling);

/// Sound pressure at a point over time, Pa. Each element contributes its output times source_pa_m·D(θ)·e^{−αR}/R,
/// delayed by R/c. Directivity D and absorption α are those at the carrier.
/// @param trains  one an element
/// @throws Error{bad_input} when the point coincides with an element or `trains` is of another length
[[nodiscard]] std::vector<double> pressure_over_time(const Array& array, const Resonator& resonator,
                                                     std::span<const std::vector<DrivePulse>> trains, Vec3 point,
                                                     const Sampling& sampling);

/// Complex envelope of a carrier in evenly spaced samples: 2/T ∫ s(t)·e^{−jωt} dt over the period around each sample,
/// with t = 0 at the first sample. A steady carrier is s(t) = Re(envelope·e^{jωt}). The first and the last half period,
/// around which no whole period lies, are 0.
/// @param samples_per_period  even
[[nodiscard]] std::vector<std::complex<double>> envelope(std::span<const double> samples,
                                                         std::size_t samples_per_period);

/// Pulses that focus on a point, one for each element and each carrier period from `first` to `first + periods`,
/// without the last. They have the array's duty and come at such a time in the period that all waves arrive in phase.
/// The times are exact, not rounded to ticks.
[[nodiscard]] std::vector<std::vector<DrivePulse>> focal_trains(const Array& array, Vec3 focus, std::size_t first,
                                                                std::size_t periods);

/// How long a focus takes to form from silence when every element starts in the same carrier period.
struct RingUp {
    double first_arrival_s = 0.0;  ///< of sound at the focus, from the start of the period
    double flight_spread_s = 0.0;  ///< from the nearest element's arrival to the farthest one's (Haptogram eq. 4)
    double rise_s = 0.0;           ///< from the first arrival until the focus has `fraction` of its steady amplitude
    double ring_up_s = 0.0;        ///< the same with one element alone
};
[[nodiscard]] RingUp ring_up(const Array& array, const Resonator& resonator, Vec3 focus, double fraction = 0.9);

/// How strong a focus still is when the array alternates between it and another one.
struct Alternation {
    double peak = 0.0;   ///< largest amplitude, over that of the focus alone
    double power = 0.0;  ///< mean square, over that of the focus alone; ½ if transducers had no ring-up and the other
                         ///< focus no side lobes
};

/// Strength of `focus` while the array plays it for `periods` carrier periods, then `other` for as many, and so on,
/// long after the start. The drive changes only between carrier periods, as the core's does.
/// @throws Error{bad_input} when `periods` is 0
[[nodiscard]] Alternation alternate(const Array& array, const Resonator& resonator, Vec3 focus, Vec3 other,
                                    std::size_t periods);

}  // namespace haptogram
