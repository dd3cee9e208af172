// SPDX-License-Identifier: Apache-2.0
#include "haptogram/image/manifest.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "haptogram/base/error.hpp"

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

Error bad_member(const std::string& where, const char* key, const char* expected, const ordered_json& found) {
    return bad_input(where,
                     fmt::format("{} must be {}, found {}; compile the image again", key, expected, found.dump()));
}

double positive(const ordered_json& json, const char* key, const std::string& where) {
    const ordered_json& member = json.at(key);
    if (!member.is_number() || !(member.get<double>() > 0.0)) throw bad_member(where, key, "a positive number", member);
    return member.get<double>();
}

double not_negative(const ordered_json& json, const char* key, const std::string& where) {
    const ordered_json& member = json.at(key);
    if (!member.is_number() || !(member.get<double>() >= 0.0))
        throw bad_member(where, key, "a number, not negative", member);
    return member.get<double>();
}

std::uint32_t count(const ordered_json& json, const char* key, std::uint32_t low, const std::string& where) {
    const ordered_json& member = json.at(key);
    if (!member.is_number_unsigned() || member.get<std::uint64_t>() > 0xffffffffU || member.get<std::uint32_t>() < low)
        throw bad_member(where, key, low > 0 ? "a positive whole number" : "a whole number", member);
    return member.get<std::uint32_t>();
}

/// "piston", "point", or the amplitudes at even steps from 0 to 90°.
ordered_json directivity_to_json(const Transducer& transducer) {
    if (transducer.pattern == Pattern::table) return transducer.table;
    return transducer.pattern == Pattern::point ? "point" : "piston";
}

/// Manifests of before transducer files have none: a piston.
void read_directivity(Transducer& transducer, const ordered_json& json, const std::string& where) {
    const auto member = json.find("directivity");
    if (member == json.end() || *member == "piston") {
        transducer.pattern = Pattern::piston;
    } else if (*member == "point") {
        transducer.pattern = Pattern::point;
    } else {
        if (!member->is_array() || member->size() < 2 ||
            !std::all_of(member->begin(), member->end(), [](const ordered_json& value) { return value.is_number(); }))
            throw bad_member(where, "directivity", "\"piston\", \"point\" or a list of at least two amplitudes",
                             *member);
        transducer.pattern = Pattern::table;
        transducer.table = member->get<std::vector<double>>();
    }
}

/// The JSON library quotes what it could not read, which may be any bytes.
std::string printable(std::string text) {
    std::replace_if(
        text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c > 0x7e; }, '?');
    return text;
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
    json["medium"] = {{"speed_m_s", m.array.medium.speed_m_s},
                      {"density_kg_m3", m.array.medium.density_kg_m3},
                      {"absorption_np_m", m.array.medium.absorption_np_m}};
    json["transducer"] = {{"name", m.array.transducer.name},
                          {"radius_mm", m.array.transducer.radius_m / millimetre},
                          {"source_pa_m", m.array.transducer.source_pa_m},
                          {"bandwidth_hz", m.array.transducer.bandwidth_hz},
                          {"directivity", directivity_to_json(m.array.transducer)}};
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
        m.array.carrier_hz = positive(json.at("array"), "carrier_hz", where);
        m.array.duty = positive(json.at("array"), "duty", where);
        for (const auto& element : json.at("array").at("elements_mm"))
            m.array.elements.push_back(from_mm_json(element));
        const auto& medium = json.at("medium");
        m.array.medium.speed_m_s = positive(medium, "speed_m_s", where);
        m.array.medium.density_kg_m3 = positive(medium, "density_kg_m3", where);
        if (medium.contains("absorption_np_m"))  // older manifests have none
            m.array.medium.absorption_np_m = not_negative(medium, "absorption_np_m", where);
        const auto& transducer = json.at("transducer");
        m.array.transducer.name = transducer.at("name").get<std::string>();
        m.array.transducer.radius_m = not_negative(transducer, "radius_mm", where) * millimetre;
        m.array.transducer.source_pa_m = positive(transducer, "source_pa_m", where);
        m.array.transducer.bandwidth_hz = positive(transducer, "bandwidth_hz", where);
        read_directivity(m.array.transducer, transducer, where);
        const auto& board = json.at("board");
        m.array.board = {board.at("name").get<std::string>(),   positive(board, "clock_hz", where),
                         count(board, "baud", 1, where),        count(board, "channels", 1, where),
                         count(board, "records", 1, where),     count(board, "sequence_depth", 2, where),
                         count(board, "timing_bits", 1, where), count(board, "pulse_bits", 1, where)};
        const auto& timer = json.at("timer");
        m.timer = {m.array.board.clock_hz, count(timer, "prescaler", 1, where), count(timer, "cycle_ticks", 2, where),
                   count(timer, "pulse_ticks", 1, where)};
        const auto& rendering = json.at("rendering");
        m.rate_hz = positive(rendering, "rate_hz", where);
        m.formation = {not_negative(rendering, "flight_spread_s", where), count(rendering, "beta_periods", 0, where),
                       not_negative(rendering, "formation_s", where), not_negative(rendering, "ring_up_s", where)};
        for (const auto& record : json.at("records")) {
            m.foci.push_back(from_mm_json(record.at("focus_mm")));
            m.dwell_cycles.push_back(count(record, "dwell_cycles", 0, where));
        }
        if (m.array.elements.empty() || m.array.elements.size() > m.array.board.channels)
            throw bad_input(where, fmt::format("{} elements for {} channels; compile the image again",
                                               m.array.elements.size(), m.array.board.channels));
        return m;
    } catch (const nlohmann::json::exception& error) {
        throw bad_input(where, fmt::format("not a manifest that this version understands: {}; compile the image again",
                                           printable(error.what())));
    }
}

}  // namespace haptogram
