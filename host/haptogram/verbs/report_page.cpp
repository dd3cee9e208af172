// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/report_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "haptogram/acoustics/skin_force.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/process.hpp"
#include "haptogram/verbs/field.hpp"
#include "haptogram/verbs/level.hpp"

namespace haptogram {
namespace {

using nlohmann::ordered_json;

bool modulated(const Compiled& compiled) {
    return !compiled.path.modulation.samples.empty() || compiled.bundle.manifest.modulation.has_value();
}

/// Points of a shape that are visited so many times a second, whose number is free to choose.
bool is_visited_at_rate(const Project& project) {
    return project.is_of_shapes() && !project.pace.speed_m_s && !project.pace.frequency_hz && !project.even &&
           project.am.empty();
}

/// Down to three digits, so that what is asked for is met.
double rounded_down(double value) {
    const double unit = std::pow(10.0, std::floor(std::log10(value)) - 2.0);
    // The digits of a double are those of its text: 2.97 and not 2.9700000000000002.
    return std::stod(fmt::format("{:.12g}", std::floor(value / unit) * unit));
}

/// Fewer points, or fewer passes, in which every dwell has at least so many carrier periods.
std::vector<Remedy> longer_dwells(const Project& project, const Compiled& compiled, std::uint32_t periods) {
    if (!is_visited_at_rate(project)) return {};
    const double carrier_hz = compiled.bundle.manifest.timer.carrier_hz();
    // Key frames make the path longer than the pass, whose points it repeats.
    const std::size_t count = compiled.points.points.size();
    std::vector<Remedy> found;
    // Dwells are rounded to whole periods, so that some are one shorter than their share.
    const auto points = static_cast<std::size_t>(carrier_hz / project.rate_hz / periods);
    if (points >= 3 && points < count) found.push_back({fmt::format("Take {} points", points), {{"points", points}}});
    const double rate_hz = rounded_down(carrier_hz / (static_cast<double>(count) * periods));
    if (rate_hz > 0.0 && rate_hz < project.rate_hz)
        found.push_back({fmt::format("Make {:g} passes a second", rate_hz), {{"rate_hz", rate_hz}}});
    return found;
}

void find_short_dwells(const Project& project, const Compiled& compiled, std::vector<Finding>& found) {
    const std::string words = short_dwell_warning(compiled);
    if (words.empty()) return;
    const Manifest& manifest = compiled.bundle.manifest;
    const auto needed =
        static_cast<std::uint32_t>(std::ceil(manifest.formation.with_ring_up_s() / manifest.timer.period_s() - 1e-9));
    found.push_back({"short-dwell", words, {}, longer_dwells(project, compiled, needed)});
}

void find_steady(const Compiled& compiled, std::vector<Finding>& found) {
    if (modulated(compiled)) return;
    const std::vector<PathStep>& steps = compiled.path.steps;
    if (!std::all_of(steps.begin(), steps.end(), [&](const PathStep& step) { return step.foci == steps[0].foci; }))
        return;
    found.push_back({"steady",
                     "the focal point neither moves nor changes, and skin hardly feels a steady pressure; let its "
                     "amplitude follow a waveform",
                     {},
                     {{"Modulate with 200 Hz", {{"am", "sine:200"}}}}});
}

void find_lost_to_bandwidth(const Compiled& compiled, std::vector<Finding>& found) {
    constexpr double least_left = 0.5;
    const Manifest& manifest = compiled.bundle.manifest;
    if (compiled.pressure_left.least >= least_left || modulated(compiled)) return;
    const std::vector<double> left = pressure_left(manifest.array, compiled.path);
    std::set<std::size_t> records;
    for (std::size_t step = 0; step < left.size(); ++step) {
        if (compiled.path.steps[step].foci.empty() || left[step] >= least_left) continue;
        const Vec3 place = compiled.path.steps[step].foci.front().position;
        for (std::size_t i = 0; i < manifest.records.size(); ++i)
            if (!manifest.records[i].foci.empty() && manifest.records[i].foci.front().position == place)
                records.insert(i);
    }
    found.push_back({"bandwidth",
                     fmt::format("the transducers' bandwidth leaves the weakest focus {:.0f} % of its pressure; foci "
                                 "that lie nearer together in their order, or last longer, keep more",
                                 100.0 * compiled.pressure_left.least),
                     {records.begin(), records.end()}});
}

/// Without the records in which a modulation makes a focus weak on purpose.
ImageAnalysis at_full_strength(const Compiled& compiled, ImageAnalysis analysis) {
    if (compiled.path.modulation.samples.empty()) return analysis;
    const Manifest& manifest = compiled.bundle.manifest;
    const auto place = [](const RecordMeaning& record) {
        const Vec3& at = record.foci.front().position;
        return std::tuple(at.x, at.y, at.z);
    };
    std::map<std::tuple<double, double, double>, double> most;  // of each place: some may be weaker than others
    for (const RecordMeaning& record : manifest.records) {
        double& so_far = most[place(record)];
        so_far = std::max(so_far, record.amplitude);
    }
    std::erase_if(analysis.points, [&](const PointAnalysis& point) {
        const RecordMeaning& record =
            manifest.records[manifest.place_of(static_cast<std::uint32_t>(point.record)).value()];
        return record.amplitude < 0.99 * most[place(record)];
    });
    return analysis;
}

/// Places of the records for which `is` holds of one of their foci.
template <class Is>
std::vector<std::size_t> records_that(const Manifest& manifest, const ImageAnalysis& analysis, Is is) {
    std::set<std::size_t> found;
    for (const PointAnalysis& point : analysis.points)
        if (is(point)) found.insert(manifest.place_of(static_cast<std::uint32_t>(point.record)).value());
    return {found.begin(), found.end()};
}

/// In how many places the foci of some records are.
std::size_t weak_points(const Manifest& manifest, const std::vector<std::size_t>& records) {
    std::set<std::tuple<double, double, double>> places;
    for (const std::size_t record : records)
        for (const Focus& focus : manifest.records[record].foci)
            places.insert({focus.position.x, focus.position.y, focus.position.z});
    return places.size();
}

void find_weak(const Compiled& compiled, const ImageAnalysis& analysis, std::vector<Finding>& found) {
    const auto records =
        records_that(compiled.bundle.manifest, analysis, [](const PointAnalysis& p) { return p.too_weak; });
    if (records.empty()) return;
    double least = INFINITY;
    for (const PointAnalysis& point : analysis.points) least = std::min(least, point.focus.force_n);
    const std::size_t points = compiled.bundle.manifest.points().size();
    found.push_back(
        {"weak",
         fmt::format("{} of {} point{} may be too weak to feel: the weakest has {:.3g} mN, which is {:.0f} % of the "
                     "{:.3g} mN that a palm is known to feel; nearer to the array, or to its axis, it is stronger",
                     weak_points(compiled.bundle.manifest, records), points, points == 1 ? "" : "s", least * 1e3,
                     100.0 * least / least_felt_n, least_felt_n * 1e3),
         records});
}

void find_uneven(const Project& project, const Compiled& compiled, const ImageAnalysis& analysis,
                 std::vector<Finding>& found) {
    if (modulated(compiled)) return;  // records of one focus then share its time
    if (project.fade) return;         // it is to be stronger at one side
    const auto strength = [](const PointAnalysis& p) {
        return p.focus.radiation_pa * static_cast<double>(p.dwell_cycles);
    };
    double most = 0.0, least = INFINITY;
    for (const PointAnalysis& point : analysis.points) {
        most = std::max(most, strength(point));
        least = std::min(least, strength(point));
    }
    if (least >= least_even_share * most) return;
    Finding finding{"uneven",
                    fmt::format("the weakest focus has {:.0f} % of the radiation pressure that the strongest has, "
                                "weighted by the time that each lasts; they will not feel alike",
                                100.0 * least / most),
                    records_that(compiled.bundle.manifest, analysis,
                                 [&](const PointAnalysis& p) { return strength(p) < least_even_share * most; })};
    if (project.is_of_shapes() && !project.even)
        finding.remedies.push_back({"Give the weak ones more time", {{"even", true}}});
    found.push_back(std::move(finding));
}

void find_side_lobes(const Compiled& compiled, const ImageAnalysis& analysis, std::vector<Finding>& found) {
    const auto records = records_that(compiled.bundle.manifest, analysis,
                                      [](const PointAnalysis& p) { return p.focus.side_lobe > most_side_lobe; });
    if (records.empty()) return;
    double most = 0.0;
    for (const PointAnalysis& point : analysis.points) most = std::max(most, point.focus.side_lobe);
    found.push_back({"side-lobe",
                     fmt::format("beside {} of {} foci there is up to {:.0f} % of their radiation pressure, which may "
                                 "be felt as a second point; nearer to the axis there is less",
                                 records.size(), compiled.bundle.manifest.records.size(), 100.0 * most),
                     records});
}

void find_small(const Project& project, const Compiled& compiled, const ImageAnalysis& analysis,
                std::vector<Finding>& found) {
    const std::vector<Vec3> points = compiled.bundle.manifest.points();
    if (points.size() < 2) return;
    const Box box = bounding_box(Shape{{Cloud{points}}});
    const double extent = std::max({box.extent().x, box.extent().y, box.extent().z});
    double width = 0.0;
    for (const PointAnalysis& point : analysis.points) width = std::max(width, point.focus.width_m);
    if (extent == 0.0 || extent >= least_widths * width) return;
    Finding finding{"small",
                    fmt::format("the focal points span {:.3g} mm, and one focus is {:.3g} mm wide; all will feel "
                                "like one point",
                                extent / millimetre, width / millimetre)};
    if (project.is_of_shapes()) {
        // The focal points span a little less than the object that they are sampled from.
        const double size_mm = std::ceil(2.0 * least_widths * width / millimetre);
        finding.remedies.push_back(
            {fmt::format("Make it {:g} mm large", size_mm), {{"place", {{"size_mm", size_mm}}}}});
    }
    found.push_back(std::move(finding));
}

void find_left_out(const Compiled& compiled, std::vector<Finding>& found) {
    const TouredPoints& points = compiled.points;
    if (points.clipped > 0)
        found.push_back(
            {"out-of-reach",
             fmt::format("{} of {} points are left out because the array cannot reach them; move the object "
                         "over the array, or make it smaller",
                         points.clipped, points.clipped + points.points.size())});
}

void find_others(const Compiled& compiled, std::vector<Finding>& found) {
    if (compiled.points.duplicates > 0)
        found.push_back({"duplicates", fmt::format("{} points lie on others and are left out; {} remain",
                                                   compiled.points.duplicates, compiled.points.points.size())});
    const std::string told = short_dwell_warning(compiled);
    for (const std::string& warning : compiled.warnings)
        if (warning != told) found.push_back({"warning", warning});
}

}  // namespace

std::vector<Finding> findings_of(const Project& project, const Compiled& compiled) {
    std::vector<Finding> found;
    find_left_out(compiled, found);
    find_short_dwells(project, compiled, found);
    find_steady(compiled, found);
    find_lost_to_bandwidth(compiled, found);
    find_others(compiled, found);
    return found;
}

std::vector<Finding> findings_of(const Project& project, const Compiled& compiled, const ImageAnalysis& whole) {
    const ImageAnalysis analysis = at_full_strength(compiled, whole);
    std::vector<Finding> found;
    find_left_out(compiled, found);
    find_weak(compiled, analysis, found);
    find_short_dwells(project, compiled, found);
    for (Finding& finding : found)
        if (finding.kind == "short-dwell")
            finding.records = records_that(compiled.bundle.manifest, analysis, [](const PointAnalysis& p) {
                return p.dwell_cycles < p.focus.dwell_cycles;
            });
    find_steady(compiled, found);
    find_small(project, compiled, analysis, found);
    find_uneven(project, compiled, analysis, found);
    find_side_lobes(compiled, analysis, found);
    find_lost_to_bandwidth(compiled, found);
    std::ranges::move(findings_of(analysis.loudness), std::back_inserter(found));
    find_others(compiled, found);
    return found;
}

std::vector<Finding> findings_of(const Loudness& loudness) {
    std::vector<Finding> found;
    if (loudness.at_300_mm_db > recommended_for_ears_db)
        found.push_back({"loud", fmt::format("an ear 300 mm above the array would meet {:.0f} dB, and {:.0f} dB are "
                                             "recommended as the limit; keep ears away. This is a model's number, and "
                                             "certifies nothing",
                                             loudness.at_300_mm_db, recommended_for_ears_db)});
    if (loudness.intensity_w_m2 > safe_in_tissue_w_m2)
        found.push_back(
            {"intense", fmt::format("{:.0f} W/m² {:.0f} mm above the array are more than the {:.0f} W/m² that "
                                    "are known to be safe inside tissue; skin lets 0.1 % in",
                                    loudness.intensity_w_m2, loudness.highest_at_m / millimetre, safe_in_tissue_w_m2)});
    return found;
}

ordered_json to_json(const Remedy& remedy) { return {{"label", remedy.label}, {"changes", remedy.changes}}; }

ordered_json to_json(const Finding& finding) {
    ordered_json records = ordered_json::array(), remedies = ordered_json::array();
    for (const std::size_t place : finding.records) records.push_back(place + 1);
    for (const Remedy& remedy : finding.remedies) remedies.push_back(to_json(remedy));
    return {{"kind", finding.kind}, {"message", finding.message}, {"records", records}, {"remedies", remedies}};
}

namespace {

/// "28" or "12 to 40".
template <class Value>
std::string range(Value least, Value most, const char* unit) {
    return least == most
               ? fmt::format("{:.4g} {}", static_cast<double>(least), unit)
               : fmt::format("{:.4g} to {:.4g} {}", static_cast<double>(least), static_cast<double>(most), unit);
}

std::string periods(std::uint32_t count) { return fmt::format("{} carrier period{}", count, count == 1 ? "" : "s"); }

struct Dwells {
    std::uint32_t least = 0, most = 0;  // carrier periods
    std::uint64_t pass = 0;
};

Dwells dwells_of(const Manifest& manifest) {
    Dwells found;
    for (const RecordMeaning& record : manifest.records) {
        if (record.dwell_cycles == 0) continue;
        found.least = found.pass == 0 ? record.dwell_cycles : std::min(found.least, record.dwell_cycles);
        found.most = std::max(found.most, record.dwell_cycles);
        found.pass += record.dwell_cycles;
    }
    return found;
}

std::size_t most_foci_at_once(const Manifest& manifest) {
    std::size_t most = 0;
    for (const RecordMeaning& record : manifest.records) most = std::max(most, record.foci.size());
    return most;
}

std::string how_phases_are_made(const Manifest& manifest) {
    if (manifest.foci)
        return "The board computes the phase and the amplitude of each transducer from the foci, in 1/256 of a carrier "
               "period and 1/255 of the full amplitude.";
    std::string text = fmt::format(
        "Emission times are counted in ticks of {:.4g} ns, {} in a carrier period, of which a pulse lasts {:.4g} %",
        manifest.timer.tick_s() * 1e9, manifest.timer.cycle_ticks, 100.0 * manifest.timer.duty());
    if (manifest.has_several_foci())
        for (const MethodName& method : method_names)
            if (method.method == manifest.solver)
                text += fmt::format("; drives for foci at the same time were found by {}", method.about);
    return text + ".";
}

/// The least distance of two elements, in words.
std::string apart(const Array& array) {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < array.elements.size(); ++i)
        for (std::size_t k = 0; k < i; ++k)
            least = std::min(least, distance(array.elements[i].position, array.elements[k].position));
    return array.elements.size() < 2 ? "" : fmt::format(" at least {:.4g} mm apart", least / millimetre);
}

std::string where_they_lie(const std::vector<Vec3>& points) {
    if (points.empty()) return "";
    Vec3 low = points.front(), high = low;
    for (const Vec3& point : points) {
        low = {std::min(low.x, point.x), std::min(low.y, point.y), std::min(low.z, point.z)};
        high = {std::max(high.x, point.x), std::max(high.y, point.y), std::max(high.z, point.z)};
    }
    const auto along = [](double from, double to) {
        return to - from < 0.05 * millimetre ? fmt::format("{:.1f}", from / millimetre)
                                             : fmt::format("{:.1f} to {:.1f}", from / millimetre, to / millimetre);
    };
    return fmt::format(" In its frame, whose z is the distance from it, the foci lie at x = {}, y = {}, z = {} mm.",
                       along(low.x, high.x), along(low.y, high.y), along(low.z, high.z));
}

/// Carrier periods of a pass in which nothing plays.
std::uint64_t silence_of(const Timeline& timeline) {
    std::uint64_t silent = 0;
    if (timeline.image)
        for (const SequenceEntry& entry : timeline.image->sequence)
            if (entry.index == 0) silent += entry.dwell;
    return silent;
}

std::string escaped(std::string_view text) {
    std::string safe;
    for (const char c : text) {
        if (c == '&')
            safe += "&amp;";
        else if (c == '<')
            safe += "&lt;";
        else if (c == '>')
            safe += "&gt;";
        else if (c == '"')
            safe += "&quot;";
        else
            safe += c;
    }
    return safe;
}

std::string base64(std::string_view bytes) {
    constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        const std::size_t some = std::min<std::size_t>(3, bytes.size() - i);
        std::uint32_t bits = 0;
        for (std::size_t k = 0; k < 3; ++k)
            bits = bits << 8U | (k < some ? static_cast<std::uint8_t>(bytes[i + k]) : 0U);
        for (std::size_t k = 0; k < 4; ++k) text += k <= some ? digits[bits >> (18U - 6U * k) & 63U] : '=';
    }
    return text;
}

