// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/compile.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "command.hpp"
#include "extras.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/shape/path_file.hpp"
#include "haptogram/verbs/compile_numbers.hpp"
#include "haptogram/verbs/level.hpp"
#include "haptogram/verbs/rig.hpp"
#include "haptogram/verbs/source.hpp"
#include "progress_line.hpp"
#include "report.hpp"
#include "setting_options.hpp"

namespace haptogram::cli {
namespace {

/// The options that were given. What is not given comes from the project file, or is the default.
struct CompileOptions {
    std::vector<std::string> inputs;  ///< shape files, one path file, or one project file
    std::vector<std::string> shapes;
    Given<Project> settings;
    Given<Placement> place;
    Given<ShapeSource> of_shapes;  ///< of every input and --shape that can have it
    std::optional<std::string> rig;
    bool foci = false, records = false;
    std::string output = "image.hex";
    std::string save_path;
    std::string manifest, readmemh;
    bool json = false;
    std::vector<std::string> given;  ///< names of those on the command line
};

Project project_of(const CompileOptions& options) {
    Project project;
    std::vector<std::string> files = options.inputs;
    const bool in_file = files.size() == 1 && is_project(files.front());
    if (in_file) {
        if (!options.shapes.empty())
            throw bad_argument("--shape", fmt::format("{} says what the shape is, and would play both; leave --shape "
                                                      "out, or write it as a [[shape]] into the project",
                                                      files.front()));
        project = load_project(files.front());
        files.clear();
    }
    project.makers = path_makers();
    for (const std::string& file : files) {
        if (file.empty()) throw bad_input("\"\"", "an input's name is empty; name a shape file, a path or a project");
        if (is_path_file(file)) {
            if (!project.path.empty() || std::ranges::find(options.given, "--path") != options.given.end())
                throw bad_argument("--path", fmt::format("{} is a path, too, and only one is played; leave one of them "
                                                         "out",
                                                         file));
            project.path = file;
            continue;
        }
        ShapeSource source;
        source.file = file;
        project.shapes.push_back(source);
    }
    for (const std::string& kind : options.shapes) {
        ShapeSource source;
        source.primitive.kind = kind;
        project.shapes.push_back(source);
    }
    for (const auto& [setting, value] : options.of_shapes) {
        bool is_of_one = false;
        for (ShapeSource& source : project.shapes) {
            if (in_file || !setting->has_effect(source)) continue;
            setting->put(source, *setting, value);
            is_of_one = true;
        }
        if (!is_of_one)
            throw bad_argument(std::string(setting->option),
                               fmt::format("is of {} on the command line, and there is none; {}", setting->subject,
                                           in_file ? "a project file says it for each of its shapes"
                                                   : "inputs are files, and --shape adds a built-in one"));
    }
    for (const auto& [setting, value] : options.settings) {
        const bool is_file = std::holds_alternative<File>(setting->kind);
        if (in_file && (is_file || std::holds_alternative<FileOrName>(setting->kind))) {
            const std::string& name = std::get<std::string>(value);
            setting->put(project, *setting, is_file ? std::filesystem::absolute(name).string() : from_here(name));
        } else {
            setting->put(project, *setting, value);
        }
    }
    options.place.put(project.placement);
    if (options.foci || options.records) project.image = options.foci ? ImageKind::foci : ImageKind::records;
    require_effect(options.given, project);
    return project;
}

/// A rig has one manifest and many images, which are called after it.
void check_rig_paths(CompileOptions& options) {
    if (options.output == "-" || !options.manifest.empty() || !options.readmemh.empty())
        throw bad_argument(options.output == "-"       ? "output"
                           : !options.manifest.empty() ? "manifest"
                                                       : "readmemh",
                           "is for one image, and a rig has one for each tile; name a file with -o wall.json, and the "
                           "images become wall.tile-1.hex and so on");
    options.output = manifest_path(options.output);
}

void check_paths(CompileOptions& options) {
    if (options.output.empty()) throw bad_argument("--output", "the name is empty; name the image");
    std::string beside;
    if (options.manifest.empty() && !options.rig) {
        if (options.output == "-")
            throw bad_argument("-o -", "needs --manifest FILE: an image is of little use without its manifest");
        options.manifest = manifest_path(options.output);
        beside = options.output;
    }
    if (options.rig) check_rig_paths(options);
    std::vector<NamedPath> inputs;
    for (const std::string& input : options.inputs) inputs.push_back({"an input", input});
    for (const auto& [setting, value] : options.settings) {
        const auto* name = std::get_if<std::string>(&value);
        const bool is_file = std::holds_alternative<File>(setting->kind);
        if (name != nullptr && (is_file || name->ends_with(".toml")))
            inputs.push_back({std::string(setting->option), *name});
    }
    if (options.rig && options.rig->ends_with(".toml")) inputs.push_back({"--rig", *options.rig});
    std::vector<NamedPath> outputs = {{"--output", options.output}};
    if (!options.rig) outputs.push_back({"--manifest", options.manifest, beside});
    if (!options.save_path.empty()) outputs.push_back({"--save-path", options.save_path});
    if (!options.readmemh.empty()) {
        outputs.push_back({"--readmemh", options.readmemh + ".primary.mem"});
        outputs.push_back({"--readmemh", options.readmemh + ".sequence.mem"});
    }
    require_distinct(inputs, outputs);
}

/// What stands behind each number, in lines for a person.
Report report_of(const Compiled& compiled, const CompileOptions& options) {
    const nlohmann::ordered_json numbers = numbers_of(compiled);
    const auto number = [&](const char* name) { return numbers[name].get<double>(); };
    const Manifest& m = compiled.bundle.manifest;
    const TouredPoints& p = compiled.points;
    const Timer& t = m.timer;
    std::string points = fmt::format("points            {}", m.records.size());
    if (p.clipped > 0) points += fmt::format(", {} out of reach left out", p.clipped);
    if (p.duplicates > 0) points += fmt::format(", {} duplicates left out", p.duplicates);
    Report report(numbers);
    report.tell(fmt::format("array             {}, {} elements on {} channels", m.array.name, m.array.elements.size(),
                            m.core.parameters.channels));
    report.tell(points);
    if (!p.points.empty())
        report.tell(fmt::format("tour              {:.1f} mm, {:.1f} mm as given", number("tour_mm"),
                                number("tour_as_given_mm")));
    report
        .tell(fmt::format("timer             prescaler {}, {} ticks of {:.0f} ns a cycle, pulse {} ticks ({:.1f} %), "
                          "carrier {:.1f} Hz",
                          t.prescaler, t.cycle_ticks, t.tick_s() * 1e9, t.pulse_ticks, 100.0 * t.duty(),
                          t.carrier_hz()))
        .tell(
            fmt::format("rendering rate    {:.4g} Hz, {:.1f} µs a point", m.rate_hz, number("shortest_dwell_s") * 1e6))
        .tell(fmt::format("flight spread ΔT  {:.1f} µs, β = {} periods", number("flight_spread_s") * 1e6,
                          m.formation.periods))
        .tell(fmt::format("focus forms in    T_f = {:.1f} µs, {:.1f} µs with the transducers' ring-up",
                          number("formation_s") * 1e6, number("formation_with_ring_up_s") * 1e6))
        .tell(fmt::format("full pressure for at most {} points at this rate, {} with ring-up",
                          numbers["most_points"].get<std::uint32_t>(),
                          numbers["most_points_with_ring_up"].get<std::uint32_t>()))
        .tell(options.rig ? std::string()
                          : fmt::format("image             {} ({} bytes), manifest {}", options.output,
                                        compiled.bundle.hex.size(), options.manifest));
    if (!options.rig) report.add("image", options.output).add("manifest", options.manifest);
    if (compiled.pace)
        report.tell(
            fmt::format("drawn             {:.1f} mm and jumps of {:.1f} mm at {:.4g} m/s, {:.4g} Hz, a point "
                        "every {:.3g} mm",
                        number("length_mm"), number("jumps_mm"), number("speed_m_s"), number("frequency_hz"),
                        number("spacing_mm")));
    if (compiled.evened)
        report.tell(
            fmt::format("even              spread {:.4f}, {:.4f} with equal dwells; weakest point {:.3f} of "
                        "before",
                        number("spread"), number("spread_before"), number("weakest_of_before")));
    if (!compiled.am_hz.empty())
        report.tell(fmt::format("modulation        {:.6g} Hz", fmt::join(compiled.am_hz, " Hz, ")));
    if (const auto& made = compiled.magnitude) {
        report.tell(fmt::format("magnitude         commands {:.4f}…{:.4f}{}", made->least_command, made->most_command,
                                made->moves ? "; it was measured with a focus that rests, and this one moves" : ""));
        const Transducer& transducer = compiled.bundle.manifest.array.transducer;
        report.add("level", level_json(transducer), "                  " + level_text(transducer));
    }
    return report.tell(fmt::format("bandwidth leaves  {:.1f} % of the pressure at the worst point, {:.1f} % on average",
                                   100.0 * number("pressure_left_least"), 100.0 * number("pressure_left_mean")));
}

/// Whether it is felt, where an extra knows.
void add_verdict(Report& report, const Project& project, const Bundle& bundle) {
    if (!extras().verdict || bundle.manifest.records.empty()) return;
    const bool advises = project.is_of_shapes() && project.am.empty() && project.key_frames.empty();
    const std::string verdict = extras().verdict(timeline_of(bundle), advises);
    report.add("verdict", verdict, "hand              " + verdict);
}

int compile_rig(const CompileOptions& options) {
    const Project project = project_of(options);
    CompiledRig compiled;
    {
        ProgressLine progress("compile");
        compiled = haptogram::compile_rig(project, *options.rig, options.output, progress.callback());
    }
    auto files = files_of(compiled.bundle);
    if (!options.save_path.empty())
        files.emplace_back(options.save_path,
                           to_json_text(compiled.whole.path, compiled.whole.bundle.manifest.timer.carrier_hz()));
    write_files(files);
    nlohmann::ordered_json images = nlohmann::ordered_json::array();
    for (const Bundle& tile : compiled.bundle.tiles) images.push_back(tile.name);
    report_of(compiled.whole, options)
        .add("rig", compiled.bundle.rig)
        .add("images", images)
        .add("manifest", options.output,
             fmt::format("rig               {}, {} tiles: {} to {}, manifest {}", compiled.bundle.rig, images.size(),
                         compiled.bundle.tiles.front().name, compiled.bundle.tiles.back().name, options.output))
        .print(options.json);
    for (const std::string& warning : compiled.whole.warnings) complain("warning: " + warning);
    return 0;
}

int compile(CompileOptions options) {
    check_paths(options);
    if (options.rig) return compile_rig(options);
    const Project project = project_of(options);
    Compiled compiled;
    {
        ProgressLine progress("compile");
        compiled = haptogram::compile(project, options.output, progress.callback());
    }
    std::vector<std::pair<std::filesystem::path, std::string>> files = {
        {options.output, compiled.bundle.hex}, {options.manifest, to_text(compiled.bundle.manifest)}};
    if (!options.readmemh.empty()) {
        files.emplace_back(options.readmemh + ".primary.mem", primary_readmemh(compiled.bundle.image));
        files.emplace_back(options.readmemh + ".sequence.mem", sequence_readmemh(compiled.bundle.image));
    }
    if (!options.save_path.empty())
        files.emplace_back(options.save_path, to_json_text(compiled.path, compiled.bundle.manifest.timer.carrier_hz()));
    write_files(files);
    if (options.output != "-" && options.manifest != "-") {
        Report report = report_of(compiled, options);
        add_verdict(report, project, compiled.bundle);
        report.print(options.json);
    }
    for (const std::string& warning : compiled.warnings) complain("warning: " + warning);
    return 0;
}

}  // namespace

void add_compile(CLI::App& app, Action& action) {
    auto options = std::make_shared<CompileOptions>();
    CLI::App* sub =
        app.add_subcommand("compile", "Turn shapes into an Intel HEX image of focal timings, and its manifest");
    sub->add_option("inputs", options->inputs,
                    "PLY, OBJ, STL, OFF, PCD, 3MF, glTF, SVG, XYZ or CSV files, - for standard input; several become "
                    "one shape. Or one path "
                    "(.json, .csv with times, .adaptics), or one project (.toml, .haptogram), whose settings the "
                    "options below then override");
    sub->add_option("--shape", options->shapes,
                    fmt::format("Built-in shape, may be repeated: {}", fmt::join(primitive_kinds(), ", ")));
    add_settings(*sub, shape_settings(), options->of_shapes);
    sub->add_option("--save-path", options->save_path, "Also write the path that the image plays, as JSON");
    add_settings(*sub, project_settings(), options->settings);
    sub->get_option("--am-law")->needs("--am");
    CLI::Option* array = sub->get_option("--array");
    array->description(fmt::format("{}; shipped: {}", array->get_description(), fmt::join(shipped_arrays(), ", ")));
    sub->add_option("--rig", options->rig,
                    fmt::format("Rig file (TOML) or shipped rig instead: {}. Writes an image for each of its boards, "
                                "beside a rig manifest",
                                fmt::join(shipped_rigs(), ", ")))
        ->excludes(array);
    auto* foci = sub->add_flag("--foci", options->foci,
                               "Foci of 8 bytes each, from which the board computes the timings, and the modulation in "
                               "the board's own memory (default, if the board computes foci)");
    sub->add_flag("--records", options->records,
                  "A record of timings for each focal point and each of its strengths (default otherwise)")
        ->excludes(foci);
    add_settings(*sub, place_settings(), options->place);
    sub->add_option("-o,--output", options->output, "Image; - is standard output")->capture_default_str();
    sub->add_option("--manifest", options->manifest, "Manifest (default: the image's name with .json)");
    sub->add_option("--readmemh", options->readmemh,
                    "Also write PREFIX.primary.mem and PREFIX.sequence.mem for $readmemh");
    sub->add_flag("--json", options->json, "Report as JSON");
    sub->callback([sub, options, &action] {
        options->given = given_to(*sub);
        action = [options] { return compile(*options); };
    });
}

}  // namespace haptogram::cli
