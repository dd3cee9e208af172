// SPDX-License-Identifier: Apache-2.0
#include "haptogram/format/bundle.hpp"

#include <fmt/core.h>

#include <cmath>
#include <functional>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"

namespace haptogram {
namespace {

/// As near as the image's unit of length and the manifest's digits can tell.
bool near(Vec3 a, Vec3 b) {
    constexpr double tolerance_m = 0.6 * focus_unit_m;
    return std::abs(a.x - b.x) <= tolerance_m && std::abs(a.y - b.y) <= tolerance_m &&
           std::abs(a.z - b.z) <= tolerance_m;
}

Vec3 position_of(const GeometryWords& words) {
    const auto metres = [](std::uint16_t word) { return static_cast<std::int16_t>(word) * focus_unit_m; };
    return {metres(words[0]), metres(words[1]), metres(words[2])};
}

using Fail = std::function<Error(const std::string& what)>;

/// The records of an image that has no others.
void require_same_records(const Manifest& manifest, const Image& image, const Fail& fail) {
    const Timer& t = manifest.timer;
    for (std::size_t i = 0; i < image.records.size(); ++i) {
        const Record& r = image.records[i];
        const std::uint32_t pulse = pulse_ticks(t, manifest.records[i].amplitude);
        if (r.kind != interface::Kind::timings)
            throw fail(
                fmt::format("record {} of the image holds amplitudes, of which a manifest knows nothing", i + 1));
        if (r.cycle_length != t.cycle_ticks || r.prescaler != t.prescaler || r.pulse_length != pulse)
            throw fail(fmt::format("timer {} × {} ticks, pulse {}, but record {} of the image has {} × {}, pulse {}",
                                   t.prescaler, t.cycle_ticks, pulse, i + 1, r.prescaler, r.cycle_length,
                                   r.pulse_length));
        for (std::size_t k = manifest.array.elements.size(); k < r.timings.size(); ++k)
            if (r.timings[k] < r.cycle_length)
                throw fail(fmt::format("{} elements, but record {} of the image fires channel {}",
                                       manifest.array.elements.size(), i + 1, k));
    }
}

/// Focus records and the geometry from which the board computes them.
void require_same_foci(const Manifest& manifest, const FocusRecords& foci, const Fail& fail) {
    const Timer& t = manifest.timer;
    if (foci.board_records != manifest.core.parameters.records)
        throw fail(fmt::format("a board of {} records, but the image is for one of {}",
                               manifest.core.parameters.records, foci.board_records));
    if (t.prescaler != 1 || foci.cycle_ticks != t.cycle_ticks)
        throw fail(fmt::format("timer {} × {} ticks, but the foci of the image have 1 × {}", t.prescaler, t.cycle_ticks,
                               foci.cycle_ticks));
    const std::vector<Element>& elements = manifest.array.elements;
    if (elements.size() != foci.engine.geometry.size())
        throw fail(fmt::format("{} elements, but the image's geometry is of {} channels", elements.size(),
                               foci.engine.geometry.size()));
    for (std::size_t k = 0; k < elements.size(); ++k)
        if (!near(elements[k].position, position_of(foci.engine.geometry[k])))
            throw fail(fmt::format("element {} does not lie where the image's geometry has it", k));
    for (std::size_t i = 0; i < foci.count(); ++i) {
        const RecordMeaning& meaning = manifest.records[i];
        std::size_t sounding = 0;
        for (const FocusWords& words : foci.record(i)) {
            const Focus focus = unpack_focus(words);
            if (focus.amplitude == 0.0) continue;  // fills the record up
            if (sounding == meaning.foci.size() || !near(meaning.foci[sounding].position, focus.position) ||
                std::abs(meaning.foci[sounding].amplitude * meaning.amplitude - focus.amplitude) > 1e-6)
                throw fail(fmt::format("focus {} of focus record {} of the image is another one", sounding + 1, i + 1));
            ++sounding;
        }
        if (sounding != meaning.foci.size())
            throw fail(fmt::format("{} foci in record {}, but the image has {}", meaning.foci.size(), i + 1, sounding));
    }
}

void require_agreement(const Manifest& manifest, const Image& image, const std::string& where) {
    const auto fail = [&](const std::string& what) { return bad_input(where, what + "; compile the two together"); };
    const interface::CoreParameters& core = manifest.core.parameters;
    if (manifest.records.size() != image.record_count())
        throw fail(fmt::format("{} records, but the image has {}", manifest.records.size(), image.record_count()));
    if (manifest.foci.has_value() != image.foci.has_value() || (image.foci && !image.records.empty()))
        throw fail(fmt::format("its records are {}, but the image has {} others and {} of foci",
                               manifest.foci ? "of foci" : "not of foci", image.records.size(),
                               image.foci ? image.foci->count() : 0));
    if (manifest.modulation != image.modulation) throw fail("its modulation is not that of the image");
    if (core.channels != image.channels)
        throw fail(fmt::format("{} channels, but the image has {}", core.channels, image.channels));
    if (core.clock_hz != image.clock_hz)
        throw fail(fmt::format("a clock of {} Hz, but the image is for {} Hz", core.clock_hz, image.clock_hz));
    std::vector<std::uint32_t> cycles(image.record_count());
    for (const SequenceEntry& entry : image.sequence)
        if (const auto place = place_of(image, entry.index)) cycles[*place] += entry.dwell;
    for (std::size_t i = 0; i < cycles.size(); ++i)
        if (manifest.records[i].dwell_cycles != cycles[i])
            throw fail(fmt::format("record {} is to last {} cycles, but the image's sequence gives it {}", i + 1,
                                   manifest.records[i].dwell_cycles, cycles[i]));
    if (image.foci)
        require_same_foci(manifest, *image.foci, fail);
    else
        require_same_records(manifest, image, fail);
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
    if (image == "-" && manifest.empty())
        throw bad_argument("image", "an image from standard input has no manifest beside it; name the manifest",
                           {"manifest"});
    const std::string beside = manifest.empty() ? manifest_path(image) : manifest;
    std::string hex = read_file(image);
    Image read = from_intel_hex(hex, image);
    return assemble(std::move(read), std::move(hex), manifest_from_json(read_file(beside), beside), image, beside);
}

Path path_of(const Bundle& bundle) {
    Path path;
    if (const auto& modulation = bundle.image.modulation) {
        path.modulation.periods_a_sample = modulation->divider;
        for (const std::uint8_t sample : modulation->samples) path.modulation.samples.push_back(sample / 255.0);
    }
    std::uint32_t last = 0;
    for (const SequenceEntry& entry : bundle.image.sequence) {
        if (entry.dwell == 0) continue;  // holds until the next record is ready, less than a period later
        if (!path.steps.empty() && entry.index == last && !entry.mark) {
            path.steps.back().periods += entry.dwell;
            continue;
        }
        last = entry.index;
        PathStep& step = path.steps.emplace_back();
        step.periods = entry.dwell;
        step.mark = entry.mark;
        if (entry.index == 0) continue;
        const RecordMeaning& record = bundle.manifest.records.at(place_of(bundle.image, entry.index).value());
        step.foci = record.foci;
        for (Focus& focus : step.foci) focus.amplitude *= record.amplitude;
    }
    return path;
}

}  // namespace haptogram
