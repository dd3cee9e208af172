// SPDX-License-Identifier: Apache-2.0
#include "haptogram/perception/feel.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/picture.hpp"
#include "haptogram/perception/difference.hpp"
#include "haptogram/perception/skin_wave.hpp"

namespace haptogram {
namespace {

using nlohmann::ordered_json;
using perception::FeltLine;
using perception::Line;

/// Every place once, in the order in which they come.
std::vector<Vec3> different_places(const Path& path) {
    std::vector<Vec3> places;
    for (const PathStep& step : path.steps)
        for (const Focus& focus : step.foci)
            if (std::find(places.begin(), places.end(), focus.position) == places.end())
                places.push_back(focus.position);
    return places;
}

std::vector<Vec3> evenly_chosen(const std::vector<Vec3>& all, std::size_t most) {
    if (all.size() <= most) return all;
    std::vector<Vec3> chosen;
    for (std::size_t i = 0; i < most; ++i) chosen.push_back(all[i * all.size() / most]);
    return chosen;
}

/// The speed of a single focus where its steps are no longer than `width`: way over time.
std::optional<double> speed_of(const Path& places, double carrier_hz, double width) {
    double way = 0.0, time = 0.0, all = 0.0;
    for (std::size_t i = 0; i < places.steps.size(); ++i) {
        const PathStep& step = places.steps[i];
        const PathStep& next = places.steps[(i + 1) % places.steps.size()];
        if (step.foci.empty()) continue;
        all += step.periods;
        if (step.foci.size() != 1 || next.foci.size() != 1) continue;
        const double hop = distance(step.foci.front().position, next.foci.front().position);
        if (hop > width) continue;
        way += hop;
        time += step.periods;
    }
    // A path that mostly hops does not move at a speed, and one place does not move at all.
    if (!(way > 0.0) || 2.0 * time < all) return std::nullopt;
    return way / time * carrier_hz;
}

/// The skin at a place, or where the hand is nearest to it.
FeltPlace place_at(Vec3 position, const FeelOptions& options) {
    FeltPlace felt;
    felt.place = {position, options.normal};
    felt.region = options.region;
    if (!options.skin) return felt;
    const HandSkin skin = options.skin(position);
    felt.off_skin_m = distance(skin.position, position);
    felt.place = {skin.position, skin.normal};
    felt.part = skin.part;
    felt.region = skin.part == "palm" ? perception::Region::palm : perception::Region::finger;
    return felt;
}

FeltPlace feel_at(const Array& array, const DriveSequence& sequence, Vec3 position, const FeelOptions& options) {
    FeltPlace felt = place_at(position, options);
    felt.force = force_on_skin(array, sequence, felt.place, options.contact_m);
    const auto& pressure = felt.force.pressure_pa;
    const auto& force = felt.force.force_n;
    const auto count = static_cast<double>(force.size());
    felt.mean_pa = std::accumulate(pressure.begin(), pressure.end(), 0.0) / count;
    felt.most_pa = *std::max_element(pressure.begin(), pressure.end());
    felt.mean_n = std::accumulate(force.begin(), force.end(), 0.0) / count;
    felt.depth = modulation_depth(force);
    felt.spectrum = perception::lines_of(force, sequence.carrier_hz);
    // Rounding leaves lines of a steady force that are no vibration.
    for (Line& line : felt.spectrum)
        if (line.amplitude < 1e-9 * std::abs(felt.mean_n)) line.amplitude = 0.0;
    felt.felt = perception::felt_of(felt.spectrum, options.tables, felt.region, options.grip_n);
    return felt;
}

/// The diagonal of the box around places.
double extent_of(const std::vector<Vec3>& places) {
    if (places.empty()) return 0.0;
    Vec3 low = places.front(), high = low;
    for (const Vec3& p : places) {
        low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
    return distance(low, high);
}

/// The least distance between two foci of one step.
std::optional<double> nearest_foci(const Path& path) {
    std::optional<double> nearest;
    for (const PathStep& step : path.steps)
        for (std::size_t i = 0; i < step.foci.size(); ++i)
            for (std::size_t k = i + 1; k < step.foci.size(); ++k) {
                const double apart = distance(step.foci[i].position, step.foci[k].position);
                nearest = std::min(nearest.value_or(apart), apart);
            }
    return nearest;
}

/// What is too small or too far off to be felt as it is.
void warn_of_places(Feeling& feeling, std::size_t foci) {
    const auto add = [&](std::string text) { feeling.warnings.push_back(std::move(text)); };
    const double fused_mm = perception::fused_below_m / millimetre;
    if (foci > 1 && feeling.extent_m < perception::fused_below_m)
        add(
            fmt::format("all foci lie within {:.1f} mm; two that are less than {:g} mm apart are felt as one, so this "
                        "has a place and no shape",
                        feeling.extent_m / millimetre, fused_mm));
    else if (feeling.nearest_m && *feeling.nearest_m < perception::fused_below_m)
        add(fmt::format("foci {:.1f} mm apart sound at the same time; less than {:g} mm apart they are felt as one",
                        *feeling.nearest_m / millimetre, fused_mm));
    double off = 0.0;
    for (const FeltPlace& place : feeling.places) off = std::max(off, place.off_skin_m);
    constexpr double near_m = 5e-3;  // half of a focus
    if (off > near_m)
        add(fmt::format("the hand's skin is up to {:.1f} mm away from what plays; what is said is of the nearest skin",
                        off / millimetre));
}

void warn(Feeling& feeling, const DriveSequence& sequence, const FeelOptions& options, std::size_t foci) {
    const auto add = [&](std::string text) { feeling.warnings.push_back(std::move(text)); };
    if (!sequence.repeats)
        add("fewer than two whole passes were measured, so the spectrum is of what began and ended in silence; "
            "simulate more passes");
    if (options.at.empty() && foci > feeling.places.size())
        add(fmt::format("{} of {} places were looked at, evenly chosen", feeling.places.size(), foci));
    std::size_t away = 0, estimated = 0, moving = 0;
    for (const FeltPlace& place : feeling.places) {
        away += place.force.tilt < 0.05 ? 1 : 0;
        estimated += place.expected() && place.felt.lines.front().basis != perception::Basis::tables ? 1 : 0;
        moving += place.felt.magnitude && foci > 1 ? 1 : 0;
    }
    if (away > 0) add(fmt::format("the skin hardly faces the array at {} places", away));
    if (estimated > 0)
        add(
            fmt::format("at {} places the strongest line lies outside of {:g}…{:g} Hz, which the tables cover; its "
                        "threshold is an estimate by the displacement curve",
                        estimated, options.tables.fits.front().frequency_hz, options.tables.fits.back().frequency_hz));
    if (moving > 0)
        add("the tables are of a focus that rests; magnitudes of one that goes from place to place are less certain");
    if (feeling.speed_m_s && !feeling.wave_gain)
        add(fmt::format("the focus moves at {:.3g} m/s, and waves in the skin were modelled up to {:g} m/s",
                        *feeling.speed_m_s, perception::fastest_wave_m_s));
}

const FeltPlace& strongest(const Feeling& feeling) {
    return *std::max_element(feeling.places.begin(), feeling.places.end(), [](const FeltPlace& a, const FeltPlace& b) {
        const auto over = [](const FeltPlace& place) {
            return place.felt.lines.empty() ? -INFINITY : place.felt.lines.front().over_db;
        };
        return over(a) < over(b);
    });
}

}  // namespace

Feeling feel(const Timeline& timeline, const FeelOptions& options, const Progress& progress) {
    const Array& array = timeline.manifest.array;
    const DriveSequence sequence = sequence_of(timeline);
    const Path places = places_of(timeline.manifest, sequence);
    if (sequence.periods() == 0) throw bad_input(timeline.name, "nothing is played; there is nothing to feel");
    if (options.most_places == 0) throw bad_argument("places", "found 0, expected at least 1");
    const std::vector<Vec3> foci = different_places(places);
    const std::vector<Vec3> at = options.at.empty() ? evenly_chosen(foci, options.most_places) : options.at;
    if (at.empty()) throw bad_input(timeline.name, "it has no foci; say where the skin is", {"at"});
    Feeling feeling;
    feeling.seconds = static_cast<double>(sequence.periods()) / sequence.carrier_hz;
    for (const Vec3& position : at) {
        feeling.places.push_back(feel_at(array, sequence, position, options));
        progress(0.8 * static_cast<double>(feeling.places.size()) / static_cast<double>(at.size()), "skin");
    }
    feeling.extent_m = extent_of(foci);
    feeling.nearest_m = nearest_foci(places);
    const auto count = static_cast<double>(at.size());
    for (const FeltPlace& place : feeling.places) feeling.mean_pa += place.mean_pa / count;
    double squares = 0.0;
    for (const FeltPlace& place : feeling.places)
        squares += (place.mean_pa - feeling.mean_pa) * (place.mean_pa - feeling.mean_pa) / count;
    if (feeling.mean_pa > 0.0) feeling.spread = std::sqrt(squares) / feeling.mean_pa;
    if (foci.size() > 1) {
        perception::SkinMembrane skin;
        skin.focus_width_m = focal_width(array, foci.front());
        feeling.speed_m_s = speed_of(places, sequence.carrier_hz, skin.focus_width_m);
        if (feeling.speed_m_s && *feeling.speed_m_s <= perception::fastest_wave_m_s)
            feeling.wave_gain = perception::deflection_over_static(*feeling.speed_m_s, skin);
    }
    feeling.noise = perception::noise_of(array, sequence);
    feeling.ears = perception::exposure(array, sequence, options.ears);
    feeling.loudest = perception::loudest_around(array, sequence);
    progress(1.0, "sound");
    warn(feeling, sequence, options, foci.size());
    warn_of_places(feeling, foci.size());
    return feeling;
}

void draw_feeling(const std::string& path, const Timeline& timeline, const FeelOptions& options,
                  const Feeling& feeling) {
    constexpr double shown_s = 0.05, highest_hz = 1000.0;
    const FeltPlace& best = strongest(feeling);
    const auto mm = [](Vec3 p) { return ordered_json{p.x / millimetre, p.y / millimetre, p.z / millimetre}; };
    const auto shown = std::min(best.force.pressure_pa.size(),
                                static_cast<std::size_t>(shown_s * timeline.manifest.timer.carrier_hz()));
    ordered_json json = {
        {"title", timeline.title},
        {"array", timeline.manifest.array.name},
        {"at_mm", mm(best.place.position)},
        {"contact_mm", options.contact_m / millimetre},
        {"carrier_hz", timeline.manifest.timer.carrier_hz()},
        {"pressure_pa", std::vector<double>(best.force.pressure_pa.begin(),
                                            best.force.pressure_pa.begin() + static_cast<std::ptrdiff_t>(shown))},
        {"spectrum", ordered_json::array()},
        {"thresholds", ordered_json::array()},
        {"places", ordered_json::array()},
        {"noise", ordered_json::array()},
        {"noise_db", feeling.noise.lines.empty() ? ordered_json() : ordered_json(feeling.noise.relative_db)}};
    for (const Line& line : best.spectrum)
        if (line.hz > 0.0 && line.hz <= highest_hz && line.amplitude > 0.0)
            json["spectrum"].push_back({line.hz, line.amplitude});
    for (double hz = perception::lowest_vibration_hz; hz <= perception::highest_vibration_hz; hz += 2.0) {
        const perception::LeastForce least =
            perception::least_vibration(options.tables, options.region, hz, options.grip_n);
        json["thresholds"].push_back({hz, least.force_n, perception::name_of(least.basis)});
    }
    for (const FeltPlace& place : feeling.places)
        json["places"].push_back(
            {{"mean_pa", place.mean_pa},
             {"over_db", place.felt.lines.empty() ? ordered_json() : ordered_json(place.felt.lines.front().over_db)}});
    for (const Line& line : feeling.noise.lines) json["noise"].push_back({line.hz, line.amplitude});
    Picture picture("shipped:tools/plot_feel.py");
    picture.add("feel.json", json.dump());
    picture.draw(path, "the text and --json");
}

}  // namespace haptogram
