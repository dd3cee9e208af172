// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/level.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/perception/skin_force.hpp"

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

MeasuredLevel measured_level(const Array& array, Vec3 focus, double force_n) {
    if (!(force_n > 0.0 && std::isfinite(force_n)))
        throw bad_argument("measured-mn", fmt::format("must be a positive force, found {:g}", force_n * 1e3));
    if (const std::string why = array.unreachable(focus); !why.empty()) throw bad_argument("focus", why);
    const double computed_n = perception::steady_force(array, ideal_drives(array, focus), focus);
    // Forces go with the square of the source strength.
    return {array.transducer.source_pa_m * std::sqrt(force_n / computed_n),
            fmt::format("{:g} mN on a disc of {:g} mm at ({:g},{:g},{:g}) mm, full steady drive", force_n * 1e3,
                        perception::default_contact_m / millimetre, focus.x / millimetre, focus.y / millimetre,
                        focus.z / millimetre)};
}

std::string calibrated_keys(const Array& array, Vec3 focus, double force_n) {
    const MeasuredLevel level = measured_level(array, focus, force_n);
    return fmt::format("source_pa_m = {:.4g}\nmeasured = \"{}\"\n", level.source_pa_m, level.measured);
}

}  // namespace haptogram
