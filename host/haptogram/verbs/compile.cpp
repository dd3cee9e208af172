// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/compile.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/format/board.hpp"
#include "haptogram/format/schedule.hpp"
#include "haptogram/shape/import.hpp"
#include "haptogram/shape/path_file.hpp"
#include "haptogram/shape/place.hpp"
#include "haptogram/solve/drives.hpp"
#include "haptogram/solve/segments.hpp"
#include "haptogram/verbs/focus_image.hpp"

namespace haptogram {
namespace {

constexpr std::uint32_t most_dwell = interface::sequence_entry_field::dwell.most();
constexpr std::size_t most_record_samples = 4096;  // of a modulation that becomes records

/// A shape file's shape, standing.
/// @param name  of the file, "-" for standard input @param warnings  gets what is odd about it and does no harm
Shape load(const ShapeSource& source, const ShapeFile& file, const ShapeReaders& readers,
           std::vector<std::string>& warnings) {
    const auto& [content, name, on_disk] = file;
    const ShapeFormat format = name == "-" ? shape_format(content, name) : shape_format(name);
    Shape shape = load_shape(file, format, metres_per_unit(source.unit), readers);
    if (const auto* const mesh = std::get_if<Mesh>(&shape.pieces.front()); mesh != nullptr && !mesh->flaw.empty())
        warnings.push_back(fmt::format("{}: {}", name, mesh->flaw));
    for (const std::string& remark : shape.remarks) warnings.push_back(fmt::format("{}: {}", name, remark));
    if (!source.up && format == ShapeFormat::obj && has_y_up_by_habit(content))
        warnings.push_back(
            fmt::format("{}: the program that wrote it mostly has y upwards, and z is taken to be; say "
                        "--up y if the shape lies on its back, or --up z",
                        name));
    const bool is_gltf = format == ShapeFormat::gltf;
    if (is_gltf && source.up == "z")
        throw bad_argument(
            "up", fmt::format("is y in every glTF file, as {} is; leave it out, and turn a file that is wrong", name),
            {"rotate"});
    if (is_gltf && !source.up)
        warnings.push_back(fmt::format("{}: y is up in glTF, and z here: (x, y, z) became (x, -z, y)", name));
    return is_gltf || source.up == "y" ? stood_up(std::move(shape)) : shape;
}

/// Below this a shape is a speck, much smaller than a focus, and more likely in another unit.
constexpr double speck_m = 5e-3;

/// Says so of a shape, and, of a file in a unit that may be another, in which units it would be no speck.
void warn_of_speck(const Shape& shape, const std::string& name, bool in_a_unit, std::vector<std::string>& warnings) {
    const Vec3 extent = bounding_box(shape).extent();
    const double wide_m = std::max({extent.x, extent.y, extent.z});
    if (wide_m == 0.0 || wide_m >= speck_m) return;
    std::string units;
    for (const std::string unit : {"cm", "inch", "m"})
        if (const double in_m = wide_m / millimetre * metres_per_unit(unit);
            in_a_unit && in_m >= speck_m && in_m <= 1.0)
            units += (units.empty() ? "is it --unit " : " or --unit ") + unit;
    warnings.push_back(fmt::format(
        "{}: it is {:.3g} mm wide{}", name, wide_m / millimetre,
        units.empty() ? ", much less than a focus; say how large it shall be with --size" : ": " + units + "?"));
}

/// The union of a project's shapes.
/// @param hashes  gets the hash of every file's content
/// @param ends    gets, of each shape, how many pieces there are with it
Shape gather(const Project& project, std::string& hashes, std::vector<std::string>& warnings,
             std::vector<std::size_t>* ends = nullptr) {
    Shape shape;
    for (const ShapeSource& source : project.shapes) {
        Shape part;
        if (source.file.empty() && !source.content) {
            part = make_primitive(source.primitive);
            if (!source.placement.size_m && !project.placement.size_m)
                warn_of_speck(part, source.primitive.kind, false, warnings);
        } else {
            const bool here = source.content || source.file == "-";
            const std::string name = here ? source.file : (project.folder / source.file).string();
            const std::string content = source.content ? *source.content : read_file(name);
            hashes += sha256(content);
            part = load(source, {content, name, !here}, project.makers.readers, warnings);
            if (!part.beside.empty()) hashes += sha256(part.beside);
            const bool scaled = source.placement.size_m || source.placement.scale != 1.0 || project.placement.size_m ||
                                project.placement.scale != 1.0;
            if (source.unit == "mm" && !scaled) warn_of_speck(part, name, !part.has_own_unit, warnings);
        }
        if (source.placement != Placement{}) part = placed_at(part, source.placement);
        std::move(part.pieces.begin(), part.pieces.end(), std::back_inserter(shape.pieces));
        if (ends != nullptr) ends->push_back(shape.pieces.size());
    }
    if (shape.pieces.empty())
        throw bad_argument("shape", fmt::format("there is nothing to compile: give a file, or one of the built-in "
                                                "shapes {}",
                                                fmt::join(primitive_kinds(), ", ")));
    return shape;
}

Placement placement(const Project& project) {
    Placement result = project.placement;
    const bool built_in = std::all_of(project.shapes.begin(), project.shapes.end(), [](const ShapeSource& s) {
        return (s.file.empty() && !s.content) || ending_of(s.file) == ".svg";
    });
    const bool placed = std::any_of(project.shapes.begin(), project.shapes.end(),
                                    [](const ShapeSource& s) { return s.placement.center.has_value(); });
    // This is where the Haptogram paper shows its shapes; a drawing has no height of its own.
    if (!result.center && built_in && !placed) result.center = from_mm(0.0, 0.0, 130.0);
    return result;
}

/// A project's settings as text, for the hash of all inputs. It has no names of files: their contents are hashed
/// instead.
std::string settings_text(Project project) {
    for (ShapeSource& source : project.shapes) {
        source.content.reset();
        if (!source.file.empty()) source.file = "file";
    }
    if (!project.path.empty()) project.path = "file";
    if (project.hand) {
        if (!project.hand->recording.starts_with(synthetic_prefix)) project.hand->recording = "file";
        if (!is_built_in(project.hand->object)) project.hand->object.name = "file";
        project.hand->model.clear();
    }
    project.array.reset();
    project.board.reset();
    project.live.clear();
    // Written apart, because a project file cannot hold the largest seeds.
    const std::uint64_t seed = std::exchange(project.seed, Project{}.seed);
    return fmt::format("{}seed {}\n", to_toml(project), seed);
}

/// Which record each stretch of the path plays, and for how long.
struct RecordedPath {
    std::vector<PathStep> steps;     ///< one a record
    std::vector<double> amplitudes;  ///< factor of the modulation, one a record
    std::vector<SequenceEntry> entries;
};

class PathRecorder {
public:
    PathRecorder(const Path& path, const Timer& timer, const Core& core, const std::optional<Segments>& segments)
        : path_(path), timer_(timer), core_(core), segments_(segments) {}

