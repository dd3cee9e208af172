// SPDX-License-Identifier: Apache-2.0
#include "scenes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <optional>

#include "failure.hpp"
#include "haptogram/acoustics/quantities.hpp"
#include "haptogram/array/calibration.hpp"
#include "haptogram/base/bundle.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/hand/recording.hpp"
#include "haptogram/perception/feel.hpp"
#include "haptogram/shape/import.hpp"
#include "haptogram/verbs/compile_numbers.hpp"
#include "haptogram/verbs/document.hpp"
#include "haptogram/verbs/level.hpp"
#include "ways_out.hpp"
#ifdef HAPTOGRAM_HAS_FORMATS
#include "haptogram/formats/readers.hpp"
#endif

namespace haptogram::studio {
namespace {

using nlohmann::ordered_json;

ordered_json millimetres(Vec3 point) { return {point.x / millimetre, point.y / millimetre, point.z / millimetre}; }

bool names_file(const std::string& name) { return name.ends_with(".toml") || name.find('/') != std::string::npos; }

/// A file of a project in parts of its name, none of which leads out of the project's folder.
bool stays_inside(const std::string& name) {
    const std::filesystem::path path(name);
    return path.is_relative() && path.has_filename() &&
           std::ranges::none_of(path, [](const auto& part) { return part.empty() || part.string().front() == '.'; });
}

/// The array file that another array file names, if that is a calibration, as a project names it that names the other.
std::optional<std::string> array_of(const std::string& name, const std::string& content) {
    const auto array = array_named_in(content);
    if (!array) return {};
    return (std::filesystem::path(name).parent_path() / *array).lexically_normal().generic_string();
}

/// What only the studio's other readers know the kind of.
bool is_read_by_name(const std::string& name) {
    const std::string ending = ending_of(name);
    return ending == ".toml" || ending == ".wav" || ending == ".csv" || ending == ".json" || ending == ".adaptics";
}

/// What plays one after the other: the record, counted from 1, its index on the board, where its first focus is, from
/// when and how long, and its amplitude. Silence is left out, and entries of one record in a row are one.
ordered_json tour_of(const Bundle& bundle) {
    const Manifest& manifest = bundle.manifest;
    ordered_json tour = ordered_json::array();
    std::uint64_t now = 0, from = 0;
    const std::vector<SequenceEntry>& sequence = bundle.image.sequence;
    for (std::size_t i = 0; i < sequence.size(); ++i) {
        now += sequence[i].dwell;
        const std::uint16_t index = sequence[i].index;
        if (i + 1 < sequence.size() && sequence[i + 1].index == index) continue;
        if (index != 0) {
            const std::size_t place = manifest.place_of(index).value();
            const RecordMeaning& record = manifest.records[place];
            const double period_s = manifest.timer.period_s();
            tour.push_back({{"record", place + 1},
                            {"index", index},
                            {"at", millimetres(record.foci.front().position)},
                            {"from_s", static_cast<double>(from) * period_s},
                            {"dwell_s", static_cast<double>(now - from) * period_s},
                            {"amplitude", record.amplitude}});
        }
        from = now;
    }
    return tour;
}

}  // namespace

ordered_json to_json(const Array& array) {
    ordered_json elements = ordered_json::array();
    for (const Element& element : array.elements) elements.push_back(millimetres(element.position));
    return {{"name", array.name}, {"radius_mm", array.transducer.radius_m / millimetre}, {"elements", elements}};
}

ordered_json to_json(const Scene& scene) {
    const Compiled& c = scene.compiled;
    const Manifest& m = c.bundle.manifest;
    ordered_json foci = ordered_json::array();
    for (const PathStep& step : c.path.steps)
        for (const Focus& focus : step.foci) foci.push_back(millimetres(focus.position));
    ordered_json findings = ordered_json::array();
    for (const Finding& finding : findings_of(scene.settings, c)) findings.push_back(to_json(finding));
    ordered_json triggers = ordered_json::array();
    for (const TriggeredPart& part : c.parts)
        triggers.push_back(
            {{"first", part.first}, {"length", part.length}, {"loops", part.loops}, {"pin", part.by_pin}});
    return {{"name", scene.name},        {"array", to_json(m.array)},      {"foci", foci},
            {"tour", tour_of(c.bundle)}, {"pass_s", 1.0 / m.rate_hz},      {"channels", m.core.parameters.channels},
            {"numbers", numbers_of(c)},  {"image_sha256", m.image_sha256}, {"findings", findings},
            {"triggers", triggers}};
}

ordered_json drives_json(const Scene& scene, std::uint32_t record) {
    if (record < 1 || record > scene.compiled.bundle.manifest.records.size())
        throw bad_argument("record", fmt::format("{} is no record; the scene has 1 to {}", record,
                                                 scene.compiled.bundle.manifest.records.size()));
    const double full = scene.excitation.array.transducer.source_pa_m;
    ordered_json phases = ordered_json::array(), amplitudes = ordered_json::array();
    for (const std::complex<double>& drive : scene.excitation.drives[record - 1]) {
        const double degrees = std::arg(drive) * 180.0 / std::numbers::pi;
        phases.push_back(degrees < 0.0 ? degrees + 360.0 : degrees);
        amplitudes.push_back(std::abs(drive) / full);
    }
    return {{"record", record},
            {"index", scene.compiled.bundle.manifest.index_of(record - 1)},
            {"phases_deg", phases},
            {"amplitudes", amplitudes}};
}

namespace {

/// Of what a hand feels, the places that were looked at and how far each is over what is just felt; null is nothing at
/// all.
ordered_json places_json(const Feeling& feeling) {
    const auto decibels = [](double value) { return std::isfinite(value) ? ordered_json(value) : ordered_json(); };
    ordered_json places = ordered_json::array();
    for (const FeltPlace& place : feeling.places) {
        const Vec3& at = place.place.position;
        places.push_back({{"at", {at.x / millimetre, at.y / millimetre, at.z / millimetre}},
                          {"over_db", decibels(place.verdict.over_db)},
                          {"least_db", decibels(place.verdict.least_db)},
                          {"most_db", decibels(place.verdict.most_db)}});
    }
    return places;
}

}  // namespace

ordered_json analysis_json(const Scene& scene, const ImageAnalysis& analysis) {
    const Compiled& compiled = scene.compiled;
    ordered_json foci = ordered_json::array(), findings = ordered_json::array();
    for (const PointAnalysis& point : analysis.points)
        foci.push_back(
            {{"record", compiled.bundle.manifest.place_of(static_cast<std::uint32_t>(point.record)).value() + 1},
             {"radiation_pa", point.focus.radiation_pa},
             {"width_mm", point.focus.width_m / millimetre},
             {"depth_mm", point.focus.depth_m / millimetre},
             {"side_lobe", point.focus.side_lobe},
             {"force_mn", point.focus.force_n * 1e3}});
    for (const Finding& finding : findings_of(scene.settings, compiled, analysis)) findings.push_back(to_json(finding));
    const std::optional<Feeling> feeling = feeling_at_foci(timeline_of(compiled.bundle));
    return {{"level", level_json(compiled.bundle.manifest.array.transducer)},
            {"foci", foci},
            {"places", feeling ? places_json(*feeling) : ordered_json::array()},
            {"at_300_mm_db", analysis.loudness.at_300_mm_db},
            {"most_at_300_mm_db", recommended_for_ears_db},
            {"verdict", verdict_on(feeling)},
            {"findings", findings}};
}

void Scenes::open(const std::filesystem::path& path) {
    if (const std::string ending = ending_of(path); ending != ".csv" && has_shape_ending(path.string())) {
        const std::string name = path.filename().string();
        add_file(name, read_file(path));
        const std::lock_guard lock(mutex_);
        first_ = {{"format", "haptogram-project-1"},
                  {"place", {{"size_mm", 60}, {"center_mm", {0, 0, 130}}}},
                  {"shape", {{{"file", name}}}}};
        return;
    }
    const std::filesystem::path named = project_file(path);
    const std::string text = read_file(named);
    Project project = load_project(path);
    std::map<std::string, File> files;
    const auto take = [&](const std::string& file) {
        std::string content = read_file(named_in(project.folder, file));
        std::string hash = sha256(content);
        files[file] = {std::move(content), std::move(hash)};
    };
    for (const std::string& file : files_of(project)) take(file);
    if (project.array && files.contains(*project.array))
        if (const auto behind = array_of(*project.array, files[*project.array].content)) take(*behind);
    ordered_json document = document_of(text, named.string());
    const std::lock_guard lock(mutex_);
    files_.merge(files);
    opened_ = std::move(project);
    first_ = std::move(document);
}

ordered_json Scenes::first_document() const {
    const std::lock_guard lock(mutex_);
    if (!first_.is_null()) return first_;
    return document_of("format = \"haptogram-project-1\"\nrate_hz = 7\n\n[[shape]]\nkind = \"hemisphere\"\n",
                       "example");
}

void Scenes::add_file(const std::string& name, std::string content) {
    const bool plain = std::none_of(name.begin(), name.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; });
    if (name.empty() || name.size() > 100 || !plain || !stays_inside(name))
        throw bad_input("name",
                        "a file's name has 1 to 100 bytes, stays in the project's folder, and has no dot in front; "
                        "rename the file");
    const bool by_name = is_read_by_name(name);
    if (!by_name && !name.ends_with(".lz") && !name.ends_with(".pose")) (void)shape_format(name);
    std::string hash = sha256(content);
    const std::lock_guard lock(mutex_);
    std::size_t total = content.size();
    for (const auto& [other, kept] : files_) total += other == name ? 0 : kept.content.size();
    if (total > most_file_bytes)
        throw bad_input(name, fmt::format("all files together would have {} bytes, and the studio keeps {}; start it "
                                          "again",
                                          total, most_file_bytes));
    if (by_name) {
        const std::filesystem::path place = sent_ / name;
        std::filesystem::create_directories(place.parent_path());
        write_file(place, content);
    }
    files_[name] = {std::move(content), std::move(hash)};
}

