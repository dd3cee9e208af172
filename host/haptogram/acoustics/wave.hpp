// SPDX-License-Identifier: Apache-2.0
// The vector loops behind kernel.hpp, in single precision; kernel.cpp prepares what they need in double.
#pragma once
#include <array>
#include <complex>
#include <cstddef>
#include <span>
#include <vector>

#include "haptogram/acoustics/pattern.hpp"

namespace haptogram {

/// What turns a range and a direction into a wave.
struct WaveModel {
    float half_turns_per_m = 0.0F;  ///< of the phase: 2/λ
    float absorption_np_m = 0.0F;
    FittedPattern pattern;
    bool tilted = false;  ///< some element does not face +z; if none, normals are not looked at, which is faster
};

/// One element as a block of points sees it.
struct WaveElement {
    float x, y, z;     ///< from the block's centre, metres
    float range;       ///< of the block's centre, metres
    float phase;       ///< at the block's centre, behind, half turns in [-1, 1]
    float amplitude;   ///< Pa·m
    float nx, ny, nz;  ///< normal, of length 1
};

/// Points near each other. Coordinates are counted from the block's centre, so that single precision holds them to
/// less than a thousandth of a degree of phase wherever the block is.
struct WaveBlock {
    static constexpr std::size_t most = 1024;
    alignas(64) std::array<float, most> x{}, y{}, z{};
    alignas(64) std::array<float, most> half_square{};  ///< (x² + y² + z²)/2
    std::size_t count = 0;
};

/// Makes a block of `count` points, up to WaveBlock::most.
void centre_block(const double* x, const double* y, const double* z, std::size_t count, Vec3 centre, WaveBlock& block);

/// A pair of drives for each element, side by side: two products share what is loaded of the propagation.
struct DrivePair {
    float re[2], im[2];
};

/// Sum of the elements' waves at each point.
/// @param re, im  room for WaveBlock::most
void sum_waves(const WaveModel& model, const WaveBlock& block, std::span<const WaveElement> elements, float* re,
               float* im);

/// Σ weight·|p|² at each point over many drives of the same elements, whose amplitudes are 1.
/// @param drives   pairs × elements
/// @param weights  two a pair
/// @param scratch  room for scratch_of_sum_squares() floats, aligned as Highway allocates
/// @param mean     room for WaveBlock::most
void sum_squares(const WaveModel& model, const WaveBlock& block, std::span<const WaveElement> elements,
                 std::span<const DrivePair> drives, std::span<const float> weights, float* scratch, float* mean);
[[nodiscard]] std::size_t scratch_of_sum_squares(std::size_t elements);

/// What two rows of points share of one element's field: where in it both begin, and the drive that each hears it with.
struct ShiftedShare {
    std::size_t at;
    DrivePair drives;
};

/// Adds up shifted copies of one element's field: row[i] = Σ drive·field[at + i].
/// @param field_re, field_im  readable for shifted_tile floats beyond the last one asked for
/// @param second              none when there is only one row
void sum_shifted(const float* field_re, const float* field_im, std::span<const ShiftedShare> shares,
                 std::complex<float>* first, std::complex<float>* second, std::size_t points);
inline constexpr std::size_t shifted_tile = 256;  ///< no less than four vectors of any processor

/// The instruction set chosen, by Highway's name for it.
[[nodiscard]] const char* wave_target();

}  // namespace haptogram
