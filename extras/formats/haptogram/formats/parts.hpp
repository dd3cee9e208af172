// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <fmt/format.h>

#include <bit>
#include <cstddef>
#include <cstring>
#include <string>

#include "haptogram/base/error.hpp"
#include "haptogram/base/text.hpp"
#include "haptogram/shape/formats.hpp"

namespace haptogram::formats {

static_assert(std::endian::native == std::endian::little, "numbers of files are taken as they lie in memory");

template <class Number>
double number_at(const char* bytes) {
    Number number{};
    std::memcpy(&number, bytes, sizeof number);
    return static_cast<double>(number);
}

/// Where a part of a shape goes: where its x, y and z axes and its origin come to lie.
struct Motion {
    Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1}, origin{};

    [[nodiscard]] Vec3 turned(Vec3 p) const { return p.x * x + p.y * y + p.z * z; }
    /// @throws Error{bad_input}, with `place`, when it comes to lie too far away
    [[nodiscard]] Vec3 moved(Vec3 p, const std::string& place) const {
        const Vec3 to = origin + turned(p);
        for (const double coordinate : {to.x, to.y, to.z})
            if (!is_coordinate(coordinate)) throw bad_coordinate(place, fmt::format("{}", coordinate));
        return to;
    }
    /// `inner`, then this.
    [[nodiscard]] Motion of(const Motion& inner) const {
        return {turned(inner.x), turned(inner.y), turned(inner.z), origin + turned(inner.origin)};
    }
    [[nodiscard]] bool mirrors() const { return dot(cross(x, y), z) < 0.0; }
};

/// A small file may name one part many times over, so what it comes to has a limit.
inline constexpr std::size_t most_points = 10'000'000;

/// @throws Error{bad_input} when a shape with so many more points or corners would be beyond the limit
inline void require_small(const Polygons& polygons, std::size_t more, const std::string& name) {
    if (more > most_points || polygons.vertices.size() + more > most_points ||
        polygons.corners.size() + more > 2 * most_points)
        throw bad_input(name, fmt::format("its parts come to more than {} points; export fewer, or simplify the shape",
                                          most_points));
}

}  // namespace haptogram::formats
