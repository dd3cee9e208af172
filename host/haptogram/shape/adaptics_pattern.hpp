// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "haptogram/shape/adaptics.hpp"

/// A pattern of the AdapTics designer, as its file has it.
namespace haptogram::adaptics {

constexpr double largest = 1e9;  ///< of any number in a pattern

/// Something that changes from key frame to key frame.
template <class Value>
struct Keyed {
    double time_ms = 0.0;
    Value value;
    bool step = false;  ///< holds its value until the next one, instead of changing linearly
};

/// A circle has two equal half-axes; a line has its length and its thickness.
struct Brush {
    bool line = false;
    double half_x_mm = 0.0, half_y_mm = 0.0, turn_deg = 0.0, am_hz = 0.0;
};

enum class FrameKind { standard, pause, stop };

struct Pattern {
    std::vector<std::pair<double, FrameKind>> frames;  ///< times in ms, rising
    std::vector<Keyed<Vec3>> places;                   ///< mm; one a frame, for a pause that of the frame before
    std::vector<Keyed<Brush>> brushes;
    std::vector<Keyed<double>> intensities;
    Vec3 scale{1.0, 1.0, 1.0}, translate;  ///< mm
    double turn_deg = 0.0, intensity_factor = 1.0, speed = 1.0;
};

/// What key frames say of a moment.
struct Moment {
    Vec3 place;  ///< mm, where the pattern's transform has brought it
    Brush brush;
    double intensity = 0.0;
};

/// @throws Error{bad_input} as path_from_adaptics()
[[nodiscard]] Pattern read_pattern(std::string_view text, const std::string& where, const Parameters& parameters);

/// @param after_ms  what is around this time goes on until `time_ms`: of a step the value that it ends, not that it
///                  begins
[[nodiscard]] Moment moment_of(const Pattern& pattern, double after_ms, double time_ms);

}  // namespace haptogram::adaptics
