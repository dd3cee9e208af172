// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cmath>

namespace haptogram {

/// A point or a direction, metres, in the array frame: origin at the array's centre, z away from the array.
struct Vec3 {
    double x = 0.0, y = 0.0, z = 0.0;
    friend constexpr bool operator==(const Vec3&, const Vec3&) = default;
};

[[nodiscard]] constexpr Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
[[nodiscard]] constexpr Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
[[nodiscard]] constexpr Vec3 operator*(Vec3 a, double s) { return {a.x * s, a.y * s, a.z * s}; }
[[nodiscard]] constexpr Vec3 operator*(double s, Vec3 a) { return a * s; }
[[nodiscard]] constexpr double dot(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
[[nodiscard]] constexpr Vec3 cross(Vec3 a, Vec3 b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
[[nodiscard]] inline double norm(Vec3 a) { return std::sqrt(dot(a, a)); }
/// Of a vector that is not 0.
[[nodiscard]] inline Vec3 unit(Vec3 a) { return a * (1.0 / norm(a)); }
[[nodiscard]] inline double distance(Vec3 a, Vec3 b) { return norm(a - b); }
[[nodiscard]] inline bool is_finite(Vec3 a) { return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z); }

inline constexpr double millimetre = 1e-3;  ///< metres
[[nodiscard]] constexpr Vec3 from_mm(double x, double y, double z) {
    return {x * millimetre, y * millimetre, z * millimetre};
}

}  // namespace haptogram
