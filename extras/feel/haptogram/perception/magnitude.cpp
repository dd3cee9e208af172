// SPDX-License-Identifier: Apache-2.0
#include "haptogram/perception/magnitude.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <tuple>
#include <utility>

#include "haptogram/acoustics/skin_force.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/format/waveform.hpp"
#include "haptogram/verbs/project.hpp"

namespace haptogram::perception {
namespace {

using std::numbers::pi;

constexpr std::array<std::pair<Waveform, const char*>, 6> names = {{{Waveform::square, "square"},
                                                                    {Waveform::abs_sine, "abs-sine"},
                                                                    {Waveform::sine, "sine"},
                                                                    {Waveform::cosine, "cosine"},
                                                                    {Waveform::triangle, "triangle"},
                                                                    {Waveform::sawtooth, "sawtooth"}}};

void require_duty(double duty) {
    if (!(duty > 0.0 && duty <= 1.0))
        throw bad_argument("duty", fmt::format("the duty of a square wave lies above 0 and up to 1, found {:g}", duty));
}

double output(Waveform waveform, double duty, Weighing weighing) {
    return weighing == Weighing::mean ? mean_output(waveform, duty) : fundamental_output(waveform, duty);
}

}  // namespace

std::string name_of(Waveform waveform) {
    for (const auto& [which, name] : names)
        if (which == waveform) return name;
    throw bad_argument("waveform", "no such waveform");
}

Waveform waveform_of(const std::string& name) {
    std::string known;
    for (const auto& [which, text] : names) {
        if (name == text) return which;
        known += fmt::format("{}{}", known.empty() ? "" : ", ", text);
    }
    throw bad_argument("waveform", fmt::format("expected one of {}, found '{}'", known, name));
}

const std::vector<Waveform>& all_waveforms() {
    static const std::vector<Waveform> all = [] {
        std::vector<Waveform> list;
        for (const auto& entry : names) list.push_back(entry.first);
        return list;
    }();
    return all;
}

double envelope(Waveform waveform, double phase, double duty) {
    const double t = phase - std::floor(phase);
    switch (waveform) {
        case Waveform::square: require_duty(duty); return t < duty ? 1.0 : 0.0;
        case Waveform::abs_sine: return std::abs(std::sin(pi * t));
        case Waveform::sine: return (1.0 + std::sin(2.0 * pi * t)) / 2.0;
        case Waveform::cosine: return (1.0 + std::cos(2.0 * pi * t)) / 2.0;
        case Waveform::triangle: return 1.0 - std::abs(2.0 * t - 1.0);
        case Waveform::sawtooth: return t;
    }
    throw bad_argument("waveform", "no such waveform");
}

double mean_output(Waveform waveform, double duty) {
    switch (waveform) {
        case Waveform::square: require_duty(duty); return duty;
        case Waveform::abs_sine: return 1.0 / 2.0;
        case Waveform::sine:
        case Waveform::cosine: return 3.0 / 8.0;
        case Waveform::triangle:
        case Waveform::sawtooth: return 1.0 / 3.0;
    }
    throw bad_argument("waveform", "no such waveform");
}

double fundamental_output(Waveform waveform, double duty) {
    // Fourier coefficients of m², at the frequency at which the envelope repeats.
    switch (waveform) {
        case Waveform::square: require_duty(duty); return 2.0 / pi * std::sin(pi * duty);
        case Waveform::abs_sine: return 1.0 / 2.0;
        case Waveform::sine:
        case Waveform::cosine: return 1.0 / 2.0;
        case Waveform::triangle: return 4.0 / (pi * pi);
        case Waveform::sawtooth: return std::hypot(1.0 / (pi * pi), 1.0 / pi);
    }
    throw bad_argument("waveform", "no such waveform");
}

Weighing weighing_of(const std::string& name) {
    if (name == "fundamental") return Weighing::fundamental;
    if (name == "mean") return Weighing::mean;
    throw bad_argument("weighing", fmt::format("expected fundamental or mean, found '{}'", name));
}

double waveform_factor(Waveform waveform, Weighing weighing) {
    return output(waveform, 0.5, weighing) / output(Waveform::square, 0.5, weighing);
}

double duty_factor(double duty, Weighing weighing) {
    require_duty(duty);
    if (duty == 1.0 && weighing == Weighing::fundamental)
        throw bad_argument("duty",
                           "a square wave of duty 1 does not alternate, so it is not felt as vibration; take less");
    return output(Waveform::square, 0.5, weighing) / output(Waveform::square, duty, weighing);
}

double radiation_linear(double wanted) {
    if (!(wanted >= 0.0 && wanted <= 1.0))
        throw bad_argument("wanted",
                           fmt::format("a radiation pressure as a part of the largest is 0…1, found {:g}", wanted));
    return std::sqrt(wanted);
}

namespace {

/// Rounding must not put the ends of a range outside of it.
constexpr double ends_gf = 1e-12;

double cubic(const std::array<double, 4>& p, double x) { return ((p[0] * x + p[1]) * x + p[2]) * x + p[3]; }
double parabola(const std::array<double, 3>& p, double x) { return (p[0] * x + p[1]) * x + p[2]; }

/// The x of a rising function with f(x) = y, by bisection to the last bit.
template <class Function>
double inverse(const Function& rising, double y, double low, double high) {
    for (int i = 0; i < 200 && low < high; ++i) {
        const double middle = low + (high - low) / 2.0;
        if (middle == low || middle == high) break;
        (rising(middle) < y ? low : high) = middle;
    }
    return std::abs(rising(low) - y) < std::abs(rising(high) - y) ? low : high;
}

void require_output(const FrequencyFit& fit, double gf) {
    const double most = full_output_gf(fit);
    if (!(gf >= 0.0 && gf <= most + ends_gf))
        throw bad_argument("output",
                           fmt::format("{:.5g} gf lies outside of 0…{:.5g} gf, which were measured at {:g} Hz; ask for "
                                       "an output in that range",
                                       gf, most, fit.frequency_hz));
}

}  // namespace

FrequencyFit fit_at(const Tables& tables, double frequency_hz) {
    const auto& fits = tables.fits;
    if (!(frequency_hz >= fits.front().frequency_hz && frequency_hz <= fits.back().frequency_hz))
        throw bad_argument("frequency",
                           fmt::format("{:g} Hz lies outside of {:g}…{:g} Hz, which {} covers; ask for a "
                                       "frequency in that range",
                                       frequency_hz, fits.front().frequency_hz, fits.back().frequency_hz, tables.name));
    const auto above = std::find_if(fits.begin(), fits.end(),
                                    [&](const FrequencyFit& fit) { return fit.frequency_hz >= frequency_hz; });
    if (above->frequency_hz == frequency_hz) return *above;
    const FrequencyFit& a = *(above - 1);
    const FrequencyFit& b = *above;
    // Both polynomials are linear in their coefficients, so these are interpolated instead of their values.
    const double weight = std::log(frequency_hz / a.frequency_hz) / std::log(b.frequency_hz / a.frequency_hz);
    FrequencyFit fit{
        frequency_hz, {}, {}, std::min(a.command_r2, b.command_r2), std::min(a.magnitude_r2, b.magnitude_r2)};
    for (std::size_t i = 0; i < fit.command.size(); ++i) fit.command[i] = std::lerp(a.command[i], b.command[i], weight);
    for (std::size_t i = 0; i < fit.magnitude.size(); ++i)
        fit.magnitude[i] = std::lerp(a.magnitude[i], b.magnitude[i], weight);
    return fit;
}

double full_output_gf(const FrequencyFit& fit) {
    double high = 1.0;
    while (cubic(fit.command, high) < 1.0 && high < 1e6) high *= 2.0;
    return inverse([&](double g) { return cubic(fit.command, g); }, 1.0, 0.0, high);
}

double command_of_output(const FrequencyFit& fit, double gf) {
    require_output(fit, gf);
    return cubic(fit.command, gf);
}

double output_of_command(const FrequencyFit& fit, double command) {
    const double least = fit.command.back();
    if (!(command >= least && command <= 1.0))
        throw bad_argument("command", fmt::format("{:.5g} lies outside of {:.4f}…1: below, the fit at {:g} Hz has no "
                                                  "output, and 1 is the full command",
                                                  command, least, fit.frequency_hz));
    return inverse([&](double g) { return cubic(fit.command, g); }, command, 0.0, full_output_gf(fit));
}

double magnitude_of_output(const FrequencyFit& fit, double gf) {
    require_output(fit, gf);
    return parabola(fit.magnitude, gf);
}

double output_of_magnitude(const FrequencyFit& fit, double magnitude) {
    const double full = full_output_gf(fit);
    const double least = parabola(fit.magnitude, 0.0), most = parabola(fit.magnitude, full);
    if (!(magnitude >= least && magnitude <= most))
        throw bad_argument("magnitude",
                           fmt::format("{:.5g} cannot be made at {:g} Hz, where {:.4g}…{:.4g} can; ask for "
                                       "a magnitude in that range, or a lower frequency",
                                       magnitude, fit.frequency_hz, least, most));
    return inverse([&](double g) { return parabola(fit.magnitude, g); }, magnitude, 0.0, full);
}

namespace {

using std::numbers::pi;

/// All that does not depend on the device.
Setting felt(const Tables& tables, const Wanted& wanted, const FrequencyFit& fit) {
    if (wanted.region != Region::palm)
        throw bad_argument("region",
                           fmt::format("{} has magnitudes for the palm only, and a finger feels otherwise; take "
                                       "palm, or ask for the threshold of a finger alone",
                                       tables.name));
    Setting setting;
    setting.output_gf = output_of_magnitude(fit, wanted.magnitude);
    setting.least_felt_gf = least_felt_gf(tables, wanted.region, wanted.frequency_hz, wanted.grip_n);
    if (setting.output_gf < setting.least_felt_gf)
        throw bad_argument(
            "magnitude", fmt::format("{:g} needs {:.4f} gf, which is less than the {:.4f} gf that are felt at {:g} Hz "
                                     "and a grip of {:g} N; ask for {:.3f} or more",
                                     wanted.magnitude, setting.output_gf, setting.least_felt_gf, wanted.frequency_hz,
                                     wanted.grip_n, magnitude_of_output(fit, setting.least_felt_gf)));
    setting.waveform_factor = waveform_factor(wanted.waveform, wanted.weighing);
    if (wanted.waveform == Waveform::square)
        setting.duty_factor = duty_factor(wanted.duty, wanted.weighing);
    else if (wanted.duty != 0.5)
        throw bad_argument("duty", fmt::format("a duty of {:g} belongs to the square wave, and the waveform is {}",
                                               wanted.duty, name_of(wanted.waveform)));
    return setting;
}

Error too_much(const Wanted& wanted, const Setting& setting, const std::string& who) {
    return bad_argument("magnitude",
                        fmt::format("{:g} needs {:.4f} gf with this waveform and place, and {} gives {:.4f} "
                                    "gf at most; ask for less",
                                    wanted.magnitude, setting.needed_gf, who, setting.full_gf));
}

}  // namespace

double position_factor(const Array& array, Vec3 focus, Vec3 reference) {
    return full_force(array, reference) / full_force(array, focus);
}

double pulse_duty(double amplitude, double full_duty) {
    if (!(amplitude >= 0.0 && amplitude <= 1.0))
        throw bad_argument("amplitude", fmt::format("an amplitude is 0…1, found {:g}", amplitude));
    return std::asin(amplitude * std::sin(pi * full_duty)) / pi;
}

double needed_gf(const Tables& tables, const Wanted& wanted) {
    const Setting setting = felt(tables, wanted, fit_at(tables, wanted.frequency_hz));
    return setting.output_gf * setting.duty_factor / setting.waveform_factor;
}

Setting setting_for(const Tables& tables, const Wanted& wanted) {
    const FrequencyFit fit = fit_at(tables, wanted.frequency_hz);
    Setting setting = felt(tables, wanted, fit);
    setting.factor = setting.position_factor * setting.duty_factor / setting.waveform_factor;
    setting.needed_gf = setting.output_gf * setting.factor;
    setting.full_gf = full_output_gf(fit);
    if (setting.needed_gf > setting.full_gf) throw too_much(wanted, setting, tables.name);
    setting.command = command_of_output(fit, setting.needed_gf);
    setting.pulse_duty = pulse_duty(setting.command);
    return setting;
}

Setting setting_for(const Tables& tables, const Wanted& wanted, const Array& array, Vec3 focus) {
    const FrequencyFit fit = fit_at(tables, wanted.frequency_hz);
    Setting setting = felt(tables, wanted, fit);
    // The array's force is computed where the focus is, so its place needs no factor of its own.
    setting.factor = setting.duty_factor / setting.waveform_factor;
    setting.needed_gf = setting.output_gf * setting.factor;
    setting.full_gf = mean_output(Waveform::square) * full_force(array, focus) / gram_force_n;
    if (setting.needed_gf > setting.full_gf) throw too_much(wanted, setting, array.name);
    setting.command = std::sqrt(setting.needed_gf / setting.full_gf);
    setting.pulse_duty = pulse_duty(setting.command, array.duty);
    return setting;
}

Wanted wanted_of(double magnitude, std::string_view am, bool values_are_radiation) {
    if (values_are_radiation)
        throw bad_argument(
            "magnitude", "is known of waveforms of the pressure, and these are of the radiation pressure", {"am_law"});
    const std::optional<NamedWaveform> waveform = single_waveform(am);
    if (!waveform)
        throw bad_argument("magnitude",
                           fmt::format("is known of one square, sine, abs-sine, triangle or sawtooth wave, such as "
                                       "square:200; the modulation is {}",
                                       am.empty() ? "none" : fmt::format("'{}'", am)),
                           {"am"});
    Wanted wanted;
    wanted.magnitude = magnitude;
    wanted.waveform = waveform_of(waveform->kind);
    wanted.frequency_hz = waveform->frequency_hz;
    wanted.duty = waveform->duty;
    return wanted;
}

namespace {

/// The command at a place; an error names the place.
double command_at(const Tables& tables, const Wanted& wanted, const Array& array, Vec3 place) {
    try {
        return setting_for(tables, wanted, array, place).command;
    } catch (const Error& error) {
        throw bad_argument(error.where() == "focus" ? "magnitude" : error.where(),
                           fmt::format("at ({:.1f}, {:.1f}, {:.1f}) mm: {}", place.x / millimetre, place.y / millimetre,
                                       place.z / millimetre, error.message()),
                           error.remedies());
    }
}

/// Multiplies the amplitudes of a path's foci by what `command` says of their places.
template <class Command>
PathMagnitude multiply(Path& path, Command command) {
    const auto before = [](const Vec3& a, const Vec3& b) { return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z); };
    std::map<Vec3, double, decltype(before)> commands(before);
    PathMagnitude made{1.0, 0.0, false};
    for (PathStep& step : path.steps) {
        if (step.foci.size() > 1)
            throw bad_argument("magnitude",
                               fmt::format("is known of one focus at a time, and a step of the path has {} "
                                           "that share the array's pressure",
                                           step.foci.size()));
        for (Focus& focus : step.foci) {
            const auto [at, is_new] = commands.try_emplace(focus.position, 0.0);
            if (is_new) {
                at->second = command(focus.position);
                made.least_command = std::min(made.least_command, at->second);
                made.most_command = std::max(made.most_command, at->second);
            }
            focus.amplitude *= at->second;
        }
    }
    made.moves = commands.size() > 1;
    return made;
}

constexpr double pitch_m = 5e-3;  // of the lattice

}  // namespace

