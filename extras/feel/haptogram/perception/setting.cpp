// SPDX-License-Identifier: Apache-2.0
#include "haptogram/perception/setting.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "haptogram/acoustics/skin_force.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/perception/magnitude.hpp"

namespace haptogram::perception {
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

}  // namespace haptogram::perception
