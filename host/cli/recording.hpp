// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <complex>
#include <optional>
#include <string>
#include <vector>

#include "haptogram/array/vec3.hpp"
#include "haptogram/verbs/calibration_code.hpp"

namespace haptogram::cli {

/// Reads a recording: a WAV file with one channel, or an oscilloscope's CSV: lines of time in seconds and voltage, at
/// even times, after any lines that begin with no number.
/// @throws Error{bad_input} naming the file, and the line
[[nodiscard]] Recording read_recording(const std::string& file);

/// The readings of a meter: CSV with the header `index,reading`, and a line for each record, in any order; nothing when
/// the file is none.
/// @throws Error{bad_input} naming the line
[[nodiscard]] std::optional<std::vector<double>> read_steps(const std::string& file);

/// What a receiver on a stage read at one place: of each record, in their order.
struct StageReadings {
    Vec3 off;  ///< from the stage's zero
    std::vector<std::complex<double>> readings;
};
struct Scan {
    bool amplitudes = false;  ///< of the records of steps_image; otherwise complex ones of the code's
    std::vector<StageReadings> places;
};
/// CSV with the header `x_mm,y_mm,z_mm,index,re,im` of a lock-in or `x_mm,y_mm,z_mm,index,reading` of a meter, and a
/// line for each place and record, in any order; nothing when the file is none.
/// @throws Error{bad_input} naming the line
[[nodiscard]] std::optional<Scan> read_scan(const std::string& file);

}  // namespace haptogram::cli
