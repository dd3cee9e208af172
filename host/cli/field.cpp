// SPDX-License-Identifier: Apache-2.0
#include "haptogram/acoustics/field.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <thread>

#include "command.hpp"
#include "field_file.hpp"
#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/acoustics/quantities.hpp"
#include "haptogram/acoustics/region.hpp"
#include "haptogram/analysis/measure.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "progress_line.hpp"

namespace haptogram::cli {
namespace {

struct FieldCommand {
    std::string image, focus, array = "tile-10x10";
    std::uint32_t record = 0;
    std::string pulses, manifest;
    std::string plane = "xy@z=130", line;
    bool volume = false;
    double extent_mm = 80.0, step_mm = 1.0;
    std::string x, y, z;
    std::string quantity = "radiation";
    unsigned threads = 0;
    std::string output = "-";
};

/// What makes a field: sets of drives, each for its share of the time.
struct Excitation {
    Array array;
    std::vector<std::vector<std::complex<double>>> drives;
    std::vector<double> weights;
    std::vector<Vec3> foci;
    std::string title;
};

Excitation of_focus(const FieldCommand& command) {
    Excitation found{find_array(command.array), {}, {1.0}, {}, {}};
    Vec3 focus{};
    double* const axes[] = {&focus.x, &focus.y, &focus.z};
    std::size_t at = 0;
    for (double* const axis : axes) {
        const std::size_t comma = command.focus.find(',', at);
        const bool last = axis == axes[2];
        double value = 0.0;
        if ((comma == std::string::npos) != last ||
            !CLI::detail::lexical_cast(command.focus.substr(at, last ? comma : comma - at), value) ||
            !std::isfinite(value))
            throw Error(ErrorCode::bad_argument, "--focus",
                        fmt::format("expected x,y,z in mm, found '{}'", command.focus));
        *axis = value * millimetre;
        at = comma + 1;
    }
    if (const std::string why = found.array.unreachable(focus); !why.empty())
        throw Error(ErrorCode::bad_argument, "--focus", why);
    found.drives = {ideal_drives(found.array, focus)};
    found.foci = {focus};
    found.title = fmt::format("{}, exact phases for ({}) mm", found.array.name, command.focus);
    return found;
}

Excitation of_image(const FieldCommand& command) {
    const std::string content = read_file(command.image);
    const Image image = from_intel_hex(content, command.image);
    const Manifest manifest = manifest_beside(command.image, content);
    if (command.record > image.records.size())
        throw Error(ErrorCode::bad_argument, "--record",
                    fmt::format("the image has {}, not {}", image.records.size(), command.record));
    Excitation found{manifest.array, {}, std::vector<double>(image.records.size()), manifest.foci, {}};
    for (const Record& record : image.records) found.drives.push_back(drives_of(manifest, record));
    for (const SequenceEntry& entry : image.sequence) {
        if (entry.index == 0 || entry.index > image.records.size()) continue;
        const Record& record = image.records[entry.index - 1U];
        found.weights[entry.index - 1U] += 1.0 * entry.dwell * record.cycle_length * record.prescaler;
    }
    found.title = fmt::format("{}, {} points in turn", command.image, image.records.size());
    if (command.record > 0) {
        found.drives = {found.drives[command.record - 1]};
        found.weights = {1.0};
        found.foci = {manifest.foci.at(command.record - 1)};
        found.title = fmt::format("{}, record {}", command.image, command.record);
    }
    return found;
}

/// A manifest alone: exact phases for each of its points, in the shares of its dwells.
Excitation of_manifest(const FieldCommand& command) {
    const Manifest manifest = manifest_from_json(read_file(command.image), command.image);
    if (command.record > manifest.foci.size())
        throw Error(ErrorCode::bad_argument, "--record",
                    fmt::format("the manifest has {}, not {}", manifest.foci.size(), command.record));
    Excitation found{manifest.array, {}, {}, manifest.foci, command.image + ", exact phases"};
    for (std::size_t i = 0; i < manifest.foci.size(); ++i) {
        if (command.record > 0 && i + 1 != command.record) continue;
        found.drives.push_back(ideal_drives(manifest.array, manifest.foci[i]));
        for (std::complex<double>& drive : found.drives.back())
            drive *= std::sin(std::numbers::pi * manifest.timer.duty());
        found.weights.push_back(manifest.dwell_cycles.at(i));
    }
    if (command.record > 0) found.foci = {manifest.foci[command.record - 1]};
    return found;
}

/// Root mean square of the particle's speed, m/s; in double precision, point by point.
std::vector<float> rms_velocity(const Excitation& excitation, const Grid& grid, ProgressLine& progress) {
    double total = 0.0;
    for (const double weight : excitation.weights) total += weight;
    std::vector<float> found;
    for (std::size_t i = 0; i < grid.size(); ++i) {
        double square = 0.0;
        for (std::size_t r = 0; r < excitation.drives.size(); ++r) {
            const ComplexVec3 v = particle_velocity(excitation.array, excitation.drives[r], grid.point(i));
            square += excitation.weights[r] / total * (std::norm(v.x) + std::norm(v.y) + std::norm(v.z)) / 2.0;
        }
        found.push_back(static_cast<float>(std::sqrt(square)));
        progress.update(static_cast<double>(i + 1) / static_cast<double>(grid.size()));
    }
    return found;
}

Excitation of_pulses(const FieldCommand& command) {
    const Manifest manifest = manifest_from_json(read_file(command.manifest), command.manifest);
    const std::vector<Pulse> pulses = pulses_from_csv(read_file(command.pulses), command.pulses);
    if (pulses.empty()) throw bad_input(command.pulses, "no pulses in it; expected what simulate --pulses wrote");
    Excitation found{manifest.array, {}, {}, manifest.foci, command.pulses + ", as measured at the pins"};
    for (MeasuredRecord& record : measure(manifest, pulses, command.pulses)) {
        if (record.cycles == 0) continue;
        found.drives.push_back(std::move(record.drives));
        found.weights.push_back(static_cast<double>(record.cycles));
    }
    return found;
}

Region region_of(const FieldCommand& command) {
    Reach reach{command.extent_mm * millimetre, command.step_mm * millimetre, {}, {}, {}};
    if (!command.x.empty()) reach.x = parse_range("--x", command.x);
    if (!command.y.empty()) reach.y = parse_range("--y", command.y);
    if (!command.z.empty()) reach.z = parse_range("--z", command.z);
    if (command.volume) return parse_region("--volume", "xyz", reach);
    if (!command.line.empty()) return parse_region("--line", command.line, reach);
    return parse_region("--plane", command.plane, reach);
}

int field(const FieldCommand& command) {
    FieldFile file{region_of(command), "", "", {}, {}, ""};
    const bool complex_values = command.quantity == "complex";
    check_field_path(command.output, file.region, complex_values);
    require_distinct({{"image", command.image}, {"--pulses", command.pulses}, {"--manifest", command.manifest}},
                     {{"--output", command.output}});
    const Excitation excitation = !command.focus.empty()             ? of_focus(command)
                                  : command.image.ends_with(".json") ? of_manifest(command)
                                  : !command.image.empty()           ? of_image(command)
                                                                     : of_pulses(command);
    file.marks = excitation.foci;
    file.title = excitation.title;
    ProgressLine progress("field");
    const FieldOptions options{
        command.threads == 0 ? std::max(1U, std::thread::hardware_concurrency()) : command.threads,
        progress.callback()};
    if (complex_values) {
        if (excitation.drives.size() != 1)
            throw Error(ErrorCode::bad_argument, "--quantity",
                        fmt::format("complex is of one set of phases, and this plays {}; choose one by --record",
                                    excitation.drives.size()));
        const auto p = pressure_on(excitation.array, excitation.drives.front(), file.region.grid, options);
        file.quantity = "pressure_pa";
        file.parts.resize(2);
        for (const std::complex<float> value : p) {
            file.parts[0].push_back(value.real());
            file.parts[1].push_back(value.imag());
        }
    } else if (command.quantity == "velocity") {
        file.quantity = "rms_velocity_m_s";
        file.label = "rms particle velocity / (m/s)";
        file.parts = {rms_velocity(excitation, file.region.grid, progress)};
    } else {
        std::vector<WeightedDrives> sequence;
        for (std::size_t i = 0; i < excitation.drives.size(); ++i)
            sequence.push_back({excitation.weights[i], excitation.drives[i]});
        file.parts = {mean_square_pressure(excitation.array, sequence, file.region.grid, options)};
        const Medium& medium = excitation.array.medium;
        const auto each = [&](const char* quantity, const char* label, auto make) {
            file.quantity = quantity;
            file.label = label;
            for (float& value : file.parts.front()) value = static_cast<float>(make(static_cast<double>(value)));
        };
        if (command.quantity == "radiation")
            each("radiation_pressure_pa", "time-averaged radiation pressure / Pa",
                 [&](double square) { return radiation_pressure(std::sqrt(2.0 * square), medium); });
        else if (command.quantity == "rms")
            each("rms_pressure_pa", "rms sound pressure / Pa", [](double square) { return std::sqrt(square); });
        else
            each("spl_db", "sound pressure level / dB re 20 µPa",
                 [](double square) { return sound_level_db(std::sqrt(2.0 * square)); });
    }
    write_field(command.output, file);
    return 0;
}

}  // namespace

void add_field(CLI::App& app, Action& action) {
    auto options = std::make_shared<FieldCommand>();
    CLI::App* sub = app.add_subcommand(
        "field",
        "The sound field of an image, of one focal point, or of measured pulses, along a line, in a plane or a volume");
    auto* image = sub->add_option("image", options->image,
                                  "Intel HEX image, with its manifest beside it: the mean over its sequence. Or a "
                                  "manifest (.json): the same of exact phases");
    sub->add_option("--record", options->record, "Only this record of the image")->needs(image)->check(whole(1, 65535));
    auto* focus = sub->add_option("--focus", options->focus, "Exact phases for x,y,z (mm) instead")->excludes(image);
    sub->add_option("--array", options->array, "Array of --focus")->needs(focus)->capture_default_str();
    auto* pulses = sub->add_option("--pulses", options->pulses, "Pulse file from simulate or board run instead")
                       ->excludes(image)
                       ->excludes(focus);
    auto* manifest =
        sub->add_option("--manifest", options->manifest, "Manifest of the image that was played")->needs(pulses);
    pulses->needs(manifest);
    auto* plane = sub->add_option("--plane", options->plane, "xy@z=MM, xz@y=MM or yz@x=MM")->capture_default_str();
    auto* line = sub->add_option("--line", options->line, "Such as z@x=0,y=0 (mm)")->excludes(plane);
    sub->add_flag("--volume", options->volume, "All three axes")->excludes(plane)->excludes(line);
    sub->add_option("--extent", options->extent_mm,
                    "Half-width of the region, mm; along z twice this from the array on")
        ->check(positive())
        ->capture_default_str();
    sub->add_option("--step", options->step_mm, "Between points, mm")->check(positive())->capture_default_str();
    sub->add_option("--x", options->x, "From:to along x, mm, instead of the extent");
    sub->add_option("--y", options->y, "The same along y");
    sub->add_option("--z", options->z, "The same along z");
    sub->add_option(
           "--quantity", options->quantity,
           "radiation (pressure on skin), rms (pressure), spl, velocity (of particles, rms), or complex (pressure)")
        ->check(CLI::IsMember({"radiation", "rms", "spl", "velocity", "complex"}))
        ->capture_default_str();
    sub->add_option("--threads", options->threads, "0: as many as there are")
        ->check(whole(0, 1024))
        ->capture_default_str();
    sub->add_option("-o,--output", options->output,
                    "A .csv, .npy, .vti (ParaView) or .png file; - is CSV on standard output")
        ->capture_default_str();
    sub->callback([options, &action] {
        action = [options] {
            if (options->image.empty() && options->focus.empty() && options->pulses.empty())
                throw Error(ErrorCode::bad_argument, "field",
                            "expected an image, --focus or --pulses; see haptogram field --help");
            return field(*options);
        };
    });
}

}  // namespace haptogram::cli
