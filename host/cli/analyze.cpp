// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/analyze.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "haptogram/acoustics/skin_force.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/verbs/field.hpp"
#include "haptogram/verbs/level.hpp"
#include "level_options.hpp"
#include "progress_line.hpp"
#include "report.hpp"
#include "source_options.hpp"

namespace haptogram::cli {
namespace {

constexpr double contact_mm = default_contact_m / millimetre;

struct AnalyzeOptions {
    SourceOptions what;
    std::string plane = "xz@y=0";
    double extent_mm = 150.0, step_mm = 2.0;
    double least_mn = least_felt_n * 1e3;
    LevelOptions level;
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
            {"heat_limit_mn", rounded(point.heat_limit_n * 1e3)},
            {"impulse_mn_ms", rounded(point.impulse_ns * 1e6)},
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

int analyze_source(const AnalyzeOptions& options) {
    ImageAnalysis analysis;
    Array array;
    {
        ProgressLine progress("analyze");
        const Progress all = progress.callback();
        const Timeline timeline = open_timeline(source_of(options.what, "analyze"), all);
        array = timeline.manifest.array;
        analysis = analyze(timeline, options.least_mn * 1e-3, all);
    }
    nlohmann::ordered_json points = nlohmann::ordered_json::array();
    Report report;
    for (const PointAnalysis& point : analysis.points) points.push_back(to_json(point));
    for (const std::string& warning : analysis.warnings) report.tell("warning: " + warning);
    if (!analysis.points.empty()) {
        const auto hottest = std::ranges::min_element(
            analysis.points, {}, [](const PointAnalysis& p) { return p.heat_limit_n / p.focus.force_n; });
        report.tell(
            fmt::format("the strongest focus would warm skin more than is safe in tissue from {:.0f} mN on "
                        "(Hoshi 2010, 2.4), {:.1f} times its force here",
                        hottest->heat_limit_n * 1e3, hottest->heat_limit_n / hottest->focus.force_n));
        const auto lost = std::ranges::min_element(analysis.points, {}, &PointAnalysis::left_in_other_air);
        report.add("least_left_in_other_air", lost->left_in_other_air,
                   fmt::format("air that is {:.0f} degrees C warmer or colder than computed for leaves {:.1f} % of the "
                               "pressure of a focus",
                               other_air_c, 100.0 * lost->left_in_other_air));
        const auto windiest = std::ranges::max_element(analysis.points, {}, &PointAnalysis::impulse_ns);
        report.tell(fmt::format(
            "the flow of air behind a focus grows with its force's impulse in a dwell, {:.4g} mN·ms at most "
            "(Hoshi 2010, eq. 8)",
            windiest->impulse_ns * 1e6));
    }
    const nlohmann::ordered_json safe = safety(analysis.loudness);
    const Transducer& transducer = array.transducer;
    report.add("points", points)
        .add("contact_mm", contact_mm, fmt::format("F is on a flat disc of {:g} mm at the focus", contact_mm))
        .add("source_of_impulse",
             "T. Hoshi et al., IEEE Trans. Haptics 3 (2010), eq. 8: the flow of air grows with the impulse of the "
             "force; "
             "it gives no speed")
        .add("level", level_json(transducer), level_text(transducer))
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
                         safe["note"].get<std::string>()));
    report.tell(fmt::format("{:>5} {:>24} {:>8} {:>4} {:>8} {:>7} {:>9} {:>8} {:>7} {:>7} {:>6} {:>8} {:>7}", "point",
                            "focus / mm", "spread/us", "beta", "T_f/us", "dwell", "needed", "p / Pa", "P / Pa", "width",
                            "depth", "side", "F / mN"));
    for (std::size_t i = 0; i < analysis.points.size(); ++i) report.tell(line_of(analysis.points[i], i + 1));
    report.print(options.json);
    return 0;
}

const std::vector<OptionOf> options_of_kinds = {{"--plane", {"a map"}},
                                                {"--extent", {"a map"}},
                                                {"--step", {"a map"}},
                                                {"--output", {"a map"}},
                                                {"--least-force", {"an analysis"}},
                                                {"--json", {"an analysis"}},
                                                {"--board", {"an analysis"}},
                                                {"--manifest", {"an analysis"}},
                                                {"--quantise", {"an analysis"}}};

/// What was measured says of the array's source strength.
int calibrate(const AnalyzeOptions& options) {
    const Source source = source_of(options.what, "analyze");
    if (!source.focus || !source.rig.empty())
        throw bad_argument(options.level.measured_mn ? "measured-mn" : "measured-mv",
                           "is of a focus of one array: give --array and --focus");
    fmt::print("[transducer]\n{}", calibrated_keys(find_array(source.array.value_or("tile-10x10")), *source.focus,
                                                   options.level.reading()));
    return 0;
}

int analyze_array(const AnalyzeOptions& options) {
    const Array array = find_array(*options.what.source.array);
    const Region region = parse_region("plane", options.plane,
                                       {options.extent_mm * millimetre, options.step_mm * millimetre, {}, {}, {}});
    const std::string output = options.output.empty() ? "-" : options.output;
    check_field_path(output, region, Quantity::rms);
    write_field(output, workspace_field(array, region));
    fmt::print(stderr, "{}\n", level_text(array.transducer));
    return 0;
}

}  // namespace

void add_analyze(CLI::App& app, Action& action) {
    auto options = std::make_shared<AnalyzeOptions>();
    CLI::App* sub = app.add_subcommand("analyze",
                                       "Measure each focus of an input, and how loud it is; or, with --array alone, "
                                       "the pressure that the array reaches in each place");
    add_source(*sub, options->what);
    sub->add_option("--least-force", options->least_mn,
                    "Warn of points with less in their focus, mN (default: 0.06 gf, about the least that a palm felt "
                    "in Table III of doi:10.1109/JSEN.2022.3144888)")
        ->check(positive())
        ->capture_default_str();
    sub->add_option("--plane", options->plane, "Plane of the map: xy@z=MM, xz@y=MM or yz@x=MM")->capture_default_str();
    sub->add_option("--extent", options->extent_mm, "Extent of the map: half-width, mm")
        ->check(positive())
        ->capture_default_str();
    sub->add_option("--step", options->step_mm, "Step of the map, mm")->check(positive())->capture_default_str();
    sub->add_option("-o,--output", options->output,
                    "The map as .csv, .npy, .vti or .png; default CSV on standard output");
    add_level_options(*sub, options->level, "Instead: print the level for the array's file, ");
    sub->add_flag("--json", options->json, "Print the analysis as JSON");
    sub->callback([options, sub, &action] {
        action = [options, given = given_to(*sub)] {
            const Source& source = options->what.source;
            const bool map =
                source.array && source.file.empty() && options->what.focus.empty() && source.pulses.empty();
            const char* const wanted = options->level.given() ? "a level" : map ? "a map" : "an analysis";
            require_effect(given, options_of_kinds, wanted, "what these options ask for");
            if (options->level.given()) return calibrate(*options);
            return map ? analyze_array(*options) : analyze_source(*options);
        };
    });
}

}  // namespace haptogram::cli
