// SPDX-License-Identifier: Apache-2.0
#include "haptogram/robot/tension.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "haptogram/base/error.hpp"
#include "haptogram/robot/geometry.hpp"

namespace haptogram::robot {
namespace {

using Eigen::Vector2d;

/// Corners that lie this little outside of a half-plane, in N, count as inside, so that a polygon of one point is
/// found.
constexpr double touching_n = 1e-12;

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// The part of the polygon with normal·y ≥ offset (Sutherland and Hodgman).
Polygon clip(const Polygon& polygon, const Vector2d& normal, double offset) {
    Polygon kept;
    for (std::size_t i = 0; i < polygon.count; ++i) {
        const Vector2d &a = polygon.corners[i], &b = polygon.corners[(i + 1) % polygon.count];
        const double inside_a = normal.dot(a) - offset, inside_b = normal.dot(b) - offset;
        if (inside_a >= -touching_n) kept.corners[kept.count++] = a;
        if ((inside_a > touching_n && inside_b < -touching_n) || (inside_a < -touching_n && inside_b > touching_n))
            kept.corners[kept.count++] = a + (b - a) * (inside_a / (inside_a - inside_b));
    }
    return kept;
}

/// The point of a convex polygon that is nearest to the origin.
Vector2d nearest(const Polygon& polygon) {
    bool inside = polygon.count > 2;
    Vector2d best = polygon.corners[0];
    for (std::size_t i = 0; i < polygon.count; ++i) {
        const Vector2d &a = polygon.corners[i], &b = polygon.corners[(i + 1) % polygon.count];
        inside = inside && cross(b - a, -a) >= 0.0;
        const double length = (b - a).squaredNorm();
        const double along = length > 0.0 ? std::clamp(-a.dot(b - a) / length, 0.0, 1.0) : 0.0;
        const Vector2d point = a + along * (b - a);
        if (point.squaredNorm() < best.squaredNorm()) best = point;
    }
    return inside ? Vector2d::Zero() : best;
}

Vector2d centroid(const Polygon& polygon) {
    Vector2d weighted = Vector2d::Zero(), mean = Vector2d::Zero();
    double area = 0.0;
    const Vector2d& origin = polygon.corners[0];
    for (std::size_t i = 0; i < polygon.count; ++i) {
        const Vector2d a = polygon.corners[i] - origin, b = polygon.corners[(i + 1) % polygon.count] - origin;
        area += cross(a, b);
        weighted += cross(a, b) * (a + b) / 3.0;
        mean += polygon.corners[i] / static_cast<double>(polygon.count);
    }
    return area > 1e-18 ? Vector2d(origin + weighted / area) : mean;
}

}  // namespace

std::optional<TensionSpace> tension_space(const Structure& structure, const Wrench& wrench) {
    // Torques are measured in newtons at a tenth of a metre, so that the rank does not depend on the unit of length;
    // neither the null space nor the solution of least norm changes.
    constexpr double arm_m = 0.1, singular = 1e-9;
    Structure scaled = structure;
    scaled.bottomRows<3>() /= arm_m;
    Wrench load = -wrench;
    load.tail<3>() /= arm_m;
    const Eigen::ColPivHouseholderQR<Eigen::Matrix<double, cable_count, 6>> qr(scaled.transpose());
    const auto& r = qr.matrixR();
    if (!(std::abs(r(5, 5)) > singular * std::abs(r(0, 0)))) return std::nullopt;
    // A·P = Q·R, so Aᵀ·t = load is Rᵀ·(Q₁ᵀ·t) = Pᵀ·load, and the columns of Q behind Q₁ are the null space.
    const Eigen::Matrix<double, cable_count, cable_count> q = qr.householderQ();
    const Wrench permuted = qr.colsPermutation().transpose() * load;
    const Wrench inner = r.topLeftCorner<6, 6>().triangularView<Eigen::Upper>().transpose().solve(permuted);
    return TensionSpace{q.leftCols<6>() * inner, q.rightCols<2>()};
}

Polygon feasible_polygon(const TensionSpace& space, const PerCable& least_n, const PerCable& most_n) {
    // ‖y‖ is at most the norm of the largest tensions, because null and particular are orthogonal.
    const double bound = most_n.norm() + 1.0;
    Polygon polygon;
    polygon.count = 4;
    polygon.corners[0] = {-bound, -bound};
    polygon.corners[1] = {bound, -bound};
    polygon.corners[2] = {bound, bound};
    polygon.corners[3] = {-bound, bound};
    for (int i = 0; i < cable_count && polygon.count > 0; ++i) {
        const Vector2d normal = space.null_space.row(i).transpose();
        polygon = clip(polygon, normal, least_n[i] - space.particular[i]);
        polygon = clip(polygon, -normal, space.particular[i] - most_n[i]);
    }
    return polygon;
}

Choice choice_of(const std::string& name) {
    if (name == "norm") return Choice::least_norm;
    if (name == "sum") return Choice::least_sum;
    if (name == "centroid") return Choice::centroid;
    if (name == "paper") return Choice::paper;
    throw bad_argument("choice", fmt::format("expected norm, sum, centroid or paper, found '{}'", name));
}

std::optional<PerCable> positive_null_vector(const TensionSpace& space) {
    // The smallest of eight cosines over a circle is largest where one of them peaks or two are equal.
    double best = 0.0;
    Vector2d best_y = Vector2d::Zero();
    const auto attempt = [&](Vector2d y) {
        if (!(y.norm() > 0.0)) return;
        y.normalize();
        for (const double sign : {1.0, -1.0}) {
            const double smallest = (space.null_space * (sign * y)).minCoeff();
            if (smallest > best) {
                best = smallest;
                best_y = sign * y;
            }
        }
    };
    for (int i = 0; i < cable_count; ++i) {
        const Vector2d a = space.null_space.row(i).transpose();
        attempt(a);
        for (int j = 0; j < i; ++j) {
            const Vector2d difference = a - space.null_space.row(j).transpose();
            attempt({-difference.y(), difference.x()});
        }
    }
    if (best <= 1e-12) return std::nullopt;
    return space.null_space * best_y;
}

std::optional<Distribution> distribute(const Structure& structure, const Wrench& wrench, const PerCable& least_n,
                                       const PerCable& most_n, Choice choice) {
    const std::optional<TensionSpace> space = tension_space(structure, wrench);
    if (!space) return std::nullopt;
    if (choice == Choice::paper) {
        const std::optional<PerCable> positive = positive_null_vector(*space);
        if (!positive) return std::nullopt;
        const double factor = ((least_n - space->particular).array() / positive->array()).maxCoeff();
        const PerCable tensions = factor * *positive + space->particular;
        return Distribution{tensions, (tensions - most_n).maxCoeff() <= touching_n};
    }
    const Polygon polygon = feasible_polygon(*space, least_n, most_n);
    if (polygon.count == 0) return std::nullopt;
    Vector2d y = polygon.corners[0];
    if (choice == Choice::least_norm) y = nearest(polygon);
    if (choice == Choice::centroid) y = centroid(polygon);
    if (choice == Choice::least_sum) {
        const Vector2d sum = space->null_space.colwise().sum().transpose();
        for (std::size_t i = 1; i < polygon.count; ++i)
            if (sum.dot(polygon.corners[i]) < sum.dot(y)) y = polygon.corners[i];
    }
    return Distribution{space->particular + space->null_space * y, true};
}

std::optional<Distribution> distribute(const Structure& structure, const Wrench& wrench, double least_n, double most_n,
                                       Choice choice) {
    return distribute(structure, wrench, PerCable::Constant(least_n), PerCable::Constant(most_n), choice);
}

std::optional<double> largest_wrench(const Geometry& geometry, const Pose& pose, const Wrench& direction) {
    if (!(direction.norm() > 0.0)) throw bad_argument("direction", "a wrench of zero has no direction");
    const Structure structure = structure_of(geometry, pose);
    const auto holds = [&](double factor) {
        return distribute(structure, geometry.weight() + factor * direction, geometry.least_n, geometry.most_n)
            .has_value();
    };
    if (!holds(0.0)) return std::nullopt;
    // What can be balanced is a convex set, so along a line it is one interval.
    double low = 0.0, high = 1.0;
    while (holds(high)) high *= 2.0;
    for (int i = 0; i < 60; ++i) {
        const double middle = (low + high) / 2.0;
        (holds(middle) ? low : high) = middle;
    }
    return low;
}

std::string infeasible(const Geometry& geometry, const Pose& pose, const Wrench& wrench) {
    if (std::string why = out_of_length(geometry, cable_lengths(geometry, pose)); !why.empty()) return why;
    if (std::string why = interference(geometry, pose); !why.empty()) return why;
    if (!distribute(structure_of(geometry, pose), wrench, geometry.least_n, geometry.most_n))
        return fmt::format("no tensions from {:g} to {:g} N balance the wrench there", geometry.least_n,
                           geometry.most_n);
    return {};
}

}  // namespace haptogram::robot