std::string millimetres(Vec3 place) {
    return fmt::format("{:.1f}, {:.1f}, {:.1f}", place.x / millimetre, place.y / millimetre, place.z / millimetre);
}

using Row = std::pair<std::string, std::string>;

std::vector<Row> numbers_of(const Timeline& timeline, const ImageAnalysis& analysis) {
    const Manifest& manifest = timeline.manifest;
    const Dwells dwells = dwells_of(manifest);
    const double period_us = 1e6 / manifest.timer.carrier_hz();
    std::vector<Row> rows = {
        {"what is looked at", timeline.title},
        {"array", fmt::format("{}, {} transducers {}", manifest.array.name, manifest.array.elements.size(),
                              manifest.array.transducer.name)},
        {"board", fmt::format("{}, {} channels, {:.4g} MHz", manifest.core.name, manifest.core.parameters.channels,
                              1e-6 * manifest.timer.clock_hz)},
        {"level", level_text(manifest.array.transducer)},
        {"carrier", fmt::format("{:.2f} Hz", manifest.timer.carrier_hz())},
        {"records", fmt::format("{}, with {} foci", manifest.records.size(), manifest.points().size())},
        {"passes a second", fmt::format("{:.4g}", manifest.rate_hz)},
        {"one pass", fmt::format("{:.4g} ms", 1e-3 * period_us * static_cast<double>(dwells.pass))},
        {"dwell", range(dwells.least, dwells.most, "carrier periods")},
        {"formation of the slowest focus, without and with ring-up",
         fmt::format("{:.4g} µs, {:.4g} µs", 1e6 * manifest.formation.formation_s,
                     1e6 * manifest.formation.with_ring_up_s())},
        {"pressure left by the transducers' bandwidth, least and mean",
         fmt::format("{:.1f} %, {:.1f} %", 100.0 * analysis.pressure_left.least, 100.0 * analysis.pressure_left.mean)},
        {"sound on the axis at 300 mm, by a model",
         fmt::format("{:.1f} dB SPL; {:.0f} are recommended for ears as the most", analysis.loudness.at_300_mm_db,
                     recommended_for_ears_db)}};
    if (manifest.modulation)
        rows.emplace_back("modulation", fmt::format("{} samples of {} each", manifest.modulation->samples.size(),
                                                    periods(manifest.modulation->divider)));
    rows.emplace_back("SHA-256 of the image", manifest.image_sha256);
    rows.emplace_back("SHA-256 of its input", manifest.input_sha256);
    rows.emplace_back("made by", fmt::format("Haptogram {}", version()));
    return rows;
}

