// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/level.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <utility>
#include <vector>

#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/acoustics/skin_force.hpp"
#include "haptogram/base/error.hpp"

namespace haptogram {

std::string level_text(const Transducer& transducer) {
    if (!transducer.measured.empty())
        return fmt::format("calibrated level: {:g} Pa·m, {}", transducer.source_pa_m, transducer.measured);
    return fmt::format(
        "nominal level: {:g} Pa·m of {} was not measured on this array; measured devices made {:g} to {:g} "
        "times less force (Hoshi 2010: 16 of 134 mN; Multimodal: 0.540 of 5.15 gf)",
        transducer.source_pa_m, transducer.name, nominal_excess_least, nominal_excess_most);
}

nlohmann::ordered_json level_json(const Transducer& transducer) {
    return {{"calibrated", !transducer.measured.empty()},
            {"source_pa_m", transducer.source_pa_m},
            {"note", level_text(transducer)}};
}

double microphone_pa(double rms_mv, double mv_a_pa) {
    for (const auto& [name, value] : {std::pair("measured-mv", rms_mv), std::pair("sensitivity", mv_a_pa)})
        if (!(value > 0.0 && std::isfinite(value)))
            throw bad_argument(name, fmt::format("must be positive, found {:g}", value));
    return rms_mv / mv_a_pa;
}

MeasuredLevel measured_level(const Array& array, Vec3 focus, const LevelReading& reading) {
    if (const std::string why = array.unreachable(focus); !why.empty()) throw bad_argument("focus", why);
    const std::string where = fmt::format("at ({:g},{:g},{:g}) mm, full steady drive", focus.x / millimetre,
                                          focus.y / millimetre, focus.z / millimetre);
    const std::vector<std::complex<double>> drives = ideal_drives(array, focus);
    if (reading.rms_pa) {
        if (!(*reading.rms_pa > 0.0 && std::isfinite(*reading.rms_pa)))
            throw bad_argument("measured-mv",
                               fmt::format("must be a positive pressure, found {:g} Pa", *reading.rms_pa));
        const double computed_pa = std::abs(pressure(array, drives, focus)) / std::numbers::sqrt2;
        return {array.transducer.source_pa_m * *reading.rms_pa / computed_pa,
                fmt::format("{:g} Pa rms by a microphone {}", *reading.rms_pa, where)};
    }
    if (!(reading.force_n && *reading.force_n > 0.0 && std::isfinite(*reading.force_n)))
        throw bad_argument("measured-mn",
                           fmt::format("must be a positive force, found {:g}", reading.force_n.value_or(0.0) * 1e3));
    // Forces go with the square of the source strength.
    const double computed_n = steady_force(array, drives, focus);
    return {
        array.transducer.source_pa_m * std::sqrt(*reading.force_n / computed_n),
        fmt::format("{:g} mN on a disc of {:g} mm {}", *reading.force_n * 1e3, default_contact_m / millimetre, where)};
}

std::string calibrated_keys(const Array& array, Vec3 focus, const LevelReading& reading) {
    const MeasuredLevel level = measured_level(array, focus, reading);
    return fmt::format("source_pa_m = {:.4g}\nmeasured = \"{}\"\n", level.source_pa_m, level.measured);
}

}  // namespace haptogram
