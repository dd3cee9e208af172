// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/findings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

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
    const std::size_t count = compiled.path.steps.size();
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

void find_weak(const Compiled& compiled, const ImageAnalysis& analysis, std::vector<Finding>& found) {
    const auto records =
        records_that(compiled.bundle.manifest, analysis, [](const PointAnalysis& p) { return p.too_weak; });
    if (records.empty()) return;
    double least = INFINITY;
    for (const PointAnalysis& point : analysis.points) least = std::min(least, point.focus.force_n);
    found.push_back(
        {"weak",
         fmt::format("{} of {} records may be too weak to feel: the weakest focus has {:.3g} mN, and a palm "
                     "is known to feel {:.3g} mN; nearer to the array, or to its axis, it is stronger",
                     records.size(), compiled.bundle.manifest.records.size(), least * 1e3, least_felt_n * 1e3),
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
            {"intense", fmt::format("{:.3g} W/m² {:.0f} mm above the array are more than the {:.0f} W/m² that "
                                    "are known to be safe inside tissue; skin lets 0.1 % in",
                                    loudness.intensity_w_m2, loudness.highest_at_m / millimetre, safe_in_tissue_w_m2)});
    return found;
}

ordered_json to_json(const Finding& finding) {
    ordered_json records = ordered_json::array(), remedies = ordered_json::array();
    for (const std::size_t place : finding.records) records.push_back(place + 1);
    for (const Remedy& remedy : finding.remedies)
        remedies.push_back({{"label", remedy.label}, {"changes", remedy.changes}});
    return {{"kind", finding.kind}, {"message", finding.message}, {"records", records}, {"remedies", remedies}};
}

}  // namespace haptogram
