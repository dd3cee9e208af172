// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "haptogram/perception/tables.hpp"

namespace haptogram::perception {

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

}  // namespace haptogram::perception