std::string Scenes::file(const std::string& name) const {
    const std::lock_guard lock(mutex_);
    return file_of(name).content;
}

void Scenes::find_file(std::string& name, const std::string& opened, std::string& identity) const {
    const auto known = files_.find(name);
    if (known == files_.end())
        throw bad_input(name,
                        "the studio does not have this file, and the page may name no other of this machine; drop "
                        "it onto the page, or start the studio with a project that names it");
    identity += known->second.hash;
    if (std::filesystem::exists(sent_ / name))
        name = (sent_ / name).string();
    else if (name != opened)
        throw bad_input(name, "the studio was not started with it; drop it onto the page");
}

std::optional<std::string> Scenes::array_behind(const std::string& name) const {
    const auto known = files_.find(name);
    return known == files_.end() ? std::nullopt : array_of(name, known->second.content);
}

std::vector<std::string> Scenes::needed_files(const Project& project) const {
    std::vector<std::string> files = files_of(project);
    const std::lock_guard lock(mutex_);
    if (!project.array || !names_file(*project.array)) return files;
    if (const auto behind = array_behind(*project.array)) files.push_back(*behind);
    return files;
}

Project Scenes::project_of(const std::string& text, std::string& identity) const {
    Project project = project_from_toml(text, "project");
    project.makers = path_makers();
#ifdef HAPTOGRAM_HAS_FORMATS
    project.makers.readers = formats::readers();
#endif
    const std::lock_guard lock(mutex_);
    project.folder = opened_.folder;
    identity = text;
    if (project.array && names_file(*project.array)) {
        if (const auto behind = array_behind(*project.array)) identity += file_of(*behind).hash;
        find_file(*project.array, opened_.array.value_or(""), identity);
    }
    if (project.board && names_file(*project.board)) find_file(*project.board, opened_.board.value_or(""), identity);
    if (!project.path.empty()) find_file(project.path, opened_.path, identity);
    for (const std::string kind : {"wav:", "csv:"}) {
        if (!project.am.starts_with(kind)) continue;
        std::string name = project.am.substr(kind.size());
        find_file(name, opened_.am.starts_with(kind) ? opened_.am.substr(kind.size()) : "", identity);
        project.am = kind + name;
    }
    for (ShapeSource& source : project.shapes) {
        if (source.file.empty()) continue;
        const File& file = file_of(source.file);
        source.content = file.content;
        identity += file.hash;
    }
    return project;
}