std::string table_of(const ImageAnalysis& analysis) {
    std::string html = fmt::format(
        "<table class=\"foci\"><thead><tr><th>record</th><th>focus, mm</th><th>dwell, periods</th><th>pressure, "
        "Pa</th><th>radiation pressure, Pa</th><th>width, mm</th><th>depth, mm</th><th>side lobe</th><th>force on a "
        "disc of {:g} mm, mN</th></tr></thead><tbody>\n",
        default_contact_m / millimetre);
    for (const PointAnalysis& point : analysis.points) {
        const FocusAnalysis& f = point.focus;
        html += fmt::format(
            "<tr{}><td>{}</td><td>{}</td><td>{}</td><td>{:.0f}</td><td>{:.1f}</td><td>{:.1f}</td><td>{:.1f}</td>"
            "<td>{:.2f}</td><td>{:.3f}</td></tr>\n",
            point.too_weak ? " class=\"weak\"" : "", point.record, millimetres(f.focus), point.dwell_cycles,
            f.pressure_pa, f.radiation_pa, f.width_m / millimetre, f.depth_m / millimetre, f.side_lobe,
            f.force_n * 1e3);
    }
    return html + "</tbody></table>\n";
}

constexpr std::string_view style =
    "<style>:root{color-scheme:light dark}body{font:16px/1.5 system-ui,sans-serif;max-width:60rem;margin:2rem "
    "auto;padding:0 1rem}table{border-collapse:collapse}th,td{text-align:left;padding:.2rem .8rem .2rem "
    "0;border-bottom:1px solid #8888;vertical-align:top;overflow-wrap:anywhere}.foci td{text-align:right;white-space:"
    "nowrap}.weak{font-style:italic}img{max-width:100%;background:#fff}</style>\n";

}  // namespace

