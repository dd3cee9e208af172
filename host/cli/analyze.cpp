// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "field_file.hpp"
#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/analysis/focus_analysis.hpp"
#include "haptogram/analysis/measure.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "progress_line.hpp"

namespace haptogram::cli {
namespace {

struct AnalyzeOptions {
    std::string image, array;
    std::string plane = "xz@y=0";
    double extent_mm = 150.0, step_mm = 2.0;
    double least_mn = 0.58;
    std::string output;
    bool json = false;
};

nlohmann::ordered_json to_json(const FocusAnalysis& a) {
    const auto rounded = [](double value) { return std::round(value * 1e4) / 1e4; };
    return {{"focus_mm",
             {rounded(a.focus.x / millimetre), rounded(a.focus.y / millimetre), rounded(a.focus.z / millimetre)}},
            {"flight_spread_us", rounded(a.formation.flight_spread_s * 1e6)},
            {"periods", a.formation.periods},
            {"formation_us", rounded(a.formation.formation_s * 1e6)},
            {"ring_up_us", rounded(a.formation.ring_up_s * 1e6)},
            {"dwell_needed_cycles", a.dwell_cycles},
            {"pressure_pa", rounded(a.pressure_pa)},
            {"radiation_pressure_pa", rounded(a.radiation_pa)},
            {"width_mm", rounded(a.width_m / millimetre)},
            {"depth_mm", rounded(a.depth_m / millimetre)},
            {"side_lobe", rounded(a.side_lobe)},
            {"force_mn", rounded(a.force_n * 1e3)}};
}

/// Information, not certification: it is what this model computes, beside what one paper says.
nlohmann::ordered_json safety(const Loudness& loud) {
    constexpr double recommended_db = 110.0;
    constexpr double tissue_w_m2 = 1000.0;
    const auto rounded = [](double value) { return std::round(value * 10.0) / 10.0; };
    return {{"note", "information computed from a model, no certification; keep ears away from the array"},
            {"highest_on_axis_db_spl", rounded(loud.highest_db)},
            {"highest_at_mm", rounded(loud.highest_at_m / millimetre)},
            {"at_300_mm_db_spl", rounded(loud.at_300_mm_db)},
            {"recommended_for_ears_db_spl", recommended_db},
            {"intensity_w_m2", rounded(loud.intensity_w_m2)},
            {"safe_in_tissue_w_m2", tissue_w_m2},
            {"source_of_limits", "Hoshi 2.4: 110 dB SPL for ears; 100 mW/cm2 in tissue, of which skin absorbs 0.1 %"}};
}

int analyze_image(const AnalyzeOptions& options) {
    const std::string content = read_file(options.image);
    const Image image = from_intel_hex(content, options.image);
    const Manifest manifest = manifest_beside(options.image, content);
    if (manifest.foci.size() != image.records.size())
        throw bad_input(manifest_path(options.image), fmt::format("it has {} focal points, the image {} records",
                                                                  manifest.foci.size(), image.records.size()));
    std::vector<std::vector<std::complex<double>>> drives;
    std::vector<WeightedDrives> sequence;
    nlohmann::ordered_json points = nlohmann::ordered_json::array();
    std::vector<std::string> warnings;
    std::size_t weak = 0;
    std::size_t short_dwells = 0;
    ProgressLine progress("analyze");
    for (std::size_t i = 0; i < image.records.size(); ++i) {
        drives.push_back(drives_of(manifest, image.records[i]));
        const FocusAnalysis found = analyze(manifest.array, drives.back(), manifest.foci[i]);
        nlohmann::ordered_json point = to_json(found);
        point["dwell_cycles"] = manifest.dwell_cycles.at(i);
        point["too_weak"] = found.force_n * 1e3 < options.least_mn;
        weak += point["too_weak"].get<bool>() ? 1 : 0;
        short_dwells += manifest.dwell_cycles[i] < found.dwell_cycles ? 1 : 0;
        points.push_back(std::move(point));
        progress.update(static_cast<double>(i + 1) / static_cast<double>(image.records.size()));
    }
    for (std::size_t i = 0; i < drives.size(); ++i)
        sequence.push_back({static_cast<double>(manifest.dwell_cycles[i]), drives[i]});
    if (weak > 0)
        warnings.push_back(
            fmt::format("{} of {} points may be too weak to feel: less than {} mN in their focus (--least-force)", weak,
                        points.size(), options.least_mn));
    if (short_dwells > 0)
        warnings.push_back(
            fmt::format("{} of {} points are left before 90 % of their pressure is there; take fewer points or a "
                        "lower rate",
                        short_dwells, points.size()));
    const nlohmann::ordered_json safe = safety(loudness(manifest.array, sequence));
    if (options.json) {
        fmt::print("{}\n",
                   nlohmann::ordered_json{{"points", points}, {"warnings", warnings}, {"safety", safe}}.dump(1));
        return 0;
    }
    fmt::print("{:>5} {:>24} {:>8} {:>4} {:>8} {:>7} {:>9} {:>8} {:>7} {:>7} {:>6} {:>8} {:>7}\n", "point",
               "focus / mm", "spread/us", "beta", "T_f/us", "dwell", "needed", "p / Pa", "P / Pa", "width", "depth",
               "side", "F / mN");
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto& p = points[i];
        const auto value = [&p](const char* name) { return p.at(name).get<double>(); };
        fmt::print(
            "{:>5} {:>24} {:>8.1f} {:>4.0f} {:>8.1f} {:>7.0f} {:>9.0f} {:>8.0f} {:>7.1f} {:>7.1f} {:>6.1f} {:>8.3f} "
            "{:>7.2f}{}\n",
            i + 1,
            fmt::format("{:.1f}, {:.1f}, {:.1f}", p["focus_mm"][0].get<double>(), p["focus_mm"][1].get<double>(),
                        p["focus_mm"][2].get<double>()),
            value("flight_spread_us"), value("periods"), value("formation_us"), value("dwell_cycles"),
            value("dwell_needed_cycles"), value("pressure_pa"), value("radiation_pressure_pa"), value("width_mm"),
            value("depth_mm"), value("side_lobe"), value("force_mn"), p["too_weak"].get<bool>() ? "  weak" : "");
    }
    for (const std::string& warning : warnings) fmt::print("warning: {}\n", warning);
    fmt::print(
        "sound on the axis, averaged over the sequence: {} dB SPL at most, at {} mm, {} dB at 300 mm; {} dB are "
        "recommended "
        "for ears (Hoshi 2.4)\n{}\n",
        safe["highest_on_axis_db_spl"].dump(), safe["highest_at_mm"].dump(), safe["at_300_mm_db_spl"].dump(),
        safe["recommended_for_ears_db_spl"].dump(), safe["note"].get<std::string>());
    return 0;
}

int analyze_array(const AnalyzeOptions& options) {
    const Array array = find_array(options.array);
    FieldFile file{parse_region("--plane", options.plane,
                                {options.extent_mm * millimetre, options.step_mm * millimetre, {}, {}, {}}),
                   "reachable_pressure_pa",
                   "pressure amplitude that a focus can have / Pa",
                   {},
                   {},
                   array.name + ", focused on each point"};
    const std::string output = options.output.empty() ? "-" : options.output;
    check_field_path(output, file.region, false);
    file.parts = {workspace(array, file.region.grid)};
    write_field(output, file);
    return 0;
}

}  // namespace

