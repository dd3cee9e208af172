// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <complex>
#include <span>
#include <vector>

#include "haptogram/array/array.hpp"
#include "haptogram/format/bundle.hpp"
#include "haptogram/format/path.hpp"

namespace haptogram {

/// How good a focus some drives make, compared with exact phases at the same duty.
struct FocusCheck {
    double pressure_pa = 0.0;    ///< amplitude at the asked point
    double pressure_kept = 0.0;  ///< as a fraction of that of exact phases
    double peak_offset_m = 0.0;  ///< between the peak in the asked plane and that of exact phases
};

/// What a record's foci may lose and still be what was asked for.
struct FocusLimits {
    double expected_kept = 1.0;     ///< of the pressure, after rounding phases as the image says
    double least_kept = 0.999;      ///< below which something is wrong
    double most_offset_m = 0.2e-3;  ///< of the peak
};

/// The limits of a record. Unless an image says that its pulses lie on segments, they are the contract's: 99.9 % and
/// 0.2 mm. On N segments each phase is off by an error e that is evenly spread over ± Δ, Δ = π/N. Then
///
///     mean of cos e          sin(Δ)/Δ of the pressure is kept: 0.9936 for N = 16, and 0.9872 of its square
///     deviation of cos e     Δ²/√45 for small Δ
///     deviation of the peak  Δ/√3 over k·√(Σ s²), s the cosines between the ways of the waves and an axis, without
///                            their mean
///
/// A record may lose four standard deviations more than the mean, and 0.1 % as any record, and its peak may be four
/// deviations farther off: one of 16,000 correct records would. Errors of the eight elements that a square array's
/// symmetry makes alike count as one in the pressure; for the peak, symmetry helps.
///
/// A board that adds up several foci gives each element a pulse of its own, whose errors do not cancel exactly. In a
/// cycle of C ticks, and with the 1,024 steps of the table from amplitudes to lengths, an element of amplitude a is off
/// by up to half of π/C·√(1 − a²), 1/1024 and 2π/C·a: by its length, by the table, and by its phase. These are evenly
/// spread, alike for elements that are driven alike, and each element's wave carries them to the focus. A focus may
/// lose four deviations of that sum, over its own pressure, more than the 0.1 %: a weak focus beside strong ones loses
/// most. Its peak may be as far off as four deviations of the sum's slope move it, over the curvature of a lone focus.
[[nodiscard]] FocusLimits limits_of(const Manifest& manifest, const RecordMeaning& record);

/// The drives that a record is to have: exact phases for its foci, every element at full strength, as all channels of a
/// record have pulses of one length.
/// @param solver  by which the phases for several foci are found
[[nodiscard]] std::vector<std::complex<double>> exact_drives(const Array& array, std::span<const Focus> foci,
                                                             Method solver = Method::gauss_newton);

/// The drives that a record of a manifest asks for, one an element, Pa·m: exact phases at the duty of the timer and the
/// record's amplitude. Of a focus record, the sums of its foci, with an amplitude for each element.
[[nodiscard]] std::vector<std::complex<double>> asked_drives(const Manifest& manifest, const RecordMeaning& record);

/// The point of largest pressure in the plane z = start.z, climbed to from `start` in shrinking steps; finds the peak
/// of the main lobe that `start` lies in, to a micrometre.
[[nodiscard]] Vec3 lateral_peak(const Array& array, std::span<const std::complex<double>> drives, Vec3 start);

/// @param drives     one an element, Pa·m
/// @param reference  what they should be, with exact phases
[[nodiscard]] FocusCheck check_focus(const Array& array, std::span<const std::complex<double>> drives,
                                     std::span<const std::complex<double>> reference, Vec3 focus);

/// The worst of a record's foci, compared with exact phases at the pulse lengths that the timer can make. Where the
/// board modulates, with the lengths of the exact drives, so that the phases alone are compared.
[[nodiscard]] FocusCheck check_record(const Manifest& manifest, const RecordMeaning& record,
                                      std::span<const std::complex<double>> drives);

}  // namespace haptogram
