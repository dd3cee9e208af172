// SPDX-License-Identifier: Apache-2.0
#include "haptogram/perception/feel.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <numeric>
#include <set>
#include <utility>
#include <vector>

#include "haptogram/acoustics/field.hpp"
#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/acoustics/quantities.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/picture.hpp"
#include "haptogram/perception/felt.hpp"

namespace haptogram::perception {
namespace {

using std::numbers::pi;

double largest_deflection(double speed_m_s, const SkinMembrane& skin) {
    constexpr int count = 512;
    constexpr double side_m = 0.4;
    // A Gaussian e^{−r²/a²} falls to half at r = a·√(ln 2).
    const double a = skin.focus_width_m / 2.0 / std::sqrt(std::numbers::ln2);
    const double omega = 2.0 * pi * skin.foundation_hz, c = skin.wave_speed_m_s;
    std::vector<std::complex<double>> along(count);  // the sum over k across the line, for each k along it
    for (int i = 0; i < count; ++i) {
        const double kx = 2.0 * pi / side_m * (i - count / 2), turn = kx * speed_m_s;
        for (int j = 0; j < count; ++j) {
            const double ky = 2.0 * pi / side_m * (j - count / 2), square = kx * kx + ky * ky;
            along[static_cast<std::size_t>(i)] +=
                std::exp(-square * a * a / 4.0) /
                std::complex<double>(omega * omega + c * c * square - turn * turn, 2.0 * skin.damping_1_s * turn);
        }
    }
    double largest = 0.0;
    for (int x = 0; x < count; ++x) {
        double sum = 0.0;
        for (int i = 0; i < count; ++i) {
            const double angle = 2.0 * pi * ((i - count / 2) * x % count) / count;
            sum += along[static_cast<std::size_t>(i)].real() * std::cos(angle) -
                   along[static_cast<std::size_t>(i)].imag() * std::sin(angle);
        }
        largest = std::max(largest, sum);
    }
    return largest;
}

}  // namespace

double deflection_over_static(double speed_m_s, const SkinMembrane& skin) {
    if (!(speed_m_s >= 0.0 && speed_m_s <= fastest_wave_m_s))
        throw bad_argument("speed", fmt::format("{:g} m/s lies outside of 0…{:g} m/s, for which the skin's waves "
                                                "were modelled",
                                                speed_m_s, fastest_wave_m_s));
    return largest_deflection(speed_m_s, skin) / largest_deflection(0.0, skin);
}

namespace {

using std::numbers::pi;

constexpr double lowest_hz = 20.0, highest_hz = 16e3, reference_hz = 200.0;

/// The A-weighted second derivative of a line of E².
double heard(const Line& line) {
    const double omega = 2.0 * pi * line.hz;
    return line.amplitude * omega * omega * a_weighting(line.hz);
}

/// The reference's sum of squares: the square of ½ + ½·sin is ⅜ + ½·sin − ⅛·cos of twice the frequency.
double reference(const Array& array) {
    const double full =
        array.transducer.source_pa_m * array.transducer.source_pa_m * static_cast<double>(array.elements.size());
    const double first = heard({reference_hz, full / 2.0}), second = heard({2.0 * reference_hz, full / 8.0});
    return first * first + second * second;
}

double largest_step(const DriveSequence& sequence) {
    double largest = 0.0;
    std::set<std::pair<std::size_t, std::size_t>> seen;
    for (std::size_t i = sequence.repeats ? 0 : 1; i < sequence.steps.size(); ++i) {
        const std::pair sets(sequence.steps[i == 0 ? sequence.steps.size() - 1 : i - 1].set, sequence.steps[i].set);
        if (!seen.insert(sets).second) continue;
        const auto& before = sequence.drives[sets.first];
        const auto& now = sequence.drives[sets.second];
        for (std::size_t m = 0; m < now.size(); ++m)
            if (now[m] != 0.0 && before[m] != 0.0)
                largest = std::max(largest, std::abs(std::arg(now[m] * std::conj(before[m]))));
    }
    return largest * 180.0 / pi;
}

/// Each set of drives with the time that it plays.
std::vector<WeightedDrives> weighted(const DriveSequence& sequence) {
    std::vector<WeightedDrives> found;
    for (const auto& drives : sequence.drives) found.push_back({0.0, drives});
    for (const DriveSequence::Step& step : sequence.steps) found[step.set].weight += static_cast<double>(step.periods);
    std::erase_if(found, [](const WeightedDrives& one) { return one.weight == 0.0; });
    return found;
}

double level_of(double mean_square) { return sound_level_db(std::sqrt(2.0 * mean_square)); }

}  // namespace

Noise noise_of(const Array& array, const DriveSequence& sequence) {
    const std::uint64_t periods = sequence.periods();
    if (periods == 0) throw bad_input("sequence", "nothing is played; there is nothing to hear");
    std::vector<double> squares(periods);
    // Several elements at a time, which the processor does in about the time of one.
    constexpr std::size_t at_once = 8;
    using Some = Eigen::Array<double, 2 * at_once, 1>;
    for (std::size_t first = 0; first < array.elements.size(); first += at_once) {
        std::vector<Some> wanted(sequence.drives.size(), Some::Zero());
        for (std::size_t set = 0; set < wanted.size(); ++set)
            for (std::size_t i = 0; i < at_once && first + i < array.elements.size(); ++i) {
                const std::complex<double> radiated =
                    sequence.drives[set][first + i] * array.elements[first + i].response;
                wanted[set][static_cast<Eigen::Index>(2 * i)] = radiated.real();
                wanted[set][static_cast<Eigen::Index>(2 * i + 1)] = radiated.imag();
            }
        follow(sequence, array.transducer.bandwidth_hz, wanted,
               [&](std::uint64_t period, const Some& carriers) { squares[period] += carriers.square().sum(); });
    }
    Noise noise;
    noise.largest_step_deg = largest_step(sequence);
    double power = 0.0, strongest = 0.0, mean = 0.0;
    for (Line line : lines_of(squares, sequence.carrier_hz)) {
        if (line.hz == 0.0) mean = line.amplitude;
        // What rounding leaves of a steady drive is no sound.
        if (line.hz < lowest_hz || line.hz > highest_hz || line.amplitude < 1e-12 * mean) continue;
        line.amplitude = heard(line);
        power += line.amplitude * line.amplitude;
        if (line.amplitude > strongest) {
            strongest = line.amplitude;
            noise.loudest_hz = line.hz;
        }
        noise.lines.push_back(line);
    }
    const double unit = std::sqrt(reference(array));
    for (Line& line : noise.lines) line.amplitude /= unit;
    noise.relative_db =
        power > 0.0 ? 10.0 * std::log10(power) - 20.0 * std::log10(unit) : -std::numeric_limits<double>::infinity();
    return noise;
}

std::vector<Exposure> exposure(const Array& array, const DriveSequence& sequence, std::span<const Vec3> ears) {
    const std::vector<WeightedDrives> sets = weighted(sequence);
    const std::vector<float> means = mean_square_pressure_at(array, sets, ears);
    std::vector<float> most(ears.size());
    for (const WeightedDrives& one : sets) {
        const std::vector<float> alone = mean_square_pressure_at(array, {&one, 1}, ears);
        for (std::size_t i = 0; i < most.size(); ++i) most[i] = std::max(most[i], alone[i]);
    }
    std::vector<Exposure> found;
    for (std::size_t i = 0; i < ears.size(); ++i)
        found.push_back({ears[i], level_of(static_cast<double>(means[i])), level_of(static_cast<double>(most[i]))});
    return found;
}

Exposure loudest_around(const Array& array, const DriveSequence& sequence, double radius_m) {
    constexpr int apart_deg = 2;
    std::vector<Vec3> points{{0.0, 0.0, radius_m}};
    for (int tilt = apart_deg; tilt <= 90; tilt += apart_deg)
        for (int turn = 0; turn < 360; turn += apart_deg) {
            const double a = tilt * pi / 180.0, b = turn * pi / 180.0;
            points.push_back(
                {radius_m * std::sin(a) * std::cos(b), radius_m * std::sin(a) * std::sin(b), radius_m * std::cos(a)});
        }
    FieldOptions options;
    options.threads = 0;
    const std::vector<float> means = mean_square_pressure_at(array, weighted(sequence), points, options);
    const auto at = static_cast<std::size_t>(std::max_element(means.begin(), means.end()) - means.begin());
    return exposure(array, sequence, {&points[at], 1}).front();
}

}  // namespace haptogram::perception

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