PathMagnitude give_magnitude(Path& path, const Tables& tables, const Wanted& wanted, const Array& array) {
    return multiply(path, [&](Vec3 place) { return command_at(tables, wanted, array, place); });
}

CommandLattice::CommandLattice(const Tables& tables, const Wanted& wanted, const Array& array)
    : tables_(tables), wanted_(wanted), array_(array), needed_gf_(needed_gf(tables, wanted)) {}

double CommandLattice::force_at(const std::array<long, 3>& corner) {
    const auto [at, is_new] = forces_.try_emplace(corner, std::numeric_limits<double>::quiet_NaN());
    if (is_new) {
        const auto along = [&](std::size_t axis) { return pitch_m * static_cast<double>(corner[axis]); };
        const Vec3 place{along(0), along(1), along(2)};
        if (array_.unreachable(place).empty()) at->second = full_force(array_, place);
    }
    return at->second;
}

double CommandLattice::at(Vec3 place) {
    if (!array_.unreachable(place).empty()) return command_at(tables_, wanted_, array_, place);  // which says why
    const std::array<double, 3> lattice = {place.x / pitch_m, place.y / pitch_m, place.z / pitch_m};
    double force = 0.0;
    for (unsigned corner = 0; corner < 8; ++corner) {
        std::array<long, 3> number{};
        double weight = 1.0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double low = std::floor(lattice[axis]), part = lattice[axis] - low;
            const bool upper = (corner >> axis & 1U) != 0;
            number[axis] = static_cast<long>(low) + (upper ? 1 : 0);
            weight *= upper ? part : 1.0 - part;
        }
        if (weight > 0.0) force += weight * force_at(number);
    }
    const double full_gf = mean_output(Waveform::square) * force / gram_force_n;
    // At the edge of what the array can do, and where a corner is out of its reach, the place itself decides.
    if (!(needed_gf_ <= 0.98 * full_gf)) return command_at(tables_, wanted_, array_, place);
    return std::sqrt(needed_gf_ / full_gf);
}

PathMagnitude give_magnitude(Path& path, CommandLattice& commands) {
    return multiply(path, [&](Vec3 place) { return commands.at(place); });
}

PathMagnitude give_magnitude(Path& path, const Project& project, const Array& array) {
    const Wanted wanted = wanted_of(project.magnitude.value(), project.am, project.am_law == AmplitudeLaw::radiation);
    return give_magnitude(path, find_tables(), wanted, array);
}

}  // namespace haptogram::perception
