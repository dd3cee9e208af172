// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

namespace haptogram::perception {

/// Shapes of the modulation: the envelope m(t) of the pressure, between 0 and 1. The radiation pressure follows m².
enum class Waveform { square, abs_sine, sine, cosine, triangle, sawtooth };

[[nodiscard]] std::string name_of(Waveform waveform);
/// @throws Error{bad_argument} naming "waveform", with the names that there are
[[nodiscard]] Waveform waveform_of(const std::string& name);
[[nodiscard]] const std::vector<Waveform>& all_waveforms();

/// m at a time. @param phase  in periods of the modulation; any number. |sine| is |sin(π·phase)|, so that it, too,
/// repeats once a period. @param duty  of the square wave, 0…1; the others do not use it
[[nodiscard]] double envelope(Waveform waveform, double phase, double duty = 0.5);

/// Mean of m² over a period: what a balance weighs.
[[nodiscard]] double mean_output(Waveform waveform, double duty = 0.5);

/// Amplitude of the fundamental of m²: the alternating part, which is what skin feels as vibration. For the square wave
/// it is (2/π)·sin(π·duty), largest at 50 %.
[[nodiscard]] double fundamental_output(Waveform waveform, double duty = 0.5);

/// How outputs of waveforms are compared.
enum class Weighing {
    fundamental,  ///< by what is felt
    mean,         ///< by what a balance shows, as the paper's eq. 8 and 9 do
};
/// "fundamental" or "mean". @throws Error{bad_argument} naming "weighing"
[[nodiscard]] Weighing weighing_of(const std::string& name);

/// F_wf of Multimodal eq. 8: a waveform's output over that of the square wave of 50 % duty.
[[nodiscard]] double waveform_factor(Waveform waveform, Weighing weighing);

/// F_D of Multimodal eq. 13 for the square wave: the output at 50 % duty, at which the tables were measured, over that
/// at `duty`. The paper's factor has the largest output on top, that of 100 % if output grows with duty; with it the
/// factor would be 2 at the duty of its own tables, so 50 % stands there.
/// @throws Error{bad_argument} naming "duty" outside of 0 < duty < 1, or = 1 when the fundamental is weighed
[[nodiscard]] double duty_factor(double duty, Weighing weighing);

/// The envelope that makes the radiation pressure follow a wanted course: m = √wanted.
/// @param wanted  0…1 @throws Error{bad_argument} naming "wanted" elsewhere
[[nodiscard]] double radiation_linear(double wanted);

}  // namespace haptogram::perception
