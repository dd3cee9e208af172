// SPDX-License-Identifier: Apache-2.0
#include "haptogram/hand/ring.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/base/error.hpp"

namespace haptogram {
namespace {

using std::numbers::pi;

/// Length of the ellipse from the end of its minor axis on, towards the major one, up to an angle φ at which the point
/// is (a·sin φ, b·cos φ).
double arc(const Ellipse& e, double eccentricity, double angle) {
    return e.half_major * std::ellint_2(eccentricity, angle);
}

/// The parameter of Ellipse::at() at which a point is nearest to a place.
double nearest_parameter(const Ellipse& e, Vec3 place) {
    constexpr int tried = 720;
    double best = 0.0, least = HUGE_VAL;
    for (int i = 0; i < tried; ++i) {
        const double parameter = 2.0 * pi * i / tried;
        const double way = distance(e.at(parameter), place);
        if (way < least) {
            least = way;
            best = parameter;
        }
    }
    return best;
}

}  // namespace

void require_sound(const RingOptions& options) {
    if (options.points < 3 || options.points > 200)
        throw bad_argument("points of a ring", fmt::format("found {}, expected 3 to 200", options.points));
    if (!(options.turns_hz > 0.0 && options.turns_hz <= 1000.0))
        throw bad_argument("turns",
                           fmt::format("found {} a second, expected more than 0, up to 1000", options.turns_hz));
    const double waves = options.still_am_hz / options.turns_hz;
    if (options.motion == FocusMotion::still && !(waves >= 1.0 && std::abs(waves - std::round(waves)) < 1e-9 &&
                                                  2.0 * waves < static_cast<double>(options.points)))
        throw bad_argument("modulation of the still focus",
                           fmt::format("found {} Hz; expected a multiple of {} Hz below {} Hz", options.still_am_hz,
                                       options.turns_hz, 0.5 * options.turns_hz * static_cast<double>(options.points)));
    const double step_m = 2.0 * pi * options.press.radius_m / options.press.foci / static_cast<double>(options.points);
    if (options.motion == FocusMotion::pressing &&
        !(options.press.foci >= 1 && options.press.foci <= 16 && options.press.turns_hz > 0.0 &&
          options.press.radius_m > 0.0 && step_m < longest_press_step_m))
        throw bad_argument(
            "pressing foci",
            fmt::format("found {} on a circle of {} mm, {} turns a second in steps of {:.3f} mm; expected 1 to 16, a "
                        "positive radius, turns, and steps below {} mm: take more points or a smaller circle",
                        options.press.foci, 1e3 * options.press.radius_m, options.press.turns_hz, 1e3 * step_m,
                        1e3 * longest_press_step_m));
}

double held_fundamental(const RingOptions& options) {
    const double step = pi * options.still_am_hz / options.turns_hz / static_cast<double>(options.points);
    return std::sin(step) / step;
}

std::vector<Vec3> ring_points(const Ellipse& ellipse, std::size_t count, const std::optional<Vec3>& start) {
    const double ratio = ellipse.half_minor / ellipse.half_major;
    const double eccentricity = std::sqrt(std::max(0.0, 1.0 - ratio * ratio));
    const double whole = ellipse.perimeter();
    // at(π/2 − φ) is (a·sin φ, b·cos φ); as φ falls, the parameter rises.
    double angle = 0.5 * pi - (start ? nearest_parameter(ellipse, *start) : 0.0);
    const double first = arc(ellipse, eccentricity, angle);
    std::vector<Vec3> points;
    for (std::size_t i = 0; i < count; ++i) {
        const double wanted = first - whole * static_cast<double>(i) / static_cast<double>(count);
        for (int round = 0; round < 20; ++round) {
            const double sine = eccentricity * std::sin(angle);
            const double step = (wanted - arc(ellipse, eccentricity, angle)) / ellipse.half_major /
                                std::sqrt(std::max(1e-12, 1.0 - sine * sine));
            angle += std::clamp(step, -0.5, 0.5);
            if (std::abs(step) < 1e-13) break;
        }
        points.push_back(ellipse.at(0.5 * pi - angle));
    }
    return points;
}

namespace {

/// Adds one finger's pressing foci to a path.
void add_press(Path& path, const Ellipse& section, const std::optional<Vec3>& start, const RingOptions& options) {
    const Vec3 from = start ? *start - section.centre : section.major;
    const double begin = std::atan2(dot(from, section.minor), dot(from, section.major));
    const double apart = 2.0 * pi / options.press.foci;
    for (std::size_t j = 0; j < options.points; ++j)
        for (unsigned k = 0; k < options.press.foci; ++k) {
            const double turn = begin + apart * (k + static_cast<double>(j) / static_cast<double>(options.points));
            path.steps[j].foci.push_back({section.centre + options.press.radius_m * (std::cos(turn) * section.major +
                                                                                     std::sin(turn) * section.minor),
                                          1.0});
        }
}

}  // namespace

Path ring_path(std::span<const Ellipse> sections, std::span<const std::optional<Vec3>> starts, double carrier_hz,
               const RingOptions& options) {
    require_sound(options);
    const double periods = std::round(carrier_hz / options.passes_hz() / static_cast<double>(options.points));
    if (periods < 1.0)
        throw bad_argument("turns", fmt::format("{} points at {} Hz leave less than a carrier period for each",
                                                options.points, options.passes_hz()));
    Path path;
    path.steps.resize(options.points);
    for (std::size_t j = 0; j < options.points; ++j) path.steps[j].periods = static_cast<std::uint32_t>(periods);
    const double waves = options.still_am_hz / options.turns_hz;
    for (std::size_t f = 0; f < sections.size(); ++f) {
        if (options.motion == FocusMotion::revolving) {
            const std::vector<Vec3> points = ring_points(sections[f], options.points, starts[f]);
            for (std::size_t j = 0; j < options.points; ++j) path.steps[j].foci.push_back({points[j], 1.0});
            continue;
        }
        if (options.motion == FocusMotion::pressing) {
            add_press(path, sections[f], starts[f], options);
            continue;
        }
        for (std::size_t j = 0; j < options.points; ++j) {
            const double turn = waves * static_cast<double>(j) / static_cast<double>(options.points);
            const double amplitude = 0.5 - 0.5 * std::cos(2.0 * pi * turn);
            if (amplitude > 0.0) path.steps[j].foci.push_back({sections[f].centre, amplitude});
        }
    }
    return path;
}

namespace {

using std::numbers::pi;

constexpr double usual_radius_m = 8e-3, usual_depth_m = 4e-3;
constexpr double least_radius_m = 5e-3, most_radius_m = 10.5e-3;
constexpr double together_m = 14e-3;  ///< elements that are nearer to each other's middle are one source
constexpr std::size_t most_together = 6;
constexpr double slant = 0.9;  ///< ratio of the half axes above which the finger is taken to come straight

Vec3 perpendicular(Vec3 a) { return unit(cross(a, std::abs(a.x) < 0.7 ? Vec3{1, 0, 0} : Vec3{0, 1, 0})); }

/// How far outside of the finger a point is.
double outside(const FingerForm& finger, Vec3 p) {
    const double along = std::max(0.0, dot(p - finger.tip, finger.to_hand));
    return distance(p, finger.tip + along * finger.to_hand) - finger.radius;
}

/// The way from a place inside, in a direction, to the skin.
double way_out(const FingerForm& finger, Vec3 from, Vec3 direction) {
    double near = 0.0, far = 6.0 * finger.radius;
    for (int round = 0; round < 50; ++round) {
        const double middle = 0.5 * (near + far);
        (outside(finger, from + middle * direction) < 0.0 ? near : far) = middle;
    }
    return near;
}

constexpr std::size_t lanes = 8;  ///< sums side by side, which a processor adds at once

/// |Σ a·conj(b)|² of so many pairs, a multiple of the lanes.
float square_of_sum(const float* a_real, const float* a_imaginary, const float* b_real, const float* b_imaginary,
                    std::size_t count) {
    std::array<float, lanes> real{}, imaginary{};
    for (std::size_t first = 0; first < count; first += lanes)
        for (std::size_t lane = 0; lane < lanes; ++lane) {
            const std::size_t i = first + lane;
            real[lane] += a_real[i] * b_real[i] + a_imaginary[i] * b_imaginary[i];
            imaginary[lane] += a_imaginary[i] * b_real[i] - a_real[i] * b_imaginary[i];
        }
    const float x = std::accumulate(real.begin(), real.end(), 0.0F);
    const float y = std::accumulate(imaginary.begin(), imaginary.end(), 0.0F);
    return x * x + y * y;
}

}  // namespace

std::optional<FingerCut> contact_of(const FingerForm& finger, Vec3 at, Vec3 inward) {
    const double height = dot(at - finger.tip, inward);  // of the surface below the round end's middle
    if (height >= finger.radius) return {};
    // A place in the surface and in the finger: below the middle, or where the finger's axis cuts the surface.
    const double steep = -dot(finger.to_hand, inward);
    Vec3 seed = finger.tip + height * inward;
    if (height < 0.0) {
        if (!(steep > 0.2)) return {};
        seed = finger.tip + (-height / steep) * finger.to_hand;
    }
    const Vec3 x = perpendicular(inward), y = cross(inward, x);
    constexpr int count = 120;
    std::vector<Vec3> outline;
    for (int i = 0; i < count; ++i) {
        const double angle = 2.0 * pi * i / count;
        const Vec3 direction = std::cos(angle) * x + std::sin(angle) * y;
        outline.push_back(seed + way_out(finger, seed, direction) * direction);
    }
    const auto section = section_of(outline, at, inward);
    if (!section) return {};
    return FingerCut{section->ellipse, inward, finger.tip + 0.5 * (finger.radius + height) * inward,
                     finger.radius - height};
}

std::optional<FingerForm> form_of(const FingerCut& contact) {
    const Ellipse& section = contact.section;
    const double minor = section.half_minor, depth = contact.deepest_m;
    FingerForm form{.to_hand = -1.0 * contact.inward, .radius = minor};
    if (depth < minor) {  // a circle of the round end, with that arrow
        form.radius = (minor * minor + depth * depth) / (2.0 * depth);
        // Of a shallow touch the radius is hardly seen.
        if (!(form.radius >= least_radius_m && form.radius <= most_radius_m)) form.radius = usual_radius_m;
        if (form.radius < minor) return {};
    }
    const double ratio = section.half_minor / section.half_major;
    if (ratio < slant) {
        // The hand is on the side of the longer axis from which the tip is seen away.
        const double side = dot(contact.inside - section.centre, section.major) > 0.0 ? -1.0 : 1.0;
        form.to_hand = -ratio * contact.inward + (side * std::sqrt(1.0 - ratio * ratio)) * section.major;
    }
    // The round end's middle lies on the axis, and its lowest place as deep as the finger is.
    const double height = depth - form.radius;  // of the middle below the surface
    form.tip = section.centre + (height / std::max(ratio < slant ? ratio : 1.0, 0.2)) * (-1.0 * form.to_hand);
    return form;
}

RingWeigher::RingWeigher(const Array& array, const FingerSound& sound)
    : sound_(sound),
      wave_number_(2.0 * pi / array.wavelength_m()),
      absorption_np_m_(array.medium.absorption_np_m),
      per_square_pa_(1.0 / (4.0 * array.medium.density_kg_m3 * array.medium.speed_m_s * array.medium.speed_m_s)) {
    for (const Element& element : array.elements) add(element, array.transducer.source_pa_m);
    for (Source& source : sources_) source.position = source.position * (1.0 / static_cast<double>(source.elements));
    while (sources_.size() % lanes != 0) {
        sources_.push_back(sources_.back());
        sources_.back().strength = 0.0;
    }
    constexpr int steps = 512;
    for (int i = 0; i <= steps; ++i)
        directivity_.push_back(std::abs(directivity(array.transducer, wave_number_, -1.0 + 2.0 * i / steps)));
}

void RingWeigher::add(const Element& element, double source_pa_m) {
    const auto near = [&](const Source& source) {
        const Vec3 middle = source.position * (1.0 / static_cast<double>(source.elements));
        return source.elements < most_together && dot(source.normal, element.normal) > 0.999 &&
               distance(middle, element.position) < together_m;
    };
    auto source = std::find_if(sources_.begin(), sources_.end(), near);
    if (source == sources_.end()) source = sources_.insert(source, Source{.normal = element.normal});
    source->position = source->position + element.position;
    source->strength += source_pa_m * std::abs(element.response * element.aligning());
    ++source->elements;
}

std::array<double, 2> RingWeigher::radii_m() const {
    return {sound_.grid().sizes.front() / wave_number_, sound_.grid().sizes.back() / wave_number_};
}

/// The wave's curvature on its way over the finger is left out.
void RingWeigher::meet(Source& source, Vec3 middle, const FingerForm& finger, const Frame& frame) const {
    const Vec3 ray = source.position - middle;
    const double range = norm(ray), cosine = std::clamp(-dot(ray, source.normal) / range, -1.0, 1.0);
    const auto directed = static_cast<std::size_t>(0.5 * (cosine + 1.0) * static_cast<double>(directivity_.size() - 1));
    source.pressure =
        static_cast<float>(source.strength * directivity_[directed] * std::exp(-absorption_np_m_ * range) / range);
    const double tilt = std::acos(std::clamp(-dot(ray, finger.to_hand) / range, -1.0, 1.0)) / pi;
    const double turn = std::atan2(dot(ray, frame.aside), dot(ray, frame.across)) / pi;
    source.tilt = static_cast<float>(tilt * static_cast<double>(sound_.grid().tilts - 1));
    source.turn = static_cast<float>(turn * static_cast<double>(sound_.grid().turns - 1));
}

/// Phases of the sources' waves at points in free air.
RingWeigher::Waves RingWeigher::ways_to(std::span<const Vec3> points) const {
    Waves ways;
    ways.real.reserve(points.size() * sources_.size());
    ways.imaginary.reserve(points.size() * sources_.size());
    for (const Vec3& point : points)
        for (const Source& source : sources_) {
            const auto phase = static_cast<float>(-wave_number_ * distance(source.position, point));
            ways.real.push_back(std::cos(phase));
            ways.imaginary.push_back(std::sin(phase));
        }
    return ways;
}

/// Of the phases at a place makes the pressures on the skin there.
void RingWeigher::put_on_skin(Waves& ways, std::size_t place, Vec3 position, const FingerForm& finger,
                              const Frame& frame) {
    const Vec3 ray = position - finger.tip;
    const double along = dot(ray, finger.to_hand);
    const double way =
        along > 0.0 ? pi / 2.0 + along / finger.radius : std::acos(std::clamp(-along / norm(ray), -1.0, 1.0));
    sound_.at_way(of_size_, way, slice_);
    const std::size_t columns = sound_.grid().turns, rows = sound_.grid().tilts;
    const auto half = static_cast<float>(columns - 1);
    const auto here = static_cast<float>(std::atan2(dot(ray, frame.aside), dot(ray, frame.across)) / pi) * half;
    for (std::size_t s = 0; s < sources_.size(); ++s) {
        const Source& source = sources_[s];
        const float apart = std::abs(source.turn - here), turn = apart > half ? 2.0F * half - apart : apart;
        const std::size_t column = std::min(static_cast<std::size_t>(turn), columns - 2);
        const std::size_t row = std::min(static_cast<std::size_t>(source.tilt), rows - 2);
        const float right = turn - static_cast<float>(column), down = source.tilt - static_cast<float>(row);
        const std::complex<float>* const upper = slice_.data() + row * columns + column;
        const std::complex<float>* const lower = upper + columns;
        const std::complex<float> above = upper[0] + right * (upper[1] - upper[0]);
        const std::complex<float> below = lower[0] + right * (lower[1] - lower[0]);
        const std::complex<float> value = source.pressure * (above + down * (below - above));
        float& real = ways.real[place * sources_.size() + s];
        float& imaginary = ways.imaginary[place * sources_.size() + s];
        const float turned = value.real() * real - value.imag() * imaginary;
        imaginary = value.real() * imaginary + value.imag() * real;
        real = turned;
    }
}

std::optional<std::vector<double>> RingWeigher::radiation_pa(std::span<const Vec3> skin, std::span<const Vec3> foci,
                                                             const FingerForm& finger) {
    const double size = wave_number_ * finger.radius;
    if (skin.empty() || foci.empty() || !sound_.knows(size)) return {};
    of_size_ = sound_.of_size(size);
    Vec3 middle;
    for (const Vec3& place : skin) middle = middle + place * (1.0 / static_cast<double>(skin.size()));
    const Vec3 across = perpendicular(finger.to_hand);
    const Frame frame{across, cross(finger.to_hand, across)};
    for (Source& source : sources_) meet(source, middle, finger, frame);
    const Waves aims = ways_to(foci);
    Waves waves = skin.data() == foci.data() && skin.size() == foci.size() ? aims : ways_to(skin);
    for (std::size_t i = 0; i < skin.size(); ++i) put_on_skin(waves, i, skin[i], finger, frame);
    const std::size_t count = sources_.size();
    std::vector<double> found;
    found.reserve(foci.size() * skin.size());
    for (std::size_t j = 0; j < foci.size(); ++j)
        for (std::size_t i = 0; i < skin.size(); ++i) {
            found.push_back(per_square_pa_ *
                            static_cast<double>(
                                square_of_sum(waves.real.data() + i * count, waves.imaginary.data() + i * count,
                                              aims.real.data() + j * count, aims.imaginary.data() + j * count, count)));
        }
    return found;
}

std::optional<RingReach> RingWeigher::weigh(std::span<const Vec3> places, const FingerForm& finger) {
    const std::optional<std::vector<double>> pa = radiation_pa(places, places, finger);
    if (!pa) return {};
    RingReach reach;
    std::vector<bool> reached;
    for (std::size_t j = 0; j < places.size(); ++j) {
        const auto first = pa->begin() + static_cast<std::ptrdiff_t>(j * places.size());
        const double here = *(first + static_cast<std::ptrdiff_t>(j));
        reach.radiation_pa.push_back(here);
        reached.push_back(*std::max_element(first, first + static_cast<std::ptrdiff_t>(places.size())) <= here);
        if (!reached.back()) continue;
        reach.even_pa = reach.reached++ == 0 ? here : std::min(reach.even_pa, here);
        reach.uneven = std::max(reach.uneven, here);
    }
    if (reach.reached == 0) return {};
    reach.uneven /= reach.even_pa;
    for (std::size_t j = 0; j < places.size(); ++j)
        reach.amplitudes.push_back(reached[j] ? std::sqrt(reach.even_pa / reach.radiation_pa[j]) : 0.0);
    return reach;
}

std::string reach_in_words(const Array& array, Vec3 place, std::size_t points) {
    const std::string what = fmt::format("a finger of {:g} mm, {:g} mm deep at ({:.0f}, {:.0f}, {:.0f}) mm",
                                         2.0 * usual_radius_m / millimetre, usual_depth_m / millimetre,
                                         place.x / millimetre, place.y / millimetre, place.z / millimetre);
    if (const std::string why = array.unreachable(place); !why.empty())
        return fmt::format("{}: no ring, the array does not reach it, {}", what, why);
    RingWeigher weigher(array);
    std::string words;
    for (const auto& [way, name] :
         {std::pair(Vec3{0, 0, 1}, "from above"), std::pair(unit(Vec3{0, -1, 1}), "aslant from above and the front")}) {
        const FingerForm finger{place + (usual_radius_m - usual_depth_m) * Vec3{0, 0, 1}, way, usual_radius_m};
        const auto contact = contact_of(finger, place, {0, 0, -1});
        const auto reach = contact ? weigher.weigh(ring_points(contact->section, points), finger) : std::nullopt;
        if (!reach) continue;
        words += fmt::format(
            "{}{}, {} of {} places of its ring are reached, the strongest {:.1f} times as strongly as the weakest; "
            "weighed, each gets {:.3g} Pa",
            words.empty() ? ": " : ". Or ", name, reach->reached, points, reach->uneven, reach->even_pa);
    }
    return words.empty() ? words : what + words;
}

}  // namespace haptogram
