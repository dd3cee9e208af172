// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <complex>
#include <optional>
#include <string>
#include <vector>

#include "haptogram/array/vec3.hpp"
#include "haptogram/calibration/calibrate.hpp"
#include "haptogram/calibration/code.hpp"

namespace haptogram {

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

/// The files of a code's parts, from names joined by commas. The name of an existing file is one name, also with a
/// comma in it.
[[nodiscard]] std::vector<std::string> files_of_recording(const std::string& recording);

/// What such files say of one place, or of each of a stage's. @param at  of the microphone, or of the stage's zero
/// @throws Error{bad_input} naming the file, also for parts that are of other places or another meter than the first
[[nodiscard]] std::vector<HeardAt> hear(const std::string& recording, const Array& array, Vec3 at);

}  // namespace haptogram
