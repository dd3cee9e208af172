// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <memory>

#include "haptogram/array/rig.hpp"
#include "haptogram/hand/object.hpp"

namespace haptogram {

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

}  // namespace haptogram
