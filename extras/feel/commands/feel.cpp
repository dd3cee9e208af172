// SPDX-License-Identifier: Apache-2.0
#include "haptogram/perception/feel.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "extras.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/perception/felt.hpp"
#include "haptogram/perception/magnitude.hpp"
#include "haptogram/verbs/analyze.hpp"
#include "haptogram/verbs/level.hpp"
#include "progress_line.hpp"
#include "report.hpp"
#include "skin_of_hand.hpp"
#include "source_options.hpp"

namespace haptogram::cli {

void add_feel(CLI::App& app, Action& action);
void add_magnitude(CLI::App& app, Action& action);
namespace {

using nlohmann::ordered_json;

SkinOfHand known_skin = nullptr;

struct FeelCommand {
    SourceOptions what;
    std::vector<std::string> at, ears{"0,-400,300"};
    std::string normal = "0,0,-1", region = "palm", tables = "multimodal", output;
    std::string hand, hand_model;
    std::size_t places = 8, hand_frame = 1;
    double contact_mm = default_contact_m / millimetre, grip_n = 1.0;
    std::optional<double> level_pa_m, volts;
    bool json = false;
};

ordered_json numbers_mm(Vec3 p) { return {p.x / millimetre, p.y / millimetre, p.z / millimetre}; }

std::string words_mm(Vec3 p) {
    return fmt::format("{:.1f}, {:.1f}, {:.1f}", p.x / millimetre, p.y / millimetre, p.z / millimetre);
}

/// A difference in decibels; nothing when there is none.
ordered_json decibels(double db) { return std::isfinite(db) ? ordered_json(db) : ordered_json(); }

ordered_json to_json(const perception::Verdict& verdict) {
    return {{"answer", perception::words_of(verdict.answer())},
            {"over_db", decibels(verdict.over_db)},
            {"least_db", decibels(verdict.least_db)},
            {"most_db", decibels(verdict.most_db)}};
}

ordered_json to_json(const FeltPlace& place) {
    ordered_json lines = ordered_json::array();
    for (const perception::FeltLine& line : place.felt.lines)
        lines.push_back({{"hz", line.hz},
                         {"force_mn", line.force_n * 1e3},
                         {"least_mn", line.least_n * 1e3},
                         {"over_db", line.over_db},
                         {"threshold_by", perception::name_of(line.basis)}});
    ordered_json json = {{"at_mm", numbers_mm(place.place.position)}};
    if (!place.part.empty()) {
        json["normal"] = {place.place.normal.x, place.place.normal.y, place.place.normal.z};
        json["part"] = place.part;
        json["off_skin_mm"] = place.off_skin_m / millimetre;
    }
    json.update({{"tilt", place.force.tilt},
                 {"mean_pa", place.mean_pa},
                 {"most_pa", place.most_pa},
                 {"mean_mn", place.mean_n * 1e3},
                 {"modulation_depth", place.depth},
                 {"lines", lines},
                 {"verdict", to_json(place.verdict)}});
    if (place.verdict.over_db > 0.0) {
        const perception::FeltLine& line = place.felt.lines.front();
        json["strength_steps"] = perception::strength_steps(place.verdict.over_db);
        if (const auto next = perception::next_frequency_hz(line.hz)) json["next_frequency_hz"] = *next;
    }
    if (place.felt.magnitude)
        json["magnitude"] = *place.felt.magnitude;
    else
        json["no_magnitude"] = place.felt.no_magnitude;
    return json;
}

std::string line_of(const FeltPlace& place, std::size_t number) {
    std::string text =
        fmt::format("{:>5} {:>22} {:>5.2f} {:>8.1f} {:>8.1f} {:>8.3f} {:>6.2f}", number, words_mm(place.place.position),
                    place.force.tilt, place.mean_pa, place.most_pa, place.mean_n * 1e3, place.depth);
    const std::string part =
        place.part.empty() ? "" : fmt::format("  {}, {:.1f} mm off", place.part, place.off_skin_m / millimetre);
    if (place.felt.lines.empty()) return text + "  nothing alternates between 10 Hz and 1 kHz: not felt" + part;
    const perception::FeltLine& line = place.felt.lines.front();
    text += fmt::format(" {:>8.1f} {:>8.4f} {:>8.4f} {:>12} {:>8.1f} {:>8}", line.hz, line.force_n * 1e3,
                        line.least_n * 1e3, perception::name_of(line.basis), place.verdict.over_db,
                        perception::words_of(place.verdict.answer()));
    return text +
           (place.felt.magnitude ? fmt::format(" {:>9.2f}", *place.felt.magnitude) : fmt::format(" {:>9}", "-")) + part;
}

/// What could be told apart from the strongest place's strongest line.
void tell_differences(Report& report, const Feeling& feeling) {
    const FeltPlace& best =
        *std::ranges::max_element(feeling.places, {}, [](const FeltPlace& place) { return place.verdict.over_db; });
    if (!(best.verdict.over_db > 0.0)) return;
    const double hz = best.felt.lines.front().hz;
    const auto [least, most] = perception::strength_steps(best.verdict.over_db);
    std::string text = fmt::format(
        "can be told apart: {} to {} strengths from the least felt to this one, by people whose vibrations were 20 "
        "to 35 dB over it",
        least, most);
    if (const auto next = perception::next_frequency_hz(hz))
        text += fmt::format("; {:.0f} Hz from {:.0f} to {:.0f} Hz or more", hz, next->at(0), next->at(1));
    report.tell(text + fmt::format("; a place to within {:g} mm", perception::place_error_m / millimetre));
}

void report_places(Report& report, const Feeling& feeling) {
    report.tell(fmt::format("{:>5} {:>22} {:>5} {:>8} {:>8} {:>8} {:>6} {:>8} {:>8} {:>8} {:>12} {:>8} {:>8} {:>9}",
                            "place", "skin / mm", "cos2", "mean/Pa", "most/Pa", "mean/mN", "depth", "line/Hz",
                            "line/mN", "least", "threshold by", "over/dB", "", "magnitude"));
    ordered_json places = ordered_json::array();
    for (const FeltPlace& place : feeling.places) {
        places.push_back(to_json(place));
        report.tell(line_of(place, places.size()));
    }
    report.add("places", places)
        .add("answer", perception::words_of(perception::answer_of(feeling.verdicts)))
        .add("verdict", perception::sentence_of(feeling.verdicts), perception::sentence_of(feeling.verdicts));
    tell_differences(report, feeling);
    for (const FeltPlace& place : feeling.places)
        if (!place.felt.magnitude) {
            report.tell(fmt::format("no magnitude, first of place {}: {}",
                                    static_cast<std::size_t>(&place - feeling.places.data()) + 1,
                                    place.felt.no_magnitude));
            break;
        }
}

void report_path(Report& report, const Feeling& feeling) {
    report.add("mean_pa", feeling.mean_pa,
               fmt::format("strength: {:.1f} Pa on average over time and places, spread {:.1f} %", feeling.mean_pa,
                           100.0 * feeling.spread));
    report.add("spread", feeling.spread);
    if (!feeling.speed_m_s) return;
    report.add("speed_m_s", *feeling.speed_m_s);
    if (feeling.wave_gain)
        report.add("wave_gain", *feeling.wave_gain,
                   fmt::format("the focus moves at {:.3g} m/s; waves in the skin make the deflection {:.2f} times that "
                               "of one that rests (a membrane, largest at 6 m/s)",
                               *feeling.speed_m_s, *feeling.wave_gain));
}

void report_sound(Report& report, const Feeling& feeling) {
    const perception::Noise& noise = feeling.noise;
    const bool silent = noise.lines.empty();
    report.add("noise",
               {{"relative_db", silent ? ordered_json() : ordered_json(noise.relative_db)},
                {"loudest_hz", silent ? ordered_json() : ordered_json(noise.loudest_hz)},
                {"largest_phase_step_deg", noise.largest_step_deg},
                {"reference", "every element at full drive under a sine from 0 to 1 at 200 Hz"}},
               silent ? "audible noise: none is expected of a steady drive"
                      : fmt::format("audible noise: {:+.1f} dB(A) beside a 200 Hz sine of the whole array, most at "
                                    "{:.0f} Hz; phases step by {:.1f} degrees at most",
                                    noise.relative_db, noise.loudest_hz, noise.largest_step_deg));
    const auto json_of = [](const perception::Exposure& ear) {
        return ordered_json{{"at_mm", numbers_mm(ear.ear)}, {"mean_db_spl", ear.mean_db}, {"most_db_spl", ear.most_db}};
    };
    ordered_json ears = ordered_json::array();
    for (const perception::Exposure& ear : feeling.ears) {
        ears.push_back(json_of(ear));
        report.tell(fmt::format("ultrasound at an ear at ({}) mm: {:.1f} dB SPL, {:.1f} dB at most", words_mm(ear.ear),
                                ear.mean_db, ear.most_db));
    }
    report.add("ears", ears)
        .add(
            "loudest_at_500_mm", json_of(feeling.loudest),
            fmt::format("loudest on a hemisphere of 500 mm: {:.1f} dB SPL at ({}) mm; {:g} dB are recommended for ears",
                        feeling.loudest.mean_db, words_mm(feeling.loudest.ear), recommended_for_ears_db))
        .add("recommended_for_ears_db_spl", recommended_for_ears_db);
}

/// What would help a shape that is not surely felt: the focus rests for 0.2 s at few places, under a modulation that a
/// palm feels best, and not far from the axis. A pass of 2.5 s is as long as the boards' sequences can modulate.
std::string advice(const Manifest& manifest) {
    const std::vector<Vec3> points = manifest.points();
    if (points.size() < 2) return "; try --am square:200";
    constexpr double small_m = 50 * millimetre;
    Vec3 low = points.front(), high = low;
    for (const Vec3& p : points) {
        low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
    const Vec3 extent = high - low;
    return fmt::format("; try --am square:200 --points 12 --rate 0.4{}",
                       std::max({extent.x, extent.y, extent.z}) > small_m ? " --size 50" : "");
}

int feel(const FeelCommand& command) {
    const Source source = source_of(command.what, "feel");
    if (!command.output.empty()) require_distinct(files_of(source), {{"--output", command.output}});
    if (!command.output.empty() && !command.output.ends_with(".png"))
        throw bad_argument("output", fmt::format("'{}' is no .png; the numbers are printed, with --json for programs",
                                                 command.output));
    FeelOptions options;
    for (const std::string& text : command.at) options.at.push_back(parse_point_mm("at", text));
    for (const std::string& text : command.ears) options.ears.push_back(parse_point_mm("ear", text));
    options.normal = parse_point_mm("normal", command.normal);
    if (!command.hand.empty() && known_skin == nullptr)
        throw bad_argument("hand", "this build has no hands; build with the extra hands");
    if (!command.hand.empty()) options.skin = known_skin(command.hand, command.hand_model, command.hand_frame);
    options.most_places = command.places;
    options.contact_m = command.contact_mm * millimetre;
    options.region = perception::region_of(command.region);
    options.grip_n = command.grip_n;
    options.tables = perception::find_tables(command.tables);
    options.level_pa_m = command.level_pa_m;
    options.supply_v = command.volts;
    Timeline timeline;
    Feeling feeling;
    {
        ProgressLine progress("feel");
        timeline = open_timeline(source);
        feeling = haptogram::feel(timeline, options, progress.callback());
    }
    if (!command.output.empty()) draw_feeling(command.output, timeline, options, feeling);
    for (const std::string& warning : feeling.warnings) complain("warning: " + warning);
    constexpr const char* note =
        "by models and printed tables of others; nothing was measured on people by this project";
    Report report;
    report.add("played", timeline.title,
               fmt::format("{}, {}: {:.4g} s of it", timeline.title, timeline.manifest.array.name, feeling.seconds));
    report.add("array", timeline.manifest.array.name).add("seconds", feeling.seconds);
    report.add("tables", options.tables.name).add("grip_n", command.grip_n);
    if (command.hand.empty()) report.add("region", command.region);
    report.add("extent_mm", feeling.extent_m / millimetre);
    report.add("contact_mm", command.contact_mm,
               fmt::format("F is on a flat disc of {:g} mm at the place", command.contact_mm));
    ordered_json level = level_json(timeline.manifest.array.transducer);
    level["used_pa_m"] = feeling.level.source_pa_m;
    report.add("level", level, feeling.level.text);
    const double nominal = timeline.manifest.array.transducer.source_pa_m;
    if (nominal != feeling.level.source_pa_m)
        report.tell(fmt::format("sound at ears is computed with the nominal {:g} Pa·m", nominal));
    report_places(report, feeling);
    report_path(report, feeling);
    report_sound(report, feeling);
    report.add("warnings", feeling.warnings).add("note", note, note).print(command.json);
    return 0;
}

}  // namespace

void add_feel(CLI::App& app, Action& action) {
    auto options = std::make_shared<FeelCommand>();
    CLI::App* sub = app.add_subcommand("feel", "Predict what a hand feels, and an ear hears, of what plays");
    add_source(*sub, options->what);
    sub->add_option("--at", options->at,
                    "A place on the skin: x,y,z mm; may be given several times; by default the foci")
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    sub->add_option("--places", options->places, "How many of the foci, evenly chosen")
        ->check(whole(1, 65535))
        ->capture_default_str();
    auto* normal =
        sub->add_option("--normal", options->normal,
                        "Direction that points out of the skin: x,y,z, of any length; by default towards the array")
            ->capture_default_str();
    auto* hand = sub->add_option("--hand", options->hand,
                                 "A hand, as render takes it: each place is the nearest one on its skin, with the "
                                 "normal and the region there")
                     ->excludes(normal);
    sub->add_option("--hand-frame", options->hand_frame, "Frame of its recording, from 1")
        ->needs(hand)
        ->check(whole(1, std::numeric_limits<std::uint32_t>::max()))
        ->capture_default_str();
    sub->add_option("--hand-model", options->hand_model, "Bones of a .pose file (default: model_hand.json beside it)")
        ->needs(hand);
    sub->add_option("--contact", options->contact_mm, "Diameter of the disc of skin over which the force is summed, mm")
        ->check(positive())
        ->capture_default_str();
    sub->add_option("--ear", options->ears, "Where a listener's ear is: x,y,z mm; may be given several times")
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
        ->capture_default_str();
    sub->add_option("--region", options->region, "palm or finger; magnitudes are known for the palm only")
        ->check(CLI::IsMember({"palm", "finger"}))
        ->excludes(hand)
        ->capture_default_str();
    sub->add_option("--grip", options->grip_n, "Grip force of the hand, N; 1 N for a bare hand")
        ->check(positive())
        ->capture_default_str();
    sub->add_option("--tables", options->tables, "Shipped perception file, or a file")->capture_default_str();
    auto* level = sub->add_option("--level", options->level_pa_m,
                                  "Source strength of an element, Pa·m (default: what is expected of the transducer)")
                      ->check(positive());
    sub->add_option("--volts", options->volts,
                    "Supply of the drivers, V, for the expected strength (default: the papers')")
        ->check(positive())
        ->excludes(level);
    sub->add_flag("--json", options->json, "Print as JSON");
    sub->add_option("-o,--output", options->output, "A picture, .png");
    sub->callback([options, &action] { action = [options] { return feel(*options); }; });
}

void use_skin_of_hand(SkinOfHand skin) { known_skin = skin; }

void register_feel(Extras& extras) {
    extras.commands[Purpose::measure].insert(extras.commands[Purpose::measure].end(), {add_feel, add_magnitude});
    extras.verdict = [](const Timeline& timeline, bool advises) {
        const std::string verdict = verdict_on(timeline);
        return verdict + (advises && !verdict.starts_with("felt") ? advice(timeline.manifest) : "");
    };
    extras.makers.of_magnitude = [](Path& path, const Project& project, const Array& array) {
        return perception::give_magnitude(path, project, array);
    };
}

}  // namespace haptogram::cli