    RecordedPath make() {
        const std::uint64_t length = path_.periods();
        const auto& samples = path_.modulation.samples;
        const std::uint64_t cycle = samples.size() * path_.modulation.periods_a_sample;
        const std::uint64_t end = samples.empty() ? length : std::lcm(length, cycle);
        std::uint64_t now = 0;
        for (std::size_t step = 0; now < end; step = (step + 1) % path_.steps.size()) {
            const std::uint64_t until = now + path_.steps[step].periods;
            bool mark = path_.steps[step].mark;  // of its first entry
            while (now < until) {
                std::uint64_t next = until;
                double factor = 1.0;
                if (!samples.empty()) {
                    const std::uint64_t at = now / path_.modulation.periods_a_sample;
                    factor = samples[at % samples.size()];
                    next = std::min(until, (at + 1) * path_.modulation.periods_a_sample);
                }
                const std::uint16_t index = record_of(path_.steps[step], factor);
                if (!samples.empty() && index == waiting_index_ && !mark) {  // samples that round to the same pulse
                    waiting_ += next - now;
                } else {
                    play_waiting();
                    waiting_index_ = index;
                    waiting_ = next - now;
                    waiting_mark_ = std::exchange(mark, false);
                }
                now = next;
            }
        }
        play_waiting();
        return std::move(recorded_);
    }

private:
    /// Index of the record with these foci at this strength, made when there is none yet; 0 for silence.
    std::uint16_t record_of(const PathStep& step, double factor) {
        double largest = 0.0;
        for (const Focus& focus : step.foci) largest = std::max(largest, focus.amplitude);
        std::uint32_t pulse = pulse_ticks(timer_, largest * factor);
        if (segments_) pulse = length_in_segments(pulse, timer_, *segments_);
        if (pulse == 0) return 0;
        std::string key(reinterpret_cast<const char*>(step.foci.data()), step.foci.size() * sizeof(Focus));
        key += fmt::format(" {}", pulse);
        const auto [entry, fresh] = records_.try_emplace(key, recorded_.steps.size() + 1);
        if (fresh) {
            recorded_.steps.push_back(step);
            recorded_.amplitudes.push_back(factor);
            if (recorded_.steps.size() > core_.parameters.records)
                throw bad_input(core_.name,
                                fmt::format("the path needs more records than the board's {}: every set of foci, and "
                                            "every strength of it, is one; take fewer points or a coarser modulation",
                                            core_.parameters.records),
                                {"points", "board", "array"});
        }
        return static_cast<std::uint16_t>(entry->second);
    }

