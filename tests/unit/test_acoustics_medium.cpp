// SPDX-License-Identifier: Apache-2.0
#include <stdlib.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>

#include "../refusal.hpp"
#include "haptogram/acoustics/field.hpp"
#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/process.hpp"
#include "haptogram/format/bundle.hpp"

using namespace haptogram;
namespace fs = std::filesystem;

namespace {

struct Folder : TemporaryFolder {
    [[nodiscard]] fs::path file(const std::string& name, const std::string& text) const {
        write_file(path() / name, text);
        return path() / name;
    }
    [[nodiscard]] Array array(const std::string& more) const {
        return load_array(file("a.toml", "[array]\nelements_mm = [[0, 0]]\n" + more));
    }
};

}  // namespace

TEST_CASE("medium: ISO 9613-1 at 40 kHz", "[medium]") {
    const auto [humidity, expected] = GENERATE(table<double, double>({{30, 1.068}, {50, 1.318}, {70, 1.286}}));
    REQUIRE(np_to_db(absorption_np_m(40e3, 20.0, humidity)) == Approx(expected).margin(0.0005));
}

TEST_CASE("medium: the table of attenuation in ISO 9613-2, dB/km", "[medium]") {
    struct Row {
        double temperature, humidity;
        std::array<double, 8> db_km;  // octaves from 63 Hz to 8 kHz
    };
    const Row row = GENERATE(Row{10, 70, {0.1, 0.4, 1.0, 1.9, 3.7, 9.7, 32.8, 117}},
                             Row{20, 70, {0.1, 0.3, 1.1, 2.8, 5.0, 9.0, 22.9, 76.6}},
                             Row{30, 70, {0.1, 0.3, 1.0, 3.1, 7.4, 12.7, 23.1, 59.3}},
                             Row{15, 20, {0.3, 0.6, 1.2, 2.7, 8.2, 28.2, 88.8, 202}},
                             Row{15, 50, {0.1, 0.5, 1.2, 2.2, 4.2, 10.8, 36.2, 129}},
                             Row{15, 80, {0.1, 0.3, 1.1, 2.4, 4.1, 8.3, 23.7, 82.8}});
    for (std::size_t i = 0; i < row.db_km.size(); ++i) {
        const double frequency = 1000.0 * std::pow(10.0, 0.3 * (static_cast<double>(i) - 4.0));  // exact midbands
        const double found = 1000.0 * np_to_db(absorption_np_m(frequency, row.temperature, row.humidity));
        CAPTURE(row.temperature, row.humidity, frequency);
        // Half the table's last digit; its 4.1 at 15 °C, 80 % and 1 kHz is 4.151 by the formula.
        REQUIRE(found == Approx(row.db_km[i]).margin(row.db_km[i] < 100 ? 0.052 : 0.51));
    }
}

TEST_CASE("medium: decibels and nepers, thinner air absorbs otherwise", "[medium]") {
    REQUIRE(np_to_db(1.0) == Approx(8.685889638));
    REQUIRE(db_to_np(np_to_db(0.115)) == Approx(0.115).epsilon(1e-14));
    REQUIRE(np_to_db(0.115) == Approx(1.0).epsilon(2e-3));  // Hoshi: 0.115 Np/m is 100 dB in 100 m
    // Classical absorption alone goes with f²/p: far above the relaxations of dry, cold air.
    const double low = absorption_np_m(1e6, -50.0, 0.0, 50e3);
    const double high = absorption_np_m(1e6, -50.0, 0.0, 100e3);
    REQUIRE(low / high == Approx(2.0).epsilon(0.01));
}

TEST_CASE("medium: density of the ideal gas", "[medium]") {
    REQUIRE(air_density(20.0) == Approx(1.2041).margin(5e-5));  // the standard atmosphere's
    REQUIRE(air_density(15.0) == Approx(1.2250).margin(5e-5));
    REQUIRE(air_density(0.0) == Approx(1.2922).margin(2e-4));
    REQUIRE(air_density(20.0, 50e3) == Approx(1.2041 * 50 / 101.325).epsilon(1e-4));
    REQUIRE(air_density(20.0, standard_pressure_pa, 50.0) == Approx(1.1988).margin(2e-4));  // vapour is lighter
}

