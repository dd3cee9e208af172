// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <complex>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace haptogram {

/// A pulse on one channel: when it rises and when it falls, seconds.
struct DrivePulse {
    double rise_s;
    double fall_s;
};

/// The carrier's complex amplitude in a train of pulses of height 1 that lasts `duration_s`: the Fourier component
/// 2/T ∫ s(t)·e^{−jωt} dt, divided by 2/π. With this scale a train of 50 % duty has amplitude 1, and one of any duty
/// sin(π·duty) (Hoshi eq. 7). The phase is −ω times the delay of the pulses' middle.
[[nodiscard]] std::complex<double> carrier_component(std::span<const DrivePulse> pulses, double carrier_hz,
                                                     double duration_s);

/// Drives in the order in which they play.
struct DriveSequence {
    struct Step {
        std::size_t set = 0;        ///< in `drives`
        std::uint64_t periods = 1;  ///< of the carrier
        std::uint32_t record = 0;   ///< its index in the image; 0: silence
    };
    std::vector<std::vector<std::complex<double>>> drives;  ///< different sets, one drive an element each, Pa·m
    std::vector<Step> steps;
    double carrier_hz = 40e3;
    bool repeats = true;  ///< from the beginning for ever; otherwise there is silence before and after

    /// Carrier periods from the beginning to the end.
    [[nodiscard]] std::uint64_t periods() const {
        std::uint64_t sum = 0;
        for (const Step& step : steps) sum += step.periods;
        return sum;
    }
};

/// How a transducer's carrier follows its drive: the rest of the difference that is left after a time t is
/// e^{−πBt}, with the half-power bandwidth B of a resonance at the carrier (acoustics/transient.hpp).
[[nodiscard]] double left_of_difference(double bandwidth_hz, double time_s);

/// Values that follow a sequence of wanted ones as a transducer's carrier follows its drive, looked at in the middle of
/// each carrier period. Sums over elements follow in the same way, because all elements have one bandwidth; the
/// different times of flight, some hundredths of a millisecond, are left out.
/// @tparam Value  with +, − and a product with a number from the left
/// @param wanted  one a set of the sequence, which has one at least
/// @param visit   called with each period's number and its value
template <class Value, class Visit>
void follow(const DriveSequence& sequence, double bandwidth_hz, const std::vector<Value>& wanted, Visit visit) {
    const double whole = left_of_difference(bandwidth_hz, 1.0 / sequence.carrier_hz);
    const double half = left_of_difference(bandwidth_hz, 0.5 / sequence.carrier_hz);
    const auto left_after = [&](std::uint64_t periods) {
        return periods == 1 ? whole
                            : left_of_difference(bandwidth_hz, static_cast<double>(periods) / sequence.carrier_hz);
    };
    Value state = 0.0 * wanted.front();
    if (sequence.repeats) {
        // From rest, a pass ends with some value; for ever, with that over 1 − the rest that a pass leaves.
        for (const DriveSequence::Step& step : sequence.steps) {
            const Value difference = state - wanted[step.set];
            state = wanted[step.set] + left_after(step.periods) * difference;
        }
        state = (1.0 / (1.0 - left_after(sequence.periods()))) * state;
    }
    std::uint64_t period = 0;
    for (const DriveSequence::Step& step : sequence.steps) {
        for (std::uint64_t i = 0; i < step.periods; ++i) {
            const Value difference = state - wanted[step.set];
            visit(period++, wanted[step.set] + half * difference);
            state = wanted[step.set] + whole * difference;
        }
    }
}

}  // namespace haptogram