    void play_waiting() {
        auto& entries = recorded_.entries;
        for (std::uint64_t periods = waiting_; periods > 0;) {
            const auto dwell = static_cast<std::uint16_t>(std::min<std::uint64_t>(periods, most_dwell));
            if (entries.size() + 1 >= core_.parameters.sequence_depth && path_.steps.size() == 1 &&
                !path_.modulation.samples.empty())
                throw bad_input(
                    core_.name,
                    fmt::format(
                        "the modulation lasts {:.3g} s, and the board's {} sequence entries hold {:.3g} s of it; take "
                        "a shorter or coarser one, or a board with a memory for it, such as tile-100-wide",
                        static_cast<double>(path_.modulation.samples.size()) * path_.modulation.periods_a_sample /
                            timer_.carrier_hz(),
                        core_.parameters.sequence_depth - 1,
                        static_cast<double>(recorded_periods_) / timer_.carrier_hz()),
                    {"am", "board", "array"});
            if (entries.size() + 1 >= core_.parameters.sequence_depth)
                throw bad_input(core_.name,
                                fmt::format("the path needs more sequence entries than the board's {}; take fewer "
                                            "points or a coarser modulation",
                                            core_.parameters.sequence_depth - 1),
                                {"points", "board", "array"});
            entries.push_back({waiting_index_, dwell, std::exchange(waiting_mark_, false)});
            periods -= dwell;
            recorded_periods_ += dwell;
        }
    }

    const Path& path_;
    const Timer& timer_;
    const Core& core_;
    const std::optional<Segments>& segments_;
    std::uint16_t waiting_index_ = 0;  ///< of the next entry, which may still grow
    std::uint64_t waiting_ = 0, recorded_periods_ = 0;
    bool waiting_mark_ = false;
    RecordedPath recorded_;
    std::map<std::string, std::size_t> records_;
};

/// A project's shapes where they are, and which pieces are of which.
struct PlacedShapes {
    Shape whole;
    std::vector<std::size_t> ends;