TEST_CASE("medium: what array files say of it", "[medium][array]") {
    const Folder folder;
    Medium m = folder.array("").medium;
    REQUIRE(m.speed_m_s == 343.2);
    REQUIRE(m.density_kg_m3 == 1.204);
    REQUIRE(m.absorption_np_m == 0.0);
    m = folder.array("[medium]\ntemperature_c = 30\n").medium;
    REQUIRE(m.density_kg_m3 == Approx(1.1644).margin(1e-4));
    REQUIRE(m.absorption_np_m == 0.0);
    m = folder.array("[medium]\ntemperature_c = 20\nhumidity_percent = 50\n").medium;
    REQUIRE(np_to_db(m.absorption_np_m) == Approx(1.318).margin(0.0005));
    REQUIRE(m.density_kg_m3 == Approx(1.1988).margin(2e-4));
    m = folder.array("carrier_hz = 25000\n[medium]\ntemperature_c = 20\nhumidity_percent = 50\npressure_kpa = 90\n")
            .medium;
    REQUIRE(m.absorption_np_m == absorption_np_m(25e3, 20.0, 50.0, 90e3));
    m = folder.array("[medium]\nspeed_m_s = 340\nabsorption_db_m = 1.0\n").medium;
    REQUIRE(m.absorption_np_m == Approx(0.11513).epsilon(1e-4));
    m = folder.array("[medium]\ntemperature_c = 30\ndensity_kg_m3 = 1.2\n").medium;
    REQUIRE(m.density_kg_m3 == 1.2);
    const std::string text =
        GENERATE(as<std::string>{}, "speed_m_s = 340\nhumidity_percent = 50\n", "pressure_kpa = 90\n",
                 "temperature_c = 20\nhumidity_percent = 50\nabsorption_db_m = 1\n",
                 "temperature_c = 20\nhumidity_percent = 101\n", "absorption_db_m = -1\n");
    REQUIRE_REFUSED(folder.array("[medium]\n" + text));
}

TEST_CASE("transducers: the shipped ones, and the reference's table of the T4010A1", "[transducer]") {
    const Transducer hoshi = find_transducer("T4010A1");
    REQUIRE(hoshi.pattern == Pattern::table);
    REQUIRE(hoshi.table == std::vector<double>{1, 1, 1, 0.891, 0.708, 0.501, 0.355, 0.251, 0.200, 0.178});
    REQUIRE(hoshi.source_pa_m == Approx(24.0 * std::numbers::sqrt2 * 0.3).epsilon(5e-4));
    REQUIRE(directivity(hoshi, 1.0, std::cos(50.0 * std::numbers::pi / 180)) == Approx(0.5).margin(0.002));  // ±50°
    REQUIRE(directivity(hoshi, 1.0, std::cos(35.0 * std::numbers::pi / 180)) == Approx((0.891 + 0.708) / 2));
    REQUIRE(find_transducer("MA40S4S").pattern == Pattern::piston);
    REQUIRE(find_transducer("MA40S4S").radius_m == Approx(4.5e-3));
    REQUIRE(find_transducer("point").pattern == Pattern::point);
    REQUIRE_REFUSED(find_transducer("nonesuch"));
    const Array array = find_array("hoshi-18x18");
    REQUIRE(array.transducer.name == "T4010A1");
    REQUIRE(array.transducer.table.size() == 10);
    REQUIRE(array.transducer.source_pa_m == 10.18);
}

