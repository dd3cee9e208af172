// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "haptogram/array/vec3.hpp"
#include "haptogram/hand/hand.hpp"

namespace haptogram {

/// A place on the skin.
struct SkinPoint {
    Vec3 position;  ///< metres, array frame
    Vec3 normal;    ///< out of the skin, length 1
};

/// A simple piece of the palmar skin: half of the side of a round finger segment, at the tip with its round end, or the
/// flat palm.
struct SkinPatch {
    Vec3 from;                ///< the near end of the segment's axis; of the palm, the middle of its edge at the wrist
    Vec3 along, side, out;    ///< length 1: to the far end, across, and out of the middle of the skin
    double length = 0.0;      ///< along it, metres
    double radius = 0.0;      ///< of a segment; 0: flat
    double width = 0.0;       ///< of the palm, across
    double thickness = 0.0;   ///< of the palm's box, half of it on either side of the skin
    std::size_t end_row = 0;  ///< of the region's raster: the first row behind the patch
    bool tip = false;         ///< a hemisphere ends it
    /// The nearest place of the skin. From behind a segment, that is on the edge of its palmar half.
    [[nodiscard]] SkinPoint nearest(Vec3 point) const;
    /// The part of a line that is in the box around the hand here: around the segment as a capsule, or the palm.
    /// @return shares of the way from a to b, 0 to 1; nothing when the line misses the box
    [[nodiscard]] std::optional<std::array<double, 2>> clip(Vec3 a, Vec3 b) const;
};

/// A part of the palmar skin as a raster: cells of rows and columns, about square.
struct SkinRegion {
    std::string_view name;  ///< thumb, index, middle, ring, pinkie or palm
    std::size_t rows = 0;   ///< of a finger: along it, from the knuckle to the tip, and over the tip's end to the nail;
                            ///< of the palm: to the fingers
    std::size_t columns = 0;         ///< of a finger: around it, over half a turn
    std::vector<Vec3> points;        ///< row by row, array frame, metres
    std::vector<Vec3> normals;       ///< out of the skin, length 1
    std::vector<SkinPatch> patches;  ///< what the raster lies on, from the first row on: up to three of a finger
    [[nodiscard]] const Vec3& point(std::size_t row, std::size_t column) const {
        return points[row * columns + column];
    }
    /// The patch under a row of the raster.
    [[nodiscard]] const SkinPatch& patch(std::size_t row) const;
    /// The nearest place of the skin to a point.
    [[nodiscard]] SkinPoint nearest(Vec3 point) const;
};

/// Measures of the hand where a recording has none; the cells' size. Metres.
struct SkinOptions {
    std::array<double, 3> finger_radii_m{9.5e-3, 8.5e-3, 7.5e-3};  ///< of the three segments
    std::array<double, 3> thumb_radii_m{10.5e-3, 9.5e-3, 8.5e-3};  ///< of the three segments
    double palm_width_m = 85e-3, palm_length_m = 90e-3;
    double palm_thickness_m = 25e-3;  ///< of the box in which the palm meets edges and corners
    double cell_m = 1e-3;             ///< neighbours in a raster are at most this far apart
};

/// The palmar surface of a hand. A finger is a chain of three round segments; the half of their surface whose normals
/// have no negative product with the palm's normal is unrolled to a raster, by arc length along the chain and by angle
/// around it, and so is the hemisphere around the tip. When a recording says how wide the finger is, its radii are
/// scaled so that the middle segment is. The palm is a rectangle around its centre, along the hand's direction and
/// across it. Fingers that the tracker did not see are left out.
/// @throws Error{bad_argument} for measures that are not positive, and for hands whose coordinates are not finite or
/// whose normal and direction are parallel
[[nodiscard]] std::vector<SkinRegion> palmar_surface(const Hand& hand, const SkinOptions& options = {});

/// An ellipse in space. The three directions have length 1 and are right-handed: major × minor = normal.
struct Ellipse {
    Vec3 centre;
    Vec3 major{1, 0, 0}, minor{0, 1, 0}, normal{0, 0, 1};
    double half_major = 0.0, half_minor = 0.0;  ///< metres

    /// The point at a parameter, which is no angle unless the ellipse is a circle.
    [[nodiscard]] Vec3 at(double parameter) const;
    [[nodiscard]] double perimeter() const;
};

/// An ellipse in a plane with axes of its own: the length of each half axis and the angle of the longer one from x.
struct PlaneEllipse {
    double x = 0.0, y = 0.0, half_major = 0.0, half_minor = 0.0, angle = 0.0;
};
using PlanePoint = std::array<double, 2>;

/// The ellipse of least algebraic distance to points (Halíř and Flusser 1998, "Numerically stable direct least squares
/// fitting of ellipses"). The points are centred and scaled first.
/// @return nothing when there are fewer than 5 points, or none but a degenerate one fits
[[nodiscard]] std::optional<PlaneEllipse> fit_ellipse(std::span<const PlanePoint> points);

/// The ellipse of least radial distance whose longer axis lies along x, the shorter one along y. It needs only a part
/// of the outline.
/// @param ratio  of the shorter to the longer half axis
[[nodiscard]] std::optional<PlaneEllipse> fit_constrained(std::span<const PlanePoint> points, double ratio);

/// When a fit is not to be trusted. Cameras on one side see half of a finger at most, and the direct fit of half an
/// outline is far too flat. Then the ellipse gets a finger's usual ratio, with the shorter axis along the line of
/// sight: what lies before a camera shows it its broad side. Where noise hides the outline's bend, it is as wide as
/// what is seen. The paper does not speak of it; all of this is ours.
struct SectionOptions {
    double least_cover_deg = 240.0;         ///< of the outline around the fitted centre
    double least_ratio = 0.5;               ///< of the half axes
    double least_m = 3e-3, most_m = 15e-3;  ///< of the longer half axis
    double usual_ratio = 0.8125;            ///< of the half axes of a finger, where only a part of it is seen
};

struct FingerSection {
    Ellipse ellipse;
    bool constrained = false;  ///< the direct fit was not to be trusted
};

/// Where a finger's outline cuts a plane (Fingers, section 3, "Haptic feedback"): the ellipse of the points beside it.
/// @param points   near the plane, metres; projected onto it
/// @param surface  a point of the plane @param inward  its normal, length 1
/// @param sight    from the camera to the finger, when there is one camera: half of the outline is behind it. Without
///                 it the seen part of the outline tells the side
/// @return nothing when there are fewer than 5 points, or no ellipse of a finger's size fits
[[nodiscard]] std::optional<FingerSection> section_of(std::span<const Vec3> points, Vec3 surface, Vec3 inward,
                                                      const std::optional<Vec3>& sight = {},
                                                      const SectionOptions& options = {});

}  // namespace haptogram
