// SPDX-License-Identifier: Apache-2.0
#include "haptogram/array/transducer.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <sstream>

#include "haptogram/array/transducer_keys.hpp"
#include "haptogram/array/vec3.hpp"
#include "haptogram/base/bundle.hpp"
#include "haptogram/base/shipped.hpp"

namespace haptogram {
namespace {

using section::Section;

constexpr std::string_view transducer_folder = "arrays/transducers";

struct Row {
    double angle_deg;
    double amplitude;
};

bool read_number(std::string_view text, double& value) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc() && end == text.data() + text.size() && std::isfinite(value);
}

std::vector<Row> read_rows(const std::filesystem::path& path) {
    std::istringstream lines(read_file(path));
    std::vector<Row> rows;
    std::string line;
    for (std::size_t number = 1; std::getline(lines, line); ++number) {
        if (line.ends_with('\r')) line.pop_back();
        if (line.empty() || line.starts_with('#') || (rows.empty() && line == "angle_deg,amplitude")) continue;
        const auto fail = [&](const std::string& expected) {
            return bad_input(fmt::format("{}:{}", path.string(), number),
                             fmt::format("expected {}, found '{}'", expected, line));
        };
        const std::string_view text = line;
        const std::size_t comma = std::min(text.find(','), text.size());
        Row row{};
        if (comma == text.size() || !read_number(text.substr(0, comma), row.angle_deg) ||
            !read_number(text.substr(comma + 1), row.amplitude) || std::abs(row.amplitude) > 10.0)
            throw fail("angle_deg,amplitude: two numbers, the amplitude over that on the axis and from -10 to 10");
        if (rows.empty() && (row.angle_deg != 0.0 || row.amplitude != 1.0)) throw fail("0,1 first, which is the axis");
        if (!rows.empty() && row.angle_deg <= rows.back().angle_deg)
            throw fail(fmt::format("an angle above {}", rows.back().angle_deg));
        if (row.angle_deg > 90.0) throw fail("angles up to 90");
        rows.push_back(row);
    }
    if (rows.empty() || rows.back().angle_deg != 90.0)
        throw bad_input(path.string(), "the table of angle_deg,amplitude must go from 0 to 90");
    return rows;
}

}  // namespace

std::vector<double> load_directivity(const std::filesystem::path& path) {
    const std::vector<Row> rows = read_rows(path);
    double narrowest = 90.0;
    double widest = 0.0;
    for (std::size_t i = 1; i < rows.size(); ++i) {
        narrowest = std::min(narrowest, rows[i].angle_deg - rows[i - 1].angle_deg);
        widest = std::max(widest, rows[i].angle_deg - rows[i - 1].angle_deg);
    }
    std::vector<double> table;
    if (widest - narrowest < 1e-9) {
        for (const Row& row : rows) table.push_back(row.amplitude);
        return table;
    }
    // Every angle of the file is one of the table's, or its corners would be cut off.
    constexpr double finest_deg = 0.01, rounding = 1e-6;
    std::int64_t common = std::llround(90.0 / finest_deg);
    for (const Row& row : rows) {
        const double hundredths = row.angle_deg / finest_deg;
        if (std::abs(hundredths - std::round(hundredths)) > rounding)
            throw bad_input(path.string(),
                            fmt::format("the angle {} is not a whole number of hundredths of a degree, which angles in "
                                        "uneven steps must be; round it",
                                        row.angle_deg));
        common = std::gcd(common, std::llround(hundredths));
    }
    const auto steps = static_cast<std::size_t>(std::llround(90.0 / finest_deg) / common);
    std::size_t at = 0;
    for (std::size_t i = 0; i <= steps; ++i) {
        const double angle = 90.0 * static_cast<double>(i) / static_cast<double>(steps);
        while (at + 2 < rows.size() && rows[at + 1].angle_deg <= angle + 0.5 * finest_deg) ++at;
        const double share = (angle - rows[at].angle_deg) / (rows[at + 1].angle_deg - rows[at].angle_deg);
        table.push_back(std::lerp(rows[at].amplitude, rows[at + 1].amplitude, share));
    }
    return table;
}

void read_transducer_keys(Transducer& transducer, const Section& section) {
    section::assign(transducer.name, section.text("name"));
    section::assign(transducer.radius_m, section.number("radius_mm", 0.1, 100.0), millimetre);
    section::assign(transducer.source_pa_m, section.number("source_pa_m", 1e-3, 1e3));
    section::assign(transducer.measured, section.text("measured"));
    section::assign(transducer.bandwidth_hz, section.number("bandwidth_hz", 1.0, 1e5));
    const auto directivity = section.text("directivity");
    if (!directivity) return;
    transducer.table.clear();
    if (*directivity == "piston") {
        transducer.pattern = Pattern::piston;
    } else if (*directivity == "point") {
        transducer.pattern = Pattern::point;
    } else if (directivity->ends_with(".csv")) {
        transducer.pattern = Pattern::table;
        transducer.table =
            load_directivity(named_in(std::filesystem::path(section.file()).parent_path(), *directivity));
    } else {
        throw bad_input(section.at("directivity"),
                        fmt::format("directivity must be \"piston\", \"point\" or the name of a .csv file beside this "
                                    "one, found \"{}\"",
                                    *directivity));
    }
}

Transducer load_transducer(const std::filesystem::path& path) {
    const toml::table root = section::parse(path);
    const Section section(path.string(), root);
    section.only({"name", "radius_mm", "source_pa_m", "bandwidth_hz", "directivity"});
    Transducer transducer;
    transducer.name = path.stem().string();
    read_transducer_keys(transducer, section);
    return transducer;
}

Transducer find_transducer(const std::string& name, const std::filesystem::path& folder) {
    if (name.find('/') != std::string::npos || name.ends_with(".toml")) return load_transducer(named_in(folder, name));
    return load_transducer(path_or_shipped(name, transducer_folder, ".toml", "transducer"));
}

}  // namespace haptogram
