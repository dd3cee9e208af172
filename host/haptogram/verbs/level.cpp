// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/level.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <utility>
#include <vector>

#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/acoustics/skin_force.hpp"
#include "haptogram/base/error.hpp"

namespace haptogram {

namespace {

/// A transducer of which a data sheet's strength is known.
struct DataSheet {
    const char* name;
    double nominal_pa_m;  ///< in the shipped files
    double sheet_pa_m;    ///< at 10 V rms
    double supply_v;      ///< that the arrays of the papers have
    const char* source;
};
constexpr double sheet_v_rms = 10.0;
/// 20 Pa rms at 0.3 m are 120 dB; of the T4010A1, 24 Pa (Hoshi 2.2).
constexpr std::array<DataSheet, 2> data_sheets = {
    {{"MA40S4S", 4.0, 8.49, 20.0, "120 dB at 0.3 m"}, {"T4010A1", 10.18, 10.18, 24.0, "121.5 dB at 0.3 m"}}};

const DataSheet* data_sheet_of(const Transducer& transducer) {
    for (const DataSheet& sheet : data_sheets)
        if (transducer.name == sheet.name && transducer.source_pa_m == sheet.nominal_pa_m) return &sheet;
    return nullptr;
}

}  // namespace

ExpectedLevel expected_level(const Transducer& transducer, std::optional<double> supply_v) {
    const DataSheet* sheet = transducer.measured.empty() ? data_sheet_of(transducer) : nullptr;
    if (supply_v && !(*supply_v > 0.0 && std::isfinite(*supply_v)))
        throw bad_argument("volts", fmt::format("must be positive, found {:g}", *supply_v));
    if (supply_v && sheet == nullptr)
        throw bad_argument("volts", fmt::format("the strength of {} is {:g} Pa·m whatever its supply is; leave it out",
                                                transducer.name, transducer.source_pa_m));
    if (!transducer.measured.empty())
        return {transducer.source_pa_m, 0.0, 0.0,
                fmt::format("level: {:g} Pa·m an element, {}", transducer.source_pa_m, transducer.measured)};
    if (sheet == nullptr)
        return {transducer.source_pa_m, -40.0 * std::log10(share_of_data_sheet), 0.0,
                fmt::format("level: {:g} Pa·m an element, as the array file says; of a data sheet's strength a whole "
                            "array makes about {:g}",
                            transducer.source_pa_m, share_of_data_sheet)};
    // A square wave's part at the carrier, over the data sheet's voltage.
    const double volts = supply_v.value_or(sheet->supply_v);
    const double drive = volts * std::numbers::sqrt2 / std::numbers::pi / sheet_v_rms;
    const double source = sheet->sheet_pa_m * share_of_data_sheet * drive;
    return {
        source, share_known_to_db, share_known_to_db,
        fmt::format("level: {:.3g} Pa·m an element, expected of {} at a supply of {:g} V; whole arrays made {:g} of "
                    "the data sheet's {:.3g} Pa·m ({}, 10 V rms)",
                    source, sheet->name, volts, share_of_data_sheet, sheet->sheet_pa_m, sheet->source)};
}

std::string level_text(const Transducer& transducer) {
    if (!transducer.measured.empty())
        return fmt::format("calibrated level: {:g} Pa·m, {}", transducer.source_pa_m, transducer.measured);
    const ExpectedLevel expected = expected_level(transducer);
    const double excess = transducer.source_pa_m / expected.source_pa_m;
    if (expected.source_pa_m == transducer.source_pa_m)
        return fmt::format(
            "nominal level: {:g} Pa·m of {} was not measured on this array; of a data sheet's level a "
            "whole array makes about {:g}, which is 10 times less force",
            transducer.source_pa_m, transducer.name, share_of_data_sheet);
    return fmt::format(
        "nominal level: {:g} Pa·m of {} was not measured on this array; {:.3g} Pa·m are expected, which makes {:.1f} "
        "times less force (Hoshi 2010: 16 of 134 mN; Multimodal: 0.540 of 5.15 gf)",
        transducer.source_pa_m, transducer.name, expected.source_pa_m, excess * excess);
}

nlohmann::ordered_json level_json(const Transducer& transducer) {
    return {{"calibrated", !transducer.measured.empty()},
            {"source_pa_m", transducer.source_pa_m},
            {"expected_pa_m", expected_level(transducer).source_pa_m},
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
