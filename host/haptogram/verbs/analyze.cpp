// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/analyze.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "haptogram/verbs/excitation.hpp"

namespace haptogram {
namespace {

/// The same places at the same times, all at full strength: a modulation's samples are no places of their own.
Path unmodulated(const Path& path) {
    Path result;
    for (PathStep step : path.steps) {
        double largest = 0.0;
        for (const Focus& focus : step.foci) largest = std::max(largest, focus.amplitude);
        for (Focus& focus : step.foci) focus.amplitude /= largest;
        if (!result.steps.empty() && result.steps.back().foci == step.foci)
            result.steps.back().periods += step.periods;
        else
            result.steps.push_back(std::move(step));
    }
    return result;
}

}  // namespace

ImageAnalysis analyze(const Bundle& bundle, double least_force_n, const Progress& progress) {
    const Excitation excitation = excitation_of(bundle);
    const Manifest& manifest = bundle.manifest;
    ImageAnalysis result;
    std::size_t weak = 0;
    std::size_t short_dwells = 0;
    for (std::size_t i = 0; i < manifest.records.size(); ++i) {
        for (const Focus& focus : manifest.records[i].foci) {
            if (focus.amplitude == 0.0) continue;
            PointAnalysis point{manifest.index_of(i),
                                analyze(manifest.array, manifest.core, excitation.drives[i], focus.position),
                                manifest.records[i].dwell_cycles, false};
            point.too_weak = point.focus.force_n < least_force_n;
            weak += point.too_weak ? 1 : 0;
            short_dwells += point.dwell_cycles < point.focus.dwell_cycles ? 1 : 0;
            result.points.push_back(point);
        }
        progress(static_cast<double>(i + 1) / static_cast<double>(manifest.records.size()));
    }
    const std::size_t points = result.points.size();
    if (weak > 0)
        result.warnings.push_back(fmt::format("{} of {} points may be too weak to feel: less than {} mN in their focus",
                                              weak, points, least_force_n * 1e3));
    if (short_dwells > 0)
        result.warnings.push_back(fmt::format(
            "{} of {} points are left before 90 % of their pressure is there; take fewer points or a lower rate",
            short_dwells, points));
    const Path path = unmodulated(path_of(bundle));
    if (!path.steps.empty()) result.pressure_left = summary_of(path, pressure_left(manifest.array, path));
    result.loudness = loudness(manifest.array, excitation.sequence());
    return result;
}

}  // namespace haptogram
