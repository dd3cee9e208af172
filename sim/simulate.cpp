// SPDX-License-Identifier: Apache-2.0
#include "simulate.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/verbs/measure.hpp"

namespace haptogram::sim {
namespace {

constexpr std::uint32_t steady_cycles = 3;

std::vector<RecordResult> check_records(const Bundle& bundle, const std::vector<Pulse>& pulses,
                                        const Progress& progress) {
    const Manifest& manifest = bundle.manifest;
    const auto measured = measure(manifest, pulses, bundle.name);
    std::vector<RecordResult> results;
    for (std::size_t i = 0; i < measured.size(); ++i) {
        RecordResult result;
        result.cycles = measured[i].cycles;
        // A run that is stopped may have cut its last record short.
        result.steady = std::min<std::uint64_t>(manifest.records[i].dwell_cycles, result.cycles) >= steady_cycles;
        if (result.cycles > 0) result.check = check_record(manifest, manifest.records[i], measured[i].drives);
        result.limits = limits_of(manifest, manifest.records[i]);
        results.push_back(result);
        progress(static_cast<double>(i + 1) / static_cast<double>(measured.size()), "focus check");
    }
    return results;
}

}  // namespace

Simulation judged(const Bundle& bundle, Playback playback, const Progress& progress) {
    Simulation result;
    result.playback = std::move(playback);
    result.records = check_records(bundle, result.playback.pulses, progress);
    for (std::size_t i = 0; i < result.records.size(); ++i) {
        const RecordResult& record = result.records[i];
        if (record.cycles == 0) continue;
        if (!record.steady) {
            ++result.unsteady;
            continue;
        }
        ++result.checked;
        const FocusCheck& check = record.check;
        result.least_kept = std::min(result.least_kept, check.pressure_kept);
        result.mean_kept += check.pressure_kept;
        result.worst_offset_m = std::max(result.worst_offset_m, check.peak_offset_m);
        if (check.pressure_kept < record.limits.least_kept || check.peak_offset_m > record.limits.most_offset_m)
            result.off.push_back(bundle.manifest.index_of(i));
    }
    if (result.checked > 0) result.mean_kept /= static_cast<double>(result.checked);
    return result;
}

Simulation simulate(const Bundle& bundle, const PlaybackOptions& options) {
    return judged(bundle, play(bundle.image, options, bundle.name), options.progress);
}

/// An FST file is a chain of blocks, each a type and its length; the chain must end where the file does.
void require_whole_trace(const std::filesystem::path& file, const std::string& name) {
    const std::string content = read_file(file);
    std::uint64_t at = 0;
    while (at + 9 <= content.size()) {
        std::uint64_t length = 0;
        for (std::size_t i = 1; i <= 8; ++i) length = length << 8 | static_cast<unsigned char>(content[at + i]);
        if (length < 8 || length > content.size()) break;
        at += 1 + length;
    }
    if (content.empty() || at != content.size())
        throw bad_input(name, "cannot be written whole; make room, nothing was left behind");
}

}  // namespace haptogram::sim