const Scenes::File& Scenes::file_of(const std::string& name) const {
    const auto file = files_.find(name);
    if (file == files_.end()) throw bad_input(name, "the studio does not have this file; drop it onto the page again");
    return file->second;
}

std::string Scenes::hash_of(const std::string& name) const {
    const std::lock_guard lock(mutex_);
    return file_of(name).hash;
}

template <class What, class Open>
std::shared_ptr<const What> Scenes::opened(Opened<What>& known, const std::string& name, const Open& open) {
    {
        const std::lock_guard lock(mutex_);
        const auto found =
            std::find_if(known.begin(), known.end(), [&](const auto& each) { return each.first == name; });
        if (found != known.end()) {
            known.splice(known.begin(), known, found);
            return known.front().second;
        }
    }
    // Not under the lock: it may take long. Two that open the same at once each make it, and one of them is kept.
    auto made = std::make_shared<const What>(open());
    const std::lock_guard lock(mutex_);
    std::erase_if(known, [&](const auto& each) { return each.first == name; });
    known.emplace_front(name, made);
    if (known.size() > most_opened) known.pop_back();
    return made;
}

/// @param identity  gets the hashes of its files
std::shared_ptr<const DrawnObject> Scenes::open_hand(Project& project, std::string& identity) {
    HandSource& hand = *project.hand;
    hand.object.readers = project.makers.readers;
    std::string hashes;
    for (const std::string& file : files_of(hand)) hashes += hash_of(file);
    identity += hashes;
    const FileReader read = [this](const std::filesystem::path& file) {
        const std::lock_guard lock(mutex_);
        return file_of(file.string()).content;
    };
    hand.hands = opened(hands_, fmt::format("{} {} {} {}", hand.recording, hand.model, hand.rate_hz, hashes),
                        [&] { return open_hands(hand.recording, hand.model, hand.rate_hz, read); });
    Project alone;  // so that its text is of the object alone
    alone.hand.emplace().object = hand.object;
    const std::string name =
        sha256(to_toml(alone) + (names_mesh(hand.object) ? hash_of(hand.object.name) : "")).substr(0, 28);
    auto object = opened(objects_, name, [&] {
        return DrawnObject{name, std::make_shared<const TouchObject>(open_object(hand.object, read)),
                           surface_of(hand.object, read)};
    });
    hand.touched = object->touched;
    return object;
}

