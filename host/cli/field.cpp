// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/field.hpp"

#include <fmt/format.h>

#include <cmath>
#include <memory>

#include "command.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/verbs/level.hpp"
#include "haptogram/verbs/probe.hpp"
#include "progress_line.hpp"
#include "report.hpp"
#include "source_options.hpp"

namespace haptogram::cli {
namespace {

struct FieldCommand {
    SourceOptions what;
    std::string plane = "xy@z=130", line;
    bool volume = false;
    double extent_mm = 80.0, step_mm = 1.0, below_db = 6.0;
    std::string x, y, z;
    std::optional<std::string> am, am_law, probe;
    std::string quantity = "radiation";
    unsigned threads = 0;
    std::string output = "-";
    bool json = false;
};

/// How the field was computed: a message on standard error, or JSON on standard output.
void tell_how(const Field& field, const std::string& surface, const Transducer& transducer, bool as_json) {
    if (as_json) {
        nlohmann::json how = {
            {"region", field.region.text},     {"quantity", field.quantity}, {"points", field.region.grid.size()},
            {"method", name_of(field.method)}, {"error", field.error},       {"level", level_json(transducer)}};
        if (!surface.empty()) how["surface"] = surface;
        tell(how, true);
        return;
    }
    fmt::print(stderr, "{}\n{}\n", description_of(field), level_text(transducer));
    if (!surface.empty()) fmt::print(stderr, "{}\n", surface);
}

Region region_of(const FieldCommand& command) {
    Reach reach{command.extent_mm * millimetre, command.step_mm * millimetre, {}, {}, {}};
    if (!command.x.empty()) reach.x = parse_range("x", command.x);
    if (!command.y.empty()) reach.y = parse_range("y", command.y);
    if (!command.z.empty()) reach.z = parse_range("z", command.z);
    if (command.volume) return parse_region("volume", "xyz", reach);
    if (!command.line.empty()) return parse_region("line", command.line, reach);
    return parse_region("plane", command.plane, reach);
}

int field(const FieldCommand& command, const std::vector<std::string>& given) {
    if (is_among(given, "--below") && !command.output.ends_with(".stl"))
        throw bad_argument("--below", "has no effect, because it is of the surface in an .stl file");
    if (command.output == "-" && command.json)
        throw bad_argument("json", "the field would go to standard output, too; give --output a file");
    const Region region = region_of(command);
    if (constexpr std::size_t many = 10'000'000; region.grid.size() > many)
        complain(
            fmt::format("warning: {} points take long and much room; a larger --step takes fewer", region.grid.size()));
    const Quantity quantity = quantity_of(command.quantity);
    check_field_path(command.output, region, quantity);
    const Source source = source_of(command.what, "field");
    require_distinct(files_of(source), {{"--output", command.output}});
    const std::optional<Probe> probe = command.probe ? std::optional(probe_of(*command.probe)) : std::nullopt;
    const Timeline timeline = open_timeline(source);
    Excitation excitation = excitation_of(timeline, source.record);
    Modulation modulation;
    if (command.am)
        modulation =
            modulation_of(*command.am, law_of(command.am_law.value_or("pressure")), excitation.array.carrier_hz)
                .modulation;
    Field found;
    {
        ProgressLine progress("field");
        if (probe) {
            found = probe_field(excitation.array, sequence_of(timeline), modulation, region, *probe, command.threads,
                                progress.callback());
            found.title = excitation.title;
            found.marks = excitation.foci;
        } else {
            if (command.am) weaken(excitation, std::sqrt(mean_square_of(modulation)));
            found = haptogram::field(excitation, region, quantity, command.threads, progress.callback());
        }
    }
    const std::string surface = write_field(command.output, found, command.below_db);
    tell_how(found, surface, excitation.array.transducer, command.json);
    return 0;
}

}  // namespace

void add_field(CLI::App& app, Action& action) {
    auto options = std::make_shared<FieldCommand>();
    CLI::App* sub = app.add_subcommand(
        "field",
        "Compute the sound field of an input, averaged over its sequence, along a line, in a plane or in a volume");
    add_source(*sub, options->what);
    sub->add_option("--record", options->what.source.record, "Only this record")
        ->excludes(sub->get_option("--focus"))
        ->check(whole(1, 65535));
    auto* plane = sub->add_option("--plane", options->plane,
                                  "xy@z=MM, xz@y=MM or yz@x=MM; or obliquely through a point (mm): "
                                  "uv@x=0,y=0,z=130 with rx, ry and rz, by which it is turned from xy (degrees about "
                                  "x, then y, then z), or with nx, ny and nz, its normal")
                      ->capture_default_str();
    auto* line = sub->add_option("--line", options->line, "Such as z@x=0,y=0 (mm)")->excludes(plane);
    sub->add_flag("--volume", options->volume, "All three axes")->excludes(plane)->excludes(line);
    sub->add_option("--extent", options->extent_mm,
                    "Half-width of the region, mm; along z twice this from the array on")
        ->check(positive())
        ->capture_default_str();
    sub->add_option("--step", options->step_mm, "Between points, mm")->check(positive())->capture_default_str();
    sub->add_option("--x", options->x, "From:to along x, or an oblique plane's u, mm, instead of the extent");
    sub->add_option("--y", options->y, "The same along y or v");
    sub->add_option("--z", options->z, "The same along z");
    std::vector<std::string> names;
    std::string about;
    for (const QuantityName& one : quantity_names) {
        names.emplace_back(one.name);
        about += fmt::format("{}{} ({})", about.empty() ? "" : ", ", one.name, one.about);
    }
    auto* wanted =
        sub->add_option("--quantity", options->quantity, about)->check(CLI::IsMember(names))->capture_default_str();
    sub->add_option("--probe", options->probe,
                    "What an instrument reads instead: haptogram, that paper's ultrasonic receiver (9 mm, rectified, "
                    "averaged), or hoshi:HZ, a pressure sensor of 2 mm (radiation pressure at the modulation's "
                    "frequency: mean, least and greatest of a minute)")
        ->excludes(wanted)
        ->excludes("--record");
    add_am(*sub, options->am, options->am_law);
    sub->add_option("--threads", options->threads, "Threads; 0: one for each processor")
        ->check(whole(0, 1024))
        ->capture_default_str();
    sub->add_option("-o,--output", options->output,
                    "A .csv, .npy, .vti (ParaView) or .png file, or of a volume an .stl file, the surface --below the "
                    "greatest value; - is CSV on standard output")
        ->capture_default_str();
    sub->add_option("--below", options->below_db, "In an .stl file: decibels below the greatest value of the volume")
        ->check(positive())
        ->capture_default_str();
    sub->add_flag("--json", options->json, "Print how it was computed, and how far it may be off, as JSON");
    sub->callback(
        [options, sub, &action] { action = [options, given = given_to(*sub)] { return field(*options, given); }; });
}

}  // namespace haptogram::cli
