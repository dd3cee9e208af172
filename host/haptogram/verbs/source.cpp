// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/source.hpp"

#include <fmt/format.h>

#include <charconv>
#include <utility>

#include "haptogram/array/rig.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/format/rig_bundle.hpp"
#include "haptogram/verbs/compile.hpp"

namespace haptogram {

Bundle open_bundle(const std::string& path, const std::string& manifest, const Progress& progress) {
    if (!is_project(path)) return load_bundle(path, manifest);
    if (!manifest.empty()) throw bad_argument("manifest", "a project makes its own; give one only with an image");
    const Compiled compiled = compile(load_project(path), path, progress);
    // Through the manifest's text, which rounds, so that a project gives the same numbers as its image does.
    return bundle_of(compiled.bundle.hex, manifest_from_json(to_text(compiled.bundle.manifest), path), path, path);
}

std::string open_hex(const std::string& path, const Progress& progress) {
    return is_project(path) ? compile(load_project(path), path, progress).bundle.hex : read_file(path);
}

Excitation open_excitation(const Source& source, const Progress& progress) {
    if (source.focus) {
        const Array array = source.rig.empty() ? find_array(source.array) : joined(find_rig(source.rig));
        const Excitation exact = excitation_of(array, *source.focus);
        return source.quantise.empty() ? exact : in_segments(exact, segments_of(source.quantise));
    }
    if (!source.image.empty()) {
        if (source.image.ends_with(".json")) {
            const std::string text = read_file(source.image);
            if (is_rig_manifest(text)) return excitation_of(load_rig_bundle(source.image).whole, source.record);
            return excitation_of(manifest_from_json(text, source.image), source.image, source.record);
        }
        return excitation_of(open_bundle(source.image, source.manifest, progress), source.record);
    }
    if (source.pulses.empty())
        throw bad_argument("image", "there is nothing to work on: give an image, a project, a focal point, or pulses",
                           {"focus", "pulses"});
    const Manifest manifest = manifest_from_json(read_file(source.manifest), source.manifest);
    return excitation_of(manifest, pulses_from_csv(read_file(source.pulses), source.pulses), source.pulses);
}

Vec3 parse_point_mm(const std::string& setting, const std::string& text) {
    Vec3 point{};
    const char* at = text.data();
    const char* const end = at + text.size();
    for (double* const axis : {&point.x, &point.y, &point.z}) {
        double value = 0.0;
        const auto [next, error] = std::from_chars(at, end, value);
        const bool last = axis == &point.z;
        if (error != std::errc() || !std::isfinite(value) || (last ? next != end : next == end || *next != ','))
            throw bad_argument(setting, fmt::format("expected x,y,z in mm, found '{}'", text));
        *axis = value * millimetre;
        at = next + 1;
    }
    return point;
}

}  // namespace haptogram
