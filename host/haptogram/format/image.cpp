// SPDX-License-Identifier: Apache-2.0
#include "haptogram/format/image.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/format/core.hpp"
#include "haptogram/format/intel_hex.hpp"

namespace haptogram {
namespace {

namespace description_field = interface::description_field;
namespace entry_field = interface::sequence_entry_field;
namespace parameters_field = interface::parameters_field;
namespace header_field = interface::sequence_header_field;
namespace record_field = interface::record_field;

template <class Word>
std::vector<std::uint8_t> little_endian(const std::vector<Word>& words) {
    std::vector<std::uint8_t> bytes;
    bytes.reserve(words.size() * sizeof(Word));
    for (const Word word : words)
        for (unsigned i = 0; i < sizeof(Word); ++i) bytes.push_back(static_cast<std::uint8_t>(word >> (8U * i)));
    return bytes;
}

template <class Word>
std::vector<Word> from_little_endian(const std::vector<std::uint8_t>& bytes) {
    std::vector<Word> words(bytes.size() / sizeof(Word));
    for (std::size_t i = 0; i < words.size() * sizeof(Word); ++i)
        words[i / sizeof(Word)] =
            static_cast<Word>(words[i / sizeof(Word)] | static_cast<Word>(bytes[i]) << (8U * (i % sizeof(Word))));
    return words;
}

/// Words of a description in the first format, which knows records and a sequence alone.
constexpr std::size_t short_description_words = description_field::board_records.offset / 16;

/// Where the records of channels end, in units of four words.
std::size_t records_end(const Image& image) { return (image.records.size() * record_words(image.channels) + 3) / 4; }

/// Where focus records begin, likewise.
std::size_t foci_base(const Image& image) { return records_end(image) + image.foci->gap; }

std::vector<std::uint16_t> description_words(const Image& image) {
    const bool is_long = image.foci || image.modulation || std::ranges::any_of(image.records, [](const Record& r) {
                             return r.kind == interface::Kind::amplitudes;
                         });
    std::vector<std::uint16_t> words(is_long ? interface::description_words : short_description_words);
    description_field::magic.set(words, interface::description_magic);
    description_field::format.set(words, is_long ? interface::description_long_format : interface::description_format);
    if (is_long) description_field::min_pulse_clocks.set(words, image.min_pulse_clocks);
    if (image.foci) description_field::board_records.set(words, image.foci->board_records);
    if (image.modulation) {
        description_field::modulation_samples.set(words, image.modulation->samples.size());
        description_field::modulation_divider.set(words, image.modulation->divider);
    }
    description_field::channels.set(words, image.channels);
    description_field::records.set(words, image.records.size());
    description_field::sequence_words.set(words, image.sequence.size() + 1);
    description_field::timing_bits.set(words, image.timing_bits);
    description_field::pulse_bits.set(words, image.pulse_bits);
    description_field::clock_hz.set(words, image.clock_hz);
    return words;
}

/// The bytes of one region, which must start at `base` and be `expected` long.
const std::vector<std::uint8_t>& region(const std::vector<intel_hex::Segment>& segments, std::uint32_t base,
                                        std::size_t expected, const char* name, const std::string& where) {
    const auto found = std::find_if(segments.begin(), segments.end(), [&](const auto& s) { return s.address == base; });
    if (found == segments.end())
        throw bad_input(
            where,
            fmt::format("no data at {:08X}, where {} begins; the image is cut short or was not made by haptogram", base,
                        name));
    if (found->bytes.size() != expected)
        throw bad_input(
            where,
            fmt::format("{} holds {} bytes from {:08X} on, its description says {}; the image is cut short or garbled",
                        name, found->bytes.size(), base, expected));
    return found->bytes;
}

}  // namespace

std::vector<std::uint16_t> primary_words(const Image& image) {
    std::vector<std::uint16_t> words;
    words.reserve(image.records.size() * record_words(image.channels));
    for (const Record& record : image.records) {
        std::array<std::uint16_t, interface::record_header_words> header{};
        record_field::cycle_length.set(header, record.cycle_length);
        record_field::pulse_length.set(header, record.pulse_length);
        record_field::prescaler.set(header, record.prescaler);
        record_field::kind.set(header, static_cast<std::uint32_t>(record.kind));
        words.insert(words.end(), header.begin(), header.end());
        words.insert(words.end(), record.timings.begin(), record.timings.end());
        words.insert(words.end(), image.channels - record.timings.size(),
                     record.kind == interface::Kind::amplitudes ? std::uint16_t{0} : interface::silent_timing);
    }
    if (image.foci) {
        words.resize(4 * foci_base(image));
        for (const FocusWords& focus : image.foci->foci) words.insert(words.end(), focus.begin(), focus.end());
    }
    return words;
}

std::vector<std::uint16_t> parameters_words(const Image& image) {
    if (!image.foci) return {};
    constexpr std::uint16_t at_once = 65535;
    const FocusRecords& foci = *image.foci;
    std::vector<std::uint16_t> words(interface::parameters_words);
    parameters_field::foci_base.set(words, foci_base(image));
    parameters_field::foci_count.set(words, foci.count());
    parameters_field::foci_last.set(words, foci.each - 1);
    parameters_field::foci_whole.set(words, foci.whole ? 1 : 0);
    parameters_field::foci_cycle.set(words, foci.cycle_ticks);
    parameters_field::wave_number.set(words, foci.engine.wave_number);
    parameters_field::gain.set(words, foci.engine.gain);
    parameters_field::phase_rate.set(words, at_once);
    parameters_field::amplitude_rate.set(words, at_once);
    parameters_field::arrival.set(words, 1);
    return words;
}

std::vector<std::uint16_t> geometry_words(const Image& image) {
    std::vector<std::uint16_t> words;
    if (image.foci)
        for (const GeometryWords& place : image.foci->engine.geometry)
            words.insert(words.end(), place.begin(), place.end());
    return words;
}

std::vector<std::uint16_t> modulation_words(const Image& image) {
    if (!image.modulation) return {};
    std::vector<std::uint8_t> bytes = image.modulation->samples;
    bytes.resize((bytes.size() + 1) / 2 * 2, 255);
    return from_little_endian<std::uint16_t>(bytes);
}

std::optional<std::size_t> place_of(const Image& image, std::uint32_t index) {
    if (index == 0) return {};
    if (index <= image.records.size()) return index - 1;
    if (!image.foci || index <= image.foci->board_records) return {};
    const std::size_t n = index - image.foci->board_records - 1;
    return n < image.foci->count() ? std::optional(image.records.size() + n) : std::nullopt;
}

std::uint16_t index_of(const Image& image, std::size_t place) {
    if (place < image.records.size()) return static_cast<std::uint16_t>(place + 1);
    return static_cast<std::uint16_t>(image.foci.value().board_records + 1 + place - image.records.size());
}

std::uint64_t cycle_clocks(const Image& image, std::size_t place) {
    if (place >= image.records.size()) return image.foci.value().cycle_ticks;
    return std::uint64_t{image.records[place].cycle_length} * image.records[place].prescaler;
}

bool has_amplitudes(const Image& image, std::size_t place) {
    return place >= image.records.size() || image.records[place].kind == interface::Kind::amplitudes;
}

std::vector<Emission> emissions_of(const Image& image, std::size_t place) {
    std::vector<Emission> emissions;
    if (place < image.records.size()) {
        for (const std::uint16_t word : image.records[place].timings)
            emissions.push_back(
                {static_cast<std::uint16_t>((word >> 8U) * 257U), static_cast<std::uint16_t>(word << 8U)});
        emissions.resize(image.channels);
        return emissions;
    }
    const FocusRecords& foci = image.foci.value();
    for (const ChannelDrive& drive : engine_drives(foci.engine, foci.record(place - image.records.size()), foci.whole))
        emissions.push_back({drive.amplitude, drive.phase});
    return emissions;
}

std::vector<EmissionWord> emission_words(const Image& image, std::span<const Emission> emissions,
                                         std::uint32_t cycle_ticks, std::uint8_t sample) {
    EmissionPeriod period;
    period.cycle_ticks = cycle_ticks;
    period.modulation = sample;
    // How wide the board's widths are bounds the cycle, which require_fits() checks, and changes nothing here.
    return EmissionModel(image.channels, image.timing_bits, image.timing_bits, image.min_pulse_clocks)
        .period(emissions, period);
}

SampledModulation sampled(const Modulation& modulation, std::uint32_t most, const std::string& board) {
    if (modulation.samples.size() > most || modulation.periods_a_sample > 65535)
        throw bad_input(board,
                        fmt::format("the modulation has {} samples of {} carrier periods, the board holds {} of at "
                                    "most 65535; take a frequency with fewer samples, or compile records",
                                    modulation.samples.size(), modulation.periods_a_sample, most),
                        {"am", "records", "board"});
    SampledModulation found{static_cast<std::uint16_t>(modulation.periods_a_sample), {}};
    for (const double sample : modulation.samples)
        found.samples.push_back(static_cast<std::uint8_t>(std::lround(255.0 * sample)));
    return found;
}

std::vector<std::uint32_t> sequence_words(const Image& image) {
    std::vector<std::uint32_t> words(image.sequence.size() + 1);
    header_field::length.set(words, image.sequence.size());
    header_field::loops.set(words, image.loops);
    for (std::size_t i = 0; i < image.sequence.size(); ++i) {
        entry_field::index.set(&words[i + 1], image.sequence[i].index);
        entry_field::dwell.set(&words[i + 1], image.sequence[i].dwell);
        entry_field::mark.set(&words[i + 1], image.sequence[i].mark ? 1 : 0);
    }
    return words;
}

std::string to_intel_hex(const Image& image) {
    std::vector<intel_hex::Segment> segments = {{interface::primary_base, little_endian(primary_words(image))},
                                                {interface::sequence_base, little_endian(sequence_words(image))},
                                                {interface::description_base, little_endian(description_words(image))}};
    if (image.foci) {
        segments.push_back({interface::parameters_base, little_endian(parameters_words(image))});
        segments.push_back({interface::geometry_base, little_endian(geometry_words(image))});
    }
    if (image.modulation) segments.push_back({interface::modulation_base, little_endian(modulation_words(image))});
    return intel_hex::write(segments);
}

void take_records(Image& image, const std::vector<std::uint16_t>& primary, const std::string& where) {
    const std::size_t stride = record_words(image.channels);
    for (std::size_t r = 0; r < primary.size() / stride; ++r) {
        const std::uint16_t* const word = primary.data() + r * stride;
        const std::uint32_t kind = record_field::kind.get(word);
        if (kind > static_cast<std::uint32_t>(interface::Kind::amplitudes))
            throw bad_input(
                where,
                fmt::format("record {}: kind {} in its header; expected 0 or 1; the image is garbled", r + 1, kind));
        image.records.push_back({record_field::cycle_length.get(word),
                                 record_field::prescaler.get(word),
                                 static_cast<std::uint8_t>(record_field::pulse_length.get(word)),
                                 {word + interface::record_header_words, word + stride},
                                 static_cast<interface::Kind>(kind)});
    }
}

namespace {

/// The format that the description says it has; 0 where there is none.
std::uint32_t require_known_format(const std::vector<intel_hex::Segment>& segments, const std::string& where) {
    for (const intel_hex::Segment& segment : segments) {
        if (segment.address != interface::description_base || segment.bytes.size() < 4) continue;
        const std::uint32_t magic = description_field::magic.get(segment.bytes);
        const std::uint32_t format = description_field::format.get(segment.bytes);
        if (magic == interface::description_magic &&
            (format == interface::description_format || format == interface::description_long_format))
            return format;
        throw bad_input(where,
                        fmt::format("the description says magic {:04X}, format {}; expected {:04X}, format {} or {}; "
                                    "compile it with this version",
                                    magic, format, interface::description_magic, interface::description_format,
                                    interface::description_long_format));
    }
    return 0;
}

/// The focus records of an image whose other records, and whose channels, are known.
/// @param primary  primary memory's contents, with them
FocusRecords foci_from(const Image& image, const std::vector<std::uint16_t>& parameters,
                       const std::vector<std::uint16_t>& geometry, const std::vector<std::uint16_t>& primary,
                       std::uint32_t board_records, const std::string& where) {
    FocusRecords found;
    found.board_records = board_records;
    found.each = parameters_field::foci_last.get(parameters) + 1;
    found.whole = parameters_field::foci_whole.get(parameters) != 0;
    found.cycle_ticks = parameters_field::foci_cycle.get(parameters);
    const std::size_t base = parameters_field::foci_base.get(parameters), end = records_end(image);
    if (base > end) found.gap = static_cast<std::uint32_t>(base - end);
    found.engine.wave_number = parameters_field::wave_number.get(parameters);
    found.engine.gain = static_cast<std::uint16_t>(parameters_field::gain.get(parameters));
    for (std::size_t k = 0; k + 3 < geometry.size(); k += 4)
        found.engine.geometry.push_back({geometry[k], geometry[k + 1], geometry[k + 2], geometry[k + 3]});
    for (std::size_t i = 4 * (end + found.gap); i + 3 < primary.size(); i += 4)
        found.foci.push_back({primary[i], primary[i + 1], primary[i + 2], primary[i + 3]});
    if (found.foci.empty() || board_records < image.records.size() || board_records + found.count() > 65535)
        throw bad_input(where,
                        fmt::format("{} focus records behind {} records of {}; expected at least one, no more records "
                                    "than the board has, and indices of 16 bits; the image is garbled",
                                    found.count(), image.records.size(), board_records));
    Image only = image;
    only.foci = found;
    if (parameters_words(only) != parameters || primary_words(only) != primary)
        throw bad_input(
            where,
            fmt::format("its parameters say {} focus records from word {} on, with what else they hold, "
                        "which is not what an image of these records has; the image is garbled, or needs "
                        "another version",
                        parameters_field::foci_count.get(parameters), 4 * parameters_field::foci_base.get(parameters)));
    return found;
}

}  // namespace

Image from_intel_hex(std::string_view text, const std::string& where) {
    const std::vector<intel_hex::Segment> segments = intel_hex::read(text, where);
    const std::uint32_t format = require_known_format(segments, where);
    const bool is_long = format == interface::description_long_format;
    for (const auto& segment : segments) {
        constexpr std::array known = {interface::primary_base,    interface::sequence_base, interface::description_base,
                                      interface::parameters_base, interface::geometry_base, interface::modulation_base};
        const auto end = is_long ? known.end() : known.begin() + 3;
        if (std::find(known.begin(), end, segment.address) == end)
            throw bad_input(where, fmt::format("{} bytes at {:08X} belong to no region, or the bytes before them are "
                                               "missing; the image is garbled",
                                               segment.bytes.size(), segment.address));
    }
    const auto holds = [&](std::uint32_t base) {
        return std::any_of(segments.begin(), segments.end(), [&](const auto& s) { return s.address == base; });
    };
    const bool has_foci = holds(interface::parameters_base) || holds(interface::geometry_base);
    const bool has_modulation = holds(interface::modulation_base);
    const auto described = from_little_endian<std::uint16_t>(
        region(segments, interface::description_base,
               2 * (is_long ? std::size_t{interface::description_words} : short_description_words),
               is_long ? "the description, which says format 2," : "the description", where));
    Image image;
    image.channels = description_field::channels.get(described);
    image.clock_hz = description_field::clock_hz.get(described);
    image.timing_bits = description_field::timing_bits.get(described);
    image.pulse_bits = description_field::pulse_bits.get(described);
    for (const auto& [name, bits] : {std::pair("TIMING_BITS", image.timing_bits), {"PULSE_BITS", image.pulse_bits}}) {
        const auto parameter =
            std::ranges::find(interface::core_parameters, name, &interface::ParameterDescription::name);
        if (bits < parameter->low || bits > parameter->high)
            throw bad_input(where, fmt::format("the description says {} = {}; expected {} to {}; the image is garbled",
                                               name, bits, parameter->low, parameter->high));
    }
    if (is_long) image.min_pulse_clocks = description_field::min_pulse_clocks.get(described);
    if (image.min_pulse_clocks == 0)
        throw bad_input(where,
                        "the description says a shortest pulse of 0 clocks; expected 1 or more; the image is garbled");
    const std::uint32_t records = description_field::records.get(described);
    const std::uint32_t words = description_field::sequence_words.get(described);
    if (image.channels == 0 || (records == 0 && !has_foci) || words == 0)
        throw bad_input(
            where, fmt::format("the description says {} channels, {} records and {} sequence words; none may be zero",
                               image.channels, records, words));
    const std::size_t stride = record_words(image.channels);
    const auto sequence = from_little_endian<std::uint32_t>(
        region(segments, interface::sequence_base, 4UL * words, "sequence memory", where));
    if (header_field::length.get(sequence) != words - 1)
        throw bad_input(where,
                        fmt::format("the sequence header says {} entries, the description {}; the image is garbled",
                                    header_field::length.get(sequence), words - 1));
    if (header_field::autostart.get(sequence) != 0)
        throw bad_input(where,
                        "the sequence header has the autostart bit, which only a bitstream may hold; compile the image "
                        "again, and have the bit set where the image is put into a bitstream",
                        {"autostart"});
    std::vector<std::uint16_t> parameters;
    std::size_t primary_size = stride * records;
    if (has_foci) {
        parameters = from_little_endian<std::uint16_t>(region(
            segments, interface::parameters_base, 2UL * interface::parameters_words, "the parameters block", where));
        primary_size = 4 * (std::size_t{parameters_field::foci_base.get(parameters)} +
                            std::size_t{parameters_field::foci_count.get(parameters)} *
                                (parameters_field::foci_last.get(parameters) + 1));
    }
    auto primary = from_little_endian<std::uint16_t>(
        region(segments, interface::primary_base, 2 * primary_size, "primary memory", where));
    const std::vector<std::uint16_t> all = primary;
    primary.resize(stride * records);
    take_records(image, primary, where);
    image.loops = static_cast<std::uint16_t>(header_field::loops.get(sequence));
    for (std::size_t i = 1; i < sequence.size(); ++i)
        image.sequence.push_back({static_cast<std::uint16_t>(entry_field::index.get(&sequence[i])),
                                  static_cast<std::uint16_t>(entry_field::dwell.get(&sequence[i])),
                                  entry_field::mark.get(&sequence[i]) != 0});
    if (has_foci) {
        const auto geometry = from_little_endian<std::uint16_t>(
            region(segments, interface::geometry_base, std::size_t{8} * image.channels, "the geometry", where));
        image.foci =
            foci_from(image, parameters, geometry, all, description_field::board_records.get(described), where);
    }
    if (has_modulation) {
        const std::uint32_t samples = description_field::modulation_samples.get(described);
        image.modulation = SampledModulation{
            static_cast<std::uint16_t>(description_field::modulation_divider.get(described)),
            region(segments, interface::modulation_base, (samples + std::size_t{1}) / 2 * 2, "the modulation", where)};
        image.modulation->samples.resize(samples);
        if (samples == 0 || image.modulation->divider == 0)
            throw bad_input(where,
                            fmt::format("the description says {} samples of modulation, each for {} carrier periods; "
                                        "neither may be zero",
                                        samples, image.modulation->divider));
    }
    return image;
}

namespace {

/// Of the n-th focus record, counted from 0.
std::vector<std::string> problems_of_foci(const FocusRecords& foci, std::size_t n) {
    std::vector<std::string> found;
    const std::span<const FocusWords> record = foci.record(n);
    for (std::size_t i = 0; i < record.size(); ++i)
        if ((record[i][3] & 0xc0U) != 0)
            found.push_back(
                fmt::format("focus record {}: reserved bits are set in focus {} of {}; the board will refuse "
                            "it",
                            n + 1, i + 1, record.size()));
    if (!found.empty()) return found;
    const std::vector<ChannelDrive> drives = engine_drives(foci.engine, record, foci.whole);
    if (std::any_of(drives.begin(), drives.end(), [](const ChannelDrive& drive) { return drive.far; }))
        found.push_back(fmt::format(
            "focus record {}: a focus is too far from a channel to count, 1.024 m or more in a coordinate", n + 1));
    return found;
}

}  // namespace

std::vector<std::string> problems(const Image& image) {
    std::vector<std::string> found;
    const auto check_cycle = [&](std::uint32_t ticks, const std::string& of) {
        const std::uint64_t most = 2 * ((std::uint64_t{1} << image.timing_bits) - 1);
        if (ticks < 2 || ticks > most)
            found.push_back(
                fmt::format("{}: a cycle of {} ticks; with amplitudes and {} timing bits it has 2 to {}; the "
                            "board will refuse it",
                            of, ticks, image.timing_bits, most));
    };
    for (std::size_t r = 0; r < image.records.size(); ++r) {
        const Record& record = image.records[r];
        if (record.kind == interface::Kind::amplitudes) {
            check_cycle(record.cycle_length, fmt::format("record {}", r + 1));
            if (record.prescaler != 1 || record.pulse_length != 0)
                found.push_back(
                    fmt::format("record {}: prescaler {} and pulse length {}; records of amplitudes have 1 "
                                "and 0; the board will refuse it",
                                r + 1, record.prescaler, record.pulse_length));
            continue;
        }
        if (record.prescaler == 0)
            found.push_back(fmt::format("record {}: prescaler 0; the board will refuse it", r + 1));
        const double cycle_s =
            static_cast<double>(record.cycle_length) * record.prescaler / std::max(image.clock_hz, 1U);
        if (cycle_s > interface::longest_cycle_s)
            found.push_back(fmt::format("record {}: a cycle lasts {:.3g} s, at most {} s; the board will refuse it",
                                        r + 1, cycle_s, interface::longest_cycle_s));
        if (record.pulse_length >= record.cycle_length)
            found.push_back(fmt::format(
                "record {}: a pulse of {} ticks is not shorter than its cycle of {}; the board will refuse it", r + 1,
                record.pulse_length, record.cycle_length));
    }
    if (image.foci) {
        check_cycle(image.foci->cycle_ticks, "the focus records");
        for (std::size_t n = 0; n < image.foci->count(); ++n)
            for (std::string& problem : problems_of_foci(*image.foci, n)) found.push_back(std::move(problem));
    }
    if (image.sequence.empty()) found.emplace_back("the sequence is empty; nothing would be played");
    for (std::size_t i = 0; i < image.sequence.size(); ++i) {
        const SequenceEntry& entry = image.sequence[i];
        if (entry.index > 0 && !place_of(image, entry.index)) {
            const std::string foci = image.foci ? fmt::format(" and {} focus records from {} on", image.foci->count(),
                                                              image.foci->board_records + 1)
                                                : std::string{};
            found.push_back(fmt::format("sequence entry {}: index {} of {} records{}; the board will refuse it", i + 1,
                                        entry.index, image.records.size(), foci));
        }
        if (entry.dwell == 0)
            found.push_back(
                fmt::format("sequence entry {}: dwell 0 lasts only until the next record is loaded", i + 1));
    }
    return found;
}

void require_playable(const Image& image, const std::string& where) {
    const std::vector<std::string> found = problems(image);
    if (found.empty()) return;
    throw bad_input(where,
                    fmt::format("{}{}", found.front(),
                                found.size() > 1 ? fmt::format(" (and {} more; see inspect)", found.size() - 1) : ""));
}

void require_fits(const Image& image, const interface::CoreParameters& core, const std::string& where) {
    const auto require = [&](bool fits, const std::string& what) {
        if (!fits)
            throw bad_input(where, what + "; compile it for this board, or use the board it was made for",
                            {"board", "array"});
    };
    require(image.channels == core.channels,
            fmt::format("the image is for {} channels, the board has {}", image.channels, core.channels));
    require(image.clock_hz == core.clock_hz,
            fmt::format("the image is for a {} Hz clock, the board has {} Hz", image.clock_hz, core.clock_hz));
    require(image.timing_bits <= core.timing_bits,
            fmt::format("the image needs {} timing bits, the board has {}", image.timing_bits, core.timing_bits));
    require(image.pulse_bits <= core.pulse_bits,
            fmt::format("the image needs {} pulse bits, the board has {}", image.pulse_bits, core.pulse_bits));
    require(image.records.size() <= core.records,
            fmt::format("the image has {} records, the board holds {}", image.records.size(), core.records));
    require(image.sequence.size() < core.sequence_depth,
            fmt::format("the image has {} sequence entries, the board holds {}", image.sequence.size(),
                        core.sequence_depth - 1));
    require(core.trigger > 0 || std::ranges::none_of(image.sequence, &SequenceEntry::mark),
            "the image marks entries for a trigger output, the board has none");
    const auto require_cycle = [&](std::uint64_t clocks, const std::string& of) {
        require(image.min_pulse_clocks == core.min_pulse_clocks,
                fmt::format("the image is for shortest pulses of {} clocks, the board's have {}",
                            image.min_pulse_clocks, core.min_pulse_clocks));
        require(core.width_bits > 0, fmt::format("{} has amplitudes, the board has none", of));
        require(clocks >= least_amplitude_cycle(core) && clocks <= most_amplitude_cycle(core),
                fmt::format("{} has a cycle of {} clocks, the board plays {} to {} with amplitudes", of, clocks,
                            least_amplitude_cycle(core), most_amplitude_cycle(core)));
    };
    if (image.foci) {
        const FocusRecords& foci = *image.foci;
        require(core.foci > 0, "the image has focus records, the board computes no foci");
        require(foci.each <= core.foci,
                fmt::format("the image has {} foci a record, the board takes {}", foci.each, core.foci));
        require(foci.board_records == core.records,
                fmt::format("the image's focus records begin behind index {}, those of the board behind {}",
                            foci.board_records, core.records));
        require(foci.engine.geometry.size() == core.channels,
                fmt::format("the image's geometry is of {} channels, the board has {}", foci.engine.geometry.size(),
                            core.channels));
        require_cycle(foci.cycle_ticks, "a focus record");
        const std::size_t words = primary_words(image).size();
        require(words <= std::size_t{core.records} * record_words(core.channels),
                fmt::format("the image fills {} words of primary memory, the board has {}", words,
                            std::size_t{core.records} * record_words(core.channels)));
    }
    if (image.modulation)
        require(image.modulation->samples.size() <= core.modulation_depth,
                fmt::format("the image has {} samples of modulation, the board holds {}",
                            image.modulation->samples.size(), core.modulation_depth));
    for (std::size_t r = 0; r < image.records.size(); ++r) {
        const Record& record = image.records[r];
        if (record.kind == interface::Kind::amplitudes)
            require_cycle(record.cycle_length, fmt::format("record {}", r + 1));
        const std::uint64_t clocks = std::uint64_t{record.cycle_length} * record.prescaler;
        require(core.width_bits == 0 || clocks >= least_timed_cycle,
                fmt::format("record {} has a cycle of {} clocks, a board with amplitudes plays {} or more", r + 1,
                            clocks, least_timed_cycle));
        const std::uint64_t unfit = 1ULL << core.timing_bits;  // rtl/record_header.v
        require(core.width_bits == 0 || record.kind == interface::Kind::amplitudes || record.cycle_length <= unfit ||
                    record.cycle_length >= unfit + (1ULL << core.width_bits),
                fmt::format("record {} has a cycle of {} ticks, a board with amplitudes plays none of {} to {}", r + 1,
                            record.cycle_length, unfit + 1, unfit + (1ULL << core.width_bits) - 1));
        if (record.pulse_length == 0) continue;
        const std::uint64_t pulse = std::uint64_t{record.pulse_length} * record.prescaler;
        require(pulse >= core.min_pulse_clocks && pulse <= max_pulse_clocks(core),
                fmt::format("record {}: a pulse lasts {} clocks, the board plays {} to {}", r + 1, pulse,
                            core.min_pulse_clocks, max_pulse_clocks(core)));
        require(256 * record.pulse_length <= core.max_duty_256 * record.cycle_length,
                fmt::format("record {}: a pulse takes {:.1f} % of its cycle, the board plays at most {:.1f} %", r + 1,
                            100.0 * record.pulse_length / record.cycle_length, core.max_duty_256 / 2.56));
    }
}

std::vector<std::uint64_t> record_clocks(const Image& image) {
    std::vector<std::uint64_t> clocks(image.record_count());
    for (const SequenceEntry& entry : image.sequence)
        if (const auto place = place_of(image, entry.index))
            clocks[*place] += entry.dwell * cycle_clocks(image, *place);
    return clocks;
}

std::string primary_readmemh(const Image& image) {
    std::string text;
    for (const std::uint16_t word : primary_words(image)) text += fmt::format("{:04x}\n", word);
    return text;
}

std::string sequence_readmemh(const Image& image) {
    std::string text;
    for (const std::uint32_t word : sequence_words(image)) text += fmt::format("{:08x}\n", word);
    return text;
}

}  // namespace haptogram
