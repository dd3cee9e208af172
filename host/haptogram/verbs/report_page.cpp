// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/report_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "haptogram/acoustics/skin_force.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/process.hpp"
#include "haptogram/verbs/field.hpp"
#include "haptogram/verbs/field_file.hpp"
#include "haptogram/verbs/level.hpp"

namespace haptogram {
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
        "Emission times are counted in ticks of {:.4g} ns, {} in a carrier period, with pulses of {:.4g} % of it",
        manifest.timer.tick_s() * 1e9, manifest.timer.cycle_ticks, 100.0 * manifest.timer.duty());
    if (manifest.has_several_foci())
        for (const MethodName& method : method_names)
            if (method.method == manifest.solver)
                text += fmt::format("; drives for foci at the same time were found by {}", method.about);
    return text + ".";
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
    rows.emplace_back("SHA-256 of what it was made of", manifest.input_sha256);
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
        "The stimulus was rendered by {} focal point{} of an airborne ultrasound array ({}: {} transducers {}, {:.5g} "
        "kHz, speed of sound {:.4g} m/s, absorption {:.3g} Np/m).",
        points, points == 1 ? "" : "s", array.name, array.elements.size(), array.transducer.name,
        1e-3 * manifest.timer.carrier_hz(), array.medium.speed_m_s, array.medium.absorption_np_m);
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
        "what it was made of {}).",
        version(), manifest.core.name, manifest.core.parameters.channels, 1e-6 * manifest.timer.clock_hz,
        manifest.image_sha256, manifest.input_sha256);
    return text;
}

std::string report_page(const Timeline& timeline, const ImageAnalysis& analysis,
                        const std::vector<std::string>& findings, const std::string& picture) {
    const std::string name = escaped(timeline.name);
    std::string html = fmt::format(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>Report on "
        "{0}</title>\n{1}</head><body>\n"
        "<h1>Report on {0}</h1>\n<h2>For a section on methods</h2>\n<p>{2}</p>\n<h2>What to know</h2>\n",
        name, style, escaped(methods_text(timeline)));
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
        "image.</p>\n{}</body></html>\n",
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
