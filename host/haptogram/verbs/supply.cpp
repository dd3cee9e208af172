// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/supply.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <utility>

#include "haptogram/base/error.hpp"

namespace haptogram {

Supply supply_of(const SupplyOptions& o) {
    using std::numbers::pi;
    const std::pair<const char*, double> positive[] = {{"volts", o.volts},
                                                       {"carrier_hz", o.carrier_hz},
                                                       {"resistance_ohm", o.resistance_ohm},
                                                       {"capacitance_f", o.capacitance_f}};
    for (const auto& [name, value] : positive)
        if (!(value > 0.0 && std::isfinite(value)))
            throw bad_argument(name, fmt::format("expected a number above 0, found {:g}", value));
    if (!(o.duty > 0.0 && o.duty <= 0.5))
        throw bad_argument("duty", fmt::format("expected more than 0 and at most 0.5, found {:g}", o.duty));
    for (const auto& [name, value] : {std::pair{"series_ohm", o.series_ohm}, std::pair{"driver_a", o.driver_a}})
        if (!(value >= 0.0 && std::isfinite(value)))
            throw bad_argument(name, fmt::format("expected 0 or more, found {:g}", value));
    const double amplitude = 2.0 * o.volts / pi * std::sin(pi * o.duty);
    Supply s;
    s.motion_w = amplitude * amplitude / (2.0 * (o.resistance_ohm + o.series_ohm));
    s.charge_w = o.capacitance_f * o.volts * o.volts * o.carrier_hz;
    s.all_w = static_cast<double>(o.channels) * (s.motion_w + s.charge_w);
    s.current_a = s.all_w / o.volts;
    s.drivers_a = static_cast<double>((o.channels + 1) / 2) * o.driver_a;
    return s;
}

}  // namespace haptogram