TEST_CASE("transducers: files by name, by path, with keys of the array's own", "[transducer][array]") {
    const Folder folder;
    fs::create_directory(folder.path() / "kinds");
    (void)folder.file("kinds/own.toml", "radius_mm = 6.0\nsource_pa_m = 3.0\ndirectivity = \"own.csv\"\n");
    (void)folder.file("kinds/own.csv", "angle_deg,amplitude\n0,1\n30,0.5\n90,0.2\n");
    Transducer t = folder.array("[transducer]\nfile = \"kinds/own.toml\"\nsource_pa_m = 4.5\n").transducer;
    REQUIRE(t.name == "own");
    REQUIRE(t.radius_m == 6e-3);
    REQUIRE(t.source_pa_m == 4.5);
    REQUIRE(t.table.size() == 4);  // 30° and 90° lie on even steps of 30°
    REQUIRE(t.table[2] == Approx(0.35));
    t = folder.array("[transducer]\nfile = \"T4010A1\"\ndirectivity = \"piston\"\n").transducer;
    REQUIRE(t.pattern == Pattern::piston);
    REQUIRE(t.table.empty());
    t = folder.array("[transducer]\ndirectivity = \"kinds/own.csv\"\n").transducer;
    REQUIRE(t.pattern == Pattern::table);
    REQUIRE(t.name == "MA40S4S");
    const std::string text =
        GENERATE(as<std::string>{}, "file = \"none\"\n", "file = \"none.toml\"\n", "directivity = \"cardioid\"\n",
                 "directivity = \"none.csv\"\n", "directivity = 3\n", "colour = 3\n");
    REQUIRE_REFUSED(folder.array("[transducer]\n" + text));
    REQUIRE_REFUSED(load_transducer(folder.file("b.toml", "\nradius_mm = -1\n")));
    REQUIRE_REFUSED(load_transducer(folder.file("b.toml", "file = \"point\"\n")));
}

TEST_CASE("transducers: uneven angles keep every corner, and a field the error that it states", "[transducer][array]") {
    CAPTURE(Catch::rngSeed());
    std::mt19937_64 g(Catch::rngSeed());
    const Folder folder;
    const std::vector<std::pair<double, double>> rows{{0, 1},       {7, 0.98},  {15.5, 0.8},
                                                      {33.25, 0.3}, {47, 0.45}, {90, 0.1}};
    std::string text;
    for (const auto& [angle, amplitude] : rows) text += std::to_string(angle) + "," + std::to_string(amplitude) + "\n";
    const auto line = [&](double degrees) {  // the file's own straight lines
        std::size_t i = 1;
        while (rows[i].first < degrees) ++i;
        const double part = (degrees - rows[i - 1].first) / (rows[i].first - rows[i - 1].first);
        return (1.0 - part) * rows[i - 1].second + part * rows[i].second;
    };
    Array array = find_array("tile-10x10");
    array.transducer.pattern = Pattern::table;
    array.transducer.table = load_directivity(folder.file("uneven.csv", text));
    std::uniform_real_distribution<double> any(0.0, 90.0);
    for (int i = 0; i < 1000; ++i) {
        const double degrees = any(g);
        REQUIRE(directivity(array.transducer, 0.0, std::cos(degrees * std::numbers::pi / 180.0)) ==
                Approx(line(degrees)).margin(1e-9));
    }
    // A focus' field beside the sum of the waves, with the file's lines.
    const Vec3 focus = from_mm(0, 0, 60);
    const auto drives = ideal_drives(array, focus);
    const double k = 2.0 * std::numbers::pi / array.wavelength_m();
    const auto sum = [&](Vec3 point) {
        std::complex<double> p = 0.0;
        for (std::size_t m = 0; m < drives.size(); ++m) {
            const Vec3 ray = point - array.elements[m].position;
            const double range = norm(ray), degrees = std::acos(ray.z / range) * 180.0 / std::numbers::pi;
            p += drives[m] *
                 std::polar(line(degrees) / range * std::exp(-array.medium.absorption_np_m * range), -k * range);
        }
        return p;
    };
    Grid grid;
    for (int i = -60; i <= 60; ++i) grid.x.push_back(i * 1e-3), grid.y.push_back(i * 1e-3);
    grid.z = {0.06};
    const PressureField field = pressure_field(array, drives, grid, FieldOptions{});
    double worst = 0.0;
    for (std::size_t i = 0; i < grid.size(); i += 7)
        worst = std::max(worst, std::abs(std::complex<double>(field.values[i]) - sum(grid.point(i))));
    CAPTURE(worst / std::abs(sum(focus)), field.error);
    REQUIRE(worst <= field.error * std::abs(sum(focus)));
    REQUIRE_REFUSED(load_directivity(folder.file("fine.csv", "0,1\n7.1234,0.5\n90,0\n")));
}

