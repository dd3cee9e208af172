// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <complex>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "haptogram/array/medium.hpp"
#include "haptogram/array/pose.hpp"
#include "haptogram/array/transducer.hpp"
#include "haptogram/array/vec3.hpp"

namespace haptogram {

/// One transducer's place, the way it faces, and how it differs from its kind. A normal has length 1.
struct Element {
    Vec3 position;
    Vec3 normal{0.0, 0.0, 1.0};
    std::complex<double> response = 1.0;  ///< what it radiates of its drive: a gain, and a phase that leads; 0: dead
    double weight = 1.0;                  ///< of full drive, how much it is given: more than 0, at most 1

    /// The drive whose wave has the phase of an element that is as its kind: as long as its weight, 0 of a dead one.
    [[nodiscard]] std::complex<double> aligning() const {
        const double gain = std::abs(response);
        return gain > 0.0 ? std::conj(response) / gain * weight : 0.0;
    }
    /// Whether it is as its kind, and driven as any.
    [[nodiscard]] bool plain() const { return response == 1.0 && weight == 1.0; }
    friend constexpr bool operator==(const Element&, const Element&) = default;
};

[[nodiscard]] inline double distance(const Element& element, Vec3 point) { return distance(element.position, point); }

/// Transducers that play together: where they are, in channel order, what they are, and the air in front of them. The
/// array frame has its origin at the array's centre; the array's axis is z.
struct Array {
    std::string name;
    std::string file;               ///< where it was read from, for messages
    std::vector<Element> elements;  ///< metres; in a grid, number row · columns + column
    std::uint32_t columns = 0;      ///< of the grid; 0 when the elements form no grid
    double carrier_hz = 40e3;
    double duty = 0.5;             ///< of the carrier period, (0, 0.5]
    std::vector<Pose> faces;       ///< of an array that was joined from several (rig.hpp): where each stands
    double reach_angle_rad = 1.0;  ///< a focal point lies within this angle of the axis, seen from the origin; of a
                                   ///< joined array, for at least one of its faces
    double nearest_m = 0.0;        ///< and no nearer than this to any element; by default where the far field begins,
                                   ///< 10·d²/4λ (Haptogram eq. 10)
    Medium medium;
    Transducer transducer;

    [[nodiscard]] double wavelength_m() const { return medium.speed_m_s / carrier_hz; }
    /// Why a focal point cannot be reached, in words; empty when it can.
    [[nodiscard]] std::string unreachable(Vec3 focus) const;
    /// For what makes records of timings, in which all pulses have one length.
    /// @throws Error{bad_input} when elements have weights
    void require_one_weight() const;
};

/// Reads an array file (TOML); host/arrays/README.md describes its keys. If it has a table [board], format/core.hpp
/// reads that. Of a calibration (calibration.hpp) it is the array that was measured, as it was measured.
/// @throws Error{bad_input} naming the file, the line and the key, also for unknown keys
[[nodiscard]] Array load_array(const std::filesystem::path& path);

/// Finds `name` as a path, or among the shipped arrays.
[[nodiscard]] Array find_array(const std::string& name);
[[nodiscard]] std::vector<std::string> shipped_arrays();

}  // namespace haptogram
