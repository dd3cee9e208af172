// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <filesystem>
#include <string>
#include <vector>

namespace haptogram::perception {

/// The forces of a focus are kept in gram-force (gf), the unit of the printed tables: 1 gf = 9.80665 mN.
inline constexpr double gram_force_n = 9.80665e-3;

/// Polynomials that were fitted at one frequency of modulation. g is the output of a focus in gf, under a square wave
/// of 50 % duty.
struct FrequencyFit {
    double frequency_hz = 0.0;
    std::array<double, 4> command{};    ///< L, M, N, U of I = L·g³ + M·g² + N·g + U (Multimodal eq. 11)
    std::array<double, 3> magnitude{};  ///< G, J, V of PI = G·g² + J·g + V, for the palm (Multimodal eq. 10)
    double command_r2 = 0.0, magnitude_r2 = 0.0;  ///< how well each fitted, as printed
};

/// The least that was felt, from … to, gf.
struct Interval {
    double low_gf = 0.0, high_gf = 0.0;
    [[nodiscard]] double centre_gf() const { return (low_gf + high_gf) / 2.0; }
};

/// Thresholds while the hand held a handle that pulled with this force.
struct ThresholdRow {
    double grip_n = 0.0;
    Interval palm, finger;
};

/// What is known of how strong a focus feels, as a perception file has it.
struct Tables {
    std::string name, file, source;
    std::vector<FrequencyFit> fits;        ///< two or more, frequencies rising
    std::vector<ThresholdRow> thresholds;  ///< two or more, grip forces rising
    double most_sensitive_from_hz = 0.0, most_sensitive_to_hz = 0.0;
};

/// Reads a perception file (TOML); extras/feel/README.md describes its keys.
/// @throws Error{bad_input} naming file, line and key; also when a polynomial does not rise where it is used, from 0 gf
/// to the output of the full command, because it could not be inverted then
[[nodiscard]] Tables load_tables(const std::filesystem::path& path);

/// Finds `name` as a path, or among the shipped perception files.
[[nodiscard]] Tables find_tables(const std::string& name = "multimodal");

}  // namespace haptogram::perception
