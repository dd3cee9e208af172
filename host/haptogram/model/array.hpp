// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "haptogram/model/medium.hpp"
#include "haptogram/model/transducer.hpp"
#include "haptogram/model/vec3.hpp"

namespace haptogram {

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

}  // namespace haptogram
