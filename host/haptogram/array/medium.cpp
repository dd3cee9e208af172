// SPDX-License-Identifier: Apache-2.0
#include "haptogram/array/medium.hpp"

#include <cmath>
#include <numbers>

namespace haptogram {
namespace {

constexpr double zero_celsius_k = 273.15;
constexpr double standard_temperature_k = 293.15;  // T0 of ISO 9613-1
constexpr double triple_point_k = 273.16;          // T01

/// Molar concentration of water vapour, as a fraction (ISO 9613-1 eq. B.1-B.3).
double vapour_fraction(double temperature_k, double pressure_pa, double humidity_percent) {
    const double exponent = -6.8346 * std::pow(triple_point_k / temperature_k, 1.261) + 4.6151;
    return humidity_percent / 100.0 * std::pow(10.0, exponent) * standard_pressure_pa / pressure_pa;
}

}  // namespace

double speed_of_sound(double temperature_c) { return 331.3 * std::sqrt(1.0 + temperature_c / zero_celsius_k); }

double air_density(double temperature_c, double pressure_pa, double humidity_percent) {
    constexpr double gas_constant = 8.314462618;  // J/(mol·K)
    constexpr double dry_air = 28.9647e-3;        // kg/mol
    constexpr double water = 18.01528e-3;
    const double kelvin = temperature_c + zero_celsius_k;
    const double vapour = vapour_fraction(kelvin, pressure_pa, humidity_percent);
    return pressure_pa * (dry_air * (1.0 - vapour) + water * vapour) / (gas_constant * kelvin);
}

double absorption_np_m(double frequency_hz, double temperature_c, double humidity_percent, double pressure_pa) {
    const double kelvin = temperature_c + zero_celsius_k;
    const double warmth = kelvin / standard_temperature_k;
    const double atmospheres = pressure_pa / standard_pressure_pa;
    const double h = 100.0 * vapour_fraction(kelvin, pressure_pa, humidity_percent);  // percent, as the standard has it
    const double oxygen_hz = atmospheres * (24.0 + 4.04e4 * h * (0.02 + h) / (0.391 + h));
    const double nitrogen_hz =
        atmospheres / std::sqrt(warmth) * (9.0 + 280.0 * h * std::exp(-4.170 * (std::pow(warmth, -1.0 / 3.0) - 1.0)));
    const double f2 = frequency_hz * frequency_hz;
    const double relaxation = 0.01275 * std::exp(-2239.1 / kelvin) / (oxygen_hz + f2 / oxygen_hz) +
                              0.1068 * std::exp(-3352.0 / kelvin) / (nitrogen_hz + f2 / nitrogen_hz);
    const double classical = 1.84e-11 / atmospheres * std::sqrt(warmth);
    return f2 * (classical + std::pow(warmth, -2.5) * relaxation);
}

double np_to_db(double nepers) { return nepers * 20.0 * std::numbers::log10e; }

double db_to_np(double decibels) { return decibels / (20.0 * std::numbers::log10e); }

}  // namespace haptogram
