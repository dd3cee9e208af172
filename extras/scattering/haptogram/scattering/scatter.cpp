// SPDX-License-Identifier: Apache-2.0
#include "haptogram/scattering/scatter.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/acoustics/skin_force.hpp"
#include "haptogram/array/rig.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/format/waveform.hpp"
#include "haptogram/hand/ring.hpp"
#include "haptogram/scattering/scatterer.hpp"
#include "haptogram/scattering/shells.hpp"
#include "haptogram/scattering/skin.hpp"
#include "haptogram/shape/adaptics.hpp"
#include "haptogram/shape/import.hpp"
#include "haptogram/shape/path_file.hpp"
#include "haptogram/solve/solver.hpp"

namespace haptogram::scattering {
namespace {

constexpr double default_radius_m = 8e-3, default_length_m = 50e-3;
constexpr double default_elements = 8.0;        ///< a wavelength
constexpr std::size_t adaptics_samples = 1000;  ///< of a pass of an AdapTics pattern
/// A polynomial takes the place of a measured pattern: only then is there a gradient that is quick (field.hpp).
constexpr double pattern_error = 0.02;

std::string in_words(Vec3 p) {
    return fmt::format("({:.2f}, {:.2f}, {:.2f}) mm", p.x / millimetre, p.y / millimetre, p.z / millimetre);
}

/// Steps with the same foci become one.
std::vector<ScatteredStep> steps_of(const Path& path) {
    std::vector<ScatteredStep> steps;
    for (const PathStep& step : path.steps) {
        const auto same = std::find_if(steps.begin(), steps.end(), [&](const auto& s) { return s.foci == step.foci; });
        ScatteredStep& one = same == steps.end() ? steps.emplace_back() : *same;
        one.foci = step.foci;
        one.share += static_cast<double>(step.periods) / static_cast<double>(path.periods());
    }
    return steps;
}

/// The built-in finger in its place.
FingerForm finger_of(const BodySource& body) {
    if (body.name != "finger")
        throw bad_argument("ring", fmt::format("is around the built-in finger, and the body is {}", body.name));
    const double radius = body.radius_m.value_or(default_radius_m);
    const auto [x, y, z] = body.placement.rotate_deg;
    const Vec3 to_hand = pose_of({}, {x, y, z}).turned({0, 0, 1});
    const double half = 0.5 * body.length_m.value_or(default_length_m);
    return {body.placement.center.value_or(Vec3{}) - (half - radius) * to_hand, to_hand, radius};
}

/// What `live` plays around the finger, from what it sees of it.
Path ring_path_of(const ScatterSource& source, const Array& array) {
    if (!(norm(source.inward) > 0.0)) throw bad_argument("inward", "expected a direction, found 0,0,0");
    const auto contact = contact_of(finger_of(source.body), *source.ring, unit(source.inward));
    if (!contact)
        throw bad_argument("ring", fmt::format("a surface through {} does not cut the finger as a finger is cut: move "
                                               "it, or turn it with --inward",
                                               in_words(*source.ring)));
    const RingOptions options;
    const std::vector<Vec3> places = ring_points(contact->section, options.points);
    std::vector<double> amplitudes(places.size(), 1.0);
    if (source.weighed) {
        RingWeigher weigher(array);
        const auto form = form_of(*contact);
        const auto reach = form ? weigher.weigh(places, *form) : std::nullopt;
        if (!reach)
            throw bad_argument("weighed",
                               fmt::format("is known of fingers with radii from {:.1f} to {:.1f} mm",
                                           weigher.radii_m()[0] / millimetre, weigher.radii_m()[1] / millimetre));
        amplitudes = reach->amplitudes;
    }
    Path path;
    for (std::size_t i = 0; i < places.size(); ++i) path.steps.push_back({{{places[i], amplitudes[i]}}, 1});
    return path;
}

RingEvenness evenness_of(const std::vector<ScatteredStep>& steps) {
    RingEvenness even{.foci = steps.size()};
    double least = HUGE_VAL, most = 0.0;
    for (const ScatteredStep& step : steps) {
        least = std::min(least, step.highest_pa);
        most = std::max(most, step.highest_pa);
        even.farthest_m = std::max(even.farthest_m, distance(step.highest_at, step.foci.front().position));
    }
    even.uneven = most / least;
    return even;
}

Path path_of(const ScatterSource& source, const Array& array) {
    const int given = (source.foci.empty() ? 0 : 1) + (source.path.empty() ? 0 : 1) + (source.plane_wave ? 1 : 0) +
                      (source.ring ? 1 : 0);
    if (given != 1)
        throw bad_argument("focus", "give foci, a path, a plane wave or a ring, just one of them",
                           {"focus", "path", "plane-wave", "ring"});
    if (source.ring) return ring_path_of(source, array);
    if (source.plane_wave) {
        if (!is_finite(*source.plane_wave) || norm(*source.plane_wave) == 0.0)
            throw bad_argument("plane-wave", "goes nowhere: give a direction x,y,z");
        if (source.flat_estimate) throw bad_argument("flat", "is of what an array sends, not of a plane wave");
        Path wave;
        wave.steps = {{{}, 1}};
        return wave;
    }
    if (!source.path.empty()) {
        const std::string text = read_file(source.path);
        return source.path.ends_with(".adaptics")
                   ? path_from_adaptics(text, source.path, array.carrier_hz, adaptics_samples)
                   : path_of_file(text, source.path, array.carrier_hz);
    }
    Path path;
    for (const Vec3& focus : source.foci) path.steps.push_back({{{focus, 1.0}}, 1});
    return path;
}

void check(const ScatterSource& source, const Array& array, const Body& body, const ScatteredStep& step) {
    for (const Focus& focus : step.foci) {
        if (const std::string why = array.unreachable(focus.position); !why.empty())
            throw bad_input(fmt::format("focus {}", in_words(focus.position)), why);
        const double outside = body.solid.distance(focus.position);
        if (!source.foci_inside && !source.ring && outside < -body.longest_edge())
            throw impossible(
                "focus",
                fmt::format("{} is {:.2f} mm inside of the body; sound cannot get there. Move it to the skin, "
                            "or say that the array shall aim there all the same",
                            in_words(focus.position), -outside / millimetre),
                {"foci_inside"});
    }
}

std::vector<std::complex<double>> drives_of(const Array& array, const std::vector<Focus>& foci) {
    std::vector<std::complex<double>> drives;
    if (foci.size() == 1) {
        drives = ideal_drives(array, foci.front().position);
        for (std::complex<double>& drive : drives) drive *= foci.front().amplitude;
    } else {
        drives = solve(array, foci);
        for (std::complex<double>& drive : drives) drive *= array.transducer.source_pa_m;
    }
    return drives;
}

/// Radiation pressure on each triangle as if it were a patch of flat skin without end, Pa: what `feel` computes with.
std::vector<float> flat_radiation(const Scattered& found, double weaker) {
    std::vector<std::vector<std::complex<double>>> drives;
    for (const ScatteredStep& step : found.steps) drives.push_back(drives_of(found.array, step.foci));
    std::vector<float> flat;
    for (const Panel& panel : found.body.panels) {
        const std::vector<PatchSound> waves = waves_at_patch(found.array, panel.centre, panel.normal);
        double mean = 0.0;
        for (std::size_t s = 0; s < drives.size(); ++s)
            mean += found.steps[s].share * weaker *
                    radiation_pressure(sound_at_patch(waves, drives[s]), found.array.medium);
        flat.push_back(static_cast<float>(mean));
    }
    return flat;
}

void require_clear(const Array& array, const Body& body) {
    const double least = body.longest_edge();
    for (std::size_t m = 0; m < array.elements.size(); ++m)
        if (const double apart = body.solid.distance(array.elements[m].position); apart < least)
            throw bad_input(body.name,
                            fmt::format("element {} of {} at {} is {}; move the body away", m, array.name,
                                        in_words(array.elements[m].position),
                                        apart < 0.0 ? "inside of the body"
                                                    : fmt::format("only {:.2f} mm off it", apart / millimetre)));
}

std::string title_of(const ScatterSource& source, const Scattered& found) {
    const std::string what =
        source.ring         ? fmt::format("a ring of {} foci{}", found.steps.size(), source.weighed ? ", weighed," : "")
        : source.plane_wave ? "a plane wave of 1 Pa"
        : !source.path.empty()    ? source.path
        : source.foci.size() == 1 ? fmt::format("a focus at {}", in_words(source.foci.front()))
                                  : fmt::format("{} foci in turn", source.foci.size());
    return fmt::format("{}: {} on {} of {} triangles", found.array.name, what, found.body.name,
                       found.body.panels.size());
}

}  // namespace

bool is_built_in_body(std::string_view name) { return name == "sphere" || name == "finger"; }

Body open_body(const BodySource& source, double wavelength_m) {
    const auto refuse = [&](const char* setting, const std::optional<double>& value, const char* owner) {
        if (value) throw bad_argument(setting, fmt::format("is of {}, not of {}", owner, source.name));
    };
    Mesh mesh;
    if (is_built_in_body(source.name)) {
        const double radius = source.radius_m.value_or(default_radius_m);
        const double edge = source.edge_m.value_or(wavelength_m / default_elements);
        if (source.name == "sphere") refuse("length", source.length_m, "the finger");
        mesh = source.name == "sphere" ? sphere_mesh(radius, edge)
                                       : capsule_mesh(radius, source.length_m.value_or(default_length_m), edge);
    } else {
        for (const auto& [setting, value] : {std::pair("radius", source.radius_m), std::pair("length", source.length_m),
                                             std::pair("edge", source.edge_m)})
            refuse(setting, value, "a built-in body");
        Shape shape = load_shape(std::filesystem::path(source.name), source.metres_per_unit, source.readers);
        if (shape_format(source.name) == ShapeFormat::gltf) shape = stood_up(std::move(shape));
        const Mesh* const found = std::get_if<Mesh>(&shape.pieces.front());
        if (found == nullptr)
            throw bad_input(source.name, "has points but no faces; a body needs a closed surface of triangles");
        if (!found->flaw.empty()) throw bad_input(source.name, found->flaw);
        mesh = *found;
    }
    const Shape placed = placed_at(Shape{{mesh}}, source.placement);
    return body_of(std::get<Mesh>(placed.pieces.front()), source.name);
}

ErrorRange mesh_error(double elements_per_wavelength) {
    const double over = std::pow(8.0 / elements_per_wavelength, 2.0);
    return {0.005 * over, 0.02 * over};
}

Scattered scatter(const ScatterSource& source, const Progress& progress) {
    Scattered found;
    found.array = source.rig.empty() ? find_array(source.array) : joined(find_rig(source.rig));
    const Array& array = found.array;
    const Path path = path_of(source, array);
    found.body = open_body(source.body, array.wavelength_m());
    const Body& body = found.body;
    require_fine(body, array.wavelength_m(), source.least_elements);
    if (!source.plane_wave) require_clear(array, body);
    const double weaker = path.modulation.samples.empty() ? 1.0 : mean_square_of(path.modulation);
    for (ScatteredStep& step : steps_of(path)) {
        check(source, array, body, step);
        const bool sounds = source.plane_wave || std::any_of(step.foci.begin(), step.foci.end(),
                                                             [](const Focus& f) { return f.amplitude > 0.0; });
        if (sounds)
            found.steps.push_back(std::move(step));
        else
            found.resting += step.share;
    }
    if (found.steps.empty()) throw bad_input(source.path, "nothing is played: all of it is silence");
    found.title = title_of(source, found);
    found.is_plane_wave = source.plane_wave.has_value();

    const double wave_number = 2.0 * std::numbers::pi / array.wavelength_m();
    progress(0.0, "matrix");
    Scatterer scatterer(body, wave_number);
    const Skin skin(body);
    if (found.steps.size() >= scatterer.worth_factorising()) {
        progress(0.0, "factors");
        scatterer.factorise();
    }
    FieldOptions field;
    field.pattern_error = pattern_error;
    std::vector<double> square(body.panels.size()), radiation(body.panels.size());
    constexpr std::size_t at_once = 16;
    for (std::size_t first = 0; first < found.steps.size(); first += at_once) {
        progress(static_cast<double>(first) / static_cast<double>(found.steps.size()), "sounds");
        const std::size_t end = std::min(first + at_once, found.steps.size());
        std::vector<IncidentSound> sounds;
        for (std::size_t s = first; s < end; ++s)
            sounds.push_back(source.plane_wave
                                 ? plane_wave_on(body, *source.plane_wave, wave_number)
                                 : incident_from(array, drives_of(array, found.steps[s].foci), body, field));
        const SurfacePressures solved = scatterer.pressures(sounds);
        found.rounds = std::max(found.rounds, solved.rounds);
        found.residual = std::max(found.residual, solved.residual);
        for (std::size_t s = first; s < end; ++s) {
            ScatteredStep& step = found.steps[s];
            const auto& pressure = solved.pressure[s - first];
            const std::vector<float> here = skin.radiation_pressure(pressure, wave_number, array.medium);
            const auto highest = std::max_element(here.begin(), here.end());
            step.highest_pa = static_cast<double>(*highest) * weaker;
            step.highest_at = body.panels[static_cast<std::size_t>(highest - here.begin())].centre;
            step.force_n = skin.force(here) * weaker;
            found.force_n = found.force_n + step.share * step.force_n;
            for (std::size_t i = 0; i < here.size(); ++i) {
                square[i] += step.share * weaker * static_cast<double>(std::norm(pressure[i])) / 2.0;
                radiation[i] += step.share * weaker * static_cast<double>(here[i]);
            }
        }
    }
    progress(1.0, "sounds");
    for (std::size_t i = 0; i < square.size(); ++i) {
        found.rms_pressure.push_back(static_cast<float>(std::sqrt(square[i])));
        found.radiation.push_back(static_cast<float>(radiation[i]));
    }
    found.highest = static_cast<std::size_t>(std::max_element(radiation.begin(), radiation.end()) - radiation.begin());
    if (source.ring) found.ring = evenness_of(found.steps);
    if (source.flat_estimate) found.flat = flat_radiation(found, weaker);
    if (array.transducer.pattern == Pattern::table) found.pattern_error = pattern_error;
    return found;
}

}  // namespace haptogram::scattering
