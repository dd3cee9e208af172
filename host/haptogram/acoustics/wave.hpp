// SPDX-License-Identifier: Apache-2.0
// The loops behind field.hpp, in single precision and with the processor's vector instructions. field.cpp prepares
// their input in double precision.
#pragma once
#include <array>
#include <complex>
#include <cstddef>
#include <span>
#include <vector>

#include "haptogram/acoustics/propagation.hpp"

namespace haptogram {

/// How the amplitude and phase of a wave follow from the range and the direction. The same for all elements.
struct WaveModel {
    float half_turns_per_m = 0.0F;  ///< phase per metre, in units of π: 2/λ
    float absorption_np_m = 0.0F;
    FittedPattern pattern;
    bool tilted = false;  ///< some element does not face +z; if none, normals are not looked at, which is faster
};

/// One element, relative to the centre of a block of points.
struct WaveElement {
    float x, y, z;     ///< position, from the block's centre, metres
    float range;       ///< from the element to the block's centre, metres
    float phase;       ///< by which the wave lags at the block's centre, in units of π, [-1, 1]
    float amplitude;   ///< Pa·m
    float nx, ny, nz;  ///< normal, of length 1
    float range_square;
};

/// Points near each other. Their coordinates are relative to the block's centre and so small that rounding them to
/// single precision changes a phase by less than 0.001°, wherever the block is.
struct WaveBlock {
    static constexpr std::size_t most = 1024;
    alignas(64) std::array<float, most> x{}, y{}, z{};
    alignas(64) std::array<float, most> half_square{};  ///< (x² + y² + z²)/2
    std::size_t count = 0;
    /// Whether each point is at least a third as far from each element as the block's centre is; then the waves are
    /// quicker to compute.
    bool far = false;
};

/// Makes a block of `count` points, at most WaveBlock::most.
void centre_block(const double* x, const double* y, const double* z, std::size_t count, Vec3 centre, WaveBlock& block);

/// One element's drives in two records. Records are computed in pairs, because then each value of the propagation is
/// loaded once for two products.
struct DrivePair {
    float re[2], im[2];
};

/// Sum of the elements' waves at each point.
/// @param re, im  room for WaveBlock::most
void sum_waves(const WaveModel& model, const WaveBlock& block, std::span<const WaveElement> elements, float* re,
               float* im);

/// Gradient of the sum of the elements' waves at each point: d/dx, d/dy and d/dz, real and imaginary part of each, in
/// Pa/m. Not for patterns that are tables, whose straight lines have no slope where they meet.
/// @param parts  six times room for WaveBlock::most: x.re, x.im, y.re, y.im, z.re, z.im
void sum_gradients(const WaveModel& model, const WaveBlock& block, std::span<const WaveElement> elements,
                   const std::array<float*, 6>& parts);

/// Σ weight·|p|² at each point over many records of drives. The elements' own amplitudes are to be 1.
/// @param drives   of the first pair of records, one an element; then of the second pair, and so on
/// @param weights  of the records, two a pair
/// @param scratch  room for scratch_of_sum_squares() floats, aligned as Highway allocates
/// @param mean     room for WaveBlock::most
void sum_squares(const WaveModel& model, const WaveBlock& block, std::span<const WaveElement> elements,
                 std::span<const DrivePair> drives, std::span<const float> weights, float* scratch, float* mean);
[[nodiscard]] std::size_t scratch_of_sum_squares(std::size_t elements);

/// A part of one element's field that contributes to two rows of points.
struct ShiftedShare {
    std::size_t at;    ///< where the part begins in the field
    DrivePair drives;  ///< what to multiply it by, for the first row and for the second
};

/// Adds up shifted copies of one element's field into one or two rows of points: row[i] = Σ drive·field[at + i].
/// @param field_re, field_im  are read up to shifted_tile floats beyond the last one that is used
/// @param second              null when there is only one row
void sum_shifted(const float* field_re, const float* field_im, std::span<const ShiftedShare> shares,
                 std::complex<float>* first, std::complex<float>* second, std::size_t points);
inline constexpr std::size_t shifted_tile = 256;  ///< at least four vectors of any processor

/// The instruction set in use on this processor, by Highway's name for it.
[[nodiscard]] const char* wave_target();

}  // namespace haptogram