HandScene Scenes::hand(const ordered_json& document) {
    std::string identity;
    HandScene scene{project_of(toml_of(document), identity), {}, {}};
    if (!scene.project.hand) throw bad_input("hand", "the project has none; add a [hand]");
    scene.object = open_hand(scene.project, identity);
    scene.instrument = instrument_of(scene.project);
    return scene;
}

Made Scenes::compile(const ordered_json& document) {
    std::string identity;
    Project project = project_of(toml_of(document), identity);
    if (project.hand) (void)open_hand(project, identity);
    const std::string name = sha256(identity).substr(0, 28);
    std::shared_ptr<const Scene> found;
    {
        const std::lock_guard lock(mutex_);
        const auto known = std::find_if(scenes_.begin(), scenes_.end(), [&](const auto& s) { return s->name == name; });
        if (known != scenes_.end()) {
            scenes_.splice(scenes_.begin(), scenes_, known);
            found = scenes_.front();
        }
    }
    if (found) return {found, shape_of(project)};
    Shape shape;
    Compiled compiled = haptogram::compile(project, "image.hex", {}, &shape);
    Excitation excitation = excitation_of(timeline_of(compiled.bundle));
    Project named = project;
    for (ShapeSource& source : named.shapes) source.content.reset();
    if (named.hand) {
        named.hand->hands.reset();
        named.hand->touched.reset();
    }
    // With the names that the page has for its files.
    const std::string text = to_toml(project_from_toml(toml_of(document), "project"));
    // A complex amplitude of √2 Pa is a mean square of 1 Pa².
    const double skin = radiation_pressure(std::sqrt(2.0), compiled.bundle.manifest.array.medium);
    const auto scene = std::make_shared<const Scene>(
        Scene{name, text, std::move(named), std::move(compiled), std::move(excitation), skin});
    const std::lock_guard lock(mutex_);
    scenes_.push_front(scene);
    if (scenes_.size() > most_scenes) scenes_.pop_back();
    return {scene, std::move(shape)};
}

ordered_json Scenes::sizes_of_files(const ordered_json& document) {
    std::string identity;
    const Project project = project_of(toml_of(document), identity);
    ordered_json sizes = ordered_json::array();
    for (const ShapeSource& source : project.shapes) {
        if (source.file.empty()) continue;
        const std::string hash = hash_of(source.file);
        ordered_json size;
        {
            const std::lock_guard lock(mutex_);
            size = sizes_[hash];
        }
        if (size.is_null()) {
            // Not under the lock: it may take long.
            const Shape shape = load_shape({*source.content, source.file, false}, shape_format(source.file), millimetre,
                                           project.makers.readers);
            size = {{"extent", millimetres(bounding_box(shape).extent())}, {"own_unit", shape.has_own_unit}};
            const std::lock_guard lock(mutex_);
            sizes_[hash] = size;
        }
        size["name"] = source.file;
        sizes.push_back(std::move(size));
    }
    return sizes;
}

std::vector<Remedy> Scenes::ways_out(const ordered_json& document, const std::function<bool()>& over) {
    const auto opened = [this](const ordered_json& of) {
        std::string identity;
        Project project = project_of(toml_of(of), identity);
        if (project.hand) (void)open_hand(project, identity);
        return project;
    };
    if (error_of([&] { (void)opened(document); })) return {};  // what cannot be read is not mended by other numbers
    std::vector<std::string> named;
    try {
        (void)haptogram::compile(opened(document), "image.hex");
    } catch (const Error& error) {
        named = error.remedies();
    }
    const auto can_be_made = [&](const ordered_json& changed) {
        return !over() && !error_of([&] { (void)haptogram::compile(opened(changed), "image.hex"); });
    };
    return studio::ways_out(document, can_be_made, named);
}

std::shared_ptr<const Scene> Scenes::find(const std::string& name) {
    const std::lock_guard lock(mutex_);
    const auto known = std::find_if(scenes_.begin(), scenes_.end(), [&](const auto& s) { return s->name == name; });
    if (known != scenes_.end()) {
        scenes_.splice(scenes_.begin(), scenes_, known);
        return scenes_.front();
    }
    throw bad_argument("scene", fmt::format("there is no scene '{}' any more; send its document again", name));
}

}  // namespace haptogram::studio
