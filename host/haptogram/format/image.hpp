// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "haptogram/format/emission.hpp"
#include "haptogram/format/focus_engine.hpp"
#include "haptogram/format/interface.hpp"
#include "haptogram/format/path.hpp"

namespace haptogram {

/// What every channel of the core does in one carrier period, as the FPGA stores it (rtl/INTERFACE.md).
struct Record {
    std::uint32_t cycle_length = 0;      ///< ticks, 24 bits
    std::uint32_t prescaler = 1;         ///< clocks per tick, 24 bits
    std::uint8_t pulse_length = 0;       ///< ticks
    std::vector<std::uint16_t> timings;  ///< one a channel; interface::silent_timing never fires. Of amplitudes: their
                                         ///< words as interface::Kind says, and prescaler 1 and pulse length 0
    interface::Kind kind = interface::Kind::timings;

    /// Whether a channel fires at all.
    [[nodiscard]] bool fires(std::size_t channel) const {
        if (kind == interface::Kind::amplitudes) return timings[channel] >> 8U != 0;
        return pulse_length > 0 && timings[channel] < cycle_length && timings[channel] != interface::silent_timing;
    }
    friend bool operator==(const Record&, const Record&) = default;
};

/// One step of the sequence.
struct SequenceEntry {
    std::uint16_t index = 0;  ///< 0 silence, 1… records
    std::uint16_t dwell = 1;  ///< carrier cycles
    bool mark = false;        ///< its beginning is an event of a board's trigger output
    friend bool operator==(const SequenceEntry&, const SequenceEntry&) = default;
};

/// Records of one to eight foci, from which the board itself computes phases and amplitudes, and what it needs for
/// that. They lie densely behind the other records, and their indices begin behind the board's RECORDS, however many
/// records there are.
struct FocusRecords {
    std::uint32_t board_records = 0;   ///< the board's RECORDS
    FocusEngine engine;                ///< with the geometry of all of the board's channels
    std::uint32_t each = 1;            ///< foci of a record, 1…8
    std::uint32_t gap = 0;             ///< foci that are left empty before them; tells tiles of a rig apart
    std::uint32_t cycle_ticks = 1250;  ///< their carrier period, in ticks of one clock
    bool whole = false;                ///< all channels at full amplitude
    std::vector<FocusWords> foci;      ///< `each` for the first record, then those of the second

    [[nodiscard]] std::size_t count() const { return foci.size() / each; }
    /// The foci of a record. @param n  counted from 0
    [[nodiscard]] std::span<const FocusWords> record(std::size_t n) const { return {foci.data() + n * each, each}; }
    friend bool operator==(const FocusRecords&, const FocusRecords&) = default;
};

/// Samples by which the board multiplies all amplitudes, over and over, whatever records play.
struct SampledModulation {
    std::uint16_t divider = 1;          ///< carrier periods a sample
    std::vector<std::uint8_t> samples;  ///< 255 leaves an amplitude as it is
    friend bool operator==(const SampledModulation&, const SampledModulation&) = default;
};

/// A path's modulation as a board's samples.
/// @param most  samples that the board holds
/// @throws Error{bad_input} naming the board, when it cannot hold them
[[nodiscard]] SampledModulation sampled(const Modulation& modulation, std::uint32_t most, const std::string& board);

/// All that a board is loaded with, and what board it was compiled for.
struct Image {
    std::uint32_t channels = 0;
    std::uint32_t clock_hz = 0;
    std::uint32_t timing_bits = 16;
    std::uint32_t pulse_bits = 8;
    std::uint32_t min_pulse_clocks = 1;  ///< of a pulse with an amplitude; the board's MIN_PULSE_CLOCKS
    std::vector<Record> records;         ///< record i of the paper is records[i − 1]
    std::vector<SequenceEntry> sequence;
    std::uint16_t loops = 0;                      ///< 0 plays for ever
    std::optional<FocusRecords> foci;             ///< for boards that compute foci
    std::optional<SampledModulation> modulation;  ///< for boards that modulate

