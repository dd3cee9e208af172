// Generated from tools/interface.toml by tools/generate_interface.py; edit the table, not this file.
// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>

namespace haptogram::interface {

inline constexpr std::string_view name = "Haptogram";
inline constexpr unsigned version_major = 2;
inline constexpr unsigned version_minor = 5;
inline constexpr std::uint32_t primary_base = 0x00000000;
inline constexpr unsigned primary_word_bits = 16;
inline constexpr std::uint32_t sequence_base = 0x10000000;
inline constexpr unsigned sequence_word_bits = 32;
inline constexpr std::uint32_t identity_base = 0x20000000;
inline constexpr unsigned identity_word_bits = 16;
inline constexpr std::uint32_t status_base = 0x30000000;
inline constexpr unsigned status_word_bits = 16;
inline constexpr std::uint32_t parameters_base = 0x50000000;
inline constexpr unsigned parameters_word_bits = 16;
inline constexpr std::uint32_t geometry_base = 0x60000000;
inline constexpr unsigned geometry_word_bits = 16;
inline constexpr std::uint32_t modulation_base = 0x70000000;
inline constexpr unsigned modulation_word_bits = 16;
inline constexpr std::uint32_t ring_base = 0x80000000;
inline constexpr unsigned ring_word_bits = 16;
inline constexpr std::uint32_t stream_base = 0x90000000;
inline constexpr unsigned stream_word_bits = 16;
inline constexpr std::uint32_t trigger_base = 0xa0000000;
inline constexpr unsigned trigger_word_bits = 16;
inline constexpr std::uint32_t description_base = 0x40000000;
inline constexpr unsigned description_word_bits = 16;
inline constexpr unsigned record_header_words = 4;
inline constexpr std::uint16_t silent_timing = 0xffff;  // a channel that never fires
inline constexpr std::uint16_t description_magic = 0x4748;
inline constexpr std::uint16_t description_format = 1;
inline constexpr std::uint16_t description_long_format = 2;
inline constexpr double longest_cycle_s = 1.0;

/// Some bits of a block of little-endian words of any width: `width` bits from bit `offset` on, counted from the block's
/// beginning. A field may reach over several words.
struct BitField {
    std::string_view name;
    unsigned offset, width;

    [[nodiscard]] constexpr std::uint32_t most() const { return static_cast<std::uint32_t>((std::uint64_t{1} << width) - 1U); }

    /// @param words  the block: a vector, an array, a span or a pointer, of 8, 16 or 32 bits each
    template <class Words>
    [[nodiscard]] constexpr std::uint32_t get(const Words& words) const {
        constexpr unsigned digits = std::numeric_limits<std::remove_cvref_t<decltype(words[0])>>::digits;
        std::uint64_t value = 0;
        for (unsigned done = 0; done < width;) {
            const unsigned low = (offset + done) % digits;
            value |= std::uint64_t{words[(offset + done) / digits]} >> low << done;
            done += digits - low;
        }
        return static_cast<std::uint32_t>(value & most());
    }

