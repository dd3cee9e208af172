// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "haptogram/acoustics/field.hpp"
#include "haptogram/array/array.hpp"
#include "haptogram/format/formation.hpp"

namespace haptogram {

/// What a focal point is like while it plays alone.
struct FocusAnalysis {
    Vec3 focus;
    Formation formation;        ///< flight-time spread, β, T_f, ring-up (Haptogram III-G)
    double pressure_pa = 0.0;   ///< amplitude at the asked point
    double radiation_pa = 0.0;  ///< radiation pressure on skin there (Hoshi et al. 2010, eq. 1)
    double width_m = 0.0;       ///< full width at half maximum of the radiation pressure, the wider of x and y
    double depth_m =
        0.0;  ///< the same along z, within what is looked at: from λ above the array to three times the height
    double side_lobe = 0.0;  ///< highest radiation pressure beside the main lobe, along x and y, over that at the peak
    double force_n = 0.0;    ///< on a disc around it, by steady_force() (acoustics/skin_force.hpp)
    std::uint32_t dwell_cycles = 0;  ///< carrier periods until 90 % of the pressure is there: spread, load and ring-up
};

[[nodiscard]] FocusAnalysis analyze(const Array& array, const Core& core, Drives drives, Vec3 focus);

/// The pressure amplitude at a point when the array focuses on it with exact phases, Pa: Σ source·D(θ)/R·e^{−αR}.
/// NaN where no focal point may lie (Array::unreachable).
[[nodiscard]] double reachable_pressure(const Array& array, Vec3 point);
/// The same at every point of a grid.
[[nodiscard]] std::vector<float> workspace(const Array& array, const Grid& grid);

/// The points of a grid where a focus that plays alone, with exact phases, has at least this force on a disc
/// (acoustics/skin_force.hpp).
[[nodiscard]] std::vector<Vec3> felt_places(const Array& array, const Grid& grid, double least_force_n);

/// How loud a sequence is for an ear, averaged over time, in dB SPL: at the loudest place of the axis farther than λ
/// from the array, and at 300 mm.
struct Loudness {
    double highest_db = 0.0;
    double highest_at_m = 0.0;
    double at_300_mm_db = 0.0;
    double intensity_w_m2 = 0.0;  ///< p_rms²/(ρc) where it is highest
};
[[nodiscard]] Loudness loudness(const Array& array, std::span<const WeightedDrives> sequence);

}  // namespace haptogram
