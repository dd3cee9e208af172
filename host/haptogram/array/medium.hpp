// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace haptogram {

/// The air between array and hand.
struct Medium {
    double speed_m_s = 343.2;
    double density_kg_m3 = 1.204;
    double absorption_np_m = 0.0;  ///< of the pressure amplitude, at the carrier
    friend bool operator==(const Medium&, const Medium&) = default;
};

inline constexpr double standard_pressure_pa = 101'325.0;

/// Speed of sound in dry air at a temperature, metres per second: 331.3·√(1 + T/273.15). Humidity is left out: at 20 °C
/// saturated air is 0.4 % faster.
[[nodiscard]] double speed_of_sound(double temperature_c);

/// Density of air, kg/m³, by the ideal gas law for dry air and, where the humidity is not 0, its vapour at the partial
/// pressure that ISO 9613-1 gives it: (p_d·M_d + p_v·M_v)/(R·T).
/// @param humidity_percent  relative
[[nodiscard]] double air_density(double temperature_c, double pressure_pa = standard_pressure_pa,
                                 double humidity_percent = 0.0);

/// What pure tones lose in air, Np/m of the pressure amplitude (ISO 9613-1:1993, eq. 3-5 and B.1-B.3). The standard
/// vouches for ±10 % from −20 to 50 °C, below 200 kPa, up to 10 Hz/Pa (1 MHz at sea level), and from 0.05 to 5 % of
/// vapour, molar.
/// @param humidity_percent  relative, 0 to 100
[[nodiscard]] double absorption_np_m(double frequency_hz, double temperature_c, double humidity_percent,
                                     double pressure_pa = standard_pressure_pa);

/// Nepers of the amplitude to decibels, 20·lg e = 8.686 each, and back.
[[nodiscard]] double np_to_db(double nepers);
[[nodiscard]] double db_to_np(double decibels);

}  // namespace haptogram
