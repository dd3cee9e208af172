// SPDX-License-Identifier: Apache-2.0
#include "haptogram/acoustics/region.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>

#include "haptogram/base/error.hpp"
#include "haptogram/base/system.hpp"

namespace haptogram {
namespace {

/// Memory that each point takes: the field, and the quantity that is computed from it.
constexpr double bytes_a_point = 16.0;

/// The finite number that `text` is as a whole, or nothing.
std::optional<double> number(std::string_view text) {
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return {};
    return value;
}

/// How many coordinates an axis has. A double, because settings may ask for more than any integer holds.
double count_of(char axis, const Reach& reach) {
    const auto& range = axis == 'x' ? reach.x : axis == 'y' ? reach.y : reach.z;
    if (range) return std::floor((range->second - range->first) / reach.step_m + 1e-9) + 1.0;
    const double half = std::floor(reach.extent_m / reach.step_m + 1e-9);
    return axis == 'z' ? 2.0 * half : 2.0 * half + 1.0;
}

std::vector<double> coordinates(char axis, const Reach& reach) {
    const auto& range = axis == 'x' ? reach.x : axis == 'y' ? reach.y : reach.z;
    const auto count = static_cast<std::size_t>(count_of(axis, reach));
    // A range begins where it says. Without one, coordinates are whole multiples of the step, so that 0 is among them.
    const double first = range         ? range->first / reach.step_m
                         : axis == 'z' ? 1.0
                                       : -std::floor(static_cast<double>(count) / 2.0);
    std::vector<double> values;
    for (std::size_t i = 0; i < count; ++i) values.push_back((first + static_cast<double>(i)) * reach.step_m);
    return values;
}

using Values = std::map<std::string, double>;

/// The name=value pairs that stand behind the @, with commas between them; nothing when the text is none of this.
std::optional<Values> values_of(const std::string& text) {
    Values found;
    for (std::size_t at = text.find('@'); at != std::string::npos;) {
        const std::size_t end = text.find(',', at + 1);
        const std::string part = text.substr(at + 1, end == std::string::npos ? end : end - at - 1);
        const std::size_t equals = part.find('=');
        if (equals == std::string::npos) return {};
        const auto value = number(std::string_view(part).substr(equals + 1));
        if (!value || !found.emplace(part.substr(0, equals), *value).second) return {};
        at = end;
    }
    return found;
}

/// Whether the axes are those of x, y and z that are not fixed, in this order, and nothing else is fixed.
bool spreads_along(const std::string& axes, const Values& fixed) {
    std::string varying;
    for (const char axis : {'x', 'y', 'z'})
        if (!fixed.contains(std::string(1, axis))) varying += axis;
    return !varying.empty() && varying == axes && varying.size() + fixed.size() == 3;
}

/// The pose of an oblique plane; nothing when a name is unknown, or it has both turns and a normal, or a normal of 0.
std::optional<Pose> oblique_pose(const Values& named) {
    std::size_t used = 0;
    const auto vector = [&](const char* x, const char* y, const char* z) {
        Vec3 found;
        for (const auto& [name, to] : {std::pair(x, &found.x), std::pair(y, &found.y), std::pair(z, &found.z)})
            if (const auto value = named.find(name); value != named.end()) {
                *to = value->second;
                ++used;
            }
        return found;
    };
    const Vec3 origin = vector("x", "y", "z") * millimetre;
    const std::size_t places = used;
    const Vec3 angles = vector("rx", "ry", "rz");
    const bool turned = used > places;
    const std::size_t before = used;
    const Vec3 normal = vector("nx", "ny", "nz");
    const bool faces = used > before;
    if (used != named.size() || (turned && faces)) return {};
    if (!faces) return pose_of(origin, angles);
    const double length = norm(normal);
    if (!(length > 0.0) || !std::isfinite(length)) return {};
    const Vec3 n = normal * (1.0 / length);
    constexpr double upright = 1e-6;  // a normal this near to x leaves no u near x, which is then y
    const Vec3 across = Vec3{1.0, 0.0, 0.0} - n * n.x;
    const Vec3 u = norm(across) > upright ? across * (1.0 / norm(across)) : Vec3{0.0, 1.0, 0.0};
    return Pose{origin, u, cross(n, u), n};
}

void require_room(double points) {
    const double memory = system::memory_bytes();
    if (!(points * bytes_a_point < 0.8 * memory))
        throw bad_argument(
            "step",
            fmt::format("{:.4g} points are too many: they need {:.3g} GB, this machine has {:.3g}; take a larger step "
                        "or a smaller region",
                        points, points * bytes_a_point / 1e9, memory / 1e9));
}

/// Of all points of a region, which is a box in its own coordinates.
double lowest_z(const Region& region) {
    const Grid& grid = region.grid;
    double least = std::numeric_limits<double>::infinity();
    for (const double x : {grid.x.front(), grid.x.back()})
        for (const double y : {grid.y.front(), grid.y.back()}) {
            const Vec3 corner{x, y, grid.z.front()};
            least = std::min(least, region.pose ? region.pose->outwards(corner).z : corner.z);
        }
    return least;
}

}  // namespace

std::pair<double, double> parse_range(const std::string& setting, const std::string& text) {
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    const std::size_t colon = text.find(':');
    const double low = number(std::string_view(text).substr(0, colon)).value_or(none);
    const double high =
        colon == std::string::npos ? none : number(std::string_view(text).substr(colon + 1)).value_or(none);
    if (!(low < high))
        throw bad_argument(setting, fmt::format("expected LOW:HIGH in mm, such as -40:40, found '{}'", text));
    return {low * millimetre, high * millimetre};
}

Region parse_region(const std::string& setting, const std::string& text, const Reach& reach) {
    const auto fail = [&] {
        return bad_argument(
            setting,
            fmt::format("expected a line such as z@x=0,y=5, a plane such as xy@z=130, xz@y=0, yz@x=0 or, obliquely, "
                        "uv@z=130,rx=30 (degrees) or uv@z=130,ny=-1,nz=2 (its normal), or the volume xyz (mm), found "
                        "'{}'",
                        text));
    };
    if (!(reach.step_m > 0.0) || !(reach.extent_m >= reach.step_m))
        throw bad_argument("step",
                           fmt::format("must be positive and no more than the extent; found a step of {} mm and an "
                                       "extent of {} mm",
                                       reach.step_m / millimetre, reach.extent_m / millimetre),
                           {"extent"});
    const auto named = values_of(text);
    if (!named) throw fail();
    Region region;
    region.text = text;
    region.axes = text.substr(0, text.find('@'));
    const bool oblique = region.axes == "uv";
    if (oblique) {
        region.pose = oblique_pose(*named);
        if (!region.pose) throw fail();
        require_room(count_of('x', reach) * count_of('y', reach));
        region.grid = {coordinates('x', reach), coordinates('y', reach), {0.0}};
    } else {
        if (!spreads_along(region.axes, *named)) throw fail();
        double points = 1.0;
        for (const char axis : region.axes) points *= count_of(axis, reach);
        require_room(points);
        std::vector<double>* const axes[] = {&region.grid.x, &region.grid.y, &region.grid.z};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const char name = "xyz"[axis];
            const auto fixed = named->find(std::string(1, name));
            *axes[axis] =
                fixed == named->end() ? coordinates(name, reach) : std::vector<double>{fixed->second * millimetre};
        }
    }
    const double lowest = lowest_z(region);
    if (lowest <= 0.0)
        throw bad_argument(
            setting, fmt::format("'{}' has points on or behind the array, at z = {:.4g} mm; z must be positive{}", text,
                                 lowest / millimetre, oblique ? "; take a smaller extent, or a higher plane" : ""));
    return region;
}

}  // namespace haptogram
