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
    /// @param part  the codes of several parts (CodePart) are like no other
    /// @throws Error{bad_input} when there are no elements
    explicit CalibrationCode(std::size_t elements, std::size_t part = 1);

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

/// One of several images, for a board that holds too few records for all elements at once.
struct CodePart {
    std::size_t number = 1, of = 1;
};

/// The elements that a part's code plays; the others are silent. Nine that are spread over the array play in each part:
/// what is heard of them tells how the parts go together.
/// @throws Error{bad_argument} when there are more parts than elements to share out
[[nodiscard]] std::vector<std::size_t> elements_of_part(const Array& array, CodePart part);

/// How many parts the code takes on a core: one, if that holds all of it.
/// @throws Error{bad_input} when no number of parts is enough
[[nodiscard]] std::size_t parts_of_code(const Array& array, const Core& core);

/// The code as an image, which plays for ever.
/// @throws Error{bad_input} when the core holds fewer records than the code has patterns, with the number of parts that
/// it takes
[[nodiscard]] Image calibration_image(const Array& array, const Core& core, CodePart part = {});

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
/// @param part  whose code it is; the elements are then that part's
/// @throws Error{bad_input} when the rate is too low, the recording clipped, no whole pass long, or without the code
[[nodiscard]] ElementSounds decode(const Recording& recording, std::size_t elements, double carrier_hz,
                                   std::size_t part = 1);

/// The elements' sounds from what a lock-in read of the code's patterns, in their order.
/// @throws Error{bad_input} when there is not one of each
[[nodiscard]] ElementSounds from_patterns(std::span<const std::complex<double>> readings, std::size_t elements,
                                          const std::string& name, std::size_t part = 1);

/// The sounds of all elements from those of each part's, which share neither phase nor level.
/// @throws Error{bad_input} when those that play in each part sound otherwise from one to another
[[nodiscard]] ElementSounds join_parts(const Array& array, std::span<const ElementSounds> parts,
                                       const std::string& name);

/// What tells phases to a meter that reads amplitudes alone. A few elements near the middle play at the phases of a
/// focus on the microphone; each element in turn plays beside them, or of them, with that phase and three quarter turns
/// ahead of it. Record 4 · element + step + 1, to be played one by one; a part has the records of some elements, in
/// their order.
/// @throws Error{bad_input} when the core holds fewer records, with the number of parts that it takes
[[nodiscard]] Image steps_image(const Array& array, const Core& core, Vec3 microphone, CodePart part = {});

/// The elements' sounds from the meter's readings of those records, in their order.
/// @throws Error{bad_input} when there are not four an element
[[nodiscard]] ElementSounds from_steps(const Array& array, std::span<const double> readings, Vec3 microphone,
                                       const std::string& name);

}  // namespace haptogram
