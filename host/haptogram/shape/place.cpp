// SPDX-License-Identifier: Apache-2.0
#include "haptogram/shape/place.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>

#include "haptogram/base/error.hpp"
#include "haptogram/base/text.hpp"
#include "haptogram/shape/shape_path.hpp"

namespace haptogram {
namespace {

Error bad_setting(const char* name, double found, const char* expected) {
    return bad_argument(name, fmt::format("found {}, expected {}; correct it", found, expected), {name});
}

/// p → turn · (scale · p) + shift, where `turn` is a rotation given by the images of the axes.
struct Motion {
    double scale = 1.0;
    std::array<Vec3, 3> turn{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    Vec3 shift{};

    [[nodiscard]] Vec3 operator()(Vec3 p) const {
        return scale * p.x * turn[0] + scale * p.y * turn[1] + scale * p.z * turn[2] + shift;
    }
};

Shape moved(Shape shape, const Motion& motion) {
    struct Mover {
        const Motion& motion;
        void operator()(Curve& curve) const {
            curve.at = [at = curve.at, motion = motion](double s) { return motion(at(s / motion.scale)); };
            curve.length *= motion.scale;
        }
        void operator()(Mesh& mesh) const {
            std::transform(mesh.vertices.begin(), mesh.vertices.end(), mesh.vertices.begin(), motion);
        }
        void operator()(Cloud& cloud) const {
            std::transform(cloud.points.begin(), cloud.points.end(), cloud.points.begin(), motion);
        }
    };
    for (Piece& piece : shape.pieces) std::visit(Mover{motion}, piece);
    return shape;
}

/// The same turn and scale as `motion`, but about `center`, which stays where it is.
Motion about(Vec3 center, Motion motion) {
    motion.shift = {};
    motion.shift = center - motion(center);
    return motion;
}

Vec3 rotated(Vec3 p, const std::array<double, 3>& degrees) {
    const auto turn = [](double& a, double& b, double angle_deg) {
        const double angle = angle_deg * (std::numbers::pi / 180.0);
        const double new_a = std::cos(angle) * a - std::sin(angle) * b;
        b = std::sin(angle) * a + std::cos(angle) * b;
        a = new_a;
    };
    turn(p.y, p.z, degrees[0]);
    turn(p.z, p.x, degrees[1]);
    turn(p.x, p.y, degrees[2]);
    return p;
}

/// The largest value of `sign` · coordinate on a curve. It is found at evenly spaced points first. Between two of them
/// a coordinate cannot rise by more than their distance along the curve, so the exact search runs only around points
/// that come that near to the largest value found.
double furthest(const Curve& curve, double Vec3::*axis, double sign) {
    constexpr int steps = 256;
    const double step = curve.length / steps;
    const auto value = [&](double s) { return sign * (curve.at(std::clamp(s, 0.0, curve.length)).*axis); };
    std::array<double, steps + 1> values{};
    for (int i = 0; i <= steps; ++i) values.at(static_cast<std::size_t>(i)) = value(i * step);
    double largest = *std::max_element(values.begin(), values.end());
    for (int i = 0; i <= steps; ++i) {
        if (values.at(static_cast<std::size_t>(i)) + step < largest) continue;
        double from = (i - 1) * step;
        double to = (i + 1) * step;
        for (int k = 0; k < 40; ++k) {  // golden section
            const double part = (to - from) / (1.0 + std::numbers::phi);
            if (value(from + part) < value(to - part))
                from += part;
            else
                to -= part;
        }
        largest = std::max(largest, value(0.5 * (from + to)));
    }
    return largest;
}

}  // namespace

Box bounding_box(const Shape& shape) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    Box box{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
    for (double Vec3::*const axis : {&Vec3::x, &Vec3::y, &Vec3::z}) {
        const auto add = [&](double low, double high) {
            box.low.*axis = std::min(box.low.*axis, low);
            box.high.*axis = std::max(box.high.*axis, high);
        };
        for (const Piece& piece : shape.pieces) {
            if (const auto* const curve = std::get_if<Curve>(&piece))
                add(-furthest(*curve, axis, -1.0), furthest(*curve, axis, 1.0));
            if (const auto* const cloud = std::get_if<Cloud>(&piece))
                for (const Vec3& point : cloud->points) add(point.*axis, point.*axis);
            if (const auto* const mesh =
                    std::get_if<Mesh>(&piece))  // corners only: a file may hold vertices of no triangle
                for (const auto& triangle : mesh->triangles)
                    for (const std::uint32_t corner : triangle)
                        add(mesh->vertices[corner].*axis, mesh->vertices[corner].*axis);
        }
    }
    if (box.low.x > box.high.x)
        throw bad_argument("shape", "found nothing, expected a curve, a surface or points; name a shape", {"shape"});
    return box;
}

Shape placed_at(const Shape& shape, const Placement& placement) {
    const auto check_positive = [](const char* name, double value) {
        if (!(value > 0.0) || !std::isfinite(value)) throw bad_setting(name, value, "a positive number");
    };
    check_positive("scale", placement.scale);
    if (placement.size_m) check_positive("size", *placement.size_m);
    for (const double angle : placement.rotate_deg)
        if (!std::isfinite(angle)) throw bad_setting("rotate", angle, "three angles in degrees");
    if (placement.center && !is_finite(*placement.center))
        throw bad_argument("center", "expected three finite numbers; correct it", {"center"});

    Shape placed = moved(shape, {.scale = placement.scale});
    if (placement.size_m) {
        const Box box = bounding_box(placed);
        const double largest = std::max({box.extent().x, box.extent().y, box.extent().z});
        if (largest == 0.0)
            throw bad_argument("size", "found a single point, which has no size; leave it out", {"size"});
        placed = moved(placed, about(box.center(), {.scale = *placement.size_m / largest}));
    }
    if (const auto& angles = placement.rotate_deg; angles != std::array<double, 3>{}) {
        const Motion turn{.turn = {rotated({1, 0, 0}, angles), rotated({0, 1, 0}, angles), rotated({0, 0, 1}, angles)}};
        placed = moved(placed, about(bounding_box(placed).center(), turn));
    }
    if (placement.center) placed = moved(placed, {.shift = *placement.center - bounding_box(placed).center()});
    return placed;
}

void require_reachable(const Path& path, const Array& array) {
    std::vector<Vec3> points;
    for (const PathStep& step : path.steps)
        for (const Focus& focus : step.foci) points.push_back(focus.position);
    (void)reachable_points(points, array, false);  // throws when one is not
}

namespace {

constexpr std::string_view axes = "xyz";
/// Of each axis the lower end, then the upper one.
constexpr std::string_view sides[] = {"left", "right", "front", "back", "below", "above"};

double along(Vec3 point, std::size_t axis) { return axis == 0 ? point.x : axis == 1 ? point.y : point.z; }

/// What fade_pattern says of a share: "0", or a point and up to six digits.
bool is_share(std::string_view text) {
    if (text == "0") return true;
    if (text.starts_with('0')) text.remove_prefix(1);
    return text.size() >= 2 && text.size() <= 7 && text[0] == '.' &&
           std::all_of(text.begin() + 1, text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

}  // namespace

std::optional<Fade> fade_of(std::string_view text) {
    const std::size_t colon = text.find(':');
    if (colon == std::string_view::npos) return {};
    const auto* const side = std::find(std::begin(sides), std::end(sides), text.substr(0, colon));
    const std::string_view share = text.substr(colon + 1);
    if (side == std::end(sides) || !is_share(share)) return {};
    const auto place = static_cast<std::size_t>(side - std::begin(sides));
    return Fade{.axis = place / 2, .from_upper = place % 2 == 1, .share = parse_number(share).value()};
}

std::string to_text(const Fade& fade) {
    std::string share = fmt::format("{:.6f}", fade.share);
    share.erase(share.find_last_not_of('0') + 1);
    if (share.ends_with('.')) share.pop_back();
    return fmt::format("{}:{}", sides[2 * fade.axis + (fade.from_upper ? 1 : 0)], share);
}

void apply(const Fade& fade, const Box& box, Path& path) {
    const double low = along(box.low, fade.axis), extent = along(box.high, fade.axis) - low;
    if (!(extent > 1e-9 * norm(box.high - box.low)))  // curves are measured no finer
        throw bad_argument("fade", fmt::format("the shape has no extent along {}; take another axis", axes[fade.axis]));
    for (PathStep& step : path.steps) {
        for (Focus& focus : step.foci) {
            // A curve's box may be short of it by what it is measured to.
            const double part = std::clamp((along(focus.position, fade.axis) - low) / extent, 0.0, 1.0);
            focus.amplitude *= std::lerp(fade.share, 1.0, fade.from_upper ? part : 1.0 - part);
        }
        std::erase_if(step.foci, [](const Focus& focus) { return focus.amplitude == 0.0; });
    }
}

}  // namespace haptogram