std::string methods_text(const Timeline& timeline) {
    const Manifest& manifest = timeline.manifest;
    if (manifest.image_sha256.empty())
        throw bad_argument("focus", "a focal point alone has no image to report on; compile one that plays it");
    const Array& array = manifest.array;
    const Dwells dwells = dwells_of(manifest);
    const double period_us = 1e6 / manifest.timer.carrier_hz();
    const std::size_t at_once = most_foci_at_once(manifest), points = manifest.points().size();
    std::string text = fmt::format(
        "The stimulus was rendered by {} focal point{} of an airborne ultrasound array ({}: {} transducers {}{}, "
        "{:.5g} kHz, speed of sound {:.4g} m/s, absorption {:.3g} Np/m). Its {}.{}",
        points, points == 1 ? "" : "s", array.name, array.elements.size(), array.transducer.name, apart(array),
        1e-3 * manifest.timer.carrier_hz(), array.medium.speed_m_s, array.medium.absorption_np_m,
        level_text(array.transducer), where_they_lie(manifest.points()));
    if (at_once <= 1)
        text += " All waves arrive at a focal point in phase (Haptogram, eq. 2 to 5).";
    else
        text += fmt::format(" Up to {} focal points were made at the same time.", at_once);
    text += fmt::format(" {}", how_phases_are_made(manifest));
    if (manifest.records.size() > 1)
        text += fmt::format(
            " {} were played one after the other, each for {} ({}), {:.4g} times a second.",
            at_once <= 1 ? "The focal points" : fmt::format("The {} sets of focal points", manifest.records.size()),
            range(dwells.least, dwells.most, "carrier periods"),
            range(period_us * dwells.least, period_us * dwells.most, "µs"), manifest.rate_hz);
    if (const std::uint64_t silent = silence_of(timeline); silent > 0)
        text += fmt::format(" Nothing was played for {:.3g} % of the time.",
                            100.0 * static_cast<double>(silent) / static_cast<double>(silent + dwells.pass));
    text += fmt::format(
        " The slowest focus takes {:.4g} µs to form (Haptogram, eq. 12), and {:.4g} µs with the transducers' ring-up "
        "to 90 %.",
        1e6 * manifest.formation.formation_s, 1e6 * manifest.formation.with_ring_up_s());
    if (manifest.modulation)
        text += fmt::format(" The board multiplied all amplitudes by {} samples of {} each, over and over ({:.4g} Hz).",
                            manifest.modulation->samples.size(), periods(manifest.modulation->divider),
                            1e6 / (period_us * static_cast<double>(manifest.modulation->samples.size() *
                                                                   manifest.modulation->divider)));
    text += fmt::format(
        " The image was compiled by Haptogram {} for {} with {} channels at {:.4g} MHz (SHA-256 of the image {}, of "
        "its input {}).",
        version(), manifest.core.name, manifest.core.parameters.channels, 1e-6 * manifest.timer.clock_hz,
        manifest.image_sha256, manifest.input_sha256);
    return text;
}

