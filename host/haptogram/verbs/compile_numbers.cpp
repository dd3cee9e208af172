// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/compile_numbers.hpp"

#include "haptogram/format/schedule.hpp"

namespace haptogram {

nlohmann::ordered_json numbers_of(const Compiled& compiled) {
    const Manifest& m = compiled.bundle.manifest;
    const TouredPoints& p = compiled.points;
    const Formation& f = m.formation;
    nlohmann::ordered_json json{
        {"array", m.array.name},
        {"points", m.records.size()},
        {"clipped", p.clipped},
        {"duplicates", p.duplicates},
        {"tour_mm", p.tour_m / millimetre},
        {"tour_as_given_mm", p.as_given_m / millimetre},
        {"prescaler", m.timer.prescaler},
        {"cycle_ticks", m.timer.cycle_ticks},
        {"pulse_ticks", m.timer.pulse_ticks},
        {"carrier_hz", m.timer.carrier_hz()},
        {"rate_hz", m.rate_hz},
        {"shortest_dwell_s", compiled.shortest_dwell_s()},
        {"flight_spread_s", f.flight_spread_s},
        {"beta_periods", f.periods},
        {"formation_s", f.formation_s},
        {"formation_with_ring_up_s", f.with_ring_up_s()},
        {"most_points", most_points(m.rate_hz, f.formation_s)},
        {"most_points_with_ring_up", most_points(m.rate_hz, f.with_ring_up_s())},
        {"image_bytes", compiled.bundle.hex.size()},
    };
    if (const auto& pace = compiled.pace) {
        json["speed_m_s"] = pace->speed_m_s;
        json["frequency_hz"] = pace->frequency_hz;
        json["length_mm"] = pace->length_m / millimetre;
        json["jumps_mm"] = pace->jumps_m / millimetre;
        json["spacing_mm"] = pace->spacing_m / millimetre;
    }
    if (const auto& evened = compiled.evened) {
        json["spread"] = evened->after.spread;
        json["spread_before"] = evened->before.spread;
        json["weakest_of_before"] = evened->after.weakest / evened->before.weakest;
    }
    if (!compiled.am_hz.empty()) json["am_hz"] = compiled.am_hz;
    if (const auto& made = compiled.magnitude) {
        json["least_command"] = made->least_command;
        json["most_command"] = made->most_command;
        json["focus_moves"] = made->moves;
    }
    json["pressure_left_least"] = compiled.pressure_left.least;
    json["pressure_left_mean"] = compiled.pressure_left.mean;
    return json;
}

}  // namespace haptogram
