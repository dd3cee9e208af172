// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "haptogram/format/path.hpp"

namespace haptogram {

/// What a waveform's values are: fractions of the pressure, or of the radiation pressure, which is the pressure's
/// square and what the hand feels.
enum class AmplitudeLaw { pressure, radiation };

/// A modulation and the frequencies that came out, because the core repeats whole numbers of samples.
struct MadeModulation {
    Modulation modulation;
    std::vector<double> frequencies_hz;  ///< one a waveform; of a file, how often it repeats
};

/// Makes a modulation from a text. A waveform goes from 0 to 1:
///
///     static               always 1
///     sine:HZ              ½ + ½·sin(2πft)
///     square:HZ[:DUTY]     1 for the duty's share of a period, then 0; the duty is ½ unless told
///     abs-sine:HZ          |sin(πft)|, HZ bows a second
///     triangle:HZ          up for half a period, then down
///     sawtooth:HZ          up from 0 to 1, then at once to 0
///     A+B+…                the mean of several waveforms
///     wav:FILE             PCM of 8, 16, 24 or 32 bits or float, one channel; −1…1 becomes 0…1
///     csv:FILE             rows of time_s or time_ms and amplitude, straight lines between them
///
/// A sample is the waveform's mean over its carrier periods, so that a step which falls into a sample makes no tone of
/// its own. The samples hold whole periods of each frequency, as few as keep it within 0.1 %, or as near as
/// `most_samples` allow. Files are sampled at a tenth of the carrier.
/// @param folder  that relative names of files start from
/// @throws Error{bad_argument} for what is no waveform, frequencies above half the carrier, and duties outside 0…1;
/// Error{bad_input} for files, naming what is wrong with them
[[nodiscard]] MadeModulation modulation_of(std::string_view text, AmplitudeLaw law, double carrier_hz,
                                           const std::filesystem::path& folder = {}, std::size_t most_samples = 4096);

/// The 32 frequencies of the modulation of Hoshi et al. 2010 (section 3.1): 5 bits, from 1 to 1000 Hz at equal steps of
/// the logarithm, 1000^(i/31) Hz.
[[nodiscard]] std::array<double, 32> hoshi_frequencies_hz();

/// Means of a modulation over time: by these factors it lowers the mean pressure and the mean radiation pressure.
[[nodiscard]] double mean_of(const Modulation& modulation);
[[nodiscard]] double mean_square_of(const Modulation& modulation);

/// The sound of a WAV file with one channel, −1…1, and how many samples it has a second. Other channels, codings and
/// damage are errors.
struct Wave {
    std::vector<double> samples;
    double rate_hz = 0.0;
};
[[nodiscard]] Wave wave_from_wav(std::string_view bytes, const std::string& where);

/// The wave at another rate: band-limited interpolation by a sinc of 32 lobes under a Hann window. What the new rate
/// cannot hold is filtered out. The wave repeats, so its ends meet.
[[nodiscard]] std::vector<double> resampled(std::span<const double> samples, double rate_hz, double new_rate_hz,
                                            std::size_t count);

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
