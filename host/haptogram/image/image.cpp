// SPDX-License-Identifier: Apache-2.0
#include "haptogram/image/image.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>

#include "haptogram/base/error.hpp"
#include "haptogram/boards/core.hpp"
#include "haptogram/image/intel_hex.hpp"

namespace haptogram {
namespace {

namespace description_field = interface::description_field;
namespace entry_field = interface::sequence_entry_field;
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

std::vector<std::uint16_t> description_words(const Image& image) {
    std::vector<std::uint16_t> words(interface::description_words);
    description_field::magic.set(words, interface::description_magic);
    description_field::format.set(words, interface::description_format);
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
        words.insert(words.end(), header.begin(), header.end());
        words.insert(words.end(), record.timings.begin(), record.timings.end());
        words.insert(words.end(), image.channels - record.timings.size(), interface::silent_timing);
    }
    return words;
}

std::vector<std::uint32_t> sequence_words(const Image& image) {
    std::vector<std::uint32_t> words(image.sequence.size() + 1);
    header_field::length.set(words, image.sequence.size());
    header_field::loops.set(words, image.loops);
    for (std::size_t i = 0; i < image.sequence.size(); ++i) {
        entry_field::index.set(&words[i + 1], image.sequence[i].index);
        entry_field::dwell.set(&words[i + 1], image.sequence[i].dwell);
    }
    return words;
}

std::string to_intel_hex(const Image& image) {
    return intel_hex::write({{interface::primary_base, little_endian(primary_words(image))},
                             {interface::sequence_base, little_endian(sequence_words(image))},
                             {interface::description_base, little_endian(description_words(image))}});
}

void take_words(Image& image, const std::vector<std::uint16_t>& primary, const std::vector<std::uint32_t>& sequence,
                const std::string& where) {
    const std::size_t stride = record_words(image.channels);
    for (std::size_t r = 0; r < primary.size() / stride; ++r) {
        const std::uint16_t* word = primary.data() + r * stride;
        if (record_field::reserved.get(word) != 0)
            throw bad_input(where,
                            fmt::format("record {}: reserved bits are set in its header; the image is garbled", r + 1));
        image.records.push_back({record_field::cycle_length.get(word),
                                 record_field::prescaler.get(word),
                                 static_cast<std::uint8_t>(record_field::pulse_length.get(word)),
                                 {word + interface::record_header_words, word + stride}});
    }
    image.loops = static_cast<std::uint16_t>(header_field::loops.get(sequence));
    for (std::size_t i = 1; i < sequence.size(); ++i)
        image.sequence.push_back({static_cast<std::uint16_t>(entry_field::index.get(&sequence[i])),
                                  static_cast<std::uint16_t>(entry_field::dwell.get(&sequence[i]))});
}

Image from_intel_hex(std::string_view text, const std::string& where) {
    const std::vector<intel_hex::Segment> segments = intel_hex::read(text, where);
    for (const auto& segment : segments) {
        constexpr std::array known = {interface::primary_base, interface::sequence_base, interface::description_base};
        if (std::find(known.begin(), known.end(), segment.address) == known.end())
            throw bad_input(where, fmt::format("{} bytes at {:08X} belong to no region, or the bytes before them are "
                                               "missing; the image is garbled",
                                               segment.bytes.size(), segment.address));
    }
    const auto described = from_little_endian<std::uint16_t>(region(segments, interface::description_base,
                                                                    std::size_t{2} * interface::description_words,
                                                                    "the description", where));
    const std::uint32_t magic = description_field::magic.get(described);
    const std::uint32_t format = description_field::format.get(described);
    if (magic != interface::description_magic || format != interface::description_format)
        throw bad_input(where,
                        fmt::format("the description says magic {:04X}, format {}; expected {:04X}, format {}; compile "
                                    "it with this version",
                                    magic, format, interface::description_magic, interface::description_format));
    Image image;
    image.channels = description_field::channels.get(described);
    image.clock_hz = description_field::clock_hz.get(described);
    image.timing_bits = description_field::timing_bits.get(described);
    image.pulse_bits = description_field::pulse_bits.get(described);
    const std::uint32_t records = description_field::records.get(described);
    const std::uint32_t words = description_field::sequence_words.get(described);
    if (image.channels == 0 || records == 0 || words == 0)
        throw bad_input(
            where, fmt::format("the description says {} channels, {} records and {} sequence words; none may be zero",
                               image.channels, records, words));
    const std::size_t stride = record_words(image.channels);
    const auto primary = from_little_endian<std::uint16_t>(
        region(segments, interface::primary_base, 2 * stride * records, "primary memory", where));
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
    take_words(image, primary, sequence, where);
    return image;
}

std::vector<std::string> problems(const Image& image) {
    std::vector<std::string> found;
    for (std::size_t r = 0; r < image.records.size(); ++r) {
        const Record& record = image.records[r];
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
    if (image.sequence.empty()) found.emplace_back("the sequence is empty; nothing would be played");
    for (std::size_t i = 0; i < image.sequence.size(); ++i) {
        const SequenceEntry& entry = image.sequence[i];
        if (entry.index > image.records.size())
            found.push_back(fmt::format("sequence entry {}: index {} of {} records; the board will refuse it", i + 1,
                                        entry.index, image.records.size()));
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
    for (std::size_t r = 0; r < image.records.size(); ++r) {
        const Record& record = image.records[r];
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
    std::vector<std::uint64_t> clocks(image.records.size());
    for (const SequenceEntry& entry : image.sequence) {
        if (entry.index == 0 || entry.index > image.records.size()) continue;
        const Record& record = image.records[entry.index - 1U];
        clocks[entry.index - 1U] += std::uint64_t{entry.dwell} * record.cycle_length * record.prescaler;
    }
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
