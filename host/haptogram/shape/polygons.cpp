// SPDX-License-Identifier: Apache-2.0
#include "haptogram/shape/polygons.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <limits>
#include <span>
#include <utility>

#include "haptogram/base/error.hpp"

namespace haptogram {
namespace {

double triangle_area(Vec3 a, Vec3 b, Vec3 c) { return 0.5 * norm(cross(b - a, c - a)); }

/// Cuts one face into triangles by clipping ears (Meisters 1975), seen along the mean normal of the face. An ear is a
/// corner that points outwards and whose triangle with its two neighbours holds no other corner of the face.
class EarClipper {
public:
    EarClipper(const std::vector<Vec3>& vertices, std::span<const std::uint32_t> face)
        : vertices_(vertices), left_(face.begin(), face.end()) {
        for (std::size_t k = 2; k < face.size(); ++k)
            normal_ = normal_ + cross(at(face[k - 1]) - at(face[0]), at(face[k]) - at(face[0]));
        for (std::size_t k = 0; k < left_.size(); ++k)
            if (turn(at(before(k)), at(left_[k]), at(after(k))) < 0.0) inward_.push_back(left_[k]);
    }

    /// @return the area of the triangles that lie upside down, which happens only in a face that crosses itself
    double cut(std::vector<std::array<std::uint32_t, 3>>& triangles) {
        std::size_t k = 1;
        for (std::size_t failures = 0; !inward_.empty() && left_.size() > 3 && failures < left_.size();) {
            k %= left_.size();
            if (is_ear(k)) {
                triangles.push_back({before(k), left_[k], after(k)});
                if (const auto found = std::find(inward_.begin(), inward_.end(), left_[k]); found != inward_.end())
                    inward_.erase(found);
                left_.erase(left_.begin() + static_cast<std::ptrdiff_t>(k));
                failures = 0;
            } else {
                ++k;
                ++failures;
            }
        }
        double upside_down = 0.0;  // what is left is convex, or crosses itself
        for (std::size_t i = 2; i < left_.size(); ++i) {
            triangles.push_back({left_[0], left_[i - 1], left_[i]});
            if (turn(at(left_[0]), at(left_[i - 1]), at(left_[i])) <= 0.0)
                upside_down += triangle_area(at(left_[0]), at(left_[i - 1]), at(left_[i]));
        }
        return upside_down;
    }

private:
    [[nodiscard]] Vec3 at(std::uint32_t vertex) const { return vertices_[vertex]; }
    [[nodiscard]] std::uint32_t before(std::size_t k) const { return left_[k == 0 ? left_.size() - 1 : k - 1]; }
    [[nodiscard]] std::uint32_t after(std::size_t k) const { return left_[k + 1 == left_.size() ? 0 : k + 1]; }

    /// Positive when a, b and c turn the way the face turns.
    [[nodiscard]] double turn(Vec3 a, Vec3 b, Vec3 c) const { return dot(cross(b - a, c - b), normal_); }

    [[nodiscard]] bool is_ear(std::size_t k) const {
        const Vec3 a = at(before(k));
        const Vec3 b = at(left_[k]);
        const Vec3 c = at(after(k));
        const double area = turn(a, b, c);
        if (area < 0.0) return false;
        // A corner on a straight side can always go: its triangle is empty.
        if (triangle_area(a, b, c) == 0.0) return true;
        if (area == 0.0) return false;
        // The outermost of the corners inside always points inwards, so only those need a look.
        return std::none_of(inward_.begin(), inward_.end(), [&](std::uint32_t vertex) {
            const Vec3 p = at(vertex);
            if (p == a || p == b || p == c) return false;
            return turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0;
        });
    }

    const std::vector<Vec3>& vertices_;
    std::vector<std::uint32_t> left_;    ///< corners that are not clipped yet
    std::vector<std::uint32_t> inward_;  ///< corners that pointed inwards at the beginning
    Vec3 normal_{};
};

}  // namespace

Piece as_piece(Polygons polygons, const std::string& name) {
    if (polygons.vertices.empty())
        throw bad_input(name, "found no points, expected at least one; export the shape again");
    if (polygons.vertices.size() > std::numeric_limits<std::uint32_t>::max())
        throw bad_input(name, fmt::format("found {} vertices, expected at most {}; export the shape with fewer",
                                          polygons.vertices.size(), std::numeric_limits<std::uint32_t>::max()));
    if (polygons.face_ends.empty()) return Cloud{std::move(polygons.vertices)};

    Mesh mesh{std::move(polygons.vertices), {}};
    mesh.triangles.reserve(polygons.corners.size() - 2 * polygons.face_ends.size());
    double crossed_area = 0.0;
    std::vector<std::size_t> crossed;  // numbers of faces
    std::size_t begin = 0;
    for (std::size_t i = 0; i < polygons.face_ends.size(); ++i) {
        const auto face = std::span(polygons.corners).subspan(begin, polygons.face_ends[i] - begin);
        begin = polygons.face_ends[i];
        if (face.size() == 3) {
            mesh.triangles.push_back({face[0], face[1], face[2]});
            continue;
        }
        const double upside_down = EarClipper(mesh.vertices, face).cut(mesh.triangles);
        crossed_area += upside_down;
        if (upside_down > 0.0) crossed.push_back(i + 1);
    }
    double area = 0.0;
    for (const auto& [a, b, c] : mesh.triangles)
        area += triangle_area(mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]);
    if (area == 0.0)
        throw bad_input(
            name,
            fmt::format(
                "all {} faces together have zero area, expected a surface; export the shape as points or with faces "
                "that are not flat to a line",
                polygons.face_ends.size()));
    constexpr double rounding = 1e-6;  // corners rounded by the exporting program may cross by this much
    if (crossed_area > rounding * area)
        mesh.flaw = fmt::format(
            "{} of its {} faces cross themselves, face {} first, and were cut into triangles as they "
            "are, {:.3g} % of the area upside down; export the shape as triangles",
            crossed.size(), polygons.face_ends.size(), crossed.front(), 100.0 * crossed_area / area);
    return mesh;
}

}  // namespace haptogram
