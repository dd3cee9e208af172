// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <complex>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "haptogram/array/array.hpp"
#include "haptogram/format/core.hpp"
#include "haptogram/format/image.hpp"

namespace haptogram {

/// What an array plays so that one microphone hears every element: patterns in which each element has phase 0 or half a
/// turn. Each element follows a column of a Hadamard matrix, so the sum over the patterns with its signs is its sound
/// alone, 10·log₁₀(patterns) dB above what it would be by itself. Columns without an element must come out silent: they
/// tell where the code begins, how far the recorder's clock is off, and how loud the noise is. Patterns are
/// negated by chance, and columns chosen by chance, so that the code is like no shifted copy of itself.
class CalibrationCode {
public:
    /// @throws Error{bad_input} when there are no elements
    explicit CalibrationCode(std::size_t elements);

    static constexpr std::uint32_t periods = 320;  ///< of the carrier that a pattern plays, 8 ms

    [[nodiscard]] std::size_t patterns() const { return negated_.size(); }
    /// Whether an element plays half a turn late in a pattern.
    [[nodiscard]] bool turned(std::size_t pattern, std::size_t element) const;
    /// From the sound of each pattern that of each column, of which the first belong to elements.
    [[nodiscard]] std::vector<std::complex<double>> columns(std::span<const std::complex<double>> sounds) const;

private:
    std::vector<bool> negated_;
    std::vector<std::size_t> column_of_;  ///< of each element, and then those that have none
};

/// The code as an image, which plays for ever.
/// @throws Error{bad_input} when the core holds fewer records than the code has patterns
[[nodiscard]] Image calibration_image(const Array& array, const Core& core);

/// What one microphone heard.
struct Recording {
    std::string name;  ///< for messages
    double rate_hz = 0.0;
    std::vector<double> samples;
};

/// What each element alone would have made it hear, in the recording's unit, up to a phase that all share.
struct ElementSounds {
    std::vector<std::complex<double>> sounds;
    double noise = 0.0;      ///< rms of the error of each
    double start_s = 0.0;    ///< where the first whole pass of the code begins
    double clock_ppm = 0.0;  ///< by which the carrier was recorded too high
    std::size_t passes = 0;  ///< of the code that were averaged
};

/// Finds the code in a recording of it.
/// @throws Error{bad_input} when the rate is too low, the recording clipped, no whole pass long, or without the code
[[nodiscard]] ElementSounds decode(const Recording& recording, std::size_t elements, double carrier_hz);

/// The elements' sounds from what a lock-in read of the code's patterns, in their order.
/// @throws Error{bad_input} when there is not one of each
[[nodiscard]] ElementSounds from_patterns(std::span<const std::complex<double>> readings, std::size_t elements,
                                          const std::string& name);

/// What tells phases to a meter that reads amplitudes alone. A few elements near the middle play at the phases of a
/// focus on the microphone; each element in turn plays beside them, or of them, with that phase and three quarter turns
/// ahead of it. Record 4 · element + step + 1, to be played one by one.
/// @throws Error{bad_input} when the core holds fewer records
[[nodiscard]] Image steps_image(const Array& array, const Core& core, Vec3 microphone);

/// The elements' sounds from the meter's readings of those records, in their order.
/// @throws Error{bad_input} when there are not four an element
[[nodiscard]] ElementSounds from_steps(const Array& array, std::span<const double> readings, Vec3 microphone,
                                       const std::string& name);

}  // namespace haptogram
