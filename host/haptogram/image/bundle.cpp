// SPDX-License-Identifier: Apache-2.0
#include "haptogram/image/bundle.hpp"

#include <fmt/core.h>

#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/solve/drives.hpp"

namespace haptogram {
namespace {

void require_agreement(const Manifest& manifest, const Image& image, const std::string& where) {
    const auto fail = [&](const std::string& what) { return bad_input(where, what + "; compile the two together"); };
    const interface::CoreParameters& core = manifest.core.parameters;
    if (manifest.records.size() != image.records.size())
        throw fail(fmt::format("{} records, but the image has {}", manifest.records.size(), image.records.size()));
    if (core.channels != image.channels)
        throw fail(fmt::format("{} channels, but the image has {}", core.channels, image.channels));
    if (core.clock_hz != image.clock_hz)
        throw fail(fmt::format("a clock of {} Hz, but the image is for {} Hz", core.clock_hz, image.clock_hz));
    std::vector<std::uint32_t> cycles(image.records.size());
    for (const SequenceEntry& entry : image.sequence)
        if (entry.index > 0 && entry.index <= cycles.size()) cycles[entry.index - 1U] += entry.dwell;
    const Timer& t = manifest.timer;
    for (std::size_t i = 0; i < image.records.size(); ++i) {
        const Record& r = image.records[i];
        const RecordMeaning& meaning = manifest.records[i];
        const std::uint32_t pulse = pulse_ticks(t, meaning.amplitude);
        if (r.cycle_length != t.cycle_ticks || r.prescaler != t.prescaler || r.pulse_length != pulse)
            throw fail(fmt::format("timer {} × {} ticks, pulse {}, but record {} of the image has {} × {}, pulse {}",
                                   t.prescaler, t.cycle_ticks, pulse, i + 1, r.prescaler, r.cycle_length,
                                   r.pulse_length));
        if (meaning.dwell_cycles != cycles[i])
            throw fail(fmt::format("record {} is to last {} cycles, but the image's sequence gives it {}", i + 1,
                                   meaning.dwell_cycles, cycles[i]));
        for (std::size_t k = manifest.array.elements.size(); k < r.timings.size(); ++k)
            if (r.timings[k] < r.cycle_length)
                throw fail(fmt::format("{} elements, but record {} of the image fires channel {}",
                                       manifest.array.elements.size(), i + 1, k));
    }
}

Bundle assemble(Image image, std::string hex, Manifest manifest, const std::string& name,
                const std::string& manifest_name) {
    require_playable(image, name);
    if (const std::string hash = sha256(hex); manifest.image_sha256 != hash)
        throw bad_input(manifest_name,
                        fmt::format("it belongs to another image than {} (hash {}…, expected {}…); compile the two "
                                    "together",
                                    name, hash.substr(0, 12), manifest.image_sha256.substr(0, 12)));
    require_agreement(manifest, image, manifest_name);
    return {std::move(image), std::move(manifest), std::move(hex), name};
}

}  // namespace

std::string manifest_path(const std::string& image) {
    return std::filesystem::path(image).replace_extension(".json").string();
}

Bundle bundle_of(std::string hex, Manifest manifest, const std::string& name, const std::string& manifest_name) {
    Image image = from_intel_hex(hex, name);
    return assemble(std::move(image), std::move(hex), std::move(manifest), name, manifest_name);
}

Bundle load_bundle(const std::string& image, const std::string& manifest) {
    const std::string beside = manifest.empty() ? manifest_path(image) : manifest;
    std::string hex = read_file(image);
    Image read = from_intel_hex(hex, image);
    return assemble(std::move(read), std::move(hex), manifest_from_json(read_file(beside), beside), image, beside);
}

Path path_of(const Bundle& bundle) {
    Path path;
    std::uint32_t last = 0;
    for (const SequenceEntry& entry : bundle.image.sequence) {
        if (entry.dwell == 0) continue;  // holds until the next record is ready, less than a period later
        if (!path.steps.empty() && entry.index == last) {
            path.steps.back().periods += entry.dwell;
            continue;
        }
        last = entry.index;
        PathStep& step = path.steps.emplace_back();
        step.periods = entry.dwell;
        if (entry.index == 0) continue;
        const RecordMeaning& record = bundle.manifest.records.at(entry.index - 1U);
        step.foci = record.foci;
        for (Focus& focus : step.foci) focus.amplitude *= record.amplitude;
    }
    return path;
}

}  // namespace haptogram