std::string report_page(const Timeline& timeline, const ImageAnalysis& analysis,
                        const std::vector<std::string>& findings, const std::string& picture,
                        const std::string& verdict) {
    const std::string name = escaped(timeline.name);
    std::string html = fmt::format(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>Report on "
        "{0}</title>\n{1}</head><body><main>\n"
        "<h1>Report on {0}</h1>\n<h2>For a section on methods</h2>\n<p>{2}</p>\n<h2>What to know</h2>\n",
        name, style, escaped(methods_text(timeline)));
    if (!verdict.empty()) html += fmt::format("<p>Whether a hand feels it, by models: {}.</p>\n", escaped(verdict));
    if (findings.empty()) {
        html += "<p>Nothing was found that may not feel as expected.</p>\n";
    } else {
        html += "<ul>\n";
        for (const std::string& finding : findings) html += fmt::format("<li>{}</li>\n", escaped(finding));
        html += "</ul>\n";
    }
    html += "<h2>Numbers</h2>\n<table>\n";
    for (const auto& [what, value] : numbers_of(timeline, analysis))
        html += fmt::format("<tr><th>{}</th><td>{}</td></tr>\n", escaped(what), escaped(value));
    html += "</table>\n";
    if (!picture.empty())
        html += fmt::format(
            "<h2>Field</h2>\n<img alt=\"Radiation pressure on the plane through the foci, averaged over a pass\" "
            "src=\"data:image/png;base64,{}\">\n",
            base64(picture));
    html += fmt::format(
        "<h2>Foci</h2>\n<p>Computed, not measured: what a model of the array makes of the "
        "image.</p>\n{}</main></body></html>\n",
        table_of(analysis));
    return html;
}

std::string report_picture(const Timeline& timeline, unsigned threads, const Progress& progress) {
    const std::vector<Vec3> points = timeline.manifest.points();
    double height = 0.0, extent = 0.0;
    for (const Vec3& point : points) {
        height += point.z / static_cast<double>(points.size());
        extent = std::max({extent, std::abs(point.x), std::abs(point.y)});
    }
    // The foci with as much around them as shows their side lobes, in 200 steps.
    Reach reach;
    reach.extent_m = std::ceil((extent + 20 * millimetre) / (5 * millimetre)) * 5 * millimetre;
    reach.step_m = reach.extent_m / 100.0;
    const Region region = parse_region("plane", fmt::format("xy@z={:.3f}", height / millimetre), reach);
    const TemporaryFolder folder;
    const std::string file = (folder.path() / "field.png").string();
    write_field(file, field(excitation_of(timeline), region, Quantity::radiation, threads, progress));
    return read_file(file);
}

}  // namespace haptogram
