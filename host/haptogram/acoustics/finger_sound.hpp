// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <complex>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace haptogram {

/// What a rigid finger makes of a plane wave: the pressure on its skin over that which would be there without it, by
/// boundary elements. A finger is half a sphere with a cylinder behind it. So a place on it is a way from the tip along
/// the skin, and of the directions around it only that between the place and the source counts.
class FingerSound {
public:
    /// The places of the table, without its values.
    struct Grid {
        std::vector<double> sizes;  ///< wave number times radius
        std::vector<double> ways;   ///< from the tip, in radii; behind the last one all is as there
        std::size_t tilts = 0;  ///< of the source, from where the tip points (0) to the hand's side (180°), even steps
        std::size_t turns = 0;  ///< of the place around the finger, from the source's side (0) to 180°, even steps
        [[nodiscard]] std::size_t slice() const { return tilts * turns; }
    };
    /// Values for one size: of each way those of each tilt, of these those of each turn.
    using Values = std::vector<std::complex<float>>;

    /// Reads a table as write_finger_sound() has it. @param file  for messages
    /// @throws Error{bad_input} naming the line
    FingerSound(std::string_view text, const std::string& file);

    [[nodiscard]] const Grid& grid() const { return grid_; }
    /// Whether the table has fingers of this size, wave number times radius.
    [[nodiscard]] bool knows(double size) const;
    /// Between those of the table. @param size  one that it knows
    [[nodiscard]] Values of_size(double size) const;
    /// Between those of the table, one value a tilt and turn. @param of_size  what of_size() gave
    void at_way(const Values& of_size, double way, Values& slice) const;

private:
    Grid grid_;
    std::vector<Values> values_;  ///< one a size
};

/// The table that is shipped (tools/bench/finger_sound.cpp makes it).
[[nodiscard]] const FingerSound& shipped_finger_sound();

/// The table as text, from its values of each size.
[[nodiscard]] std::string write_finger_sound(const FingerSound::Grid& grid,
                                             const std::vector<FingerSound::Values>& values);

}  // namespace haptogram
