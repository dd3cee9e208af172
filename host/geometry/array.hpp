// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "geometry/vec3.hpp"

namespace haptogram {

/// The air between array and hand.
struct Medium {
    double speed_m_s = 343.2;
    double density_kg_m3 = 1.204;
    double absorption_np_m = 0.0;  ///< of the pressure amplitude, at the carrier
};

/// How a transducer's far field depends on the angle from its axis.
enum class Pattern {
    piston,  ///< 2·J1(ka·sin θ)/(ka·sin θ) (Haptogram eq. 9)
    point,   ///< the same in every direction (eq. 6)
    table,   ///< as it was measured
};

/// One kind of transducer. `source_pa_m` is calibrated per kind: pressure amplitude times distance on the axis, at full
/// (50 %) duty, in Pa·m.
struct Transducer {
    std::string name = "MA40S4S";
    double radius_m = 4.5e-3;
    double source_pa_m = 4.0;
    double bandwidth_hz = 2000.0;  ///< half-power; gives the ring-up time
    Pattern pattern = Pattern::piston;
    std::vector<double> table;  ///< of Pattern::table: amplitudes at even steps of angle from 0 to 90°, 1 on the axis
};

/// The FPGA board that drives the array.
struct BoardSpec {
    std::string name = "generic";
    double clock_hz = 50e6;
    std::uint32_t baud = 1'000'000;
    std::uint32_t channels = 100;
    std::uint32_t records = 400;
    std::uint32_t sequence_depth = 1024;  ///< words, the first of which is the header
    std::uint32_t timing_bits = 16;
    std::uint32_t pulse_bits = 8;
};

/// An array file: where the elements are, in channel order, and all that a compiler must know about them.
/// Elements may be fewer than the board's channels; the rest stay silent.
struct Array {
    std::string name = "tile-10x10";
    std::string file;            ///< where it was read from, for messages
    std::vector<Vec3> elements;  ///< metres, z = 0, channel order (row · columns + column)
    std::uint32_t columns = 0;   ///< of a grid; 0 when the file lists the elements
    double carrier_hz = 40e3;
    double duty = 0.5;             ///< of the carrier period, (0, 0.5]
    double reach_angle_rad = 1.0;  ///< a focal point lies within this angle of the axis, seen from the array's centre
    double nearest_m = 0.0;  ///< and no nearer to any element: the far field, by default 10·d²/4λ (Haptogram eq. 10)
    Medium medium;
    Transducer transducer;
    BoardSpec board;

    [[nodiscard]] double wavelength_m() const { return medium.speed_m_s / carrier_hz; }
    /// Why a focal point cannot be reached, in words; empty when it can.
    [[nodiscard]] std::string unreachable(Vec3 focus) const;
};

/// Reads an array file (TOML); see host/arrays/README.md for its keys.
/// @param board  takes the place of the file's [board]
/// @throws Error{bad_input} naming the file, the line and the key, also for unknown keys
[[nodiscard]] Array load_array(const std::filesystem::path& path, const std::optional<BoardSpec>& board = {});

/// Finds `name` as a path, or among the shipped arrays ("tile-10x10", "tile-7x8", "hoshi-18x18").
[[nodiscard]] Array find_array(const std::string& name, const std::optional<BoardSpec>& board = {});

/// Speed of sound in dry air at a temperature, metres per second: 331.3·√(1 + T/273.15).
[[nodiscard]] double speed_of_sound(double temperature_c);

}  // namespace haptogram