void add_analyze(CLI::App& app, Action& action) {
    auto options = std::make_shared<AnalyzeOptions>();
    CLI::App* sub = app.add_subcommand(
        "analyze",
        "What each point of an image is like, and how loud it all is; or what pressure an array can reach where");
    auto* image = sub->add_option("image", options->image, "Intel HEX image, with its manifest beside it");
    auto* array =
        sub->add_option("--array", options->array, "Map the workspace of this array instead")->excludes(image);
    sub->add_option(
           "--least-force", options->least_mn,
           "Warn of points with less in their focus, mN (default: 0.06 gf, about the least that a palm felt in the "
           "Multimodal paper's Table III)")
        ->check(positive())
        ->capture_default_str();
    sub->add_option("--plane", options->plane, "Of the map: xy@z=MM, xz@y=MM or yz@x=MM")
        ->needs(array)
        ->capture_default_str();
    sub->add_option("--extent", options->extent_mm, "Of the map: half-width, mm")
        ->needs(array)
        ->check(positive())
        ->capture_default_str();
    sub->add_option("--step", options->step_mm, "Of the map, mm")
        ->needs(array)
        ->check(positive())
        ->capture_default_str();
    sub->add_option("-o,--output", options->output,
                    "The map as .csv, .npy, .vti or .png; default CSV on standard output")
        ->needs(array);
    sub->add_flag("--json", options->json, "Print the analysis as JSON")->excludes(array);
    sub->callback([options, &action] {
        action = [options] {
            if (options->image.empty() == options->array.empty())
                throw Error(ErrorCode::bad_argument, "analyze",
                            "expected an image or --array; see haptogram analyze --help");
            return options->image.empty() ? analyze_array(*options) : analyze_image(*options);
        };
    });
}

}  // namespace haptogram::cli
