// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/field.hpp"

#include <fmt/format.h>

#include <cmath>
#include <memory>

#include "command.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/verbs/field_file.hpp"
#include "haptogram/verbs/source.hpp"
#include "progress_line.hpp"
#include "report.hpp"

namespace haptogram::cli {
namespace {

struct FieldCommand {
    Source source;
    std::string focus;
    std::string plane = "xy@z=130", line;
    bool volume = false;
    double extent_mm = 80.0, step_mm = 1.0, below_db = 6.0;
    std::string x, y, z;
    std::optional<std::string> am, am_law, quantise;
    std::string quantity = "radiation";
    unsigned threads = 0;
    std::string output = "-";
    bool json = false;
};

/// How the field was computed: a message on standard error, or JSON on standard output.
void tell_how(const Field& field, const std::string& surface, bool as_json) {
    if (as_json) {
        nlohmann::json how = {{"region", field.region.text},
                              {"quantity", field.quantity},
                              {"points", field.region.grid.size()},
                              {"method", name_of(field.method)},
                              {"error", field.error}};
        if (!surface.empty()) how["surface"] = surface;
        tell(how, true);
        return;
    }
    fmt::print(stderr, "{}\n", description_of(field));
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

int field(const FieldCommand& command) {
    if (command.output == "-" && command.json)
        throw bad_argument("json", "the field would go to standard output, too; give --output a file");
    const Region region = region_of(command);
    const Quantity quantity = quantity_of(command.quantity);
    check_field_path(command.output, region, quantity);
    require_distinct(
        {{"image", command.source.image}, {"--pulses", command.source.pulses}, {"--manifest", command.source.manifest}},
        {{"--output", command.output}});
    Source source = command.source;
    if (!command.focus.empty()) source.focus = parse_point_mm("focus", command.focus);
    source.quantise = command.quantise.value_or("");
    Excitation excitation = open_excitation(source);
    if (command.am) {
        const MadeModulation made =
            modulation_of(*command.am, law_of(command.am_law.value_or("pressure")), excitation.array.carrier_hz);
        weaken(excitation, std::sqrt(mean_square_of(made.modulation)));
    }
    Field found;
    {
        ProgressLine progress("field");
        found = haptogram::field(excitation, region, quantity, command.threads, progress.callback());
    }
    const std::string surface = write_field(command.output, found, command.below_db);
    tell_how(found, surface, command.json);
    return 0;
}

}  // namespace

void add_field(CLI::App& app, Action& action) {
    auto options = std::make_shared<FieldCommand>();
    CLI::App* sub = app.add_subcommand(
        "field",
        "The sound field of an image, of one focal point, or of measured pulses, along a line, in a plane or a volume");
    auto* image = sub->add_option("image", options->source.image,
                                  "Intel HEX image, with its manifest beside it, or a project (.toml): the mean over "
                                  "its sequence. Or a manifest (.json): the same of exact phases, or a rig's manifest: "
                                  "of all its images together");
    sub->add_option("--record", options->source.record, "Only this record of the image")
        ->needs(image)
        ->check(whole(1, 65535));
    auto* focus = sub->add_option("--focus", options->focus, "Exact phases for x,y,z (mm) instead")->excludes(image);
    auto* array =
        sub->add_option("--array", options->source.array, "Array of --focus")->needs(focus)->capture_default_str();
    sub->add_option("--rig", options->source.rig, "Rig of --focus instead: several arrays in their places")
        ->needs(focus)
        ->excludes(array);
    auto* pulses = sub->add_option("--pulses", options->source.pulses, "Pulse file from simulate or board run instead")
                       ->excludes(image)
                       ->excludes(focus);
    auto* manifest =
        sub->add_option("--manifest", options->source.manifest, "Manifest of the image that was played")->needs(pulses);
    pulses->needs(manifest);
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
    sub->add_option("--quantity", options->quantity, about)->check(CLI::IsMember(names))->capture_default_str();
    add_am(*sub, options->am, options->am_law);
    add_quantise(*sub, options->quantise)->needs(focus);
    sub->add_option("--threads", options->threads, "0: as many as there are")
        ->check(whole(0, 1024))
        ->capture_default_str();
    sub->add_option("-o,--output", options->output,
                    "A .csv, .npy, .vti (ParaView) or .png file, or of a volume an .stl file, the surface --below the "
                    "greatest value; - is CSV on standard output")
        ->capture_default_str();
    sub->add_option("--below", options->below_db, "Of an .stl file: decibels below the greatest value of the volume")
        ->check(positive())
        ->capture_default_str();
    sub->add_flag("--json", options->json, "Print how it was computed, and how far it may be off, as JSON");
    sub->callback([options, &action] {
        action = [options] {
            if (options->source.image.empty() && options->focus.empty() && options->source.pulses.empty())
                throw bad_argument("field", "expected an image, --focus or --pulses; see haptogram field --help");
            return field(*options);
        };
    });
}

}  // namespace haptogram::cli
