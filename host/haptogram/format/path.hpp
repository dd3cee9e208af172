// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "haptogram/array/vec3.hpp"

namespace haptogram {

/// A part of the sequence in a device's memory, which something starts.
struct TriggeredPart {
    std::uint16_t first = 1, length = 1;  ///< entries
    std::uint16_t loops = 1;              ///< passes; 0: until another part starts
    bool by_pin = false;                  ///< by the device's trigger input, without the host
    friend bool operator==(const TriggeredPart&, const TriggeredPart&) = default;
};

/// A focal point and how strong it is to be.
struct Focus {
    Vec3 position;           ///< metres, array frame
    double amplitude = 1.0;  ///< of the pressure, as a fraction of the most that the array can make there: 0…1
    friend constexpr bool operator==(const Focus&, const Focus&) = default;
};

/// Foci that exist at the same time. A step without foci is silence.
struct PathStep {
    std::vector<Focus> foci;
    std::uint32_t periods = 1;  ///< of the carrier, for which they last
    bool mark = false;          ///< its beginning is told at a board's trigger output
    friend bool operator==(const PathStep&, const PathStep&) = default;
};

/// A slow factor on the amplitude of everything that is played, repeated from the beginning of the path on.
struct Modulation {
    std::vector<double> samples;         ///< 0…1; empty: none
    std::uint32_t periods_a_sample = 1;  ///< of the carrier
    friend bool operator==(const Modulation&, const Modulation&) = default;
};

/// What a renderer makes: foci in time. Everything that comes after rendering takes a path. It knows nothing of arrays,
/// boards or records.
struct Path {
    std::vector<PathStep> steps;
    Modulation modulation;

    /// Carrier periods of one pass.
    [[nodiscard]] std::uint64_t periods() const;
    friend bool operator==(const Path&, const Path&) = default;
};

/// @throws Error{bad_argument} naming the step, for positions or amplitudes that are not finite, amplitudes outside
/// 0…1, steps of no period, a modulation outside 0…1, or a path without steps
void require_sound(const Path& path);

/// Makes all foci weaker.
/// @param amplitude  factor on the pressure, above 0 and at most 1
/// @throws Error{bad_argument} naming "amplitude" for any other
void weaken(Path& path, double amplitude);

/// The foci of a step, none of amplitude 0, whose strongest has amplitude 1; and a key of such foci, rounded.
[[nodiscard]] std::vector<Focus> without_factor(std::vector<Focus> foci);
[[nodiscard]] std::vector<std::array<double, 4>> key_of(const std::vector<Focus>& foci);

/// Adds a step, or makes the last one longer when its foci are the same but for a common factor, as of a modulation.
void add_places(Path& path, const std::vector<Focus>& foci, std::uint32_t periods);

}  // namespace haptogram
