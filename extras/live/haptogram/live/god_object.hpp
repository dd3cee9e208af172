// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <functional>

#include "haptogram/array/rig.hpp"

namespace haptogram {

/// How a finger pushes an object (Fingers, section 3, "Physics simulation"). The paper gives no numbers; these are
/// ours.
struct ContactOptions {
    double stiffness_n_m = 200.0;
    double damping_n_s_m = 1.0;
    double static_friction = 0.8, dynamic_friction = 0.6;
    double spread_m = 3e-3;  ///< four further god-objects are so far from the middle one, in the contact's plane
};
/// @throws Error{bad_argument} naming what is negative or not finite, or a dynamic friction above the static one
void require_sound(const ContactOptions& options);

/// Where the god-object goes when the friction does not hold it: x_g + [(x − x_g)·t − μ_d (x − x_g)·n] t, when
/// (x − x_g)·t > μ_s (x − x_g)·n, with t the direction of the part of x − x_g along the surface; else it stays.
/// @param inward  into the object, length 1. The paper does not say which way n points; only so the friction is
/// positive
[[nodiscard]] Vec3 slid(Vec3 god_object, Vec3 finger, Vec3 inward, double static_friction, double dynamic_friction);

/// A force on an object, and where it acts, array frame.
struct Push {
    Vec3 force;  ///< N
    Vec3 place;
};

/// A finger in an object: the middle of its points, held by a spring and a damper to where it came in, and four points
/// around it that move with it, so that a grasp also resists turning. Each has a fifth of the stiffness and of the
/// damping. A finger's own turning is not sensed, so the four keep their directions.
class FingerContact {
public:
    static constexpr std::size_t god_objects = 5;

    /// @param finger  where it came in, array frame
    /// @param inward  the surface's normal there, into the object, array frame, length 1
    /// @param body    the object's pose
    FingerContact(const ContactOptions& options, Vec3 finger, Vec3 inward, const Pose& body);

    /// The forces on the object for a finger at a place, and the god-objects moved by friction. A finger pushes only:
    /// of a god-object whose force would pull the object outwards there is none.
    /// @param velocity_of  of the object's material at a place, m/s
    [[nodiscard]] std::array<Push, god_objects> pushes(Vec3 finger, Vec3 finger_velocity, const Pose& body,
                                                       const std::function<Vec3(Vec3 place)>& velocity_of);
    /// Whether the finger has come out again: (x − x_g)·n < 0 in the middle.
    [[nodiscard]] bool ended(Vec3 finger, const Pose& body) const;

    /// Turns the contact to another normal, as when a finger has slid round a bend or over an edge. Each spring turns
    /// about the finger with the normal, so it keeps its length and its energy.
    /// @param inward  array frame, length 1
    void turn(Vec3 finger, Vec3 inward, const Pose& body);

    /// The middle god-object, and the normal into the object there, array frame.
    [[nodiscard]] Vec3 place(const Pose& body) const { return body.outwards(gods_[0]); }
    [[nodiscard]] Vec3 inward(const Pose& body) const { return body.turned(inward_); }
    /// The same normal in the object's own frame.
    [[nodiscard]] Vec3 inward_of_body() const { return inward_; }
    /// ½·K·(x − x_g)² of all springs whose god-object is pushed inwards, J.
    [[nodiscard]] double spring_energy(Vec3 finger, const Pose& body) const;

private:
    ContactOptions options_;
    std::array<Vec3, god_objects> offsets_;  ///< of the finger's points from its middle, array frame
    std::array<Vec3, god_objects> gods_;     ///< in the object's own frame, which carries them
    Vec3 inward_;                            ///< in the object's own frame
};

}  // namespace haptogram
