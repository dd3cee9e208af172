// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "haptogram/hand/object.hpp"
#include "haptogram/live/cluster.hpp"
#include "haptogram/live/crossing.hpp"
#include "haptogram/live/god_object.hpp"
#include "haptogram/live/world.hpp"

namespace haptogram {

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
