// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "haptogram/array/calibration.hpp"
#include "haptogram/calibration/code.hpp"
#include "haptogram/verbs/level.hpp"

namespace haptogram {

/// What a microphone heard at a place, and how well that place is known.
struct HeardAt {
    ElementSounds heard;
    Vec3 place;
};

struct CalibrateOptions {
    double place_error_m = 2e-3;  ///< of the places, in each direction
    double speed_error = 4e-3;    ///< of the array file's speed of sound, relative
    std::optional<Transducer>
        microphone;  ///< its directivity, facing against the array's axis; none: the same everywhere
};

/// A fault that the sounds show.
struct CalibrationFault {
    std::string cause;  ///< "dead", "weak", "floating", "reversed", "exchanged", "mirrored", "contradicting", "echo",
                        ///< "array" or "supply"
    std::vector<std::size_t> elements;
    std::string what, advice;
};

/// What the sounds say of the elements, and how surely.
struct Calibrated {
    Calibration calibration;
    std::vector<Vec3> places;            ///< as they came out
    std::vector<double> place_errors_m;  ///< largest of a place's three
    double speed_error_m_s = 0.0;
    std::vector<CalibrationFault> faults;
    double fits = 0.0;  ///< how well the array file's places do, as the logarithm of a likelihood
    double focus_before = 0.0, focus_after = 0.0;  ///< share of the ideal pressure where the first microphone was
};

/// Fits the elements' gains and phases, the microphone's places and gains, and the speed of sound to what was heard, by
/// Gauss and Newton's method in the logarithm of the sounds, in which all but places and speed are linear. Gains are
/// taken to differ by some 15 %, phases by some 0.3 rad, and any element may be reversed. A dead element is told from a
/// weak one by its sound's likelihood; elements with swapped wires are found by exchanges that make their sounds
/// consistent at three places or more. At one carrier a wrong resonance is a phase, and is found as one.
/// @param array  as its file describes it, without a calibration
/// @throws Error{bad_input} when fewer than half of the elements are heard, or their phases fit no place near the named
/// one
[[nodiscard]] Calibrated calibrate(const Array& array, std::span<const HeardAt> heard,
                                   const CalibrateOptions& options = {});

/// A shipped array whose elements are where the sounds come from, when those of another array are not, or surely less.
/// @param fits  of the named array, if its calibration could be made
/// @param hear  the sounds of an array's code; throws when there is none
[[nodiscard]] std::optional<std::string> other_array(const Array& named, std::optional<double> fits,
                                                     const std::function<std::vector<HeardAt>(const Array&)>& hear,
                                                     const CalibrateOptions& options = {});

/// What it means that a level was measured before and is another now, with the elements' gains taken into account.
[[nodiscard]] std::optional<CalibrationFault> supply_fault(const Transducer& before, const MeasuredLevel& now);

}  // namespace haptogram