    void add(Shape& shape, std::size_t i) const {
        for (std::size_t k = i == 0 ? 0 : ends[i - 1]; k < ends[i]; ++k) shape.pieces.push_back(whole.pieces[k]);
    }
};

/// What the focus goes through at first: the shapes that no key frame names, or, when all are named, that of the first.
Shape own_shape(const Project& project, const PlacedShapes& placed) {
    const std::vector<KeyFrame>& frames = project.key_frames;
    Shape own;
    for (std::size_t i = 0; i < placed.ends.size(); ++i)
        if (std::ranges::find(frames, i + 1, &KeyFrame::shape) == frames.end()) placed.add(own, i);
    if (!own.pieces.empty()) return own;
    if (const auto none = std::ranges::find(frames, 0U, &KeyFrame::shape); none != frames.end())
        throw bad_argument("keyframe",
                           fmt::format("key frame {} names no shape, and all shapes are named by others; name "
                                       "one there, too, or add the shape that it has of itself",
                                       none - frames.begin() + 1));
    placed.add(own, frames.front().shape - 1);
    return own;
}

/// @param pass  over the shape itself, whose centre is given
/// @param warnings  gets what is left out of the shapes that key frames name
Path with_key_frames(const Project& project, const Path& pass, Vec3 centre, const PlacedShapes& placed,
                     const Array& array, double carrier_hz, ShapePathOptions options, std::size_t most_steps,
                     std::vector<std::string>& warnings) {
    std::vector<Vec3> foci;
    for (const PathStep& step : pass.steps)
        for (const Focus& focus : step.foci) foci.push_back(focus.position);
    options.points = foci.size();
    Forms forms;
    for (const KeyFrame& frame : project.key_frames) {
        if (frame.shape == 0 || forms.contains(frame.shape)) continue;
        Shape shape;
        placed.add(shape, frame.shape - 1);
        const TouredPoints tour = tour_of(shape, array, options);
        if (tour.clipped > 0)
            warnings.push_back(
                fmt::format("shape {}, which the key frames name: {} points are out of reach and left out", frame.shape,
                            tour.clipped));
        forms.emplace(frame.shape, matched(foci, tour.points));
    }
    Path path = moved_by(project.key_frames, pass, centre, carrier_hz, most_steps, forms);
    require_reachable(path, array);
    return path;
}

/// Draws a shape's curves, or, when it has surfaces or clouds, visits its points in a short tour.
Drawing drawing_of(const Project& project, const Shape& shape, const Array& array, double carrier_hz,
                   const ShapePathOptions& options) {
    std::vector<Curve> curves;
    for (const Piece& piece : shape.pieces)
        if (const Curve* const curve = std::get_if<Curve>(&piece)) curves.push_back(*curve);
    if (curves.size() < shape.pieces.size())
        return drawing_of(tour_of(shape, array, options), carrier_hz, project.pace);
    return drawing_of(curve_tour(curves), array, carrier_hz, project.pace, project.jump, options);
}

/// The path that a project names.
/// @throws Error{bad_input} also when the array cannot reach a focus
Path path_in_file(const Project& project, const Array& array, double carrier_hz, std::string& hash,
                  std::vector<std::string>& warnings) {
    if (!project.shapes.empty())
        throw bad_argument("path", "a path file has its own places; give either shapes or a path");
    if (project.placement != Placement{} || project.clip || project.fade || project.pace.speed_m_s ||
        project.pace.frequency_hz)
        throw bad_argument("path",
                           "a path file has its own places and times; scale, size, rotate, center, clip, fade, "
                           "speed and frequency are for shapes");
    const std::string name = (project.folder / project.path).string();
    const std::string text = read_file(name);
    hash = sha256(text);
    Path path;
    if (ending_of(name) == ".adaptics") {
        if (!project.makers.of_pattern)
            throw bad_argument("path", "nothing here reads AdapTics patterns; give verbs/pattern.hpp as a maker");
        RenderedPath rendered = project.makers.of_pattern(project, text, name, carrier_hz);
        path = std::move(rendered.path);
        warnings = std::move(rendered.warnings);
    } else {
        path = path_of_file(text, name, carrier_hz);
    }
    require_reachable(path, array);
    return path;
}

/// What a project's hand feels, as `haptogram render` writes it and compile reads it, so that both ways lead to the
/// same image.
/// @param hash  gets that of the path
Path path_of_hand(const Project& project, const ProjectInstrument& instrument, double carrier_hz, std::string& hash,
                  std::vector<std::string>& warnings, std::optional<PathMagnitude>& magnitude) {
    if (!project.shapes.empty() || project.placement != Placement{} || project.clip || project.even || project.fade)
        throw bad_argument("hand",
                           "what a hand feels has its own places; leave out shapes, scale, size, rotate, "
                           "center, clip, even and fade");
    if (!project.makers.of_hand) throw bad_argument("hand", "this build plays no hands; build with the extra hands");
    RenderedPath rendered = project.makers.of_hand(project, instrument);
    const std::string text = to_json_text(rendered.path, rendered.carrier_hz);
    hash += sha256(text);
    warnings = std::move(rendered.warnings);
    magnitude = rendered.magnitude;
    Path path = path_from_json(text, "what the hand feels", carrier_hz);
    require_reachable(path, instrument.array);
    return path;
}

/// Chooses dwells that make all points feel alike, a third of the given ones and a carrier period at the least.
/// @return shares of the time, before and after
Evened make_even(std::vector<Stretch>& stretches, const Array& array) {
    constexpr std::size_t rounds = 3000;
    constexpr double least_part = 1.0 / 3.0;
    std::vector<Vec3> points;
    std::vector<double> periods, floors;
    for (const Stretch& stretch : stretches) {
        if (stretch.foci.empty()) continue;
        points.push_back(stretch.foci.front().position);
        periods.push_back(stretch.periods);
        floors.push_back(std::min(stretch.periods, std::max(1.0, least_part * stretch.periods)));
    }
    const CrossTalk cross_talk(array, points);
    const auto evenness = [&] {
        const Path path = path_of(stretches);
        std::vector<double> shares;
        for (const PathStep& step : path.steps)
            if (!step.foci.empty())
                shares.push_back(static_cast<double>(step.periods) / static_cast<double>(path.periods()));
        return cross_talk.evenness(shares);
    };
    Evened result;
    result.before = evenness();
    const std::vector<double> even = cross_talk.even_shares(periods, floors, rounds);
    std::size_t next = 0;
    for (Stretch& stretch : stretches)
        if (!stretch.foci.empty()) stretch.periods = even[next++];
    result.after = evenness();
    return result;
}

DrawnPace pace_of(const Drawing& drawing, const Path& path, double carrier_hz) {
    const double frequency_hz = carrier_hz / static_cast<double>(path.periods());
    return {drawing.length_m, drawing.jumps_m, drawing.travelled_m * frequency_hz, frequency_hz, drawing.spacing_m};
}

/// Lets the amplitude follow the project's waveform. A path of one step has no length of its own: it takes the
/// modulation's, so that no more sequence entries are needed than that has samples.
/// @param most_samples  that the image can hold
/// @param hashes        gets the hash of the samples
/// @return the frequencies as they came out
std::vector<double> modulate(Path& path, const Project& project, double carrier_hz, std::size_t most_samples,
                             std::string& hashes) {
    if (project.am.empty()) return {};
    if (!path.modulation.samples.empty())
        throw bad_argument("am", "the path has a modulation of its own; leave one of them out");
    MadeModulation made = modulation_of(project.am, project.am_law, carrier_hz, project.folder, most_samples);
    path.modulation = std::move(made.modulation);
    hashes += sha256(fmt::format("{}", fmt::join(path.modulation.samples, " ")));
    if (path.steps.size() == 1)
        path.steps.front().periods =
            static_cast<std::uint32_t>(path.modulation.samples.size()) * path.modulation.periods_a_sample;
    return made.frequencies_hz;
}

/// Lets the foci be, or feel, as strong as the project says.
std::optional<PathMagnitude> feel(Path& path, const Project& project, const Array& array) {
    weaken(path, project.amplitude);
    if (!project.magnitude) return {};
    require_one_strength(project.magnitude, project.amplitude);
    if (!project.makers.of_magnitude)
        throw bad_argument("magnitude", "this build knows no magnitudes; build with the extra feel");
    return project.makers.of_magnitude(path, project, array);
}

/// A modulation that keeps step with the path may be off whenever a focus has its turn, and a weak pulse may round to
/// none on a device's segments.
void warn_of_unheard_foci(Compiled& compiled) {
    const bool modulated = !compiled.path.modulation.samples.empty();
    if (!modulated && compiled.bundle.manifest.quantise.empty()) return;
    std::size_t unheard = 0;
    const auto& records = compiled.bundle.manifest.records;
    for (const PathStep& step : compiled.path.steps) {
        const auto plays = [&](const RecordMeaning& record) {
            return std::equal(record.foci.begin(), record.foci.end(), step.foci.begin(), step.foci.end(),
                              [](const Focus& a, const Focus& b) { return a.position == b.position; });
        };
        const bool audible =
            std::any_of(step.foci.begin(), step.foci.end(), [](const Focus& focus) { return focus.amplitude > 0.0; });
        if (audible && std::none_of(records.begin(), records.end(), plays)) ++unheard;
    }
    if (unheard > 0)
        compiled.warnings.push_back(fmt::format(
            "{} of {} steps of the path are never heard, because {}", unheard, compiled.path.steps.size(),
            modulated ? "the modulation is at 0 whenever they play; take a frequency that does not divide the "
                        "modulation's"
                      : "their pulses are shorter than half a segment of the device; raise their amplitudes"));
}

/// What an image holds when nobody has said it.
ImageKind kind_of(std::optional<ImageKind> asked, const Core& core, const std::string& quantise) {
    if (asked == ImageKind::foci && !quantise.empty())
        throw bad_argument("quantise",
                           "segments are of records, whose pulses the host computes; leave foci or segments "
                           "out",
                           {"quantise", "foci"});
    if (asked == ImageKind::foci && core.parameters.foci == 0)
        throw bad_input(core.name, "it computes no foci; compile records for it, or take a board that does",
                        {"records", "board"});
    return asked.value_or(core.parameters.foci > 0 && quantise.empty() ? ImageKind::foci : ImageKind::records);
}

Timer timer_of(ImageKind kind, const Array& array, const Core& core) {
    return kind == ImageKind::foci ? choose_amplitude_timer(array, core) : choose_timer(array, core);
}

/// Records of timings: fills in the image, and the manifest's records and solver.
Image records_image(const Path& path, const Array& array, const Core& core, Method solver, Manifest& manifest,
                    std::string& settings) {
    const std::uint32_t channels = manifest.core.parameters.channels;
    std::optional<Segments> segments;
    if (!manifest.quantise.empty()) segments = segments_of(manifest.quantise);
    const RecordedPath recorded = PathRecorder(path, manifest.timer, core, segments).make();
    if (recorded.steps.empty())
        throw bad_argument(
            "path", "every step is silent, or so weak that its pulse would have no length; there is nothing to play");

    Image image;
    image.channels = channels;
    image.clock_hz = core.parameters.clock_hz;
    image.timing_bits = core.parameters.timing_bits;
    image.pulse_bits = core.parameters.pulse_bits;
    image.records = records_of(array, manifest.timer, image.channels, recorded.steps, recorded.amplitudes, solver);
    if (segments)
        for (Record& record : image.records) record = in_segments(record, manifest.timer, *segments);
    image.sequence = recorded.entries;

    std::vector<std::uint32_t> dwells(image.records.size());
    for (const SequenceEntry& entry : image.sequence)
        if (entry.index > 0) dwells[entry.index - 1U] += entry.dwell;
    for (std::size_t i = 0; i < recorded.steps.size(); ++i) {
        RecordMeaning meaning{recorded.steps[i].foci, recorded.amplitudes[i], dwells[i]};
        double largest = 0.0;
        for (const Focus& focus : meaning.foci) largest = std::max(largest, focus.amplitude);
        for (Focus& focus : meaning.foci) focus.amplitude /= largest;
        meaning.amplitude *= largest;
        manifest.records.push_back(std::move(meaning));
    }
    manifest.solver = solver;
    // Images of single foci do not depend on it.
    if (manifest.has_several_foci()) settings += fmt::format("\nsolver {}", name_of(solver));
    return image;
}

Compiled compile_path(Path path, const ProjectInstrument& instrument, std::uint16_t loops, const std::string& name,
                      std::string settings, Method solver, const std::string& quantise, ImageKind kind,
                      FociFrom from = FociFrom::memory) {
    const auto& [array, core, boards] = instrument;
    require_sound(path);
    if (boards == 1) require_channels(array, core);
    Manifest manifest;
    manifest.array = array;
    manifest.core = core;
    if (boards > 1) manifest.core.parameters.channels = static_cast<std::uint32_t>(array.elements.size());
    manifest.timer = timer_of(kind, array, core);
    manifest.quantise = quantise;
    std::vector<std::string> warnings;
    Image image;
    if (kind == ImageKind::foci) {
        FocusImage made = focus_image_of(path, array, core, loops, boards, from);
        image = std::move(made.image);
        manifest.records = std::move(made.records);
        manifest.foci = made.meaning;
        manifest.modulation = image.modulation;
        manifest.solver = Method::superposition;
        warnings = std::move(made.warnings);
        settings += "\nimage foci";
    } else {
        image = records_image(path, array, core, solver, manifest, settings);
    }
    image.loops = loops;

    std::uint64_t periods = 0;
    for (const SequenceEntry& entry : image.sequence) periods += entry.dwell;
    manifest.rate_hz = manifest.timer.carrier_hz() / static_cast<double>(periods);
    manifest.formation = slowest_formation(array, core, manifest.points(), image.foci ? image.foci->each : 0);
    Manifest before;  // the members that do not depend on the points
    before.array = array;
    before.core = manifest.core;
    before.timer = manifest.timer;
    manifest.input_sha256 = sha256(fmt::format("{} {} {}", version(), settings, to_text(before)));
    std::string hex = to_intel_hex(image);
    manifest.image_sha256 = sha256(hex);
    Compiled compiled{{std::move(image), std::move(manifest), std::move(hex), name},
                      std::move(path),
                      {},
                      {},
                      {},
                      {},
                      {},
                      {},
                      std::move(warnings)};
    // As `analyze` has it, of what is played: a modulation may have become silence between the records.
    const Path places = places_of(compiled.bundle.manifest, compiled.bundle.image.sequence);
    if (!places.steps.empty()) compiled.pressure_left = summary_of(places, pressure_left(array, places));
    if (kind == ImageKind::records) warn_of_unheard_foci(compiled);
    const std::string short_dwell = short_dwell_warning(compiled);
    if (!short_dwell.empty()) compiled.warnings.push_back(short_dwell);
    return compiled;
}

/// What all of one call of compile() needs.
struct Job {
    const ProjectInstrument& instrument;
    const Project& project;
    const std::string& name;
    const Progress& progress;
    ImageKind kind;
    double carrier_hz;
    std::string hashes{};  // of the contents that were read
    std::vector<std::string> warnings{};

