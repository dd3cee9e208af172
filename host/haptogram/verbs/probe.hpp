// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string_view>

#include "haptogram/acoustics/drive.hpp"
#include "haptogram/format/path.hpp"
#include "haptogram/verbs/field.hpp"

namespace haptogram {

/// An instrument that is moved through a field, its face parallel to the array, and its readings.
struct Probe {
    /// An ultrasonic receiver's signal is the mean of the complex pressure over its face, from which its directivity
    /// follows: 2·J1(ka·sin θ)/(ka·sin θ). Otherwise a pressure sensor gives the mean radiation pressure on its face.
    bool receives_ultrasound = true;
    double aperture_m = 0.0;  ///< diameter of the face
    /// Of a receiver 0: its rectified signal's mean over the sequence is read, as an rms pressure. Of a sensor: the
    /// amplitude of the radiation pressure at this frequency, by Fourier sums over windows.
    double hz = 0.0;
    double window_s = 0.0;       ///< about this long, in whole periods of the frequency
    double observation_s = 0.0;  ///< in windows, of which the mean, the least and the greatest amplitude are read
};

/// "haptogram": the receiver on the paper's robot arm (section IV-A), a Murata MA40S4R, whose rectified signal is
/// averaged over 20 readings. A scan is not in step with what plays, so they stand for the mean over all of it.
/// "hoshi:HZ": the sensor of Hoshi et al. 2010 (section 3.3), 2 mm wide: the component at the frequency of the
/// modulation, and the least and the greatest of a minute. The window of a tenth of a second is ours.
/// @throws Error{bad_argument} naming "probe" for anything else
[[nodiscard]] Probe probe_of(std::string_view text);

/// What a probe reads over a region. Drives change at once, as in every field: without the transducers' bandwidth.
/// @param modulation  that what plays has not yet; without samples: none
/// @throws Error{bad_argument} naming "probe" for a frequency above half the carrier; Error{bad_input} for a sequence
/// that does not repeat
[[nodiscard]] Field probe_field(const Array& array, const DriveSequence& sequence, const Modulation& modulation,
                                const Region& region, const Probe& probe, unsigned threads = 0,
                                const Progress& progress = {});

}  // namespace haptogram
