// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "haptogram/array/array.hpp"
#include "haptogram/format/path.hpp"
#include "haptogram/format/waveform.hpp"

namespace haptogram {

/// Positions in rows and columns, and in layers above each other: the only ones that a focus has on a device which
/// holds a table. Those of Hoshi et al. 2010 (section 3.1) are 18 × 18 squares of 10 mm at 200 mm; their interaction
/// system (section 5) adds heights from 150 to 300 mm.
struct PositionGrid {
    std::size_t columns = 18, rows = 18, layers = 1;
    double pitch_m = 0.01;  ///< between neighbours in a layer, and between layers
    double lowest_m = 0.2;  ///< height of the first layer
    Vec3 centre{0, 0, 0};   ///< of the layers in x and y

    /// All of them, row by row from −x and −y, layer by layer from below.
    [[nodiscard]] std::vector<Vec3> positions() const;
    /// The position that is nearest to a point.
    [[nodiscard]] Vec3 nearest(Vec3 point) const;
};

/// The grid of the interaction system: 18 × 18 × 16 positions, 10 mm apart. The paper names the range of the heights;
/// the distance of 10 mm is ours, that of the other two axes.
[[nodiscard]] PositionGrid interaction_grid();

/// How the focus moves in Hoshi et al. 2010 (section 4.3, Fig. 16).
enum class Movement {
    line,    ///< from one end to the other, then from the beginning again
    circle,  ///< counterclockwise, seen from above
    spiral,  ///< from the middle outwards, turns a constant distance apart, then from the middle again
    random,  ///< hops to random places in a square, anew and anew
};
/// @throws Error{bad_argument} for other names than line, circle, spiral and random
[[nodiscard]] Movement movement_of(std::string_view name);

/// The paper gives speed and length of the line alone (section 4.1: 50 mm at 50 mm/s, and 30 mm/s in 4.2); the other
/// measures are ours.
struct MovementOptions {
    Vec3 centre{0, 0, 0.2};
    double size_m = 0.05;  ///< length of the line, diameter of circle and spiral, edge of the random square
    double direction_rad = 1.5707963267948966;  ///< of the line, from x towards y
    double turns = 3.0;                         ///< of the spiral
    double speed_m_s = 0.05;                    ///< along line, circle and spiral
    double spacing_m = 0.5e-3;                  ///< at most, from one place of the focus to the next
    double hop_s = 0.01;                        ///< for which it stays at a random place
    double seconds = 1.0;                       ///< of random hops, before they begin again
    std::uint64_t seed = 1;                     ///< of the hops
    std::optional<PositionGrid> grid;           ///< the focus stays on these positions
    Modulation modulation;                      ///< a pass is made to end with it
};

/// A movement as a path, and what came out.
struct MadeMovement {
    Path path;
    double length_m = 0.0;   ///< of the curve, or the sum of the hops
    double speed_m_s = 0.0;  ///< as it came out, because a pass has whole carrier periods, and whole repetitions of the
                             ///< modulation; 0 for hops
};

/// A movement in a plane parallel to the array. A pass ends together with the modulation, so that both repeat. On a
/// grid, the focus is at the position nearest to where it would be without one.
/// @param carrier_hz  in whose periods the path counts
/// @throws Error{bad_argument} for measures that are not positive and finite, and Error{bad_input} when the focus would
/// have to move within less than a carrier period
[[nodiscard]] MadeMovement movement_path(Movement movement, const MovementOptions& options, double carrier_hz);

/// A movement as a user names it.
struct MovementRequest {
    std::string movement;     ///< line, circle, spiral or random
    MovementOptions options;  ///< but for its grid and modulation
    bool grid = false;        ///< only the positions of the device's table, at the height of the centre
    std::string am = "square:200";
    AmplitudeLaw am_law = AmplitudeLaw::pressure;
    std::optional<std::string> array, board;  ///< as a project has them
};

/// The path, and for what it was made.
struct MovementOnArray {
    MadeMovement made;
    Array array;
    double carrier_hz = 0.0;
    std::size_t places = 0;  ///< different ones
    [[nodiscard]] double seconds() const { return static_cast<double>(made.path.periods()) / carrier_hz; }
};

/// A modulated focus that moves as in Hoshi et al. 2010.
/// @throws Error{bad_argument} for names and measures that make no sense, Error{bad_input} when the array cannot reach
/// a place
[[nodiscard]] MovementOnArray movement(const MovementRequest& request);

}  // namespace haptogram