    [[nodiscard]] std::size_t most_samples() const {
        return kind == ImageKind::foci ? std::max(1U, instrument.core.parameters.modulation_depth)
                                       : most_record_samples;
    }
};

/// The image of a path whose amplitudes are as they shall be.
Compiled focused(const Job& job, Path path, FociFrom from = FociFrom::memory) {
    job.progress(0.8, "focusing");
    Compiled compiled = compile_path(std::move(path), job.instrument, job.project.loops, job.name,
                                     settings_text(job.project) + job.hashes, Method::gauss_newton,
                                     job.project.quantise, job.kind, from);
    compiled.warnings.insert(compiled.warnings.begin(), job.warnings.begin(), job.warnings.end());
    job.progress(1.0, "focusing");
    return compiled;
}

/// The same with the amplitudes that the project asks for.
Compiled focused_as_asked(Job& job, Path path, FociFrom from = FociFrom::memory) {
    const std::vector<double> am_hz = modulate(path, job.project, job.carrier_hz, job.most_samples(), job.hashes);
    if (const Modulation& sound = path.modulation;
        job.kind == ImageKind::foci && !job.project.am.empty() && sound.samples.size() > job.most_samples()) {
        const double sample_s = sound.periods_a_sample / job.carrier_hz;
        throw bad_input(
            job.instrument.core.name,
            fmt::format("the modulation lasts {:.4g} s, {} samples, and the board holds {:.4g} s of it; cut "
                        "it to that, or compile records",
                        static_cast<double>(sound.samples.size()) * sample_s, sound.samples.size(),
                        static_cast<double>(job.most_samples()) * sample_s),
            {"am", "records", "board"});
    }
    const auto magnitude = feel(path, job.project, job.instrument.array);
    Compiled compiled = focused(job, std::move(path), from);
    compiled.am_hz = am_hz;
    compiled.magnitude = magnitude;
    return compiled;
}

Compiled compile_path_file(Job& job, FociFrom from) {
    Path path = path_in_file(job.project, job.instrument.array, job.carrier_hz, job.hashes, job.warnings);
    return focused_as_asked(job, std::move(path), from);
}

Compiled compile_hand(Job& job) {
    std::optional<PathMagnitude> magnitude;
    Path path = path_of_hand(job.project, job.instrument, job.carrier_hz, job.hashes, job.warnings, magnitude);
    Compiled compiled = focused(job, std::move(path));
    compiled.magnitude = magnitude;
    return compiled;
}

ShapePathOptions path_options(const Job& job) {
    const interface::CoreParameters& core = job.instrument.core.parameters;
    const bool foci = job.kind == ImageKind::foci;
    const std::uint32_t held = foci ? job.instrument.core.most_focus_records() : core.records;
    return {job.project.points,
            job.project.seed,
            job.project.clip,
            std::min(held, core.sequence_depth - 1),
            job.instrument.core.name,
            fmt::format("{} {}records, {} sequence entries", held, foci ? "focus " : "", core.sequence_depth - 1)};
}

/// How a shape came to be a path.
struct ShapePath {
    TouredPoints points;
    Path path;
    std::optional<DrawnPace> pace;
    std::optional<Evened> evened;
};

ShapePath drawn_path(const Job& job, const Shape& shape, const ShapePathOptions& options) {
    ShapePath made;
    Drawing drawing = drawing_of(job.project, shape, job.instrument.array, job.carrier_hz, options);
    if (job.project.even) made.evened = make_even(drawing.stretches, job.instrument.array);
    made.path = path_of(drawing.stretches);
    made.pace = pace_of(drawing, made.path, job.carrier_hz);
    made.points = std::move(drawing.points);
    return made;
}

ShapePath toured_path(const Job& job, const Shape& shape, const ShapePathOptions& options) {
    ShapePath made;
    made.points = tour_of(shape, job.instrument.array, options);
    made.path = path_through(made.points.points,
                             even_dwells(job.carrier_hz, job.project.rate_hz, made.points.points.size(), most_dwell));
    if (job.project.even) {
        std::vector<Stretch> stretches;
        for (const PathStep& step : made.path.steps)
            stretches.push_back({step.foci, static_cast<double>(step.periods)});
        made.evened = make_even(stretches, job.instrument.array);
        made.path = path_of(stretches);
    }
    return made;
}

Compiled compile_shapes(Job& job, Shape* placed) {
    const Project& project = job.project;
    PlacedShapes all;
    all.whole = placed_at(gather(project, job.hashes, job.warnings, &all.ends), placement(project));
    const Shape own = project.key_frames.empty() ? Shape{} : own_shape(project, all);
    const Shape& shape = project.key_frames.empty() ? all.whole : own;
    job.progress(0.3, "sampling");
    const ShapePathOptions options = path_options(job);
    const bool is_drawn = project.pace.speed_m_s || project.pace.frequency_hz;
    ShapePath made = is_drawn ? drawn_path(job, shape, options) : toured_path(job, shape, options);
    if (project.fade) {
        if (project.magnitude)
            throw bad_argument("fade", "a magnitude makes all foci feel alike; leave one of them out",
                               {"fade", "magnitude"});
        apply(*project.fade, bounding_box(shape), made.path);
    }
    if (!project.key_frames.empty())
        made.path =
            with_key_frames(project, made.path, bounding_box(shape).center(), all, job.instrument.array, job.carrier_hz,
                            options, job.instrument.core.parameters.sequence_depth - 1, job.warnings);
    Compiled compiled = focused_as_asked(job, std::move(made.path));
    if (placed != nullptr) *placed = std::move(all.whole);
    compiled.points = std::move(made.points);
    compiled.pace = made.pace;
    compiled.evened = made.evened;
    return compiled;
}

Compiled compile_on(const ProjectInstrument& instrument, const Project& project, const std::string& name,
                    const Progress& progress, Shape* placed = nullptr, FociFrom from = FociFrom::memory) {
    const ImageKind kind = kind_of(project.image, instrument.core, project.quantise);
    Job job{instrument, project, name, progress, kind, timer_of(kind, instrument.array, instrument.core).carrier_hz()};
    progress(0.0, "reading shapes");
    if (!project.path.empty()) return compile_path_file(job, from);
    if (project.hand) return compile_hand(job);
    return compile_shapes(job, placed);
}

}  // namespace

void require_one_strength(const std::optional<double>& magnitude, double amplitude) {
    if (magnitude && amplitude != 1.0)
        throw bad_argument("amplitude", "a magnitude says how strong foci are; leave one of them out",
                           {"amplitude", "magnitude"});
}

double Compiled::shortest_dwell_s() const {
    // A long dwell is several entries of one record in a row; silence is no focus.
    const std::vector<SequenceEntry>& sequence = bundle.image.sequence;
    std::uint64_t least = std::numeric_limits<std::uint64_t>::max();
    for (std::size_t i = 0, next = 0; i < sequence.size(); i = next) {
        std::uint64_t dwell = 0;
        for (; next < sequence.size() && sequence[next].index == sequence[i].index; ++next)
            dwell += sequence[next].dwell;
        if (sequence[i].index != 0) least = std::min(least, dwell);
    }
    return static_cast<double>(least) * bundle.manifest.timer.period_s();
}

std::string short_dwell_warning(const Compiled& compiled) {
    // A modulation's samples are no foci of their own.
    if (!compiled.path.modulation.samples.empty()) return {};
    const Formation& formation = compiled.bundle.manifest.formation;
    const double dwell_s = compiled.shortest_dwell_s();
    if (dwell_s >= formation.with_ring_up_s()) return {};
    const bool geometry = dwell_s < formation.formation_s;
    return fmt::format(
        "a point lasts {:.1f} µs, shorter than the {:.1f} µs {}; it will not reach its full pressure", dwell_s * 1e6,
        (geometry ? formation.formation_s : formation.with_ring_up_s()) * 1e6,
        geometry ? "in which all waves arrive at a focus" : "that the transducers' ring-up takes as well");
}

double metres_per_unit(const std::string& unit) {
    for (const auto& [name, metres] :
         {std::pair{"mm", millimetre}, {"cm", 0.01}, {"m", 1.0}, {"inch", 0.0254}, {"in", 0.0254}})
        if (unit == name) return metres;
    throw bad_argument("unit", fmt::format("must be mm, cm, m or inch, found '{}'", unit));
}

ProjectInstrument instrument_of(const Project& project) {
    ProjectInstrument found;
    if (project.board) {
        const std::string board = project.beside(*project.board);
        found.core = find_core(board);
        const std::string drives = project.array ? project.beside(*project.array) : array_of_board(board);
        found.array = find_array(drives);
    } else {
        const std::string array = project.array ? project.beside(*project.array) : "tile-10x10";
        found.array = find_array(array);
        found.core = core_of_array(array);
    }
    require_channels(found.array, found.core);
    return found;
}

Shape shape_of(const Project& project) {
    if (!project.is_of_shapes()) return {};
    std::string hashes;
    std::vector<std::string> warnings;  // compile tells them
    return placed_at(gather(project, hashes, warnings), placement(project));
}

Compiled compile(const Project& project, const std::string& name, const Progress& progress, Shape* shape) {
    const ProjectInstrument instrument = instrument_of(project);
    require_pin(project.triggers, instrument.core);
    Compiled compiled = compile_on(instrument, project, name, progress, shape);
    compiled.parts =
        parts_of(project.triggers, compiled.bundle.image.sequence, compiled.bundle.manifest.timer.carrier_hz());
    return compiled;
}

Compiled compile(const ProjectInstrument& instrument, const Project& project, const std::string& name,
                 const Progress& progress) {
    return compile_on(instrument, project, name, progress);
}

Compiled compile_for_stream(const Project& project, const std::string& name) {
    ProjectInstrument instrument = instrument_of(project);
    instrument.core.parameters.sequence_depth = interface::sequence_header_field::length.most() + 1;
    return compile_on(instrument, project, name, {}, nullptr, FociFrom::line);
}

Compiled compile(const Path& path, const Array& array, const Core& core, std::uint16_t loops, const std::string& name,
                 Method solver, const std::string& quantise, std::optional<ImageKind> kind) {
    return compile(path, {array, core}, loops, name, solver, quantise, kind);
}

Compiled compile(const Path& path, const ProjectInstrument& instrument, std::uint16_t loops, const std::string& name,
                 Method solver, const std::string& quantise, std::optional<ImageKind> kind) {
    std::string settings = fmt::format("path {}", loops);
    for (const PathStep& step : path.steps) {
        settings += fmt::format("\n{}", step.periods);
        for (const Focus& f : step.foci)
            settings += fmt::format(" {} {} {} {}", f.position.x, f.position.y, f.position.z, f.amplitude);
    }
    settings += fmt::format("\n{} {}", path.modulation.periods_a_sample, fmt::join(path.modulation.samples, " "));
    if (!quantise.empty()) settings += fmt::format("\nquantise {}", quantise);
    return compile_path(path, instrument, loops, name, settings, solver, quantise,
                        kind_of(kind, instrument.core, quantise));
}

}  // namespace haptogram
