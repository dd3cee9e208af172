// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace haptogram {

/// How a transducer's far field depends on the angle from its axis.
enum class Pattern {
    piston,  ///< 2·J1(ka·sin θ)/(ka·sin θ) (Haptogram eq. 9)
    point,   ///< the same in every direction (Haptogram eq. 6)
    table,   ///< as it was measured
};

/// One kind of transducer. `source_pa_m` is pressure amplitude times distance on the axis, at full (50 %) duty, in
/// Pa·m. Every absolute pressure and force follows from it. It is *calibrated* when it was measured on the array
/// itself, and *nominal* otherwise.
struct Transducer {
    std::string name = "MA40S4S";
    double radius_m = 4.5e-3;
    double source_pa_m = 4.0;
    std::string measured;          ///< how source_pa_m was measured on this array; empty: it is nominal
    double bandwidth_hz = 2000.0;  ///< half-power; gives the ring-up time
    Pattern pattern = Pattern::piston;
    std::vector<double> table;  ///< of Pattern::table: amplitudes at even steps of angle from 0 to 90°, 1 on the axis
    friend bool operator==(const Transducer&, const Transducer&) = default;
};

/// Reads a transducer file (TOML); see host/arrays/README.md for its keys.
/// @throws Error{bad_input} naming the file, the line and the key, also for unknown keys
[[nodiscard]] Transducer load_transducer(const std::filesystem::path& path);

/// Finds `name` as a path, relative to `folder`, when it has a slash or ends in .toml, or else among the shipped
/// transducers.
[[nodiscard]] Transducer find_transducer(const std::string& name, const std::filesystem::path& folder = {});

/// Reads a measured pattern: CSV with the columns angle_deg,amplitude, angles rising from 0 to 90, amplitude 1 at 0.
/// Angles at uneven steps, which must be whole hundredths of a degree, are interpolated linearly to the widest even
/// ones that all of them lie on, so that nothing of the straight lines between them is lost.
/// @return amplitudes at even steps from 0 to 90°
/// @throws Error{bad_input} naming the file and the line
[[nodiscard]] std::vector<double> load_directivity(const std::filesystem::path& path);

}  // namespace haptogram
