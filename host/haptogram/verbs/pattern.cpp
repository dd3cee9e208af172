// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/pattern.hpp"

#include <fmt/format.h>

#include "haptogram/base/error.hpp"
#include "haptogram/shape/adaptics.hpp"
#include "haptogram/verbs/project.hpp"

namespace haptogram {

RenderedPath path_of_pattern(const Project& project, std::string_view text, const std::string& where,
                             double carrier_hz) {
    RenderedPath made{
        path_from_adaptics(text, where, carrier_hz, project.points, parameters_of(project.set).value_or(Parameters{})),
        carrier_hz,
        {},
        {}};
    const double samples_hz =
        static_cast<double>(project.points) * carrier_hz / static_cast<double>(made.path.periods());
    // A pattern that is looked at too seldom loses the shape of its brush.
    if (samples_hz < 2.0 * adaptics_brush_hz)
        made.warnings.push_back(fmt::format(
            "the pattern is looked at {:.4g} times a second, and its brush is drawn {:.4g} times; the brush is lost, "
            "take more points",
            samples_hz, adaptics_brush_hz));
    return made;
}

}  // namespace haptogram
