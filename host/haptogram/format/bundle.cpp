// SPDX-License-Identifier: Apache-2.0
#include "haptogram/format/bundle.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <numeric>
#include <utility>
#include <vector>

#include "haptogram/base/depth.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/text.hpp"

namespace haptogram {

const char* name_of(Method method) {
    for (const MethodName& one : method_names)
        if (one.method == method) return one.name;
    return "";
}

Method method_of(const std::string& name, const std::string& setting) {
    std::vector<std::string> names;
    for (const MethodName& one : method_names) {
        if (name == one.name) return one.method;
        names.emplace_back(one.name);
    }
    throw bad_argument(setting, fmt::format("'{}' is no solver; expected {}", name, fmt::join(names, ", ")));
}

namespace {

using nlohmann::ordered_json;

/// The parameters of the core on which an image depends. A manifest does not hold the others.
constexpr std::pair<const char*, std::uint32_t interface::CoreParameters::*> core_members[] = {
    {"clock_hz", &interface::CoreParameters::clock_hz},
    {"baud", &interface::CoreParameters::baud},
    {"channels", &interface::CoreParameters::channels},
    {"records", &interface::CoreParameters::records},
    {"sequence_depth", &interface::CoreParameters::sequence_depth},
    {"timing_bits", &interface::CoreParameters::timing_bits},
    {"pulse_bits", &interface::CoreParameters::pulse_bits}};

/// Those of which only some boards have any. They are left out when they are 0.
constexpr std::pair<const char*, std::uint32_t interface::CoreParameters::*> optional_core_members[] = {
    {"width_bits", &interface::CoreParameters::width_bits},
    {"modulation_depth", &interface::CoreParameters::modulation_depth},
    {"slew", &interface::CoreParameters::slew},
    {"foci", &interface::CoreParameters::foci}};

/// Where pulses have widths of their own, they depend on this as well.
constexpr const char* min_pulse_clocks = "min_pulse_clocks";

/// Rounded to a ten-thousandth of a millimetre, so that the file is short and the same on every machine. That is
/// 1/86,000 of a wavelength, far less than a timer can resolve.
ordered_json to_mm(Vec3 v) {
    const auto round = [](double metres) { return std::round(metres * 1e7) / 1e4 + 0.0; };
    return {round(v.x), round(v.y), round(v.z)};
}

Vec3 from_mm_json(const ordered_json& json) {
    if (json.size() != 3) throw ordered_json::other_error::create(599, "a position has three coordinates", &json);
    return from_mm(json.at(0).get<double>(), json.at(1).get<double>(), json.at(2).get<double>());
}

/// Position, and where the element does not face along z, its normal.
ordered_json element_to_json(const Element& element) {
    ordered_json json = to_mm(element.position);
    if (element.normal != Element{}.normal)
        for (const double part : {element.normal.x, element.normal.y, element.normal.z}) json.push_back(part);
    return json;
}

Element element_from_json(const ordered_json& json) {
    if (json.size() != 6) return {from_mm_json(json)};
    const Vec3 normal{json.at(3).get<double>(), json.at(4).get<double>(), json.at(5).get<double>()};
    if (!(std::abs(norm(normal) - 1.0) < 1e-6))
        throw ordered_json::other_error::create(599, "an element's normal has a length of 1", &json);
    return {from_mm(json.at(0).get<double>(), json.at(1).get<double>(), json.at(2).get<double>()), normal};
}

Error bad_member(const std::string& where, const char* key, const char* expected, const ordered_json& found) {
    return bad_input(where,
                     fmt::format("{} must be {}, found {}; compile the image again", key, expected, found.dump()));
}

void read_responses(Array& array, const ordered_json& json, const std::string& where) {
    if (json.size() != array.elements.size())
        throw bad_member(where, "array.responses", "a list of [real, imaginary, weight], one an element", json);
    for (std::size_t m = 0; m < array.elements.size(); ++m) {
        const ordered_json& one = json.at(m);
        Element& element = array.elements[m];
        element.response = {one.at(0).get<double>(), one.at(1).get<double>()};
        if (one.size() > 2) element.weight = one.at(2).get<double>();
        if (one.size() > 3 || !(element.weight > 0.0 && element.weight <= 1.0))
            throw bad_member(where, "array.responses",
                             "a list of [real, imaginary, weight], one an element, with weights above 0 and up to 1",
                             one);
    }
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

/// Manifests that are older than transducer files name no pattern. They mean a piston.
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

/// Older manifests name no solver. They mean superposition, which was the only one.
Method solver_from_json(const ordered_json& json, const std::string& where) {
    const auto member = json.find("solver");
    if (member == json.end()) return Method::superposition;
    for (const MethodName& one : method_names)
        if (*member == one.name) return one.method;
    throw bad_member(where, "solver", "a solver that this version knows", *member);
}

ordered_json record_to_json(const RecordMeaning& record, std::size_t index) {
    ordered_json json = {{"index", index}};
    if (record.foci.size() == 1 && record.foci.front().amplitude == 1.0) {
        json["focus_mm"] = to_mm(record.foci.front().position);
    } else {
        json["foci"] = ordered_json::array();
        for (const Focus& focus : record.foci)
            json["foci"].push_back({{"position_mm", to_mm(focus.position)}, {"amplitude", focus.amplitude}});
    }
    if (record.amplitude != 1.0) json["amplitude"] = record.amplitude;
    json["dwell_cycles"] = record.dwell_cycles;
    return json;
}

double fraction(const ordered_json& json, const char* key, const std::string& where) {
    const ordered_json& member = json.at(key);
    if (!member.is_number() || !(member.get<double>() >= 0.0 && member.get<double>() <= 1.0))
        throw bad_member(where, key, "a number from 0 to 1", member);
    return member.get<double>();
}

/// Each sample is a byte.
SampledModulation modulation_from_json(const ordered_json& json, const std::string& where) {
    const std::uint32_t periods = count(json, "periods_a_sample", 1, where);
    if (periods > 65535) throw bad_member(where, "periods_a_sample", "at most 65535", json.at("periods_a_sample"));
    SampledModulation found{static_cast<std::uint16_t>(periods), {}};
    for (const ordered_json& sample : json.at("samples")) {
        if (!sample.is_number_unsigned() || sample.get<std::uint64_t>() > 255)
            throw bad_member(where, "samples", "whole numbers from 0 to 255", sample);
        found.samples.push_back(sample.get<std::uint8_t>());
    }
    if (found.samples.empty()) throw bad_member(where, "samples", "at least one", json.at("samples"));
    return found;
}

RecordMeaning record_from_json(const ordered_json& json, const std::string& where) {
    RecordMeaning record;
    if (json.contains("foci"))
        for (const auto& focus : json.at("foci"))
            record.foci.push_back({from_mm_json(focus.at("position_mm")), fraction(focus, "amplitude", where)});
    else
        record.foci.push_back({from_mm_json(json.at("focus_mm"))});
    if (json.contains("amplitude")) record.amplitude = fraction(json, "amplitude", where);
    record.dwell_cycles = count(json, "dwell_cycles", 0, where);
    return record;
}

}  // namespace

std::uint32_t Manifest::index_of(std::size_t place) const {
    return static_cast<std::uint32_t>(place) + 1 + (foci ? core.parameters.records : 0);
}

std::optional<std::size_t> Manifest::place_of(std::uint32_t index) const {
    const std::uint32_t first = index_of(0);
    if (index < first || index - first >= records.size()) return {};
    return index - first;
}

std::uint64_t Manifest::repeat_periods() const {
    if (!(rate_hz > 0.0)) return 0;
    const auto pass = static_cast<std::uint64_t>(std::max(1.0, std::round(timer.carrier_hz() / rate_hz)));
    return modulation ? std::lcm(pass, std::uint64_t{modulation->divider} * modulation->samples.size()) : pass;
}

std::vector<Vec3> Manifest::points() const {
    std::vector<Vec3> found;
    for (const RecordMeaning& record : records)
        for (const Focus& focus : record.foci)
            if (focus.amplitude > 0.0) found.push_back(focus.position);
    return found;
}

bool Manifest::has_several_foci() const {
    return std::any_of(records.begin(), records.end(), [](const RecordMeaning& r) { return r.foci.size() > 1; });
}

std::string version() { return HAPTOGRAM_VERSION; }

ordered_json to_json(const Manifest& m) {
    ordered_json json;
    json["format"] = "haptogram-manifest-1";
    json["tool"] = {{"name", "haptogram"}, {"version", version()}};
    json["inputs_sha256"] = m.input_sha256;
    json["image_sha256"] = m.image_sha256;
    json["array"] = {{"name", m.array.name}, {"carrier_hz", m.array.carrier_hz}, {"duty", m.array.duty}};
    for (const Element& element : m.array.elements) json["array"]["elements_mm"].push_back(element_to_json(element));
    if (std::ranges::any_of(m.array.elements, [](const Element& e) { return !e.plain(); }))
        for (const Element& element : m.array.elements) {
            ordered_json one{element.response.real(), element.response.imag()};
            if (element.weight != 1.0) one.push_back(element.weight);
            json["array"]["responses"].push_back(one);
        }
    json["medium"] = {{"speed_m_s", m.array.medium.speed_m_s},
                      {"density_kg_m3", m.array.medium.density_kg_m3},
                      {"absorption_np_m", m.array.medium.absorption_np_m}};
    json["transducer"] = {{"name", m.array.transducer.name},
                          {"radius_mm", m.array.transducer.radius_m / millimetre},
                          {"source_pa_m", m.array.transducer.source_pa_m},
                          {"bandwidth_hz", m.array.transducer.bandwidth_hz},
                          {"directivity", directivity_to_json(m.array.transducer)}};
    if (!m.array.transducer.measured.empty()) json["transducer"]["measured"] = m.array.transducer.measured;
    json["board"] = {{"name", m.core.name}};
    for (const auto& [key, member] : core_members) json["board"][key] = m.core.parameters.*member;
    for (const auto& [key, member] : optional_core_members)
        if (m.core.parameters.*member != 0) json["board"][key] = m.core.parameters.*member;
    if (m.core.parameters.width_bits != 0) json["board"][min_pulse_clocks] = m.core.parameters.min_pulse_clocks;
    json["timer"] = {{"tick_s", m.timer.tick_s()},
                     {"prescaler", m.timer.prescaler},
                     {"cycle_ticks", m.timer.cycle_ticks},
                     {"pulse_ticks", m.timer.pulse_ticks}};
    json["rendering"] = {{"rate_hz", m.rate_hz},
                         {"flight_spread_s", m.formation.flight_spread_s},
                         {"beta_periods", m.formation.periods},
                         {"formation_s", m.formation.formation_s},
                         {"ring_up_s", m.formation.ring_up_s}};
    if (m.has_several_foci()) json["solver"] = name_of(m.solver);
    if (!m.quantise.empty()) json["quantise"] = m.quantise;
    if (m.foci) json["foci"] = {{"full_sum", m.foci->full}};
    if (m.modulation)
        json["modulation"] = {{"periods_a_sample", m.modulation->divider}, {"samples", m.modulation->samples}};
    json["records"] = ordered_json::array();
    for (std::size_t i = 0; i < m.records.size(); ++i)
        json["records"].push_back(record_to_json(m.records[i], m.index_of(i)));
    return json;
}

std::string to_text(const Manifest& manifest) { return to_json(manifest).dump(1) + "\n"; }

Manifest manifest_from_json(std::string_view text, const std::string& where) {
    require_shallow(text, where);
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
            m.array.elements.push_back(element_from_json(element));
        if (json.at("array").contains("responses")) read_responses(m.array, json.at("array").at("responses"), where);
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
        m.array.transducer.measured = transducer.value("measured", std::string());
        read_directivity(m.array.transducer, transducer, where);
        const auto& board = json.at("board");
        m.core.name = board.at("name").get<std::string>();
        for (const auto& [key, member] : core_members) m.core.parameters.*member = count(board, key, 1, where);
        for (const auto& [key, member] : optional_core_members)
            m.core.parameters.*member = board.contains(key) ? count(board, key, 1, where) : 0;
        if (m.core.parameters.width_bits != 0)
            m.core.parameters.min_pulse_clocks = count(board, min_pulse_clocks, 1, where);
        const auto& timer = json.at("timer");
        m.timer = {static_cast<double>(m.core.parameters.clock_hz), count(timer, "prescaler", 1, where),
                   count(timer, "cycle_ticks", 2, where), count(timer, "pulse_ticks", 1, where)};
        const auto& rendering = json.at("rendering");
        m.rate_hz = positive(rendering, "rate_hz", where);
        m.formation = {not_negative(rendering, "flight_spread_s", where), count(rendering, "beta_periods", 0, where),
                       not_negative(rendering, "formation_s", where), not_negative(rendering, "ring_up_s", where)};
        if (json.contains("foci")) m.foci = FocusMeaning{positive(json.at("foci"), "full_sum", where)};
        if (json.contains("modulation")) m.modulation = modulation_from_json(json.at("modulation"), where);
        for (const auto& record : json.at("records")) m.records.push_back(record_from_json(record, where));
        m.solver = solver_from_json(json, where);
        if (json.contains("quantise")) m.quantise = json.at("quantise").get<std::string>();
        if (m.array.elements.empty() || m.array.elements.size() > m.core.parameters.channels)
            throw bad_input(where, fmt::format("{} elements for {} channels; compile the image again",
                                               m.array.elements.size(), m.core.parameters.channels));
        return m;
    } catch (const nlohmann::json::exception& error) {
        throw bad_input(where, fmt::format("not a manifest that this version understands: {}; compile the image again",
                                           printable(error.what())));
    }
}

namespace {

/// As near as the image's unit of length and the manifest's digits can tell.
bool near(Vec3 a, Vec3 b) {
    constexpr double tolerance_m = 0.6 * focus_unit_m;
    return std::abs(a.x - b.x) <= tolerance_m && std::abs(a.y - b.y) <= tolerance_m &&
           std::abs(a.z - b.z) <= tolerance_m;
}

Vec3 position_of(const GeometryWords& words) {
    const auto metres = [](std::uint16_t word) { return static_cast<std::int16_t>(word) * focus_unit_m; };
    return {metres(words[0]), metres(words[1]), metres(words[2])};
}

using Fail = std::function<Error(const std::string& what)>;

/// The records of an image that has no others.
void require_same_records(const Manifest& manifest, const Image& image, const Fail& fail) {
    const Timer& t = manifest.timer;
    for (std::size_t i = 0; i < image.records.size(); ++i) {
        const Record& r = image.records[i];
        const std::uint32_t pulse = pulse_ticks(t, manifest.records[i].amplitude);
        if (r.kind != interface::Kind::timings)
            throw fail(
                fmt::format("record {} of the image holds amplitudes, of which a manifest knows nothing", i + 1));
        if (r.cycle_length != t.cycle_ticks || r.prescaler != t.prescaler || r.pulse_length != pulse)
            throw fail(fmt::format("timer {} × {} ticks, pulse {}, but record {} of the image has {} × {}, pulse {}",
                                   t.prescaler, t.cycle_ticks, pulse, i + 1, r.prescaler, r.cycle_length,
                                   r.pulse_length));
        for (std::size_t k = manifest.array.elements.size(); k < r.timings.size(); ++k)
            if (r.timings[k] < r.cycle_length)
                throw fail(fmt::format("{} elements, but record {} of the image fires channel {}",
                                       manifest.array.elements.size(), i + 1, k));
    }
}

/// Focus records and the geometry from which the board computes them.
void require_same_foci(const Manifest& manifest, const FocusRecords& foci, const Fail& fail) {
    const Timer& t = manifest.timer;
    if (foci.board_records != manifest.core.parameters.records)
        throw fail(fmt::format("a board of {} records, but the image is for one of {}",
                               manifest.core.parameters.records, foci.board_records));
    if (t.prescaler != 1 || foci.cycle_ticks != t.cycle_ticks)
        throw fail(fmt::format("timer {} × {} ticks, but the foci of the image have 1 × {}", t.prescaler, t.cycle_ticks,
                               foci.cycle_ticks));
    const std::vector<Element>& elements = manifest.array.elements;
    if (elements.size() != foci.engine.geometry.size())
        throw fail(fmt::format("{} elements, but the image's geometry is of {} channels", elements.size(),
                               foci.engine.geometry.size()));
    for (std::size_t k = 0; k < elements.size(); ++k)
        if (!near(elements[k].position, position_of(foci.engine.geometry[k])))
            throw fail(fmt::format("element {} does not lie where the image's geometry has it", k));
    for (std::size_t i = 0; i < foci.count(); ++i) {
        const RecordMeaning& meaning = manifest.records[i];
        std::size_t sounding = 0;
        for (const FocusWords& words : foci.record(i)) {
            const Focus focus = unpack_focus(words);
            if (focus.amplitude == 0.0) continue;  // fills the record up
            if (sounding == meaning.foci.size() || !near(meaning.foci[sounding].position, focus.position) ||
                std::abs(meaning.foci[sounding].amplitude * meaning.amplitude - focus.amplitude) > 1e-6)
                throw fail(fmt::format("focus {} of focus record {} of the image is another one", sounding + 1, i + 1));
            ++sounding;
        }
        if (sounding != meaning.foci.size())
            throw fail(fmt::format("{} foci in record {}, but the image has {}", meaning.foci.size(), i + 1, sounding));
    }
}

void require_agreement(const Manifest& manifest, const Image& image, const std::string& where) {
    const auto fail = [&](const std::string& what) { return bad_input(where, what + "; compile the two together"); };
    const interface::CoreParameters& core = manifest.core.parameters;
    if (manifest.records.size() != image.record_count())
        throw fail(fmt::format("{} records, but the image has {}", manifest.records.size(), image.record_count()));
    if (manifest.foci.has_value() != image.foci.has_value() || (image.foci && !image.records.empty()))
        throw fail(fmt::format("its records are {}, but the image has {} others and {} of foci",
                               manifest.foci ? "of foci" : "not of foci", image.records.size(),
                               image.foci ? image.foci->count() : 0));
    if (manifest.modulation != image.modulation) throw fail("its modulation is not that of the image");
    if (core.channels != image.channels)
        throw fail(fmt::format("{} channels, but the image has {}", core.channels, image.channels));
    if (core.clock_hz != image.clock_hz)
        throw fail(fmt::format("a clock of {} Hz, but the image is for {} Hz", core.clock_hz, image.clock_hz));
    std::vector<std::uint32_t> cycles(image.record_count());
    for (const SequenceEntry& entry : image.sequence)
        if (const auto place = place_of(image, entry.index)) cycles[*place] += entry.dwell;
    for (std::size_t i = 0; i < cycles.size(); ++i)
        if (manifest.records[i].dwell_cycles != cycles[i])
            throw fail(fmt::format("record {} is to last {} cycles, but the image's sequence gives it {}", i + 1,
                                   manifest.records[i].dwell_cycles, cycles[i]));
    if (image.foci)
        require_same_foci(manifest, *image.foci, fail);
    else
        require_same_records(manifest, image, fail);
}

Bundle assemble(Image image, std::string hex, Manifest manifest, const std::string& name,
                const std::string& manifest_name) {
    require_playable(image, name);
    if (const std::string hash = sha256(hex); manifest.image_sha256 != hash)
        throw bad_input(manifest_name,
                        fmt::format("it belongs to another image than {} (hash {}…, expected {}…); compile the two "
                                    "together",
                                    name, hash.substr(0, 12), manifest.image_sha256.substr(0, 12)));
    require_agreement(manifest, image, manifest_name);
    return {std::move(image), std::move(manifest), std::move(hex), name};
}

}  // namespace

std::string manifest_path(const std::string& image) {
    return std::filesystem::path(image).replace_extension(".json").string();
}

Bundle bundle_of(std::string hex, Manifest manifest, const std::string& name, const std::string& manifest_name) {
    Image image = from_intel_hex(hex, name);
    return assemble(std::move(image), std::move(hex), std::move(manifest), name, manifest_name);
}

Bundle load_bundle(const std::string& image, const std::string& manifest) {
    if (image == "-" && manifest.empty())
        throw bad_argument("image", "an image from standard input has no manifest beside it; name the manifest",
                           {"manifest"});
    const std::string beside = manifest.empty() ? manifest_path(image) : manifest;
    std::string hex = read_file(image);
    Image read = from_intel_hex(hex, image);
    return assemble(std::move(read), std::move(hex), manifest_from_json(read_file(beside), beside), image, beside);
}

Path path_of(const Bundle& bundle) {
    Path path;
    if (const auto& modulation = bundle.image.modulation) {
        path.modulation.periods_a_sample = modulation->divider;
        for (const std::uint8_t sample : modulation->samples) path.modulation.samples.push_back(sample / 255.0);
    }
    std::uint32_t last = 0;
    for (const SequenceEntry& entry : bundle.image.sequence) {
        if (entry.dwell == 0) continue;  // holds until the next record is ready, less than a period later
        if (!path.steps.empty() && entry.index == last && !entry.mark) {
            path.steps.back().periods += entry.dwell;
            continue;
        }
        last = entry.index;
        PathStep& step = path.steps.emplace_back();
        step.periods = entry.dwell;
        step.mark = entry.mark;
        if (entry.index == 0) continue;
        const RecordMeaning& record = bundle.manifest.records.at(place_of(bundle.image, entry.index).value());
        step.foci = record.foci;
        for (Focus& focus : step.foci) focus.amplitude *= record.amplitude;
    }
    return path;
}

Path places_of(const Manifest& manifest, std::span<const SequenceEntry> pass) {
    Path path;
    for (const SequenceEntry& entry : pass) {
        if (entry.dwell == 0) continue;  // as in path_of()
        const auto place = manifest.place_of(entry.index);
        add_places(path, place ? manifest.records.at(*place).foci : std::vector<Focus>(), entry.dwell);
    }
    return path;
}

}  // namespace haptogram
