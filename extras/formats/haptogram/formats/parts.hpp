// SPDX-License-Identifier: Apache-2.0
// Each reader takes a whole file and makes of it what shape/formats.hpp does, with its errors.
#pragma once
#include <fmt/format.h>

#include <bit>
#include <cstddef>
#include <cstring>
#include <functional>
#include <optional>
#include <string>

#include "haptogram/base/error.hpp"
#include "haptogram/base/text.hpp"
#include "haptogram/shape/formats.hpp"
#include "haptogram/shape/readers.hpp"

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

/// Meshes and clouds as text, without colours.
[[nodiscard]] Polygons read_off(const ShapeFile& file);
/// Clouds of the Point Cloud Library, in the file's unit. Points of NaN are unseen pixels.
[[nodiscard]] Polygons read_pcd(const ShapeFile& file);
/// What a 3MF file builds: meshes of objects and their components, each at its place.
[[nodiscard]] Polygons read_three_mf(const ShapeFile& file);
/// The same, unpacked. @param part  the content of a file in it, if there is one
using Parts = std::function<std::optional<std::string>(const std::string& part)>;
[[nodiscard]] Polygons read_three_mf_parts(const Parts& part, const std::string& name);
/// The default scene of a glTF or GLB file, in metres, with y upwards as the file has it.
[[nodiscard]] Polygons read_gltf(const ShapeFile& file);
/// The outlines of a drawing, as curves in the plane z = 0, with y upwards.
[[nodiscard]] Polygons read_svg(const ShapeFile& file);

}  // namespace haptogram::formats
