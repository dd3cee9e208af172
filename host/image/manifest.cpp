// SPDX-License-Identifier: Apache-2.0
#include "image/manifest.hpp"

#include <fmt/core.h>

#include <cmath>

#include "base/error.hpp"

namespace haptogram {
namespace {

using nlohmann::ordered_json;

/// Micrometre steps keep the file short and equal everywhere; they are a thousandth of a wavelength's phase step.
ordered_json to_mm(Vec3 v) {
    const auto round = [](double metres) { return std::round(metres * 1e7) / 1e4 + 0.0; };
    return {round(v.x), round(v.y), round(v.z)};
}

Vec3 from_mm_json(const ordered_json& json) {
    if (json.size() != 3) throw ordered_json::other_error::create(599, "a position has three coordinates", &json);
    return from_mm(json.at(0).get<double>(), json.at(1).get<double>(), json.at(2).get<double>());
}

}  // namespace

std::string version() { return HAPTOGRAM_VERSION; }

ordered_json to_json(const Manifest& m) {
    ordered_json json;
    json["format"] = "haptogram-manifest-1";
    json["tool"] = {{"name", "haptogram"}, {"version", version()}};
    json["inputs_sha256"] = m.input_sha256;
    json["image_sha256"] = m.image_sha256;
    json["array"] = {{"name", m.array.name}, {"carrier_hz", m.array.carrier_hz}, {"duty", m.array.duty}};
    for (const Vec3& element : m.array.elements) json["array"]["elements_mm"].push_back(to_mm(element));
    json["medium"] = {{"speed_m_s", m.array.medium.speed_m_s}, {"density_kg_m3", m.array.medium.density_kg_m3}};
    json["transducer"] = {{"name", m.array.transducer.name},
                          {"radius_mm", m.array.transducer.radius_m / millimetre},
                          {"source_pa_m", m.array.transducer.source_pa_m},
                          {"bandwidth_hz", m.array.transducer.bandwidth_hz}};
    json["board"] = {{"name", m.array.board.name},
                     {"clock_hz", m.array.board.clock_hz},
                     {"baud", m.array.board.baud},
                     {"channels", m.array.board.channels},
                     {"records", m.array.board.records},
                     {"sequence_depth", m.array.board.sequence_depth},
                     {"timing_bits", m.array.board.timing_bits},
                     {"pulse_bits", m.array.board.pulse_bits}};
    json["timer"] = {{"tick_s", m.timer.tick_s()},
                     {"prescaler", m.timer.prescaler},
                     {"cycle_ticks", m.timer.cycle_ticks},
                     {"pulse_ticks", m.timer.pulse_ticks}};
    json["rendering"] = {{"rate_hz", m.rate_hz},
                         {"flight_spread_s", m.formation.flight_spread_s},
                         {"beta_periods", m.formation.periods},
                         {"formation_s", m.formation.formation_s},
                         {"ring_up_s", m.formation.ring_up_s}};
    json["records"] = ordered_json::array();
    for (std::size_t i = 0; i < m.foci.size(); ++i)
        json["records"].push_back(
            {{"index", i + 1}, {"focus_mm", to_mm(m.foci[i])}, {"dwell_cycles", m.dwell_cycles[i]}});
    return json;
}

Manifest manifest_from_json(std::string_view text, const std::string& where) {
    try {
        const ordered_json json = ordered_json::parse(text);
        if (json.at("format") != "haptogram-manifest-1")
            throw bad_input(
                where, fmt::format("format is {}, expected haptogram-manifest-1; compile the image with this version",
                                   json.at("format").dump()));
        Manifest m;
        m.input_sha256 = json.at("inputs_sha256").get<std::string>();
        m.image_sha256 = json.at("image_sha256").get<std::string>();
        m.array.name = json.at("array").at("name").get<std::string>();
        m.array.carrier_hz = json.at("array").at("carrier_hz").get<double>();
        m.array.duty = json.at("array").at("duty").get<double>();
        for (const auto& element : json.at("array").at("elements_mm"))
            m.array.elements.push_back(from_mm_json(element));
        m.array.medium = {json.at("medium").at("speed_m_s").get<double>(),
                          json.at("medium").at("density_kg_m3").get<double>()};
        const auto& transducer = json.at("transducer");
        m.array.transducer = {transducer.at("name").get<std::string>(),
                              transducer.at("radius_mm").get<double>() * millimetre,
                              transducer.at("source_pa_m").get<double>(), transducer.at("bandwidth_hz").get<double>()};
        const auto& board = json.at("board");
        m.array.board = {board.at("name").get<std::string>(),          board.at("clock_hz").get<double>(),
                         board.at("baud").get<std::uint32_t>(),        board.at("channels").get<std::uint32_t>(),
                         board.at("records").get<std::uint32_t>(),     board.at("sequence_depth").get<std::uint32_t>(),
                         board.at("timing_bits").get<std::uint32_t>(), board.at("pulse_bits").get<std::uint32_t>()};
        const auto& timer = json.at("timer");
        m.timer = {m.array.board.clock_hz, timer.at("prescaler").get<std::uint32_t>(),
                   timer.at("cycle_ticks").get<std::uint32_t>(), timer.at("pulse_ticks").get<std::uint32_t>()};
        const auto& rendering = json.at("rendering");
        m.rate_hz = rendering.at("rate_hz").get<double>();
        m.formation = {rendering.at("flight_spread_s").get<double>(), rendering.at("beta_periods").get<std::uint32_t>(),
                       rendering.at("formation_s").get<double>(), rendering.at("ring_up_s").get<double>()};
        for (const auto& record : json.at("records")) {
            m.foci.push_back(from_mm_json(record.at("focus_mm")));
            m.dwell_cycles.push_back(record.at("dwell_cycles").get<std::uint32_t>());
        }
        if (m.array.elements.empty() || m.array.elements.size() > m.array.board.channels)
            throw bad_input(where, fmt::format("{} elements for {} channels; compile the image again",
                                               m.array.elements.size(), m.array.board.channels));
        return m;
    } catch (const nlohmann::json::exception& error) {
        throw bad_input(where, fmt::format("not a manifest that this version understands: {}; compile the image again",
                                           error.what()));
    }
}

}  // namespace haptogram
