// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>
#include <string_view>

namespace haptogram {

/// One waveform with a frequency, as a text names it.
struct NamedWaveform {
    std::string kind;  ///< sine, square, abs-sine, triangle or sawtooth
    double frequency_hz = 0.0;
    double duty = 0.5;  ///< of a square wave
};

/// The waveform of a modulation's text (modulation_of()) that is a single one with a frequency; nothing for static
/// ones, sums and files.
/// @throws Error{bad_argument} naming "am" for what is no waveform, frequencies that are not positive, and duties
/// outside 0…1
[[nodiscard]] std::optional<NamedWaveform> single_waveform(std::string_view text);

}  // namespace haptogram