/// The part of a force that is felt at once, as felt_within_s has it.
std::span<const double> felt_part(const std::vector<double>& force, double carrier_hz) {
    const auto length = static_cast<std::size_t>(std::lround(felt_within_s * carrier_hz));
    if (force.size() <= length) return force;
    double sum = std::accumulate(force.begin(), force.begin() + static_cast<std::ptrdiff_t>(length), 0.0);
    double most = sum;
    std::size_t first = 0;
    for (std::size_t end = length; end < force.size(); ++end) {
        sum += force[end] - force[end - length];
        if (sum > most * (1.0 + 1e-9)) {  // not for rounding's sake
            most = sum;
            first = end - length + 1;
        }
    }
    return std::span(force).subspan(first, length);
}

FeltPlace feel_at(const Array& array, const DriveSequence& sequence, Vec3 position, const FeelOptions& options,
                  const ExpectedLevel& level, std::optional<double> rounds_hz) {
    FeltPlace felt = place_at(position, options);
    felt.force = force_on_skin(array, sequence, felt.place, options.contact_m);
    auto& pressure = felt.force.pressure_pa;
    auto& force = felt.force.force_n;
    const double nominal = level.source_pa_m / array.transducer.source_pa_m;
    for (double& value : pressure) value *= nominal * nominal;
    for (double& value : force) value *= nominal * nominal;
    const auto count = static_cast<double>(force.size());
    felt.mean_pa = std::accumulate(pressure.begin(), pressure.end(), 0.0) / count;
    felt.most_pa = *std::max_element(pressure.begin(), pressure.end());
    felt.mean_n = std::accumulate(force.begin(), force.end(), 0.0) / count;
    felt.depth = modulation_depth(force);
    felt.spectrum = perception::lines_of(felt_part(force, sequence.carrier_hz), sequence.carrier_hz);
    // Rounding leaves lines of a steady force that are no vibration.
    for (Line& line : felt.spectrum)
        if (line.amplitude < 1e-9 * std::abs(felt.mean_n)) line.amplitude = 0.0;
    felt.felt = perception::felt_of(felt.spectrum, options.tables, felt.region, options.grip_n);
    felt.verdict = perception::verdict_of(felt.felt, level, options.tables, felt.region, options.grip_n,
                                          *std::max_element(force.begin(), force.end()), rounds_hz);
    return felt;
}

