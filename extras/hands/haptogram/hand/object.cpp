// SPDX-License-Identifier: Apache-2.0
#include "haptogram/hand/object.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "haptogram/array/rig.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/text.hpp"
#include "haptogram/hand/solid.hpp"
#include "haptogram/verbs/hand_source.hpp"

namespace haptogram {
namespace {

Edge circle(double radius, double z) {
    constexpr int corners = 360;
    Edge edge;
    for (int i = 0; i <= corners; ++i) {
        const double angle = 2.0 * std::numbers::pi * (i % corners) / corners;
        edge.push_back({radius * std::cos(angle), radius * std::sin(angle), z});
    }
    return edge;
}

std::array<Vec3, 4> square(double half, double z) {
    return {Vec3{-half, -half, z}, {half, -half, z}, {half, half, z}, {-half, half, z}};
}

void add_square(TouchObject& object, double half, double z) {
    const std::array<Vec3, 4> corners = square(half, z);
    for (std::size_t i = 0; i < 4; ++i) object.edges.push_back({corners.at(i), corners.at((i + 1) % 4)});
    object.corners.insert(object.corners.end(), corners.begin(), corners.end());
}

/// The object in its own frame, with its box around the origin.
TouchObject standing(std::string_view kind, double size, double height) {
    TouchObject object;
    object.name = kind;
    const double half = 0.5 * size, top = 0.5 * height;
    object.low = {-half, -half, -top};
    object.high = {half, half, top};
    if (kind == "cube" || kind == "sphere" || kind == "half-space") {
        object.low.z = -half;
        object.high.z = half;
    }
    if (kind == "cube") {
        object.solid = solid_box({}, {size, size, size});
        add_square(object, half, -half);
        add_square(object, half, half);
        for (std::size_t i = 0; i < 4; ++i)
            object.edges.push_back({square(half, -half).at(i), square(half, half).at(i)});
    } else if (kind == "sphere") {
        object.solid = solid_sphere({}, half);
    } else if (kind == "cone") {
        object.solid = solid_cone({0, 0, -top}, half, height);
        object.edges = {circle(half, -top)};
        object.corners = {{0, 0, top}};
    } else if (kind == "pyramid") {
        object.solid = solid_pyramid({0, 0, -top}, size, height);
        add_square(object, half, -top);
        for (const Vec3 corner : square(half, -top)) object.edges.push_back({corner, {0, 0, top}});
        object.corners.push_back({0, 0, top});
    } else if (kind == "cylinder") {
        object.solid = solid_cylinder({}, half, height);
        object.edges = {circle(half, -top), circle(half, top)};
    } else {
        object.solid = half_space({}, {0, 0, 1});
    }
    return object;
}

}  // namespace

TouchObject built_in_object(std::string_view kind, const ObjectMeasures& measures) {
    const auto kinds = object_kinds();
    if (std::find(kinds.begin(), kinds.end(), kind) == kinds.end())
        throw bad_argument("object",
                           fmt::format("found \"{}\", expected {} or a mesh file", kind, fmt::join(kinds, ", ")));
    for (const auto& [name, value] : {std::pair("size", measures.size), std::pair("height", measures.height)})
        require_positive(name, value);
    if (!is_finite(measures.centre) || !is_finite(measures.angles_deg))
        throw bad_argument("center", "a number is not finite; correct it");
    TouchObject object = standing(kind, measures.size, measures.height);
    const Pose pose = pose_of(measures.centre, measures.angles_deg);
    object.solid = moved(object.solid, measures.centre, measures.angles_deg);
    const Vec3 low = object.low, high = object.high;
    object.low = object.high = pose.outwards(low);
    for (int i = 1; i < 8; ++i) {
        const Vec3 p = pose.outwards(
            {(i & 1) != 0 ? high.x : low.x, (i & 2) != 0 ? high.y : low.y, (i & 4) != 0 ? high.z : low.z});
        object.low = {std::min(object.low.x, p.x), std::min(object.low.y, p.y), std::min(object.low.z, p.z)};
        object.high = {std::max(object.high.x, p.x), std::max(object.high.y, p.y), std::max(object.high.z, p.z)};
    }
    for (Edge& edge : object.edges)
        for (Vec3& p : edge) p = pose.outwards(p);
    for (Vec3& corner : object.corners) corner = pose.outwards(corner);
    return object;
}

TouchObject mesh_object(const std::string& name, std::span<const Vec3> vertices,
                        std::span<const std::array<std::uint32_t, 3>> triangles, double sharp_deg) {
    TouchObject object;
    object.name = name;
    object.solid = mesh_solid(vertices, triangles);
    object.low = object.high = vertices.front();
    for (const Vec3& p : vertices) {
        object.low = {std::min(object.low.x, p.x), std::min(object.low.y, p.y), std::min(object.low.z, p.z)};
        object.high = {std::max(object.high.x, p.x), std::max(object.high.y, p.y), std::max(object.high.z, p.z)};
    }
    const std::vector<std::uint32_t> same = welded(vertices);
    const double least_cosine = std::cos(sharp_deg * std::numbers::pi / 180.0);
    std::map<std::pair<std::uint32_t, std::uint32_t>, Vec3> normals;  // of the face beside each edge that was seen once
    std::map<std::uint32_t, std::vector<std::uint32_t>> sharp;        // where sharp edges lead from a vertex
    for (const auto& triangle : triangles) {
        const std::array<std::uint32_t, 3> corner{same[triangle[0]], same[triangle[1]], same[triangle[2]]};
        const Vec3 across = cross(vertices[corner[1]] - vertices[corner[0]], vertices[corner[2]] - vertices[corner[0]]);
        if (norm(across) == 0.0) continue;
        const Vec3 normal = across * (1.0 / norm(across));
        for (std::size_t i = 0; i < 3; ++i) {
            const std::uint32_t from = corner.at(i), to = corner.at((i + 1) % 3);
            const auto [seen, first] = normals.try_emplace({std::min(from, to), std::max(from, to)}, normal);
            if (first || dot(seen->second, normal) > least_cosine) continue;
            sharp[from].push_back(to);
            sharp[to].push_back(from);
        }
    }
    const auto walk = [&](std::uint32_t from, std::uint32_t to) {
        Edge edge{vertices[from]};
        for (const std::uint32_t begin = from;;) {
            std::erase(sharp[from], to);
            std::erase(sharp[to], from);
            edge.push_back(vertices[to]);
            if (to == begin || sharp[to].size() != 1 ||
                std::find(object.corners.begin(), object.corners.end(), vertices[to]) != object.corners.end())
                return edge;
            from = to;
            to = sharp[from].front();
        }
    };
    for (const auto& [vertex, others] : sharp)
        if (others.size() != 2) object.corners.push_back(vertices[vertex]);
    std::vector<std::uint32_t> begins;
    for (const auto& [vertex, others] : sharp)
        if (others.size() != 2) begins.push_back(vertex);
    for (const auto& [vertex, others] : sharp)
        if (others.size() == 2) begins.push_back(vertex);  // rings, when nothing else is left
    for (const std::uint32_t vertex : begins)
        while (!sharp[vertex].empty()) object.edges.push_back(walk(vertex, sharp[vertex].front()));
    return object;
}

}  // namespace haptogram
