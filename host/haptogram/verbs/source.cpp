// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <utility>

#include "haptogram/array/rig.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/text.hpp"
#include "haptogram/format/pulses.hpp"
#include "haptogram/format/rig_bundle.hpp"
#include "haptogram/shape/import.hpp"
#include "haptogram/shape/path_file.hpp"
#include "haptogram/solve/segments.hpp"
#include "haptogram/verbs/compile.hpp"
#include "haptogram/verbs/rig.hpp"

namespace haptogram {
namespace {

enum class FileKind { image, rig, project, path, shape, manifest };

FileKind kind_of_csv(const std::string& file) {
    const std::string text = read_file(file);
    if (is_pulses_csv(text))
        throw bad_argument("pulses",
                           fmt::format("{} has measured pulses: field, analyze, feel and report take them with "
                                       "--pulses and --manifest; for anything else name the image that was "
                                       "played",
                                       file));
    return is_path_csv(text) ? FileKind::path : FileKind::shape;
}

FileKind kind_of_json(const std::string& file) {
    const std::string text = read_file(file);
    if (is_rig_manifest(text)) return FileKind::rig;
    return is_path_json(text) ? FileKind::path : FileKind::manifest;
}

FileKind kind_of(const std::string& file) {
    const std::string ending = ending_of(file);
    if (is_project(file)) return FileKind::project;
    if (ending == ".json") return kind_of_json(file);
    if (ending == ".csv") return kind_of_csv(file);
    if (ending == ".adaptics") return FileKind::path;
    return has_shape_ending(file) ? FileKind::shape : FileKind::image;
}

/// What has an array and a board of its own must be for those that a user names.
void require_made_for(const Source& source, const Manifest& manifest, const std::string& name) {
    if (!source.array && !source.board) return;
    const Array array = source.array ? find_array(*source.array) : manifest.array;
    const Core core = source.board ? find_core(*source.board) : core_of_array(array.file);
    const Array& other = manifest.array;
    const interface::CoreParameters& a = core.parameters;
    const interface::CoreParameters& b = manifest.core.parameters;
    const auto near = [](double p, double q) { return std::abs(p - q) <= 1e-6 * std::abs(q); };
    const auto same_place = [](const Element& p, const Element& q) {
        return distance(p, q.position) < 1e-6 && distance(p.normal, q.normal) < 1e-6 &&
               std::abs(p.response - q.response) < 1e-6 && std::abs(p.weight - q.weight) < 1e-6;
    };
    if (near(array.medium.speed_m_s, other.medium.speed_m_s) && near(array.duty, other.duty) &&
        near(array.transducer.radius_m, other.transducer.radius_m) && a.channels == b.channels &&
        a.clock_hz == b.clock_hz && array.carrier_hz == other.carrier_hz &&
        std::equal(array.elements.begin(), array.elements.end(), other.elements.begin(), other.elements.end(),
                   same_place))
        return;
    throw bad_input(name,
                    fmt::format("it was compiled for {} ({} elements, {} channels, {} Hz), not for {} ({} elements, {} "
                                "channels, {} Hz); compile it for {}",
                                other.name, other.elements.size(), b.channels, b.clock_hz, array.name,
                                array.elements.size(), a.channels, a.clock_hz, array.name),
                    {source.array ? "array" : "board"});
}

/// A path or a shape, with every other setting at its default.
Project project_of(const Source& source, FileKind kind) {
    Project project;
    project.array = source.array;
    project.board = source.board;
    if (kind == FileKind::path) {
        project.path = source.file;
        return project;
    }
    ShapeSource shape;
    shape.file = source.file;
    project.shapes = {shape};
    return project;
}

Bundle open_bundle(const Source& source, FileKind kind, const Progress& progress) {
    if (!source.manifest.empty() && kind != FileKind::image)
        throw bad_argument("manifest",
                           fmt::format("{} has or makes its own; give one only with an image", source.file));
    if (kind == FileKind::manifest)
        throw bad_argument("image",
                           fmt::format("{} is a manifest, which says what its image makes, but not with what pulses; "
                                       "name the image",
                                       source.file));
    Bundle bundle;
    if (kind == FileKind::image) {
        bundle = load_bundle(source.file, source.manifest);
    } else if (kind == FileKind::rig) {
        bundle = load_rig_bundle(source.file).whole;
    } else {
        const bool is_whole = kind == FileKind::project;
        Project project = is_whole ? load_project(source.file) : project_of(source, kind);
        project.makers = source.makers;
        const Compiled compiled = compile(project, source.file, progress);
        // Through the manifest's text, which rounds, so that a project gives the same numbers as its image does.
        bundle = bundle_of(compiled.bundle.hex, manifest_from_json(to_text(compiled.bundle.manifest), source.file),
                           source.file, source.file);
        if (!is_whole) return bundle;
    }
    require_made_for(source, bundle.manifest, source.file);
    return bundle;
}

/// Of an image, or of a rig's images as one.
Manifest manifest_of(const std::string& file) {
    const std::string text = read_file(file);
    return is_rig_manifest(text) ? load_rig_bundle(file).whole.manifest : manifest_from_json(text, file);
}

Timeline open_focus(const Source& source) {
    Timeline timeline;
    if (source.rig.empty()) {
        const Array array = find_array(source.array.value_or("tile-10x10"));
        const Core core = source.board ? find_core(*source.board) : core_of_array(array.file);
        timeline = timeline_of(array, core, *source.focus);
    } else {
        const Rig rig = find_rig(source.rig);
        timeline = timeline_of(joined(rig), cores_of(rig, source.board).front(), *source.focus);
    }
    if (!source.quantise.empty()) {
        timeline.segments = source.quantise;
        timeline.title += fmt::format(", in the segments of {}", segments_of(source.quantise).name);
    }
    return timeline;
}

}  // namespace

bool is_source_file(const std::string& file) {
    const std::string ending = ending_of(file);
    if (ending == ".csv") return kind_of_csv(file) == FileKind::path;
    return is_project(file) || has_shape_ending(file) || ending == ".hex" || ending == ".json" || ending == ".adaptics";
}

bool is_path_file(const std::string& file) { return kind_of(file) == FileKind::path; }

bool is_rig_file(const std::string& file) { return file.ends_with(".json") && is_rig_manifest(read_file(file)); }

Bundle open_bundle(const Source& source, const Progress& progress) {
    if (source.file.empty())
        throw bad_argument("image", source.pulses.empty()
                                        ? "there is no image: give an image, a project, a path, a shape or a rig"
                                        : "pulses have no image; name the image that was played");
    return open_bundle(source, kind_of(source.file), progress);
}

std::string open_hex(const std::string& file, const PathMakers& makers, const Progress& progress) {
    const FileKind kind = kind_of(file);
    if (kind == FileKind::image) return read_file(file);
    Source source;
    source.file = file;
    source.makers = makers;
    return open_bundle(source, kind, progress).hex;
}

std::optional<std::uint32_t> likely_rate(const std::string& file) {
    const FileKind kind = kind_of(file);
    try {
        if (kind == FileKind::project) return instrument_of(load_project(file)).core.parameters.baud;
        if (kind == FileKind::image && file != "-") return load_bundle(file).manifest.core.parameters.baud;
    } catch (const Error&) {  // an image needs no manifest, and what is wrong with a project its compiler says
    }
    return {};
}

Timeline open_timeline(const Source& source, const Progress& progress) {
    const int named = (source.file.empty() ? 0 : 1) + (source.focus ? 1 : 0) + (source.pulses.empty() ? 0 : 1);
    if (named != 1)
        throw bad_argument("image",
                           named == 0 ? "there is nothing to work on: give an image, a project, a path, a shape, a "
                                        "rig's manifest, a focal point, or pulses"
                                      : "give one of a file, a focal point and pulses",
                           {"focus", "pulses"});
    if (source.focus) return open_focus(source);
    if (!source.pulses.empty()) {
        const Manifest manifest = manifest_of(source.manifest);
        require_made_for(source, manifest, source.manifest);
        return timeline_of(manifest, pulses_from_csv(read_file(source.pulses), source.pulses), source.pulses);
    }
    const FileKind kind = kind_of(source.file);
    if (kind != FileKind::manifest) return timeline_of(open_bundle(source, kind, progress));
    const Manifest manifest = manifest_of(source.file);
    require_made_for(source, manifest, source.file);
    return timeline_of(manifest, source.file);
}

Vec3 parse_three(const std::string& setting, const std::string& text, std::string_view unit) {
    constexpr double most = 1e6;  // a kilometre of millimetres
    Vec3 point{};
    const char* at = text.data();
    const char* const end = at + text.size();
    for (double* const axis : {&point.x, &point.y, &point.z}) {
        double value = 0.0;
        const auto [next, error] = std::from_chars(at, end, value);
        const bool last = axis == &point.z;
        if (error == std::errc() && std::abs(value) > most)
            throw bad_argument(setting, fmt::format("found {} {}, expected at most {}{}", value, unit, most,
                                                    unit == "mm" ? ", a kilometre" : ""));
        if (error != std::errc() || !std::isfinite(value) || (last ? next != end : next == end || *next != ','))
            throw bad_argument(setting, fmt::format("expected x,y,z in {}, found '{}'", unit, text));
        *axis = value;
        at = next + 1;
    }
    return point;
}

Vec3 parse_point_mm(const std::string& setting, const std::string& text) {
    return parse_three(setting, text, "mm") * millimetre;
}

}  // namespace haptogram