    /// @throws std::out_of_range when the value is wider than the field
    template <class Words>
    constexpr void set(Words&& words, std::uint64_t value) const {
        using Word = std::remove_cvref_t<decltype(words[0])>;
        constexpr unsigned digits = std::numeric_limits<Word>::digits;
        if (value > most())
            throw std::out_of_range(std::string(name) + " is " + std::to_string(value) + ", but its field has " +
                                    std::to_string(width) + " bits, at most " + std::to_string(most()));
        for (unsigned done = 0; done < width;) {
            const unsigned low = (offset + done) % digits;
            const std::uint64_t mask = std::uint64_t{most()} >> done << low;
            auto& word = words[(offset + done) / digits];
            word = static_cast<Word>((word & ~mask) | (value >> done << low & mask));
            done += digits - low;
        }
    }
};

namespace record_field {  // words of 16 bits
inline constexpr BitField cycle_length = {"cycle_length", 0, 24};  // carrier period in ticks
inline constexpr BitField pulse_length = {"pulse_length", 24, 8};  // length of each pulse in ticks
inline constexpr BitField prescaler = {"prescaler", 32, 24};  // clocks per tick
inline constexpr BitField kind = {"kind", 56, 8};  // what the channels' words mean
}  // namespace record_field

namespace sequence_header_field {  // words of 32 bits
inline constexpr BitField length = {"length", 0, 15};  // entries of the sequence
inline constexpr BitField autostart = {"autostart", 15, 1};  // 1: the image, in a bitstream or in flash, plays at power-up and after a reset of the FPGA, with outputs enabled and no watchdog, until a host sends a command that does more than ask
inline constexpr BitField loops = {"loops", 16, 16};  // how often it plays; 0 is for ever
}  // namespace sequence_header_field

namespace sequence_entry_field {  // words of 32 bits
inline constexpr BitField index = {"index", 0, 15};  // record to play; 0 is silence
inline constexpr BitField mark = {"mark", 15, 1};  // 1: its beginning is event `mark`; needs trigger
inline constexpr BitField dwell = {"dwell", 16, 16};  // carrier cycles to play; 0: until the next record is ready
}  // namespace sequence_entry_field

namespace identity_field {  // words of 16 bits
inline constexpr BitField version_minor = {"version_minor", 128, 8};  // grows with changes that old hosts may ignore
inline constexpr BitField version_major = {"version_major", 136, 8};  // grows with changes that break old hosts
inline constexpr BitField channels = {"channels", 144, 16};  // CHANNELS
inline constexpr BitField records = {"records", 160, 16};  // RECORDS
inline constexpr BitField sequence_depth = {"sequence_depth", 176, 16};  // SEQUENCE_DEPTH
inline constexpr BitField live_depth = {"live_depth", 192, 16};  // LIVE_DEPTH
inline constexpr BitField timing_bits = {"timing_bits", 208, 8};  // TIMING_BITS
inline constexpr BitField pulse_bits = {"pulse_bits", 216, 8};  // PULSE_BITS
inline constexpr BitField clock_hz = {"clock_hz", 224, 32};  // CLOCK_HZ
inline constexpr BitField features = {"features", 256, 16};  // see the feature bits
inline constexpr BitField frame_bytes = {"frame_bytes", 272, 16};  // longest frame that always fits, decoded, without CRC
inline constexpr BitField min_pulse_clocks = {"min_pulse_clocks", 288, 16};  // shortest pulse of a record, in clocks
inline constexpr BitField max_pulse_clocks = {"max_pulse_clocks", 304, 16};  // longest pulse of a record, in clocks
inline constexpr BitField max_duty_256 = {"max_duty_256", 320, 16};  // largest duty of a pulse, in 1/256
inline constexpr BitField max_cycle_clocks = {"max_cycle_clocks", 336, 32};  // longest cycle of a record, in clocks: one second
inline constexpr BitField width_bits = {"width_bits", 368, 16};  // WIDTH_BITS
inline constexpr BitField foci = {"foci", 384, 16};  // FOCI
inline constexpr BitField modulation_words = {"modulation_words", 400, 16};  // MODULATION_DEPTH / 2
}  // namespace identity_field

namespace status_field {  // words of 16 bits
inline constexpr BitField enabled = {"enabled", 0, 1};  // pulses reach the pins
inline constexpr BitField mode = {"mode", 1, 2};  // where the next record comes from: 0 nowhere (the last may still be playing), 1 SELECT, 2 sequence memory, 3 live FIFO
inline constexpr BitField stopped = {"stopped", 3, 1};  // the stop input is active: ENABLE is refused
inline constexpr BitField modulated = {"modulated", 4, 1};  // the modulation runs
inline constexpr BitField waiting = {"waiting", 5, 1};  // something waits behind a gate
inline constexpr BitField streaming = {"streaming", 6, 1};  // a stream plays (mode is live)
inline constexpr BitField flash = {"flash", 7, 2};  // image in the flash (SDRAM): 0 none, 1 whole, 2 broken: damaged, refused, or cut by a host
inline constexpr BitField present_index = {"present_index", 16, 16};  // record at the pins; 0 is silence
inline constexpr BitField underruns = {"underruns", 32, 16};  // changes and periods that were due before they were ready
inline constexpr BitField refused_records = {"refused_records", 48, 16};  // records that broke a limit
inline constexpr BitField frames_good = {"frames_good", 64, 16};  // frames that arrived whole
inline constexpr BitField frames_damaged = {"frames_damaged", 80, 16};  // frames dropped: CRC, framing, length or no room
inline constexpr BitField frames_repeated = {"frames_repeated", 96, 16};  // frames applied before
inline constexpr BitField watchdog_trips = {"watchdog_trips", 112, 16};  // times the host fell silent
inline constexpr BitField guard_trips = {"guard_trips", 128, 16};  // times a pin was high for too long
inline constexpr BitField live_level = {"live_level", 144, 16};  // indices waiting in the live FIFO
inline constexpr BitField watchdog_ms = {"watchdog_ms", 160, 16};  // watchdog time in ms; 0 is off
inline constexpr BitField frames_refused = {"frames_refused", 176, 16};  // good frames that were refused
inline constexpr BitField bent_periods = {"bent_periods", 192, 16};  // periods in which the slew limiter kept a channel from its target
inline constexpr BitField far_foci = {"far_foci", 208, 16};  // focus records with a focus too far from a channel
inline constexpr BitField role = {"role", 224, 2};  // 0 alone, 1 master, 2 slave of SYNC
inline constexpr BitField in_step = {"in_step", 226, 1};  // a slave's cycles begin with the master's; if not, its outputs are off
inline constexpr BitField numbered = {"numbered", 227, 1};  // a slave's periods have the master's numbers
inline constexpr BitField sync_misses = {"sync_misses", 240, 16};  // periods in which SYNC came late to a slave in step
inline constexpr BitField sync_losses = {"sync_losses", 256, 16};  // times a slave fell out of step; outputs then go off
inline constexpr BitField late_changes = {"late_changes", 272, 16};  // starts, modulations and pushes carried out when their carrier period had begun or was next; from here on: needs schedule
inline constexpr BitField period = {"period", 288, 32};  // carrier period at the pins when the answer begins; 0 before the first since reset
inline constexpr BitField period_high = {"period_high", 320, 16};  // bits 47…32
inline constexpr BitField stream_late = {"stream_late", 336, 16};  // too late patterns; from here on: needs stream
inline constexpr BitField stream_lost = {"stream_lost", 352, 16};  // lost periods
inline constexpr BitField stream_early = {"stream_early", 368, 16};  // too early patterns
inline constexpr BitField stream_repeated = {"stream_repeated", 384, 16};  // repeated patterns
}  // namespace status_field

namespace parameters_field {  // words of 16 bits
inline constexpr BitField foci_base = {"foci_base", 0, 16};  // start of focus records in primary memory, in units of four words
inline constexpr BitField foci_count = {"foci_count", 16, 16};  // number of focus records; the first has index RECORDS + 1
inline constexpr BitField foci_last = {"foci_last", 32, 3};  // foci per record, less one
inline constexpr BitField foci_whole = {"foci_whole", 35, 1};  // 1: all channels play at full amplitude
inline constexpr BitField foci_cycle = {"foci_cycle", 48, 16};  // carrier period of focus records in clocks; 40 kHz at power-up
inline constexpr BitField wave_number = {"wave_number", 64, 18};  // turns per 1/128 mm, times 2^27
inline constexpr BitField gain = {"gain", 96, 16};  // round(39953 / n) gives full amplitude where n full foci meet in phase
inline constexpr BitField slew = {"slew", 112, 2};  // 0: none (power-up); 1: at most phase_rate and amplitude_rate a period; 2: a new record's values are reached in `arrival` periods
inline constexpr BitField phase_rate = {"phase_rate", 128, 16};  // slew 1: phase change a period, in 1/65,536 turn; 65,535 at power-up
inline constexpr BitField amplitude_rate = {"amplitude_rate", 144, 16};  // slew 1: amplitude change a period; 65,535 is full, and at power-up
inline constexpr BitField arrival = {"arrival", 160, 12};  // slew 2: periods; 0 counts as 1
}  // namespace parameters_field

namespace ring_field {  // words of 16 bits
inline constexpr BitField base = {"base", 0, 16};  // start in primary memory, in units of four words
inline constexpr BitField first = {"first", 16, 16};  // index of the focus record at the base
inline constexpr BitField count = {"count", 32, 16};  // records; more than LIVE_DEPTH, so that none is overwritten before it plays; 0 at power-up
}  // namespace ring_field

namespace stream_field {  // words of 16 bits
inline constexpr BitField first = {"first", 0, 16};  // index of the record or focus record that is slot 0
inline constexpr BitField slot_bits = {"slot_bits", 16, 4};  // 2^slot_bits slots, at most STREAM; 0 (power-up): no streams
inline constexpr BitField hold = {"hold", 32, 16};  // lost periods that the last pattern bridges
inline constexpr BitField fade = {"fade", 48, 16};  // then amplitudes fall by so much a period; 65,535 is full; not 0
}  // namespace stream_field

namespace trigger_field {  // words of 16 bits
inline constexpr BitField event = {"event", 0, 3};  // none at power-up
inline constexpr BitField out_periods = {"out_periods", 16, 16};  // event `period`: carrier periods between events; 0 counts as 1
inline constexpr BitField out_length = {"out_length", 32, 24};  // clocks that a pulse lasts; 0 counts as 1
inline constexpr BitField in_low = {"in_low", 64, 1};  // the trigger input is active low
inline constexpr BitField in_level = {"in_level", 65, 1};  // 1: the active level triggers; 0: the change to it
inline constexpr BitField in_gates = {"in_gates", 66, 1};  // while the input is inactive all pins are low; playing goes on, and `enabled` stays 1
inline constexpr BitField in_least = {"in_least", 80, 16};  // clocks, beside the first, that a change of the input must last
inline constexpr BitField test = {"test", 96, 2};  // what the test output shows: 0 low (power-up), 1 `carrier`, the pin of test_channel; toggles when 2 `cycle`, a carrier cycle begins at the pins, 3 `index`, another record does
inline constexpr BitField test_channel = {"test_channel", 112, 16};  // channel of test `carrier`, in as many bits as a channel number needs
inline constexpr BitField now = {"now", 128, 32};  // clocks since power-up as the answer begins; all words from here on are of that moment
inline constexpr BitField now_high = {"now_high", 160, 16};  // bits 47…32
inline constexpr BitField out_count = {"out_count", 176, 16};  // events at the trigger output
inline constexpr BitField out = {"out", 192, 32};  // clock of the last event
inline constexpr BitField out_high = {"out_high", 224, 16};  // bits 47…32
inline constexpr BitField in_count = {"in_count", 240, 16};  // times the trigger input became active
inline constexpr BitField in = {"in", 256, 32};  // clock in which the trigger input last became active
inline constexpr BitField in_high = {"in_high", 288, 16};  // bits 47…32
}  // namespace trigger_field

namespace description_field {  // words of 16 bits
inline constexpr BitField magic = {"magic", 0, 16};  // 0x4748, the letters HG
inline constexpr BitField format = {"format", 16, 16};  // of this block: 1 for records and a sequence only, 2 with parameters, geometry or modulation
inline constexpr BitField channels = {"channels", 32, 16};  // the board's CHANNELS
inline constexpr BitField records = {"records", 48, 16};  // records in this image
inline constexpr BitField sequence_words = {"sequence_words", 64, 16};  // 32-bit words, including the header
inline constexpr BitField timing_bits = {"timing_bits", 80, 8};  // least TIMING_BITS of a board
inline constexpr BitField pulse_bits = {"pulse_bits", 88, 8};  // least PULSE_BITS of a board
inline constexpr BitField clock_hz = {"clock_hz", 96, 32};  // the board's CLOCK_HZ
inline constexpr BitField board_records = {"board_records", 128, 16};  // the board's RECORDS; from here on: format 2
inline constexpr BitField modulation_samples = {"modulation_samples", 144, 16};  // samples; 0 is no modulation
inline constexpr BitField modulation_divider = {"modulation_divider", 160, 16};  // carrier periods per sample
inline constexpr BitField min_pulse_clocks = {"min_pulse_clocks", 176, 16};  // the board's MIN_PULSE_CLOCKS
}  // namespace description_field

/// How a host deals with a line that loses bytes; rtl/INTERFACE.md says what each number means.
namespace link_policy {
inline constexpr unsigned window = 16;
inline constexpr unsigned patience_ms = 300;
inline constexpr unsigned most_patience_ms = 10000;
inline constexpr unsigned tries = 32;
inline constexpr unsigned lost_ms = 10000;
inline constexpr unsigned first_tries = 8;
inline constexpr unsigned most_strange = 4;
inline constexpr unsigned asking_bytes = 12;
inline constexpr unsigned keep_alive_ms = 100;
inline constexpr unsigned keep_alive_share = 5;
}  // namespace link_policy

/// What stands before each frame in a chain of tiles; rtl/INTERFACE.md says how it is used.
namespace chain {
inline constexpr unsigned all = 2;
inline constexpr unsigned most_tiles = 126;
}  // namespace chain

/// Where an image lies in the flash, in bytes; rtl/sdram/flash_image.v reads it.
namespace flash_image {
inline constexpr unsigned first = 0x100000;
inline constexpr unsigned bytes = 0x300000;
}  // namespace flash_image

/// Boards with a network port; rtl/INTERFACE.md says how they are spoken to.
namespace network {
inline constexpr unsigned port = 4807;
inline constexpr unsigned open_port = 4808;
inline constexpr unsigned datagram_bytes = 1472;
inline constexpr unsigned silence_ms = 1000;
inline constexpr unsigned patience_ms = 10;
inline constexpr unsigned window = 24;
}  // namespace network

enum class IdentityWord : unsigned {
    name_0 = 0,
    name_1 = 1,
    name_2 = 2,
    name_3 = 3,
    name_4 = 4,
    name_5 = 5,
    name_6 = 6,
    name_7 = 7,
    version = 8,
    channels = 9,
    records = 10,
    sequence_depth = 11,
    live_depth = 12,
    bits = 13,
    clock_hz_low = 14,
    clock_hz_high = 15,
    features = 16,
    frame_bytes = 17,
    min_pulse_clocks = 18,
    max_pulse_clocks = 19,
    max_duty_256 = 20,
    max_cycle_low = 21,
    max_cycle_high = 22,
    width_bits = 23,
    foci = 24,
    modulation_words = 25,
};
inline constexpr unsigned identity_words = 26;

enum class StatusWord : unsigned {
    flags = 0,
    present_index = 1,
    underruns = 2,
    refused_records = 3,
    frames_good = 4,
    frames_damaged = 5,
    frames_repeated = 6,
    watchdog_trips = 7,
    guard_trips = 8,
    live_level = 9,
    watchdog_ms = 10,
    frames_refused = 11,
    bent_periods = 12,
    far_foci = 13,
    sync = 14,
    sync_misses = 15,
    sync_losses = 16,
    late_changes = 17,
    period_low = 18,
    period_middle = 19,
    period_high = 20,
    stream_late = 21,
    stream_lost = 22,
    stream_early = 23,
    stream_repeated = 24,
};
inline constexpr unsigned status_words = 25;
inline constexpr unsigned status_untimed_words = 17;  // of boards without schedule
inline constexpr unsigned status_unstreamed_words = 21;  // of boards without stream

enum class ParametersWord : unsigned {
    foci_base = 0,
    foci_count = 1,
    foci_form = 2,
    foci_cycle = 3,
    wave_number_low = 4,
    wave_number_high = 5,
    gain = 6,
    slew_mode = 7,
    phase_rate = 8,
    amplitude_rate = 9,
    arrival_periods = 10,
};
inline constexpr unsigned parameters_words = 11;

enum class RingWord : unsigned {
    base = 0,
    first = 1,
    count = 2,
};
inline constexpr unsigned ring_words = 3;

enum class StreamWord : unsigned {
    first = 0,
    slot_form = 1,
    hold = 2,
    fade = 3,
};
inline constexpr unsigned stream_words = 4;

enum class TriggerWord : unsigned {
    out_form = 0,
    out_periods = 1,
    out_length_low = 2,
    out_length_high = 3,
    in_form = 4,
    in_least = 5,
    test_form = 6,
    test_channel = 7,
    now_low = 8,
    now_middle = 9,
    now_high = 10,
    out_count = 11,
    out_low = 12,
    out_middle = 13,
    out_high = 14,
    in_count = 15,
    in_low = 16,
    in_middle = 17,
    in_high = 18,
};
inline constexpr unsigned trigger_words = 19;
inline constexpr unsigned trigger_settings = 8;  // the first of them, which a host may write

enum class DescriptionWord : unsigned {
    magic = 0,
    format = 1,
    channels = 2,
    records = 3,
    sequence_words = 4,
    bits = 5,
    clock_hz_low = 6,
    clock_hz_high = 7,
    board_records = 8,
    modulation_samples = 9,
    modulation_divider = 10,
    min_pulse_clocks = 11,
};
inline constexpr unsigned description_words = 12;

/// Bits of the identity block's features.
enum class Feature : unsigned {
    sequence = 0,  // plays a sequence from its memory
    live = 1,  // takes indices while it plays
    watchdog = 2,  // switches outputs off when the host falls silent
    guard = 3,  // bounds how long a pin can be high
    amplitude = 4,  // plays records of amplitudes
    modulation = 5,  // multiplies amplitudes by samples from a memory
    slew = 6,  // limits how fast phases and amplitudes change
    foci = 7,  // computes phases and amplitudes from foci
    schedule = 8,  // counts carrier periods; changes can wait for one, or for the end of what plays
    live_foci = 9,  // takes foci while it plays
    stream = 10,  // takes a pattern for each carrier period
    trigger = 11,  // has trigger output, trigger input and test output
    sync = 12,  // keeps its cycles in step with other boards
    chain = 13,  // passes the serial line on to another board
    net = 14,  // is reached over Ethernet, not over a serial line
};
[[nodiscard]] constexpr bool has(std::uint32_t features, Feature feature) {
    return (features >> static_cast<unsigned>(feature) & 1U) != 0;
}

/// What the words of a record are.
enum class Kind : unsigned {
    timings = 0,  // tick at which the channel's pulse starts; 0xFFFF: no pulse
    amplitudes = 1,  // bits 7…0: where in the cycle the pulse's middle lies, in 1/256; bits 15…8: amplitude a, 255 is full: the pulse lasts asin(a / 255) / π of the cycle. A pulse shorter than MIN_PULSE_CLOCKS becomes none or MIN_PULSE_CLOCKS, whichever is nearer
};

/// Where the next record comes from.
enum class Mode : unsigned {
    idle = 0,  // nowhere; the last record may still be playing, until present_index is 0
    single = 1,  // the record that SELECT named
    sequence = 2,  // sequence memory
    live = 3,  // the live FIFO
};

/// How its carrier cycles are kept in step with other boards.
enum class Role : unsigned {
    alone = 0,  // keeps its own time
    master = 1,  // gives the time
    slave = 2,  // takes the time from SYNC
};

/// What became of the image in the flash.
enum class Flash : unsigned {
    none = 0,  // there is none, or a host came before it
    whole = 1,  // it was read, and plays if it has the autostart bit
    broken = 2,  // a frame of it was damaged or refused, or a host came while it was read: it does not play
};

/// What makes a pulse at the trigger output.
enum class Event : unsigned {
    none = 0,  // no pulses
    start = 1,  // outputs are on and a record other than silence begins to play
    mark = 2,  // a sequence entry with `mark` begins, with outputs on
    pass = 3,  // a pass of a sequence begins, with outputs on
    period = 4,  // every out_periods-th carrier period begins; the first is the one after the command
    samples = 5,  // the first carrier period begins after the first sample of a pass of the modulation was taken
};

/// What is at the test output.
enum class Test : unsigned {
    off = 0,  // low
    carrier = 1,  // the pin of test_channel
    cycle = 2,  // toggles when a carrier cycle begins at the pins
    index = 3,  // toggles with the first cycle of another record
};

enum class Command : std::uint8_t {
    identify = 0x01,
    write = 0x02,
    read = 0x03,
    enable = 0x04,
    disable = 0x05,
    select = 0x06,
    push = 0x07,
    start = 0x08,
    stop = 0x09,
    watchdog = 0x0a,
    status = 0x0b,
    digest = 0x0c,
    keep_alive = 0x0d,
    reset = 0x0e,
    modulate = 0x0f,
    gate = 0x10,
    push_foci = 0x11,
    stream = 0x12,
    sync = 0x18,
};

enum class Status : std::uint8_t {
    ok = 0x00,
    repeated = 0x01,
    unknown_command = 0x02,
    bad_length = 0x03,
    out_of_order = 0x04,
    bad_address = 0x05,
    bad_alignment = 0x06,
    bad_index = 0x07,
    bad_range = 0x08,
    fifo_full = 0x09,
    stopped = 0x0a,
    gate_busy = 0x0b,
    session_ended = 0x0c,
    out_of_step = 0x10,
};

/// Whether its reply carries data.
constexpr bool replies(Command command) {
    return command == Command::identify || command == Command::read || command == Command::status || command == Command::digest;
}

constexpr std::string_view to_string(Mode mode) {
    switch (mode) {
        case Mode::idle: return "idle";
        case Mode::single: return "single";
        case Mode::sequence: return "sequence";
        case Mode::live: return "live";
    }
    return "unknown";
}

constexpr std::string_view to_string(Role role) {
    switch (role) {
        case Role::alone: return "alone";
        case Role::master: return "master";
        case Role::slave: return "slave";
    }
    return "unknown";
}

constexpr std::string_view to_string(Flash flash) {
    switch (flash) {
        case Flash::none: return "none";
        case Flash::whole: return "whole";
        case Flash::broken: return "broken";
    }
    return "unknown";
}

constexpr std::string_view to_string(Event event) {
    switch (event) {
        case Event::none: return "none";
        case Event::start: return "start";
        case Event::mark: return "mark";
        case Event::pass: return "pass";
        case Event::period: return "period";
        case Event::samples: return "samples";
    }
    return "unknown";
}

constexpr std::string_view to_string(Test test) {
    switch (test) {
        case Test::off: return "off";
        case Test::carrier: return "carrier";
        case Test::cycle: return "cycle";
        case Test::index: return "index";
    }
    return "unknown";
}

constexpr std::string_view to_string(Command command) {
    switch (command) {
        case Command::identify: return "identify";
        case Command::write: return "write";
        case Command::read: return "read";
        case Command::enable: return "enable";
        case Command::disable: return "disable";
        case Command::select: return "select";
        case Command::push: return "push";
        case Command::start: return "start";
        case Command::stop: return "stop";
        case Command::watchdog: return "watchdog";
        case Command::status: return "status";
        case Command::digest: return "digest";
        case Command::keep_alive: return "keep_alive";
        case Command::reset: return "reset";
        case Command::modulate: return "modulate";
        case Command::gate: return "gate";
        case Command::push_foci: return "push_foci";
        case Command::stream: return "stream";
        case Command::sync: return "sync";
    }
    return "unknown";
}

constexpr std::string_view to_string(Status status) {
    switch (status) {
        case Status::ok: return "ok: applied";
        case Status::repeated: return "repeated: applied before: the number is one of the 128 before the expected one. Nothing was done again, but a command that only asks is answered anew, and disable and stop have acted";
        case Status::unknown_command: return "unknown_command: no such command";
        case Status::bad_length: return "bad_length: the frame is longer or shorter than its command says";
        case Status::out_of_order: return "out_of_order: a frame before it is missing (the number is one of the 127 after the expected one), or no session has begun since reset. Nothing was done, but disable and stop have acted. Send again from the expected number, or identify";
        case Status::bad_address: return "bad_address: outside the memory, or not writable";
        case Status::bad_alignment: return "bad_alignment: address or length is no multiple of the region's word";
        case Status::bad_index: return "bad_index: index above RECORDS, or above RECORDS + foci_count on boards with foci";
        case Status::bad_range: return "bad_range: start: entries outside 1…SEQUENCE_DEPTH−1, in the command or the sequence header; modulate: samples beyond MODULATION_DEPTH, or a first sample on a board without schedule; push, push_foci: they cannot wait for an end or the trigger; push_foci: the ring has LIVE_DEPTH records or fewer, or lies outside the focus records or primary memory; sync: no such role";
        case Status::fifo_full: return "fifo_full: the live FIFO has fewer free places than the frame has indices; nothing was pushed";
        case Status::stopped: return "stopped: the stop input is active; release it, then enable. A gate for the trigger is refused, too";
        case Status::gate_busy: return "gate_busy: something already waits for another carrier period; wait until it has begun, or stop";
        case Status::session_ended: return "session_ended: the session of this frame has ended, and no other has begun. Nothing was done, but disable and stop have acted. Report it, then identify; send nothing of that session again";
        case Status::out_of_step: return "out_of_step: the board is a slave and not in step with SYNC; look at its status, wait until it is, then enable";
    }
    return "unknown status";
}

/// The parameters of rtl/haptogram_core.v; rtl/INTERFACE.md says what each is.
struct CoreParameters {
    std::uint32_t channels = 100;
    std::uint32_t records = 400;
    std::uint32_t sequence_depth = 1024;
    std::uint32_t live_depth = 256;
    std::uint32_t timing_bits = 16;
    std::uint32_t pulse_bits = 8;
    std::uint32_t clock_hz = 50000000;
    std::uint32_t baud = 1000000;
    std::uint32_t watchdog_ms = 500;
    std::uint32_t max_high_clocks = 10000;
    std::uint32_t min_pulse_clocks = 5;
    std::uint32_t max_duty_256 = 128;
    std::uint32_t width_bits = 0;
    std::uint32_t modulation_depth = 0;
    std::uint32_t slew = 0;
    std::uint32_t foci = 0;
    std::uint32_t schedule = 0;
    std::uint32_t sync = 0;
    std::uint32_t chain = 0;
    std::uint32_t net = 0;
    std::uint32_t stream = 0;
    std::uint32_t trigger = 0;
    std::uint32_t sdram = 0;
    friend bool operator==(const CoreParameters&, const CoreParameters&) = default;
};

/// A parameter may be bounded by another one, or by another one divided by a number.
struct ParameterBound {
    std::uint32_t CoreParameters::* member = nullptr;  ///< none when null
    std::uint32_t divisor = 1;
};

/// One parameter of the core, as rtl/haptogram_core.v takes it.
struct ParameterDescription {
    std::string_view name;  ///< in Verilog and in board files
    std::uint32_t CoreParameters::* member;
    std::uint32_t low, high;
    ParameterBound at_least, at_most;
    bool power_of_two, optional;  ///< optional: 0 is allowed beside low to high

