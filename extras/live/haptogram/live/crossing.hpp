// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <span>
#include <vector>

#include "haptogram/hand/solid.hpp"

namespace haptogram {

/// Where a finger goes through an object's surface. The middle of what is inside may lie nearer to another face than to
/// the one that the finger came in by, so the points just outside tell: each votes for the face that is nearest to it.
/// Beside an edge a finger goes through two faces, and the one wins that it goes through with the greater part of its
/// section. The paper does not say how it finds the normal; this is ours.
class Crossing {
public:
    /// @param outside  the finger's points close to the surface and not inside, in the solid's frame, metres
    Crossing(const Solid& solid, std::span<const Vec3> outside);
    /// That of two parts of a finger together.
    Crossing(const Crossing& a, const Crossing& b);

    /// Into the object, length 1: the mean of the votes within 45° of that about which the finger's section is largest;
    /// nothing when nobody votes.
    [[nodiscard]] std::optional<Vec3> inward() const;
    /// How much of the finger goes through what faces a direction within 45°, m²: of the convex hull of those that vote
    /// so, seen along it. 0 for fewer than three.
    [[nodiscard]] double area(Vec3 inward) const;

private:
    struct Vote {
        Vec3 place, inward;
    };
    std::vector<Vote> votes_;
};

/// The direction in which a solid's distance falls fastest, length 1; nothing where it has none, as midway between two
/// faces.
[[nodiscard]] std::optional<Vec3> inward_at(const Solid& solid, Vec3 place);

/// How far it is from a place in the solid to its surface, against the inward direction; 0 outside.
[[nodiscard]] double depth_along(const Solid& solid, Vec3 place, Vec3 inward);

}  // namespace haptogram
