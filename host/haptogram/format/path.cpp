// SPDX-License-Identifier: Apache-2.0
#include "haptogram/format/path.hpp"

#include <fmt/core.h>

#include "haptogram/base/error.hpp"

namespace haptogram {

std::uint64_t Path::periods() const {
    std::uint64_t sum = 0;
    for (const PathStep& step : steps) sum += step.periods;
    return sum;
}

void require_sound(const Path& path) {
    const auto fraction = [](double value) { return value >= 0.0 && value <= 1.0; };  // false also for NaN
    if (path.steps.empty()) throw bad_argument("path", "it has no steps; there is nothing to play");
    for (std::size_t i = 0; i < path.steps.size(); ++i) {
        const PathStep& step = path.steps[i];
        const auto fail = [&](const std::string& what) {
            return bad_argument("path", fmt::format("step {}: {}", i + 1, what));
        };
        if (step.periods == 0) throw fail("it lasts 0 carrier periods; expected at least 1");
        for (const Focus& focus : step.foci) {
            if (!is_finite(focus.position)) throw fail("a coordinate is not finite");
            if (!fraction(focus.amplitude))
                throw fail(fmt::format("an amplitude of {}; expected 0 to 1", focus.amplitude));
        }
    }
    for (const double sample : path.modulation.samples)
        if (!fraction(sample))
            throw bad_argument("path", fmt::format("a modulation sample of {}; expected 0 to 1", sample));
    if (!path.modulation.samples.empty() && path.modulation.periods_a_sample == 0)
        throw bad_argument("path", "modulation samples of 0 carrier periods; expected at least 1");
}

void weaken(Path& path, double amplitude) {
    if (!(amplitude > 0.0 && amplitude <= 1.0))
        throw bad_argument("amplitude", fmt::format("found {}, expected above 0 and at most 1", amplitude));
    for (PathStep& step : path.steps)
        for (Focus& focus : step.foci) focus.amplitude *= amplitude;
}

}  // namespace haptogram
