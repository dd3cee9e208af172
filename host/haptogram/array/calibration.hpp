// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "haptogram/array/array.hpp"

namespace haptogram {

inline constexpr std::string_view calibration_format = "haptogram-calibration-1";

/// How strongly elements that differ are driven, on boards that compute foci.
enum class Drive {
    full,       ///< all alike
    weighed,    ///< each by its gain, of the strongest's: the most pressure for the power
    equalised,  ///< so that each radiates as much as the weakest that is alive
};
inline constexpr std::array<std::pair<Drive, const char*>, 3> drive_names{
    {{Drive::full, "full"}, {Drive::weighed, "weighed"}, {Drive::equalised, "equalised"}}};

/// How one element was found to be. Errors are standard deviations.
struct MeasuredElement {
    double gain = 1.0;       ///< of its pressure, over the mean of all that are alive
    double phase_rad = 0.0;  ///< by which its wave leads, without the half turn of a reversed one
    bool reversed = false, dead = false;
    std::uint32_t channel = 0;  ///< that it is wired to
    std::optional<double> gain_error, phase_error_rad;
};

/// The elements of an array as they are, and how that was found.
struct Calibration {
    std::string array;                               ///< that was measured: a shipped one's name, or a path
    std::string date;                                ///< such as "2026-11-25"
    std::optional<double> temperature_c, speed_m_s;  ///< of the air, as it was measured
    std::optional<double> residual;                  ///< rms of what the fit leaves, of the elements' sounds
    std::optional<double> source_pa_m;               ///< where the level was measured, too
    std::string measured;                            ///< how it was
    Drive drive = Drive::full;
    std::vector<MeasuredElement> elements;  ///< in the order of the array file
};

/// Reads a calibration file (TOML); host/arrays/README.md describes its keys.
/// @throws Error{bad_input} naming the file, the line and the key, also for unknown keys
[[nodiscard]] Calibration load_calibration(const std::filesystem::path& path);
[[nodiscard]] std::string to_text(const Calibration& calibration);

/// The array that was measured, with the responses that were found, in the order of the channels.
/// @param file  of the calibration; the array takes its name
/// @throws Error{bad_input} when it has another number of elements, or two are on one channel
[[nodiscard]] Array calibrated(Array array, const Calibration& calibration, const std::string& file);

/// The array file beside it that a calibration's text names; none for a shipped array, and for any other text.
[[nodiscard]] std::optional<std::string> array_named_in(std::string_view text);

/// The array file that a file leads to: a calibration's array, and any other file itself.
[[nodiscard]] std::string array_file_of(const std::filesystem::path& path);

}  // namespace haptogram
