// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <span>
#include <vector>

#include "haptogram/hand/solid.hpp"

namespace haptogram {

/// Where a finger goes through an object's surface. The middle of what is inside may lie nearer to another face than to
/// the one that the finger came in by, so the points just outside tell: each votes with the normal of the face that is
/// nearest to it. Beside an edge the face with the most votes wins. The paper does not say how it finds the normal;
/// this is ours.
class Crossing {
public:
    /// @param outside  the finger's points close to the surface and not inside, in the solid's frame, metres
    Crossing(const Solid& solid, std::span<const Vec3> outside);

    /// Into the object, length 1: the mean of the votes within 45° of that which has the most such votes; nothing when
    /// nobody votes.
    [[nodiscard]] std::optional<Vec3> inward() const;
    /// Votes within 45° of a direction.
    [[nodiscard]] std::size_t votes_for(Vec3 inward) const;

private:
    std::vector<Vec3> votes_;
};

/// The direction in which a solid's distance falls fastest, length 1; nothing where it has none, as midway between two
/// faces.
[[nodiscard]] std::optional<Vec3> inward_at(const Solid& solid, Vec3 place);

/// How far it is from a place in the solid to its surface, against the inward direction; 0 outside.
[[nodiscard]] double depth_along(const Solid& solid, Vec3 place, Vec3 inward);

}  // namespace haptogram
