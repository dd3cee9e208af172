// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "haptogram/array/rig.hpp"
#include "haptogram/hand/object.hpp"
#include "haptogram/hand/solid.hpp"
#include "haptogram/live/cluster.hpp"

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
    /// nothing without a vote.
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

/// Where objects are and what acts on them beside hands. The paper has gravity and walls, and no numbers; these are
/// ours.
struct WorldOptions {
    Vec3 gravity{0, 0, -9.80665};                    ///< m/s²
    Vec3 low{-0.1, -0.1, 0.1}, high{0.1, 0.1, 0.3};  ///< walls, floor and ceiling that objects do not leave
    double friction = 0.5;                           ///< between objects, and with walls
    /// 16 in each step of 60 Hz. What is in a wall is put out again, and gains height: in so short a step nothing that
    /// falls gets in by more than Bullet's margin. And a force holds for a whole step, which is as if a spring came too
    /// late: in longer ones a cube that swings between two fingers gains energy.
    double step_s = 1.0 / 960.0;
};

/// A thing that can be touched and moved.
struct BodyOptions {
    double mass_kg = 0.1;  ///< 0: it stays where it is, whatever pushes it
    Pose pose;
};

/// Rigid bodies by Bullet, in single precision, with an order that does not depend on the machine. Bullet's own
/// distances are made for things of about a metre, so inside everything is twenty times as large.
class World {
public:
    /// @throws Error{bad_argument} for walls without room between them, or numbers that are negative or not finite
    explicit World(const WorldOptions& options = {});
    ~World();
    World(World&&) noexcept;
    World& operator=(World&&) noexcept;

    /// Adds a body of an object's kind and size. Its own frame has its origin in the middle of the object's box, where
    /// its mass is.
    /// @param kind  cube, sphere or cylinder
    /// @return its number, from 0
    /// @throws Error{bad_argument} for another kind, or measures that are not positive
    std::size_t add(std::string_view kind, double size_m, double height_m, const BodyOptions& options);

    [[nodiscard]] std::size_t bodies() const;
    [[nodiscard]] Pose pose(std::size_t body) const;
    [[nodiscard]] Vec3 velocity_at(std::size_t body, Vec3 place) const;  ///< of its material, m/s
    [[nodiscard]] double mass(std::size_t body) const;
    /// Kinetic energy, and m·g·height above the floor, J.
    [[nodiscard]] double energy(std::size_t body) const;

    /// A force in the next step alone.
    void push(std::size_t body, Vec3 force, Vec3 place);
    /// Goes on by one step of options.step_s.
    void step();
    [[nodiscard]] const WorldOptions& options() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// An object that hands touch, and what happens then. Defaults where the paper says nothing are ours.
struct SceneOptions {
    std::string kind = "cube";  ///< of object_kinds(); one that moves is a cube, a sphere or a cylinder
    double size_m = 40e-3, height_m = 40e-3;
    std::optional<Solid> solid{};  ///< instead of kind and measures, in the array's frame turned back by the pose
    Pose pose{.origin = {0, 0, 0.2}};
    double mass_kg = 0.1;           ///< 0: the object stays where it is
    double cluster_m = 3e-3;        ///< points at most so far apart belong to one finger
    std::size_t least_points = 30;  ///< of a finger in the object
    double gate_m = 20e-3;          ///< a finger moves no farther between two shots
    double finger_m = 20e-3;  ///< across a finger: parts within it are one finger (join_parts()); 0: they stay parts
    double slab_m = 2e-3;     ///< points so near to the contact's plane make the section
    ContactOptions contact;
    WorldOptions world;
};

/// A finger in the object, as a renderer needs it. Positions in metres, array frame.
struct SceneFinger {
    std::uint64_t id = 0;
    bool seen = true;           ///< false: missing in this shot, and where it was in the last one
    Vec3 place;                 ///< the mean of its points inside
    Vec3 velocity;              ///< of that, m/s
    Vec3 surface, inward;       ///< a point of the contact's plane, and the normal into the object
    double deepest_m = 0.0;     ///< how far its deepest point is behind that plane
    std::vector<Vec3> section;  ///< its points near that plane, on either side
    Vec3 force;                 ///< on the object, N, in the last step
};

/// Clouds of points in, fingers and the object's motion out (Fingers, section 3, "Physics simulation").
class TouchScene {
public:
    /// @throws Error{bad_argument} naming an option that makes no sense
    explicit TouchScene(const SceneOptions& options);

    /// Goes on to the time of a cloud. The physics takes steps of its own from the last time on, in which fingers move
    /// straight from where they were to where they are.
    /// @param time_s  later than that of the last cloud
    /// @throws Error{bad_argument} when it is not
    const std::vector<SceneFinger>& update(std::span<const Vec3> cloud, double time_s);

    [[nodiscard]] const std::vector<SceneFinger>& fingers() const { return fingers_; }
    [[nodiscard]] Pose object() const;
    /// Of the object and of the fingers' springs, J. With hands that do not move it never grows.
    [[nodiscard]] double energy() const;
    /// What the fingers have put into the object and their springs by moving, J, since the beginning: the sum of force
    /// times way over the steps. energy() less this never grows, whatever hands do.
    [[nodiscard]] double work() const { return work_j_; }
    /// Signed distance to the object as it is now.
    [[nodiscard]] double distance_to(Vec3 point) const;

private:
    struct Held {
        FingerContact contact;
        Vec3 from, to;  ///< where the finger was at the last cloud, and is at this one
        Vec3 force{};   ///< on the object, N, in the last step
    };
    /// A cluster, and where it goes through the surface.
    struct Entry {
        Cluster cluster;
        Crossing crossing;
        Vec3 inward;  ///< array frame
    };
    void meet(std::span<const Vec3> cloud, const std::vector<Entry>& entries,
              const std::vector<TrackedFinger>& tracked);
    [[nodiscard]] Vec3 surface_at(Vec3 god, Vec3 inward_of_body) const;
    Held& hold(const TrackedFinger& finger, const Entry* entry);
    void simulate(double seconds);
    [[nodiscard]] Entry entry_of(std::span<const Vec3> cloud, Cluster cluster) const;
    [[nodiscard]] std::vector<Entry> entries_of(std::span<const Vec3> cloud) const;
    [[nodiscard]] bool one_finger(const Entry& a, const Entry& b) const;
    void join_parts(std::span<const Vec3> cloud, std::vector<Entry>& entries) const;
    [[nodiscard]] std::vector<Vec3> section_of(std::span<const Vec3> cloud, const Cluster& cluster, Vec3 surface,
                                               Vec3 inward) const;

    SceneOptions options_;
    Solid solid_;  ///< in the object's own frame
    World world_;
    FingerTracker tracker_;
    std::map<std::uint64_t, Held> held_;  ///< by finger
    std::vector<SceneFinger> fingers_;
    std::optional<double> time_s_;
    double owed_s_ = 0.0;  ///< time that no whole step has filled yet
    double shot_s_ = 0.0;  ///< between the last two clouds
    double work_j_ = 0.0;
};

}  // namespace haptogram