    /// Records of both kinds.
    [[nodiscard]] std::size_t record_count() const { return records.size() + (foci ? foci->count() : 0); }
    friend bool operator==(const Image&, const Image&) = default;
};

[[nodiscard]] constexpr std::uint32_t record_words(std::uint32_t channels) {
    return channels + interface::record_header_words;
}

/// Where an index stands among an image's records: those of timings and amplitudes first, counted from 0, and then
/// those of foci. Empty for silence and for an index that none of them has.
[[nodiscard]] std::optional<std::size_t> place_of(const Image& image, std::uint32_t index);
/// The index of a record at such a place.
[[nodiscard]] std::uint16_t index_of(const Image& image, std::size_t place);
/// How many clocks a cycle of this record has.
[[nodiscard]] std::uint64_t cycle_clocks(const Image& image, std::size_t place);
/// Whether a record has amplitudes, so that its pulses are made anew in every carrier period.
[[nodiscard]] bool has_amplitudes(const Image& image, std::size_t place);
/// What each channel emits in a record that has amplitudes; of foci, what the board computes, to the last bit.
[[nodiscard]] std::vector<Emission> emissions_of(const Image& image, std::size_t place);
/// What the board's pulse generators are told for one carrier period of these emissions, without a slew limit.
/// @param sample  of the modulation
[[nodiscard]] std::vector<EmissionWord> emission_words(const Image& image, std::span<const Emission> emissions,
                                                       std::uint32_t cycle_ticks, std::uint8_t sample = 255);

/// Primary memory's contents: records one after the other, and behind them the focus records, from a multiple of four
/// words on.
[[nodiscard]] std::vector<std::uint16_t> primary_words(const Image& image);
/// The contents of the parameters block, of the geometry and of the modulation memory; empty where the image has none.
[[nodiscard]] std::vector<std::uint16_t> parameters_words(const Image& image);
[[nodiscard]] std::vector<std::uint16_t> geometry_words(const Image& image);
[[nodiscard]] std::vector<std::uint16_t> modulation_words(const Image& image);
/// Sequence memory's contents: the header, then the entries.
[[nodiscard]] std::vector<std::uint32_t> sequence_words(const Image& image);

/// Fills `image`, whose channels are known, with the records that primary memory holds.
/// @throws Error{bad_input} naming the record whose words cannot be one
void take_records(Image& image, const std::vector<std::uint16_t>& primary, const std::string& where);

/// The image as Intel HEX: 16-bit words of primary memory, 32-bit words of sequence memory, the description, and what
/// there is of parameters, geometry and modulation, little-endian, with extended linear addresses.
[[nodiscard]] std::string to_intel_hex(const Image& image);

/// Reads such a file back and checks everything that can be checked without knowing the array.
/// @param where  names the file in messages
/// @throws Error{bad_input} naming the line or the record
[[nodiscard]] Image from_intel_hex(std::string_view text, const std::string& where);

/// What would keep the records and the sequence from being played as they are, in words; empty when nothing does.
[[nodiscard]] std::vector<std::string> problems(const Image& image);

/// @throws Error{bad_input} with the first of the problems, naming the file
void require_playable(const Image& image, const std::string& where);

/// @throws Error{bad_input} saying why a core with these parameters cannot hold or play the image
void require_fits(const Image& image, const interface::CoreParameters& core, const std::string& where);

/// How long the record at each place plays in one pass of the sequence, in clocks.
[[nodiscard]] std::vector<std::uint64_t> record_clocks(const Image& image);

/// `$readmemh` text of primary and sequence memory, one word a line.
[[nodiscard]] std::string primary_readmemh(const Image& image);
[[nodiscard]] std::string sequence_readmemh(const Image& image);

}  // namespace haptogram
