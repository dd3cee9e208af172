// SPDX-License-Identifier: Apache-2.0
#include "haptogram/format/path.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

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

std::vector<Focus> without_factor(std::vector<Focus> foci) {
    std::erase_if(foci, [](const Focus& focus) { return focus.amplitude == 0.0; });
    double largest = 0.0;
    for (const Focus& focus : foci) largest = std::max(largest, focus.amplitude);
    for (Focus& focus : foci) focus.amplitude /= largest;
    return foci;
}

std::vector<std::array<double, 4>> key_of(const std::vector<Focus>& foci) {
    std::vector<std::array<double, 4>> key;
    for (const auto& [p, amplitude] : foci) key.push_back({p.x, p.y, p.z, std::round(amplitude * 1e6)});
    return key;
}

void add_places(Path& path, const std::vector<Focus>& foci, std::uint32_t periods) {
    std::vector<Focus> plain = without_factor(foci);
    if (!path.steps.empty() && key_of(path.steps.back().foci) == key_of(plain))
        path.steps.back().periods += periods;
    else
        path.steps.push_back({std::move(plain), periods});
}

}  // namespace haptogram
