// SPDX-License-Identifier: Apache-2.0
#include "haptogram/perception/tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "haptogram/base/error.hpp"
#include "haptogram/base/shipped.hpp"
#include "haptogram/base/toml_section.hpp"
#include "haptogram/perception/magnitude.hpp"

namespace haptogram::perception {
namespace {

using section::Section;

template <std::size_t size>
std::array<double, size> coefficients(const Section& section, std::string_view key) {
    const std::vector<double> list =
        section.required(section.numbers(key, size), key, fmt::format("a list of {} numbers", size));
    std::array<double, size> result{};
    std::copy(list.begin(), list.end(), result.begin());
    return result;
}

FrequencyFit read_fit(const std::string& file, const toml::table& table) {
    const Section section(file, table);
    section.only({"hz", "command", "command_r2", "magnitude", "magnitude_r2"});
    FrequencyFit fit;
    fit.frequency_hz = section.required(section.number("hz", 0.1, 1e4), "hz", "a frequency");
    fit.command = coefficients<4>(section, "command");
    fit.magnitude = coefficients<3>(section, "magnitude");
    section::assign(fit.command_r2, section.number("command_r2", 0.0, 1.0));
    section::assign(fit.magnitude_r2, section.number("magnitude_r2", 0.0, 1.0));
    if (!(fit.command.back() >= 0.0 && fit.command.back() < 1.0))
        throw bad_input(section.at("command"),
                        fmt::format("the command of no output must lie in 0…1, found {:g}; it is "
                                    "the last of the four numbers",
                                    fit.command.back()));
    const double full = full_output_gf(fit);
    constexpr int steps = 1000;
    for (int i = 0; i <= steps; ++i) {
        const double g = full * i / steps;
        const auto& c = fit.command;
        if (!((3.0 * c[0] * g + 2.0 * c[1]) * g + c[2] > 0.0))
            throw bad_input(section.at("command"), fmt::format("the polynomial must rise from 0 gf to where it is 1, "
                                                               "and does not at {:.4g} gf",
                                                               g));
        if (!(2.0 * fit.magnitude[0] * g + fit.magnitude[1] > 0.0))
            throw bad_input(section.at("magnitude"),
                            fmt::format("the polynomial must rise up to the full output, {:.4g} "
                                        "gf, and does not at {:.4g} gf",
                                        full, g));
    }
    return fit;
}

Interval read_interval(const Section& section, std::string_view key) {
    const auto ends = coefficients<2>(section, key);
    if (!(ends[0] > 0.0 && ends[0] <= ends[1]))
        throw bad_input(section.at(key), fmt::format("{} must be two positive numbers, the lower first, found {:g} and "
                                                     "{:g}",
                                                     key, ends[0], ends[1]));
    return {ends[0], ends[1]};
}

ThresholdRow read_threshold(const std::string& file, const toml::table& table) {
    const Section section(file, table);
    section.only({"grip_n", "palm", "finger"});
    return {section.required(section.number("grip_n", 1e-3, 1e3), "grip_n", "a force in N"),
            read_interval(section, "palm"), read_interval(section, "finger")};
}

/// Each [[key]] of the file, read by `read`; their `value` must rise.
template <class Row, class Read>
std::vector<Row> read_rows(const std::string& file, const toml::table& root, const std::string& key, Read read,
                           double Row::*value) {
    const toml::array* list = root.get(key) == nullptr ? nullptr : root.get(key)->as_array();
    if (list == nullptr || list->size() < 2 || !list->is_array_of_tables())
        throw bad_input(file, fmt::format("it needs at least two tables [[{}]]", key));
    std::vector<Row> rows;
    for (const toml::node& node : *list) {
        rows.push_back(read(file, *node.as_table()));
        if (rows.size() > 1 && !(rows.back().*value > rows[rows.size() - 2].*value))
            throw bad_input(section::place(file, node),
                            fmt::format("the tables [[{}]] must rise; {:g} follows {:g}", key, rows.back().*value,
                                        rows[rows.size() - 2].*value));
    }
    return rows;
}

}  // namespace

Tables load_tables(const std::filesystem::path& path) {
    const std::string file = path.string();
    const toml::table root = section::parse(path);
    const Section whole(file, root);
    whole.only({"format", "name", "source", "most_sensitive", "frequency", "threshold"});
    const auto format = whole.text("format");
    if (!format || *format != "haptogram-perception-1")
        throw bad_input(whole.at("format"), R"(format must be "haptogram-perception-1")");
    Tables tables;
    tables.file = file;
    tables.name = whole.required(whole.text("name"), "name", "a text in quotes");
    tables.source = whole.required(whole.text("source"), "source", "where the numbers are from, in quotes");
    tables.fits = read_rows<FrequencyFit>(file, root, "frequency", read_fit, &FrequencyFit::frequency_hz);
    tables.thresholds = read_rows<ThresholdRow>(file, root, "threshold", read_threshold, &ThresholdRow::grip_n);
    const Section band(file, root, "most_sensitive");
    band.only({"from_hz", "to_hz"});
    const double lowest = tables.fits.front().frequency_hz, highest = tables.fits.back().frequency_hz;
    tables.most_sensitive_from_hz = band.required(band.number("from_hz", lowest, highest), "from_hz", "a frequency");
    tables.most_sensitive_to_hz =
        band.required(band.number("to_hz", tables.most_sensitive_from_hz, highest), "to_hz", "a frequency");
    return tables;
}

Tables find_tables(const std::string& name) {
    return load_tables(path_or_shipped(name, "perception", ".toml", "perception file"));
}

namespace {

const Interval& interval_of(const ThresholdRow& row, Region region) {
    return region == Region::palm ? row.palm : row.finger;
}

/// Where x lies between a and b on a logarithmic scale: 0 at a, 1 at b.
double log_place(double x, double a, double b) { return std::log(x / a) / std::log(b / a); }

}  // namespace

Region region_of(const std::string& name) {
    if (name == "palm") return Region::palm;
    if (name == "finger") return Region::finger;
    throw bad_argument("region", fmt::format("expected palm or finger, found '{}'", name));
}

Interval threshold_interval(const Tables& tables, Region region, double grip_n) {
    const auto& rows = tables.thresholds;
    if (!(grip_n >= rows.front().grip_n && grip_n <= rows.back().grip_n))
        throw bad_argument(
            "grip", fmt::format("{:g} N lies outside of {:g}…{:g} N, which {} covers; for a bare hand take "
                                "{:g} N, whose threshold is an upper bound",
                                grip_n, rows.front().grip_n, rows.back().grip_n, tables.name, rows.front().grip_n));
    const auto above =
        std::find_if(rows.begin() + 1, rows.end(), [&](const ThresholdRow& row) { return row.grip_n >= grip_n; });
    const ThresholdRow& below = *(above - 1);
    const double place = log_place(grip_n, below.grip_n, above->grip_n);
    const Interval &a = interval_of(below, region), &b = interval_of(*above, region);
    return {std::lerp(a.low_gf, b.low_gf, place), std::lerp(a.high_gf, b.high_gf, place)};
}

double least_felt_gf(const Tables& tables, Region region, double frequency_hz, double grip_n) {
    const Interval interval = threshold_interval(tables, region, grip_n);
    (void)fit_at(tables, frequency_hz);  // refuses what the tables do not cover
    double place = 0.0;
    if (frequency_hz < tables.most_sensitive_from_hz)
        place = log_place(frequency_hz, tables.most_sensitive_from_hz, tables.fits.front().frequency_hz);
    else if (frequency_hz > tables.most_sensitive_to_hz)
        place = log_place(frequency_hz, tables.most_sensitive_to_hz, tables.fits.back().frequency_hz);
    return std::lerp(interval.low_gf, interval.high_gf, place);
}

ThresholdLaw threshold_law(const Tables& tables, Region region) {
    const auto count = static_cast<double>(tables.thresholds.size());
    double x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
    for (const ThresholdRow& row : tables.thresholds) {
        const double log_force = std::log(row.grip_n), centre = interval_of(row, region).centre_gf();
        x += log_force;
        y += centre;
        xx += log_force * log_force;
        xy += log_force * centre;
    }
    ThresholdLaw law;
    law.b_gf = (count * xy - x * y) / (count * xx - x * x);
    law.a_gf = (y - law.b_gf * x) / count;
    for (const ThresholdRow& row : tables.thresholds)
        law.largest_residual_gf =
            std::max(law.largest_residual_gf,
                     std::abs(interval_of(row, region).centre_gf() - law.a_gf - law.b_gf * std::log(row.grip_n)));
    return law;
}

double least_displacement_db(double frequency_hz, double area_factor) {
    constexpr double pacinian_db = -20.0, other_db = 12.5, other_to_hz = 40.0, best_hz = 250.0, rises_hz = 300.0;
    constexpr double per_decade_db = 40.0;  // 12 dB an octave
    if (!(frequency_hz >= lowest_vibration_hz && frequency_hz <= highest_vibration_hz))
        throw bad_argument("frequency", fmt::format("{:g} Hz lies outside of {:g}…{:g} Hz", frequency_hz,
                                                    lowest_vibration_hz, highest_vibration_hz));
    if (!(area_factor > 0.0 && std::isfinite(area_factor)))
        throw bad_argument("area_factor", fmt::format("must be a positive number, found {:g}", area_factor));
    double pacinian = pacinian_db - 10.0 * std::log10(area_factor);
    if (frequency_hz < best_hz) pacinian += per_decade_db * std::log10(best_hz / frequency_hz);
    if (frequency_hz > rises_hz) pacinian += per_decade_db * std::log10(frequency_hz / rises_hz);
    return frequency_hz <= other_to_hz ? std::min(pacinian, other_db) : pacinian;
}

}  // namespace haptogram::perception
