// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/analyze.hpp"

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/verbs/field_file.hpp"
#include "haptogram/verbs/source.hpp"
#include "progress_line.hpp"
#include "report.hpp"

namespace haptogram::cli {
namespace {

struct AnalyzeOptions {
    std::string image, array;
    std::string plane = "xz@y=0";
    double extent_mm = 150.0, step_mm = 2.0;
    double least_mn = least_felt_n * 1e3;
    std::string output;
    bool json = false;
};

nlohmann::ordered_json to_json(const PointAnalysis& point) {
    const FocusAnalysis& a = point.focus;
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
            {"force_mn", rounded(a.force_n * 1e3)},
            {"dwell_cycles", point.dwell_cycles},
            {"too_weak", point.too_weak}};
}

/// Information, not certification: it is what this model computes, beside what one paper says.
nlohmann::ordered_json safety(const Loudness& loud) {
    const auto rounded = [](double value) { return std::round(value * 10.0) / 10.0; };
    return {
        {"note", "information computed from a model, no certification; keep ears away from the array"},
        {"highest_on_axis_db_spl", rounded(loud.highest_db)},
        {"highest_at_mm", rounded(loud.highest_at_m / millimetre)},
        {"at_300_mm_db_spl", rounded(loud.at_300_mm_db)},
        {"recommended_for_ears_db_spl", recommended_for_ears_db},
        {"intensity_w_m2", rounded(loud.intensity_w_m2)},
        {"safe_in_tissue_w_m2", safe_in_tissue_w_m2},
        {"source_of_limits",
         "T. Hoshi et al., IEEE Trans. Haptics 3 (2010), section 2.4: 110 dB SPL for ears; 100 mW/cm2 in tissue, of "
         "which skin absorbs 0.1 %"}};
}

std::string line_of(const PointAnalysis& point, std::size_t number) {
    const FocusAnalysis& f = point.focus;
    return fmt::format(
        "{:>5} {:>24} {:>8.1f} {:>4} {:>8.1f} {:>7} {:>9} {:>8.0f} {:>7.1f} {:>7.1f} {:>6.1f} {:>8.3f} {:>7.2f}{}",
        number,
        fmt::format("{:.1f}, {:.1f}, {:.1f}", f.focus.x / millimetre, f.focus.y / millimetre, f.focus.z / millimetre),
        f.formation.flight_spread_s * 1e6, f.formation.periods, f.formation.formation_s * 1e6, point.dwell_cycles,
        f.dwell_cycles, f.pressure_pa, f.radiation_pa, f.width_m / millimetre, f.depth_m / millimetre, f.side_lobe,
        f.force_n * 1e3, point.too_weak ? "  weak" : "");
}

int analyze_image(const AnalyzeOptions& options) {
    ImageAnalysis analysis;
    {
        ProgressLine progress("analyze");
        analysis = analyze(open_bundle(options.image), options.least_mn * 1e-3, progress.callback());
    }
    nlohmann::ordered_json points = nlohmann::ordered_json::array();
    Report report;
    report.tell(fmt::format("{:>5} {:>24} {:>8} {:>4} {:>8} {:>7} {:>9} {:>8} {:>7} {:>7} {:>6} {:>8} {:>7}", "point",
                            "focus / mm", "spread/us", "beta", "T_f/us", "dwell", "needed", "p / Pa", "P / Pa", "width",
                            "depth", "side", "F / mN"));
    for (const PointAnalysis& point : analysis.points) {
        points.push_back(to_json(point));
        report.tell(line_of(point, points.size()));
    }
    for (const std::string& warning : analysis.warnings) report.tell("warning: " + warning);
    const nlohmann::ordered_json safe = safety(analysis.loudness);
    report.add("points", points)
        .add("warnings", analysis.warnings)
        .add("pressure_left_least", analysis.pressure_left.least,
             fmt::format("the transducers' bandwidth leaves {:.1f} % of the pressure at the worst point, {:.1f} % on "
                         "average",
                         100.0 * analysis.pressure_left.least, 100.0 * analysis.pressure_left.mean))
        .add("pressure_left_mean", analysis.pressure_left.mean)
        .add("safety", safe,
             fmt::format("sound on the axis, averaged over the sequence: {} dB SPL at most, at {} mm, {} dB at 300 mm; "
                         "{} dB are recommended for ears\n{}",
                         safe["highest_on_axis_db_spl"].dump(), safe["highest_at_mm"].dump(),
                         safe["at_300_mm_db_spl"].dump(), safe["recommended_for_ears_db_spl"].dump(),
                         safe["note"].get<std::string>()))
        .print(options.json);
    return 0;
}

int analyze_array(const AnalyzeOptions& options) {
    const Array array = find_array(options.array);
    const Region region = parse_region("plane", options.plane,
                                       {options.extent_mm * millimetre, options.step_mm * millimetre, {}, {}, {}});
    const std::string output = options.output.empty() ? "-" : options.output;
    check_field_path(output, region, Quantity::rms);
    write_field(output, workspace_field(array, region));
    return 0;
}

}  // namespace

void add_analyze(CLI::App& app, Action& action) {
    auto options = std::make_shared<AnalyzeOptions>();
    CLI::App* sub = app.add_subcommand(
        "analyze",
        "What each point of an image is like, and how loud it all is; or what pressure an array can reach where");
    auto* image =
        sub->add_option("image", options->image, "Intel HEX image, with its manifest beside it, or a project (.toml)");
    auto* array =
        sub->add_option("--array", options->array, "Map the workspace of this array instead")->excludes(image);
    sub->add_option("--least-force", options->least_mn,
                    "Warn of points with less in their focus, mN (default: 0.06 gf, about the least that a palm felt "
                    "in Table III of doi:10.1109/JSEN.2022.3144888)")
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
