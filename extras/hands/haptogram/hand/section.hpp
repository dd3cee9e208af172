// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "haptogram/array/vec3.hpp"

namespace haptogram {

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
