// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "haptogram/base/progress.hpp"
#include "haptogram/solve/solver.hpp"
#include "haptogram/verbs/focus_analysis.hpp"
#include "haptogram/verbs/timeline.hpp"

namespace haptogram {

/// About the least force that a palm felt: 0.06 gf (the paper “Multimodal”, Table III; see docs/references.md).
inline constexpr double least_felt_n = 0.58e-3;
/// From Hoshi et al. 2010, section 2.4: the level that is recommended as a limit for ears, and the intensity that is
/// safe inside tissue. Skin absorbs 0.1 % of the ultrasound that meets it.
inline constexpr double recommended_for_ears_db = 110.0;
inline constexpr double safe_in_tissue_w_m2 = 1000.0;
inline constexpr double absorbed_by_skin = 1e-3;

/// By how much a room's air may differ unnoticed.
inline constexpr double other_air_c = 10.0;

/// The share of the pressure of a focus that is left where it was to be, when all elements meet there in phase for the
/// array's speed of sound and the true one is another.
[[nodiscard]] double left_at_speed(const Array& array, Vec3 focus, double speed_m_s);

/// One focus of what plays.
struct PointAnalysis {
    std::size_t record = 0;          ///< index of the first record that makes it
    FocusAnalysis focus;             ///< its pressures are roots of the mean squares of its modulation
    std::uint64_t dwell_cycles = 0;  ///< carrier periods that it plays, in one pass or in all that was measured
    bool too_weak = false;           ///< less than the least force
    double heat_limit_n = 0.0;       ///< the force with which the focus' peak would leave the safe intensity in tissue
    double left_in_other_air =
        1.0;                  ///< of its pressure, where the air is other_air_c warmer or colder than computed for
    double impulse_ns = 0.0;  ///< of the force in one dwell, which drives the air behind it (Hoshi et al. 2010, eq. 8)
};

struct ImageAnalysis {
    std::vector<PointAnalysis> points;
    std::vector<std::string> warnings;
    PressureLeft pressure_left;  ///< by the transducers' bandwidth at this path's speed and spacing
    Loudness loudness;           ///< information computed from a model, no certification
    Transducer transducer;       ///< what absolute pressures and forces rest on: level_text()
};

/// What each focus of what plays is like, and how loud the whole is.
/// @param least_force_n  a focus with less force in it is called too weak to feel
[[nodiscard]] ImageAnalysis analyze(const Timeline& timeline, double least_force_n = least_felt_n,
                                    const Progress& progress = {});

}  // namespace haptogram
