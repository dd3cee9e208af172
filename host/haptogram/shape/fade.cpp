// SPDX-License-Identifier: Apache-2.0
#include "haptogram/shape/fade.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "haptogram/base/error.hpp"
#include "haptogram/base/text.hpp"

namespace haptogram {
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
