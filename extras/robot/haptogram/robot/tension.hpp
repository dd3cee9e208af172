// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <optional>
#include <string>

#include "haptogram/robot/geometry.hpp"

namespace haptogram::robot {

/// The tensions that balance a wrench: t = particular + null·y for any y, because eight cables hold six freedoms.
struct TensionSpace {
    PerCable particular;                               ///< t_s = −(Aᵀ)⁺·W, the tensions of least norm
    Eigen::Matrix<double, cable_count, 2> null_space;  ///< orthonormal columns with Aᵀ·null = 0
};

/// Solves Aᵀ·t = −W (Multimodal eq. 15; eq. 16 prints t_s = (Aᵀ)⁺·t).
/// @param wrench  acts on the handle from outside: its weight and the user
/// @return none when the structure is singular: there is a direction in which the cables cannot act
[[nodiscard]] std::optional<TensionSpace> tension_space(const Structure& structure, const Wrench& wrench);

/// A convex polygon in the plane of y, its corners in order. It can be empty, a point or a line.
struct Polygon {
    std::array<Eigen::Vector2d, 2 * cable_count + 4> corners;
    std::size_t count = 0;
};

/// All y whose tensions lie within the limits of the least and the most: 16 half-planes.
[[nodiscard]] Polygon feasible_polygon(const TensionSpace& space, const PerCable& least_n, const PerCable& most_n);

/// Which of the feasible tensions.
enum class Choice {
    least_norm,  ///< the smallest sum of squares
    least_sum,   ///< the smallest sum
    centroid,    ///< the centroid of the polygon, farthest from all limits at once
    paper,       ///< Multimodal eq. 16; it does not know the upper limit
};
/// "norm", "sum", "centroid" or "paper". @throws Error{bad_argument} naming "choice"
[[nodiscard]] Choice choice_of(const std::string& name);

struct Distribution {
    PerCable tensions;
    bool within_limits = true;  ///< false only for Choice::paper, when a tension is above the most
};

/// Tensions for a wrench.
/// @return none when no tensions within the limits balance it (for Choice::paper: when no null vector is positive in
/// all cables), or the structure is singular
[[nodiscard]] std::optional<Distribution> distribute(const Structure& structure, const Wrench& wrench,
                                                     const PerCable& least_n, const PerCable& most_n,
                                                     Choice choice = Choice::least_norm);
/// The same with the same limits for all cables.
[[nodiscard]] std::optional<Distribution> distribute(const Structure& structure, const Wrench& wrench, double least_n,
                                                     double most_n, Choice choice = Choice::least_norm);

/// The null vector of Aᵀ that is positive in every cable, of length 1, whose smallest component is largest: t_g of
/// Multimodal eq. 16. @return none when there is none
[[nodiscard]] std::optional<PerCable> positive_null_vector(const TensionSpace& space);

/// The largest multiple of `direction` that the cables can balance on top of the handle's weight, within the limits of
/// the geometry. @param direction  a wrench; the result is in its units
/// @return none when they cannot even hold the weight
[[nodiscard]] std::optional<double> largest_wrench(const Geometry& geometry, const Pose& pose, const Wrench& direction);

/// Why the handle cannot rest in a pose, in words; empty when it can: cables too long or too short, cables that
/// touch each other or the grip, or no tensions within the limits for this wrench.
[[nodiscard]] std::string infeasible(const Geometry& geometry, const Pose& pose, const Wrench& wrench);

}  // namespace haptogram::robot
