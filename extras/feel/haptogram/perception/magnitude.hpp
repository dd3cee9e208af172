// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "haptogram/array/array.hpp"
#include "haptogram/format/path.hpp"
#include "haptogram/perception/tables.hpp"
#include "haptogram/verbs/path_makers.hpp"

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

/// The polynomials at any frequency between the lowest and the highest of the tables. Command and magnitude are
/// interpolated linearly in the logarithm of the frequency; the paper leaves this open.
/// @throws Error{bad_argument} naming "frequency" outside of them
[[nodiscard]] FrequencyFit fit_at(const Tables& tables, double frequency_hz);

/// The command, 0…1, that makes an output (Multimodal eq. 11).
/// @param gf  from 0 to full_output_gf()
/// @throws Error{bad_argument} naming "output" elsewhere: the polynomial is not extrapolated
[[nodiscard]] double command_of_output(const FrequencyFit& fit, double gf);

/// The output of a command: the inverse of eq. 11, gf.
/// @throws Error{bad_argument} naming "command" below U, where the device has no output, and above 1
[[nodiscard]] double output_of_command(const FrequencyFit& fit, double command);

/// The output of the full command, 1, in gf.
[[nodiscard]] double full_output_gf(const FrequencyFit& fit);

/// The perceived magnitude of an output, without unit (Multimodal eq. 10). Near 0 gf it is negative at some
/// frequencies, as printed.
/// @throws Error{bad_argument} naming "output" when it lies outside 0…full_output_gf()
[[nodiscard]] double magnitude_of_output(const FrequencyFit& fit, double gf);

/// The output that is felt with a magnitude: the inverse of eq. 10 on its rising branch, gf.
/// @throws Error{bad_argument} naming "magnitude" when no output between 0 and full_output_gf() has it
[[nodiscard]] double output_of_magnitude(const FrequencyFit& fit, double magnitude);

/// How a focus shall feel.
struct Wanted {
    double magnitude = 2.0;  ///< perceived, in the unit of the tables
    double frequency_hz = 200.0;
    Region region = Region::palm;
    double grip_n = 1.0;  ///< the force that the hand holds at the same time
    Waveform waveform = Waveform::square;
    double duty = 0.5;  ///< of the square wave
    Weighing weighing = Weighing::fundamental;
};

/// What makes it feel so.
struct Setting {
    double output_gf = 0.0;  ///< gs: what is felt so under a square wave of 50 % duty (inverse of Multimodal eq. 10)
    double least_felt_gf = 0.0;  ///< the threshold below which nothing is promised
    double waveform_factor = 1.0, duty_factor = 1.0, position_factor = 1.0;
    double factor = 1.0;      ///< F_I of Multimodal eq. 12: all three together
    double needed_gf = 0.0;   ///< gF = gs·F_I (Multimodal eq. 11)
    double full_gf = 0.0;     ///< what the device gives at its full command
    double command = 0.0;     ///< 0…1
    double pulse_duty = 0.0;  ///< of the carrier period: how long the pulse of that command is
};

/// F_pl·F_H of Multimodal eq. 13, from physics: the full force at `reference`, where the tables were measured, over
/// that at `focus`. It is below 1 where the array is stronger than at the reference. Errors as above.
[[nodiscard]] double position_factor(const Array& array, Vec3 focus, Vec3 reference = {0.0, 0.0, 0.2});

/// How long a pulse is whose carrier has `amplitude` times that of a pulse of `full_duty`, as a part of the carrier
/// period: asin(amplitude·sin(π·full_duty))/π (Hoshi eq. 7, solved for the pulse).
/// @throws Error{bad_argument} naming "amplitude" outside of 0…1
[[nodiscard]] double pulse_duty(double amplitude, double full_duty = 0.5);

/// The output that is needed for it where the device's place costs nothing: gs over the factor of the waveform, gf.
/// @throws Error{bad_argument} as setting_for(), of what does not depend on the device
[[nodiscard]] double needed_gf(const Tables& tables, const Wanted& wanted);

/// The setting of the device that the tables were measured on, with its focus where they were measured.
/// Its command is the polynomial's (Multimodal eq. 11). The pulse is that of an amplitude equal to the command.
/// @throws Error{bad_argument} naming what lies outside of what was measured: a magnitude below the threshold, or above
/// what the full command makes. Nothing is extrapolated. Also for a finger, because the magnitudes are those of palms
[[nodiscard]] Setting setting_for(const Tables& tables, const Wanted& wanted);

/// The same for a focus of an array, from physics: the command is the amplitude of the drive, the root of the needed
/// force over the array's full one.
/// @throws Error{bad_input} naming "focus" when it cannot be reached, and {bad_argument} naming "magnitude" when the
/// array is too weak there
[[nodiscard]] Setting setting_for(const Tables& tables, const Wanted& wanted, const Array& array, Vec3 focus);

/// The modulation's part of Wanted, from its text as format/waveform.hpp reads it: one waveform with its frequency, and
/// the duty of a square wave.
/// @throws Error{bad_argument} naming "magnitude" for what no magnitude is known of: a text that is empty or static,
/// several waveforms, files, and radiation as the law of the waveform's values
[[nodiscard]] Wanted wanted_of(double magnitude, std::string_view am, bool values_are_radiation);

/// Lets every focus of a path feel with one magnitude while it is there: multiplies its amplitude by the command of its
/// place (setting_for() on the array).
/// @throws Error{bad_argument} naming "magnitude" and the place, when the array is too weak there, or when foci exist
/// at the same time and so share the array's pressure
PathMagnitude give_magnitude(Path& path, const Tables& tables, const Wanted& wanted, const Array& array);

/// Commands for one magnitude at any place of an array, for a renderer that meets new places in every frame. A focus'
/// force changes slowly from place to place. It is computed at the corners of a lattice, each when it is first needed,
/// and is linear in between; the command is then within 0.2 % of setting_for()'s above half an array's width.
class CommandLattice {
public:
    /// Keeps references to the tables and the array.
    /// @throws Error{bad_argument} when nothing feels so, wherever it is: see setting_for()
    CommandLattice(const Tables& tables, const Wanted& wanted, const Array& array);

    /// The command, 0…1. @throws Error as give_magnitude()
    [[nodiscard]] double at(Vec3 place);
    [[nodiscard]] std::size_t corners() const { return forces_.size(); }  ///< that were computed

private:
    [[nodiscard]] double force_at(const std::array<long, 3>& corner);

    const Tables& tables_;
    Wanted wanted_;
    const Array& array_;
    double needed_gf_;
    std::map<std::array<long, 3>, double> forces_;  ///< N, NaN out of the array's reach
};
/// The same for a path that is played in pieces.
PathMagnitude give_magnitude(Path& path, CommandLattice& commands);

/// The same with a project's magnitude and waveform, by the shipped tables, as PathMakers has it.
/// @throws Error as wanted_of() and give_magnitude()
PathMagnitude give_magnitude(Path& path, const Project& project, const Array& array);

}  // namespace haptogram::perception
