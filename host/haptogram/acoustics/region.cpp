// SPDX-License-Identifier: Apache-2.0
#include "haptogram/acoustics/region.hpp"

#include <fmt/core.h>
#include <unistd.h>

#include <charconv>
#include <cmath>
#include <limits>

#include "haptogram/base/error.hpp"

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
            fmt::format("expected a line such as z@x=0,y=5, a plane such as xy@z=130, xz@y=0 or yz@x=0, or the "
                        "volume xyz (mm), found '{}'",
                        text));
    };
    if (!(reach.step_m > 0.0) || !(reach.extent_m >= reach.step_m))
        throw bad_argument("step",
                           fmt::format("must be positive and no more than the extent; found a step of {} mm and an "
                                       "extent of {} mm",
                                       reach.step_m / millimetre, reach.extent_m / millimetre),
                           {"extent"});
    Region region;
    region.text = text;
    region.axes = text.substr(0, text.find('@'));
    std::optional<double> fixed[3];
    // Before each name=value stands an @ or a comma; `at` is where.
    for (std::size_t at = text.find('@'); at != std::string::npos;) {
        const std::size_t end = text.find(',', at + 1);
        const std::string part = text.substr(at + 1, end == std::string::npos ? end : end - at - 1);
        const std::size_t axis = part.empty() ? std::string::npos : std::string("xyz").find(part[0]);
        const auto value = part.size() > 2 && part[1] == '=' ? number(std::string_view(part).substr(2)) : std::nullopt;
        if (axis == std::string::npos || !value || fixed[axis]) throw fail();
        fixed[axis] = *value * millimetre;
        at = end;
    }
    std::string varying;
    double points = 1.0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const char name = "xyz"[axis];
        if (fixed[axis]) continue;
        varying += name;
        points *= count_of(name, reach);
    }
    if (varying.empty() || varying != region.axes) throw fail();
    const double memory =
        static_cast<double>(::sysconf(_SC_PHYS_PAGES)) * static_cast<double>(::sysconf(_SC_PAGE_SIZE));
    if (!(points * bytes_a_point < 0.8 * memory))
        throw bad_argument(
            "step",
            fmt::format("{:.4g} points are too many: they need {:.3g} GB, this machine has {:.3g}; take a larger step "
                        "or a smaller region",
                        points, points * bytes_a_point / 1e9, memory / 1e9));
    std::vector<double>* const axes[] = {&region.grid.x, &region.grid.y, &region.grid.z};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const char name = "xyz"[axis];
        *axes[axis] = fixed[axis] ? std::vector<double>{*fixed[axis]} : coordinates(name, reach);
    }
    if (region.grid.z.front() <= 0.0)
        throw bad_argument(
            setting, fmt::format("'{}' has points on or behind the array, at z = {:.4g} mm; z must be positive", text,
                                 region.grid.z.front() / millimetre));
    return region;
}

}  // namespace haptogram
