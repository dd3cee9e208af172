// SPDX-License-Identifier: Apache-2.0
#include "haptogram/shape/primitives.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/shape/draw.hpp"
#include "haptogram/shape/place.hpp"

namespace haptogram {
namespace {

constexpr double pi = std::numbers::pi;
constexpr unsigned segments = 360;  ///< of a turn, in surfaces

Vec3 on_circle(double radius, double angle) { return {radius * std::cos(angle), radius * std::sin(angle), 0.0}; }

/// Regular, one side below and parallel to x.
Curve regular_polygon(double diameter, unsigned sides) {
    std::vector<Vec3> corners;
    for (unsigned i = 0; i < sides; ++i)
        corners.push_back(on_circle(0.5 * diameter, 2.0 * pi * (i + 0.5) / sides - 0.5 * pi));
    return polyline(corners, true);
}

/// A point of a profile that is turned about the z axis.
struct Ring {
    double radius, z;
};

Mesh revolve(const std::vector<Ring>& profile) {
    Mesh mesh;
    for (const Ring& ring : profile)
        for (unsigned i = 0; i < segments; ++i)
            mesh.vertices.push_back(on_circle(ring.radius, 2.0 * pi * i / segments) + Vec3{0, 0, ring.z});
    for (std::uint32_t k = 0; k + 1 < profile.size(); ++k) {
        for (std::uint32_t i = 0; i < segments; ++i) {
            const std::uint32_t here = k * segments + i;
            const std::uint32_t next = k * segments + (i + 1) % segments;
            if (profile[k].radius > 0.0) mesh.triangles.push_back({here, next, next + segments});
            if (profile[k + 1].radius > 0.0) mesh.triangles.push_back({here, next + segments, here + segments});
        }
    }
    return mesh;
}

/// The part of a sphere, from the top down, that is within `angle` of the top as seen from the centre.
Mesh dome(double radius, double angle) {
    std::vector<Ring> profile{{0.0, radius}};
    const auto rings = static_cast<unsigned>(std::lround(segments * angle / (2.0 * pi)));
    for (unsigned k = 1; k <= rings; ++k) {
        const double at = angle * k / rings;
        profile.push_back({k == rings && angle == pi ? 0.0 : radius * std::sin(at), radius * std::cos(at)});
    }
    return revolve(profile);
}

Mesh box_mesh(double edge) {
    Mesh mesh;
    for (unsigned i = 0; i < 8; ++i)
        mesh.vertices.push_back(
            edge * Vec3{(i & 1U) != 0 ? 0.5 : -0.5, (i & 2U) != 0 ? 0.5 : -0.5, (i & 4U) != 0 ? 0.5 : -0.5});
    mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                      {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    return mesh;
}

Curve circle(double diameter) {
    const double radius = 0.5 * diameter;
    return {[radius](double s) { return on_circle(radius, s / radius); }, pi * diameter, true};
}

Curve helix(double diameter, double height, double turns) {
    const double radius = 0.5 * diameter;
    const double length = std::hypot(pi * diameter * turns, height);
    return {[=](double s) {
                return on_circle(radius, 2.0 * pi * turns * s / length) + Vec3{0, 0, height * (s / length)};
            },
            length, false};
}

/// A kind of shape. It takes the measures that have a default here.
struct Kind {
    PrimitiveSpec defaults;
    Shape (*make)(const PrimitiveSpec&);
};

std::vector<Kind> kinds() {
    constexpr double wide = 0.1;
    using Spec = const PrimitiveSpec&;
    return {
        {{.kind = "point"}, [](Spec) { return Shape{{Cloud{{Vec3{}}}}}; }},
        {{.kind = "line", .length = wide},
         [](Spec s) {
             return Shape{{polyline({{0, 0, 0}, {*s.length, 0, 0}}, false)}};
         }},
        {{.kind = "circle", .diameter = 0.07}, [](Spec s) { return Shape{{circle(*s.diameter)}}; }},
        {{.kind = "triangle", .length = wide},
         [](Spec s) { return Shape{{regular_polygon(*s.length * 2.0 / std::sqrt(3.0), 3)}}; }},
        {{.kind = "square", .length = wide},
         [](Spec s) { return Shape{{regular_polygon(*s.length * std::sqrt(2.0), 4)}}; }},
        {{.kind = "plus", .length = wide},
         [](Spec s) {
             const double arm = 0.5 * *s.length;
             return Shape{{polyline({{-arm, 0, 0}, {arm, 0, 0}}, false), polyline({{0, -arm, 0}, {0, arm, 0}}, false)}};
         }},
        {{.kind = "polygon", .diameter = wide, .sides = 6},
         [](Spec s) { return Shape{{regular_polygon(*s.diameter, *s.sides)}}; }},
        {{.kind = "sphere", .diameter = wide}, [](Spec s) { return Shape{{dome(0.5 * *s.diameter, pi)}}; }},
        {{.kind = "hemisphere", .diameter = wide}, [](Spec s) { return Shape{{dome(0.5 * *s.diameter, 0.5 * pi)}}; }},
        {{.kind = "cube", .length = wide}, [](Spec s) { return Shape{{box_mesh(*s.length)}}; }},
        {{.kind = "cone", .diameter = wide, .height = wide},
         [](Spec s) {
             return Shape{{revolve({{0, *s.height}, {0.5 * *s.diameter, 0}, {0, 0}})}};
         }},
        {{.kind = "cylinder", .diameter = wide, .height = wide},
         [](Spec s) {
             return Shape{{revolve({{0, *s.height}, {0.5 * *s.diameter, *s.height}, {0.5 * *s.diameter, 0}, {0, 0}})}};
         }},
        {{.kind = "helix", .diameter = 0.07, .height = wide, .turns = 3.0},
         [](Spec s) { return Shape{{helix(*s.diameter, *s.height, *s.turns)}}; }},
    };
}

/// `given` with the defaults of what it leaves out. A measure without a default is one that the shape does not take.
PrimitiveSpec completed(PrimitiveSpec given, const PrimitiveSpec& defaults) {
    std::vector<std::string> takes;
    std::vector<std::string> strange;
    const auto complete = [&](const char* name, auto& value, const auto& preset) {
        if (preset) takes.emplace_back(name);
        if (value && !preset) strange.emplace_back(name);
        if (!value) value = preset;
    };
    complete("diameter", given.diameter, defaults.diameter);
    complete("length", given.length, defaults.length);
    complete("height", given.height, defaults.height);
    complete("sides", given.sides, defaults.sides);
    complete("turns", given.turns, defaults.turns);
    if (!strange.empty())
        throw bad_argument(strange.front(),
                           fmt::format("found {} for a {}, expected {}; leave it out", fmt::join(strange, ", "),
                                       given.kind, takes.empty() ? "none" : fmt::format("{}", fmt::join(takes, ", "))),
                           strange);
    for (const auto& [name, value] : {std::pair{"diameter", given.diameter},
                                      {"length", given.length},
                                      {"height", given.height},
                                      {"turns", given.turns}})
        if (value && (!(*value > 0.0) || !std::isfinite(*value)))
            throw bad_argument(
                name, fmt::format("found {} for a {}, expected a positive number; correct it", *value, given.kind),
                {name});
    if (given.sides && (*given.sides < 3 || *given.sides > 1000))
        throw bad_argument("sides",
                           fmt::format("found {} for a {}, expected 3 to 1000; correct it", *given.sides, given.kind),
                           {"sides"});
    return given;
}

}  // namespace

std::vector<std::string> primitive_kinds() {
    std::vector<std::string> names;
    for (const Kind& kind : kinds()) names.push_back(kind.defaults.kind);
    return names;
}

namespace {

const Kind& kind_of(const PrimitiveSpec& spec, const std::vector<Kind>& known) {
    for (const Kind& kind : known)
        if (kind.defaults.kind == spec.kind) return kind;
    throw bad_argument(
        "shape",
        fmt::format("found \"{}\", expected one of {}; choose one", spec.kind, fmt::join(primitive_kinds(), ", ")),
        {"shape"});
}

}  // namespace

void check_primitive(const PrimitiveSpec& spec) {
    const auto known = kinds();
    std::ignore = completed(spec, kind_of(spec, known).defaults);
}

Shape make_primitive(const PrimitiveSpec& spec) {
    const auto known = kinds();
    const Kind& kind = kind_of(spec, known);
    return placed_at(kind.make(completed(spec, kind.defaults)), {.center = Vec3{}});
}

}  // namespace haptogram