    /// The lowest and highest value beside the others of `core`.
    [[nodiscard]] constexpr std::uint32_t lowest(const CoreParameters& core) const {
        return at_least.member == nullptr ? low : std::max(low, core.*at_least.member / at_least.divisor);
    }
    [[nodiscard]] constexpr std::uint32_t highest(const CoreParameters& core) const {
        return at_most.member == nullptr ? high : std::min(high, core.*at_most.member / at_most.divisor);
    }
    [[nodiscard]] constexpr bool allows(const CoreParameters& core) const {
        const std::uint32_t value = core.*member;
        if (optional && value == 0) return true;
        return value >= lowest(core) && value <= highest(core) && (!power_of_two || std::has_single_bit(value));
    }
};

inline constexpr std::array<ParameterDescription, 23> core_parameters = {{
    {"CHANNELS", &CoreParameters::channels, 2, 1000, {}, {}, false, false},
    {"RECORDS", &CoreParameters::records, 1, 65534, {}, {}, false, false},
    {"SEQUENCE_DEPTH", &CoreParameters::sequence_depth, 2, 32767, {}, {}, false, false},
    {"LIVE_DEPTH", &CoreParameters::live_depth, 4, 32768, {}, {}, true, false},
    {"TIMING_BITS", &CoreParameters::timing_bits, 4, 16, {}, {}, false, false},
    {"PULSE_BITS", &CoreParameters::pulse_bits, 1, 8, {}, {&CoreParameters::timing_bits, 1}, false, false},
    {"CLOCK_HZ", &CoreParameters::clock_hz, 1000000, 1000000000, {}, {}, false, false},
    {"BAUD", &CoreParameters::baud, 1, 125000000, {&CoreParameters::clock_hz, 20000}, {&CoreParameters::clock_hz, 8}, false, false},
    {"WATCHDOG_MS", &CoreParameters::watchdog_ms, 0, 65535, {}, {}, false, false},
    {"MAX_HIGH_CLOCKS", &CoreParameters::max_high_clocks, 64, 16777215, {}, {}, false, false},
    {"MIN_PULSE_CLOCKS", &CoreParameters::min_pulse_clocks, 1, 65535, {}, {&CoreParameters::max_high_clocks, 10}, false, false},
    {"MAX_DUTY_256", &CoreParameters::max_duty_256, 1, 255, {}, {}, false, false},
    {"WIDTH_BITS", &CoreParameters::width_bits, 6, 16, {&CoreParameters::pulse_bits, 1}, {&CoreParameters::timing_bits, 1}, false, true},
    {"MODULATION_DEPTH", &CoreParameters::modulation_depth, 4, 65536, {}, {}, true, true},
    {"SLEW", &CoreParameters::slew, 0, 1, {}, {}, false, false},
    {"FOCI", &CoreParameters::foci, 8, 8, {}, {}, false, true},
    {"SCHEDULE", &CoreParameters::schedule, 0, 1, {}, {}, false, false},
    {"SYNC", &CoreParameters::sync, 0, 1, {}, {}, false, false},
    {"CHAIN", &CoreParameters::chain, 0, 1, {}, {}, false, false},
    {"NET", &CoreParameters::net, 0, 1, {}, {}, false, false},
    {"STREAM", &CoreParameters::stream, 4, 1024, {}, {}, true, true},
    {"TRIGGER", &CoreParameters::trigger, 0, 1, {}, {}, false, false},
    {"SDRAM", &CoreParameters::sdram, 4, 8, {}, {}, true, true},
}};

/// A named set of parameters.
struct CoreConfiguration {
    std::string_view name;
    CoreParameters parameters;
};

inline constexpr std::array<CoreConfiguration, 22> core_configurations = {{
    {"tile-100",
     {.channels = 100, .records = 400, .sequence_depth = 1024, .live_depth = 256, .timing_bits = 16, .pulse_bits = 8, .clock_hz = 50000000, .baud = 1000000, .watchdog_ms = 500, .max_high_clocks = 10000, .min_pulse_clocks = 5, .max_duty_256 = 128, .width_bits = 0, .modulation_depth = 0, .slew = 0, .foci = 0, .schedule = 0, .sync = 0, .chain = 0, .net = 0, .stream = 0, .trigger = 0, .sdram = 0}},
    {"small-16",
     {.channels = 16, .records = 40, .sequence_depth = 64, .live_depth = 16, .timing_bits = 12, .pulse_bits = 8, .clock_hz = 50000000, .baud = 3000000, .watchdog_ms = 5, .max_high_clocks = 20000, .min_pulse_clocks = 1, .max_duty_256 = 255, .width_bits = 0, .modulation_depth = 0, .slew = 0, .foci = 0, .schedule = 1, .sync = 0, .chain = 0, .net = 0, .stream = 0, .trigger = 1, .sdram = 0}},
    {"small-16-sync",
     {.channels = 16, .records = 40, .sequence_depth = 64, .live_depth = 16, .timing_bits = 12, .pulse_bits = 8, .clock_hz = 50000000, .baud = 3000000, .watchdog_ms = 5, .max_high_clocks = 20000, .min_pulse_clocks = 1, .max_duty_256 = 255, .width_bits = 0, .modulation_depth = 0, .slew = 0, .foci = 0, .schedule = 0, .sync = 1, .chain = 1, .net = 0, .stream = 0, .trigger = 0, .sdram = 0}},
    {"small-16-wide",
     {.channels = 16, .records = 256, .sequence_depth = 256, .live_depth = 256, .timing_bits = 11, .pulse_bits = 8, .clock_hz = 50000000, .baud = 3000000, .watchdog_ms = 5, .max_high_clocks = 20000, .min_pulse_clocks = 1, .max_duty_256 = 128, .width_bits = 10, .modulation_depth = 64, .slew = 1, .foci = 8, .schedule = 1, .sync = 0, .chain = 0, .net = 0, .stream = 0, .trigger = 0, .sdram = 0}},
    {"small-16-net",
     {.channels = 16, .records = 256, .sequence_depth = 256, .live_depth = 256, .timing_bits = 11, .pulse_bits = 8, .clock_hz = 50000000, .baud = 1000000, .watchdog_ms = 5, .max_high_clocks = 20000, .min_pulse_clocks = 1, .max_duty_256 = 128, .width_bits = 10, .modulation_depth = 64, .slew = 1, .foci = 8, .schedule = 1, .sync = 0, .chain = 0, .net = 1, .stream = 16, .trigger = 1, .sdram = 0}},
    {"small-16-sdram",
     {.channels = 16, .records = 40, .sequence_depth = 64, .live_depth = 16, .timing_bits = 12, .pulse_bits = 8, .clock_hz = 50000000, .baud = 3000000, .watchdog_ms = 5, .max_high_clocks = 20000, .min_pulse_clocks = 1, .max_duty_256 = 255, .width_bits = 0, .modulation_depth = 0, .slew = 0, .foci = 0, .schedule = 1, .sync = 0, .chain = 0, .net = 0, .stream = 0, .trigger = 1, .sdram = 4}},
    {"small-16-wide-sdram",
     {.channels = 16, .records = 256, .sequence_depth = 256, .live_depth = 256, .timing_bits = 11, .pulse_bits = 8, .clock_hz = 50000000, .baud = 3000000, .watchdog_ms = 5, .max_high_clocks = 20000, .min_pulse_clocks = 1, .max_duty_256 = 128, .width_bits = 10, .modulation_depth = 64, .slew = 1, .foci = 8, .schedule = 1, .sync = 0, .chain = 0, .net = 0, .stream = 0, .trigger = 0, .sdram = 4}},
    {"tile-100-wide",
     {.channels = 100, .records = 400, .sequence_depth = 1024, .live_depth = 256, .timing_bits = 11, .pulse_bits = 8, .clock_hz = 50000000, .baud = 1000000, .watchdog_ms = 500, .max_high_clocks = 10000, .min_pulse_clocks = 5, .max_duty_256 = 128, .width_bits = 10, .modulation_depth = 4096, .slew = 1, .foci = 8, .schedule = 1, .sync = 1, .chain = 1, .net = 0, .stream = 0, .trigger = 0, .sdram = 0}},
    {"tile-100-sync",
     {.channels = 100, .records = 400, .sequence_depth = 1024, .live_depth = 256, .timing_bits = 16, .pulse_bits = 8, .clock_hz = 50000000, .baud = 1000000, .watchdog_ms = 500, .max_high_clocks = 10000, .min_pulse_clocks = 5, .max_duty_256 = 128, .width_bits = 0, .modulation_depth = 0, .slew = 0, .foci = 0, .schedule = 1, .sync = 1, .chain = 0, .net = 0, .stream = 0, .trigger = 0, .sdram = 0}},
    {"unit-36",
     {.channels = 36, .records = 400, .sequence_depth = 1024, .live_depth = 256, .timing_bits = 16, .pulse_bits = 8, .clock_hz = 25600000, .baud = 1000000, .watchdog_ms = 500, .max_high_clocks = 10000, .min_pulse_clocks = 5, .max_duty_256 = 128, .width_bits = 0, .modulation_depth = 0, .slew = 0, .foci = 0, .schedule = 1, .sync = 1, .chain = 0, .net = 0, .stream = 0, .trigger = 0, .sdram = 0}},
    {"hoshi-324",
     {.channels = 324, .records = 400, .sequence_depth = 1024, .live_depth = 256, .timing_bits = 16, .pulse_bits = 8, .clock_hz = 50000000, .baud = 1000000, .watchdog_ms = 500, .max_high_clocks = 10000, .min_pulse_clocks = 5, .max_duty_256 = 128, .width_bits = 0, .modulation_depth = 0, .slew = 0, .foci = 0, .schedule = 0, .sync = 0, .chain = 0, .net = 0, .stream = 0, .trigger = 0, .sdram = 0}},
    {"wide-256",
     {.channels = 256, .records = 160, .sequence_depth = 1024, .live_depth = 256, .timing_bits = 16, .pulse_bits = 8, .clock_hz = 50000000, .baud = 1000000, .watchdog_ms = 500, .max_high_clocks = 10000, .min_pulse_clocks = 5, .max_duty_256 = 128, .width_bits = 0, .modulation_depth = 0, .slew = 0, .foci = 0, .schedule = 0, .sync = 0, .chain = 0, .net = 0, .stream = 0, .trigger = 0, .sdram = 0}},
    {"amplitudes-256",
     {.channels = 256, .records = 160, .sequence_depth = 1024, .live_depth = 256, .timing_bits = 11, .pulse_bits = 8, .clock_hz = 50000000, .baud = 1000000, .watchdog_ms = 500, .max_high_clocks = 10000, .min_pulse_clocks = 5, .max_duty_256 = 128, .width_bits = 10, .modulation_depth = 4096, .slew = 1, .foci = 8, .schedule = 0, .sync = 0, .chain = 0, .net = 0, .stream = 0, .trigger = 0, .sdram = 0}},
    {"tile-100-3m",
     {.channels = 100, .records = 400, .sequence_depth = 1024, .live_depth = 256, .timing_bits = 16, .pulse_bits = 8, .clock_hz = 50000000, .baud = 3000000, .watchdog_ms = 500, .max_high_clocks = 10000, .min_pulse_clocks = 5, .max_duty_256 = 128, .width_bits = 0, .modulation_depth = 0, .slew = 0, .foci = 0, .schedule = 0, .sync = 0, .chain = 0, .net = 0, .stream = 0, .trigger = 0, .sdram = 0}},
    {"colorlight-5a-75b-v8.0",
     {.channels = 56, .records = 600, .sequence_depth = 1024, .live_depth = 256, .timing_bits = 16, .pulse_bits = 8, .clock_hz = 50000000, .baud = 115200, .watchdog_ms = 500, .max_high_clocks = 10000, .min_pulse_clocks = 5, .max_duty_256 = 128, .width_bits = 0, .modulation_depth = 0, .slew = 0, .foci = 0, .schedule = 0, .sync = 0, .chain = 0, .net = 0, .stream = 0, .trigger = 0, .sdram = 0}},
    {"colorlight-5a-75e-v6.0",
     {.channels = 100, .records = 400, .sequence_depth = 1024, .live_depth = 256, .timing_bits = 16, .pulse_bits = 8, .clock_hz = 50000000, .baud = 115200, .watchdog_ms = 500, .max_high_clocks = 10000, .min_pulse_clocks = 5, .max_duty_256 = 128, .width_bits = 0, .modulation_depth = 0, .slew = 0, .foci = 0, .schedule = 0, .sync = 0, .chain = 0, .net = 0, .stream = 0, .trigger = 0, .sdram = 0}},
    {"colorlight-5a-75e-v7.1",
     {.channels = 100, .records = 400, .sequence_depth = 1024, .live_depth = 256, .timing_bits = 16, .pulse_bits = 8, .clock_hz = 50000000, .baud = 115200, .watchdog_ms = 500, .max_high_clocks = 10000, .min_pulse_clocks = 5, .max_duty_256 = 128, .width_bits = 0, .modulation_depth = 0, .slew = 0, .foci = 0, .schedule = 0, .sync = 0, .chain = 0, .net = 0, .stream = 0, .trigger = 0, .sdram = 0}},
    {"colorlight-5a-75e-v7.1-net",
     {.channels = 100, .records = 360, .sequence_depth = 1024, .live_depth = 256, .timing_bits = 11, .pulse_bits = 8, .clock_hz = 50000000, .baud = 1000000, .watchdog_ms = 500, .max_high_clocks = 10000, .min_pulse_clocks = 5, .max_duty_256 = 128, .width_bits = 10, .modulation_depth = 4096, .slew = 1, .foci = 8, .schedule = 1, .sync = 1, .chain = 0, .net = 1, .stream = 256, .trigger = 0, .sdram = 0}},
    {"colorlight-5a-75e-v7.1-sdram",
     {.channels = 100, .records = 16383, .sequence_depth = 1024, .live_depth = 256, .timing_bits = 11, .pulse_bits = 8, .clock_hz = 50000000, .baud = 1000000, .watchdog_ms = 500, .max_high_clocks = 10000, .min_pulse_clocks = 5, .max_duty_256 = 128, .width_bits = 10, .modulation_depth = 4096, .slew = 1, .foci = 8, .schedule = 1, .sync = 1, .chain = 0, .net = 1, .stream = 1024, .trigger = 0, .sdram = 4}},
    {"colorlight-5a-75e-v7.1-wide",
     {.channels = 100, .records = 400, .sequence_depth = 1024, .live_depth = 256, .timing_bits = 11, .pulse_bits = 8, .clock_hz = 50000000, .baud = 115200, .watchdog_ms = 500, .max_high_clocks = 10000, .min_pulse_clocks = 5, .max_duty_256 = 128, .width_bits = 10, .modulation_depth = 4096, .slew = 1, .foci = 8, .schedule = 0, .sync = 0, .chain = 0, .net = 0, .stream = 0, .trigger = 0, .sdram = 0}},
    {"ice40-hx8k-breakout",
     {.channels = 100, .records = 64, .sequence_depth = 256, .live_depth = 256, .timing_bits = 8, .pulse_bits = 8, .clock_hz = 48000000, .baud = 3000000, .watchdog_ms = 500, .max_high_clocks = 10000, .min_pulse_clocks = 5, .max_duty_256 = 128, .width_bits = 0, .modulation_depth = 0, .slew = 0, .foci = 0, .schedule = 0, .sync = 0, .chain = 0, .net = 0, .stream = 0, .trigger = 0, .sdram = 0}},
    {"ulx3s-85f",
     {.channels = 56, .records = 600, .sequence_depth = 1024, .live_depth = 256, .timing_bits = 16, .pulse_bits = 8, .clock_hz = 50000000, .baud = 3000000, .watchdog_ms = 500, .max_high_clocks = 10000, .min_pulse_clocks = 5, .max_duty_256 = 128, .width_bits = 0, .modulation_depth = 0, .slew = 0, .foci = 0, .schedule = 1, .sync = 1, .chain = 0, .net = 0, .stream = 0, .trigger = 1, .sdram = 0}},
}};

/// The configuration of this name; null when there is none.
[[nodiscard]] constexpr const CoreConfiguration* find_configuration(std::string_view wanted) {
    for (const CoreConfiguration& configuration : core_configurations)
        if (configuration.name == wanted) return &configuration;
    return nullptr;
}

}  // namespace haptogram::interface