/// How often one focus comes round, when it goes from place to place in steps that are no longer than `width`.
std::optional<double> rounds_of(const Path& places, double carrier_hz, double width) {
    if (places.steps.size() < 3 || !speed_of(places, carrier_hz, width)) return std::nullopt;
    std::uint64_t periods = 0;
    for (const PathStep& step : places.steps) periods += step.periods;
    // A sequence may hold several rounds: it comes round when it is where it began.
    const auto& first = places.steps.front().foci;
    const auto rounds = std::ranges::count_if(places.steps, [&](const PathStep& step) {
        return first.size() == 1 && step.foci.size() == 1 && step.foci.front().position == first.front().position;
    });
    return carrier_hz * static_cast<double>(std::max<std::ptrdiff_t>(rounds, 1)) / static_cast<double>(periods);
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
        estimated += place.verdict.over_db > 0.0 && place.felt.lines.front().basis != perception::Basis::tables ? 1 : 0;
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
        return a.verdict.over_db < b.verdict.over_db;
    });
}

ExpectedLevel level_of(const Transducer& transducer, const FeelOptions& options) {
    if (!options.level_pa_m) return expected_level(transducer, options.supply_v);
    if (!(*options.level_pa_m > 0.0 && std::isfinite(*options.level_pa_m)))
        throw bad_argument("level", fmt::format("must be positive, found {:g}", *options.level_pa_m));
    return {*options.level_pa_m, 0.0, 0.0, fmt::format("level: {:g} Pa·m an element, as asked", *options.level_pa_m)};
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
    feeling.level = level_of(array.transducer, options);
    const double width_m = foci.empty() ? 0.0 : focal_width(array, foci.front());
    const std::optional<double> rounds_hz = rounds_of(places, sequence.carrier_hz, width_m);
    for (const Vec3& position : at) {
        feeling.places.push_back(feel_at(array, sequence, position, options, feeling.level, rounds_hz));
        feeling.verdicts.push_back(feeling.places.back().verdict);
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
        skin.focus_width_m = width_m;
        feeling.speed_m_s = speed_of(places, sequence.carrier_hz, skin.focus_width_m);
        if (feeling.speed_m_s && *feeling.speed_m_s <= perception::fastest_wave_m_s)
            feeling.wave_gain = perception::deflection_over_static(*feeling.speed_m_s, skin);
    }
    if (options.sound) {
        feeling.noise = perception::noise_of(array, sequence);
        feeling.ears = perception::exposure(array, sequence, options.ears);
        feeling.loudest = perception::loudest_around(array, sequence);
    }
    progress(1.0, "sound");
    warn(feeling, sequence, options, foci.size());
    warn_of_places(feeling, foci.size());
    return feeling;
}

std::optional<Feeling> feeling_at_foci(const Timeline& made) {
    // As it is read from its files, whose digits are fewer, so that every command says the same.
    Timeline timeline = made;
    timeline.manifest = manifest_from_json(to_text(made.manifest), made.name);
    FeelOptions options;
    options.tables = perception::find_tables();
    options.sound = false;
    const DriveSequence sequence = sequence_of(timeline);
    if (different_places(places_of(timeline.manifest, sequence)).empty()) return {};
    return feel(timeline, options);
}

std::string verdict_on(const std::optional<Feeling>& at_foci) {
    if (!at_foci) return "not felt: it has no foci";
    return fmt::format("{}; at {:.3g} Pa·m an element", perception::sentence_of(at_foci->verdicts),
                       at_foci->level.source_pa_m);
}

std::string verdict_on(const Timeline& timeline) { return verdict_on(feeling_at_foci(timeline)); }

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
             {"over_db", place.felt.lines.empty() ? ordered_json() : ordered_json(place.verdict.over_db)},
             {"answer", perception::words_of(place.verdict.answer())}});
    for (const Line& line : feeling.noise.lines) json["noise"].push_back({line.hz, line.amplitude});
    Picture picture("shipped:tools/plot_feel.py");
    picture.add("feel.json", json.dump());
    picture.draw(path, "the text and --json");
}

}  // namespace haptogram
