// SPDX-License-Identifier: Apache-2.0
#include "haptogram/scattering/scatter.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "extras.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/verbs/compile.hpp"
#include "haptogram/verbs/level.hpp"
#include "haptogram/verbs/source.hpp"
#include "progress_line.hpp"

namespace haptogram::cli {

void add_scatter(CLI::App& app, Action& action);
namespace {

using namespace scattering;

struct ScatterCommand {
    ScatterSource source;
    std::vector<std::string> foci;
    std::optional<double> radius_mm, length_mm, edge_mm;
    std::string plane_wave, ring, inward, center, rotate = "0,0,0", unit = "mm";
    bool json = false;
    std::string output;
};

std::optional<double> in_metres(const std::optional<double>& mm) {
    return mm ? std::optional(*mm * millimetre) : std::nullopt;
}

void print(const Scattered& s) {
    const auto in_mm = [](Vec3 p) {
        return fmt::format("({:.2f}, {:.2f}, {:.2f}) mm", p.x / millimetre, p.y / millimetre, p.z / millimetre);
    };
    const ErrorRange error = mesh_error(s.elements_per_wavelength());
    fmt::print("{}\n", s.title);
    fmt::print(
        "{:.1f} triangles a wavelength of {:.2f} mm ({:.1f} along the longest edge); sound pressure within {:.1f} "
        "to {:.1f} % of a smooth body's\n",
        s.elements_per_wavelength(), s.array.wavelength_m() / millimetre,
        s.array.wavelength_m() / s.body.longest_edge(), 100.0 * error.low, 100.0 * error.high);
    fmt::print("equations solved {}, residual {:.1e}\n",
               s.rounds > 0 ? fmt::format("in {} rounds", s.rounds) : "by factors", s.residual);
    fmt::print("highest mean radiation pressure {:.1f} Pa at {}\n", static_cast<double>(s.radiation[s.highest]),
               in_mm(s.body.panels[s.highest].centre));
    fmt::print("mean force ({:.3f}, {:.3f}, {:.3f}) mN, {:.3f} mN in all\n", s.force_n.x * 1e3, s.force_n.y * 1e3,
               s.force_n.z * 1e3, norm(s.force_n) * 1e3);
    if (s.ring)
        fmt::print(
            "ring of {} foci: the strongest presses {:.2f} times as much as the weakest, at most {:.1f} mm off its "
            "place\n",
            s.ring->foci, s.ring->uneven, s.ring->farthest_m / millimetre);
    if (!s.is_plane_wave) fmt::print("{}\n", level_text(s.array.transducer));
    if (s.resting > 0.0) fmt::print("nothing plays for {:.1f} % of the time\n", 100.0 * s.resting);
}

int scatter(const ScatterCommand& command) {
    if (!command.output.empty()) check_scattered_path(command.output);
    if (command.output == "-" && command.json)
        throw bad_argument("json", "the values would go to standard output, too; give --output a file");
    ScatterSource source = command.source;
    const std::string file = is_built_in_body(source.body.name) ? "" : source.body.name;
    if (!command.output.empty())
        require_distinct({{"the mesh", file}, {"--path", source.path}}, {{"--output", command.output}});
    for (const std::string& text : command.foci) source.foci.push_back(parse_point_mm("focus", text));
    if (!command.plane_wave.empty()) source.plane_wave = parse_point_mm("plane-wave", command.plane_wave);
    if (!command.ring.empty()) source.ring = parse_point_mm("ring", command.ring);
    if (!command.inward.empty()) source.inward = parse_point_mm("inward", command.inward);
    source.body.radius_m = in_metres(command.radius_mm);
    source.body.length_m = in_metres(command.length_mm);
    source.body.edge_m = in_metres(command.edge_mm);
    source.body.readers = path_makers().readers;
    source.body.metres_per_unit = metres_per_unit(command.unit);
    if (!command.center.empty()) source.body.placement.center = parse_point_mm("center", command.center);
    const Vec3 angles = parse_three("rotate", command.rotate, "degrees");
    source.body.placement.rotate_deg = {angles.x, angles.y, angles.z};
    ProgressLine progress("scatter");
    const Scattered found = scattering::scatter(source, progress.callback());
    if (!command.output.empty()) write_scattered(command.output, found);
    if (command.output == "-") return 0;
    if (command.json)
        fmt::print("{}", to_json_text(found));
    else
        print(found);
    return 0;
}

}  // namespace

void add_scatter(CLI::App& app, Action& action) {
    auto options = std::make_shared<ScatterCommand>();
    CLI::App* sub = app.add_subcommand(
        "scatter", "Sound and radiation pressure on the skin of a rigid body, such as a finger, by boundary elements");
    sub->add_option("body", options->source.body.name,
                    "A closed mesh (.ply, .obj, .stl, .off, .3mf, .gltf or .glb), or a built-in body: sphere, or "
                    "finger, a cylinder with round "
                    "ends along z")
        ->required();
    auto* focus = sub->add_option("--focus", options->foci,
                                  "Exact phases for x,y,z (mm); given again, one after the other for equal times");
    auto* path = sub->add_option("--path", options->source.path, "A path file (.json, .csv, .adaptics) instead")
                     ->excludes(focus);
    sub->add_option("--plane-wave", options->plane_wave,
                    "Or a plane wave of 1 Pa that travels in the direction x,y,z, at the array's frequency")
        ->excludes(focus)
        ->excludes(path);
    auto* ring = sub->add_option("--ring", options->ring,
                                 "Or ten foci around the built-in finger, where a surface through x,y,z (mm) cuts it")
                     ->excludes(focus)
                     ->excludes(path);
    sub->add_option("--inward", options->inward, "At the ring's surface: into the object, x,y,z (default: 0,0,-1)")
        ->needs(ring);
    sub->add_flag("--weighed", options->source.weighed,
                  "The ring's foci as live plays them: weaker where more of the sound arrives")
        ->needs(ring);
    auto* array =
        sub->add_option("--array", options->source.array, "Array file or shipped array")->capture_default_str();
    sub->add_option("--rig", options->source.rig, "Rig file or shipped rig instead: several arrays in their places")
        ->excludes(array);
    sub->add_option("--radius", options->radius_mm, "Radius of a built-in body, mm (default: 8)")->check(positive());
    sub->add_option("--length", options->length_mm, "Length of the finger with its ends, mm (default: 50)")
        ->check(positive());
    sub->add_option("--edge", options->edge_mm,
                    "Edge of a built-in body's triangles, mm (default: an eighth of the wavelength)")
        ->check(positive());
    sub->add_option("--unit", options->unit, "Unit of the coordinates in the mesh")
        ->check(CLI::IsMember({"mm", "cm", "m", "inch"}))
        ->capture_default_str();
    sub->add_option("--center", options->center, "Where the middle of the body goes, x,y,z in mm");
    sub->add_option("--rotate", options->rotate, "Turn it about its middle: degrees about x, then y, then z")
        ->capture_default_str();
    sub->add_flag("--foci-inside", options->source.foci_inside,
                  "Allow foci inside the body: the array aims there, and the sound stops at the skin");
    sub->add_option("--least-elements", options->source.least_elements,
                    "Refuse meshes with fewer triangles a wavelength along their mean edge")
        ->check(positive())
        ->capture_default_str();
    auto* json = sub->add_flag("--json", options->json, "The report as JSON on standard output");
    sub->add_flag("--flat", options->source.flat_estimate,
                  "Also the estimate of haptogram feel, which takes the skin for flat and large")
        ->needs(json);
    sub->add_option("-o,--output", options->output,
                    "Values of each triangle: .csv, .vtp (ParaView) or .png; - is CSV on standard output");
    sub->callback([options, &action] { action = [options] { return scatter(*options); }; });
}

void register_scattering(Extras& extras) { extras.commands[Purpose::measure].push_back(add_scatter); }

}  // namespace haptogram::cli