TEST_CASE("transducers: every damage to a pattern's table is named with its line", "[transducer]") {
    const Folder folder;
    const std::string text =
        GENERATE(as<std::string>{}, "", "0,1\n", "0,1\n80,0.5\n", "0,0.9\n90,0.5\n", "10,1\n90,0.5\n",
                 "0,1\n50\n90,0.5\n", "0,1\n50,x\n90,0.5\n", "0,1\n50,nan\n90,0.5\n", "0,1\n50,0.5\n50,0.4\n90,0.5\n",
                 "# a\nangle_deg,amplitude\n\n0,1\n91,0.5\n");
    REQUIRE_REFUSED(load_directivity(folder.file("t.csv", text)));
    REQUIRE(load_directivity(folder.file("t.csv", "0,1\r\n45,0.5\r\n90,0\r\n")) == std::vector<double>{1, 0.5, 0});
    // Uneven: interpolated at even steps that keep to the straight lines between the rows.
    const auto even = load_directivity(folder.file("t.csv", "0,1\n1,0.98\n31,0.5\n90,0\n"));
    REQUIRE(even.size() == 91);
    REQUIRE(even[0] == 1.0);
    REQUIRE(even[1] == Approx(0.98));
    REQUIRE(even[16] == Approx(0.74));
    REQUIRE(even[31] == Approx(0.5));
    REQUIRE(even[90] == Approx(0.0).margin(1e-15));
    REQUIRE(load_directivity(folder.file("t.csv", "0,1\n0.01,1\n90,0\n")).size() == 9001);
}

TEST_CASE("manifest: pattern and absorption are kept, and older manifests without them are read", "[manifest]") {
    Manifest m;
    m.array = find_array(GENERATE("hoshi-18x18", "tile-10x10"));
    m.array.medium.absorption_np_m = 0.15;
    m.timer = {50e6, 5, 250, 125};
    m.core = find_configuration("hoshi-324");
    m.records = {{{{from_mm(1, 2, 130)}}, 1.0, 20}};
    m.rate_hz = 10;
    const Manifest back = manifest_from_json(to_json(m).dump(), "m");
    REQUIRE(back.array.transducer.pattern == m.array.transducer.pattern);
    REQUIRE(back.array.transducer.table == m.array.transducer.table);
    REQUIRE(back.array.medium.absorption_np_m == 0.15);
    auto json = to_json(m);
    json["transducer"]["directivity"] = "point";
    REQUIRE(manifest_from_json(json.dump(), "m").array.transducer.pattern == Pattern::point);
    json["transducer"].erase("directivity");
    json["medium"].erase("absorption_np_m");
    const Manifest old = manifest_from_json(json.dump(), "m");
    REQUIRE(old.array.transducer.pattern == Pattern::piston);
    REQUIRE(old.array.medium.absorption_np_m == 0.0);
    for (const auto& wrong : {nlohmann::ordered_json("cardioid"), nlohmann::ordered_json({1.0}),
                              nlohmann::ordered_json({1.0, "x"}), nlohmann::ordered_json(3)}) {
        json["transducer"]["directivity"] = wrong;
        REQUIRE_REFUSED(manifest_from_json(json.dump(), "m"));
    }
    json["transducer"]["directivity"] = "piston";
    json["medium"]["absorption_np_m"] = -0.1;
    REQUIRE_REFUSED(manifest_from_json(json.dump(), "m"));
}
