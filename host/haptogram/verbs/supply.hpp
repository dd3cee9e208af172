// SPDX-License-Identifier: Apache-2.0
// What an array takes from its supply.
#pragma once
#include <cstddef>

namespace haptogram {

/// An element at its resonance: the resistance of its motion beside its capacitance, behind the driver's resistance.
struct SupplyOptions {
    std::size_t channels = 100;
    double volts = 12.0;  ///< of the drivers, whose outputs go from 0 to there and back
    double duty = 0.5;    ///< of a carrier period for which an output is high
    double carrier_hz = 40e3;
    double resistance_ohm = 700;  ///< typical of elements of 10 to 16 mm
    double capacitance_f = 2.7e-9;
    double series_ohm = 29.0;  ///< a driver of 7 Ω and 22 Ω
    double driver_a = 4.5e-3;  ///< of a dual driver whose inputs are high, at most (data sheet of the TC4427)
};

struct Supply {
    double motion_w =
        0.0;  ///< of a channel: (2 V sin(π duty) / π)² / (2 (R + series)), the carrier's part of the pulses
    double charge_w = 0.0;   ///< of a channel: C V² f, whatever the duty
    double all_w = 0.0;      ///< of all channels
    double current_a = 0.0;  ///< from the supply, for the elements
    double drivers_a = 0.0;  ///< from the supply, for the drivers themselves, with all inputs high
};

/// @throws Error{bad_argument} naming the setting that is out of range: the duty in (0, 0.5], the others above 0
[[nodiscard]] Supply supply_of(const SupplyOptions& options);

}  // namespace haptogram
