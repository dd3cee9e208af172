// Generated from tools/interface.toml by tools/generate_interface.py; edit the table, not this file.
// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string_view>

namespace haptogram::interface {

inline constexpr std::string_view name = "Haptogram";
inline constexpr unsigned version_major = 1;
inline constexpr unsigned version_minor = 1;
inline constexpr std::uint32_t primary_base = 0x00000000;  // 16-bit words
inline constexpr std::uint32_t sequence_base = 0x10000000;  // 32-bit words
inline constexpr std::uint32_t identity_base = 0x20000000;  // 16-bit words
inline constexpr std::uint32_t status_base = 0x30000000;  // 16-bit words
inline constexpr std::uint32_t description_base = 0x40000000;  // 16-bit words
inline constexpr unsigned record_header_words = 4;
inline constexpr std::uint16_t silent_timing = 0xffff;
inline constexpr std::uint32_t autostart_bit = 1U << 15;  // of the sequence header

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
};
inline constexpr unsigned identity_words = 18;

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
};
inline constexpr unsigned status_words = 12;

enum class DescriptionWord : unsigned {
    magic = 0,
    format = 1,
    channels = 2,
    records = 3,
    sequence_words = 4,
    bits = 5,
    clock_hz_low = 6,
    clock_hz_high = 7,
};
inline constexpr unsigned description_words = 8;

enum class Feature : unsigned {
    sequence = 0,
    live = 1,
    watchdog = 2,
    guard = 3,
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
};

/// Whether its reply carries data.
constexpr bool replies(Command command) { return command == Command::identify || command == Command::read || command == Command::status || command == Command::digest; }

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
    }
    return "unknown";
}

constexpr std::string_view to_string(Status status) {
    switch (status) {
        case Status::ok: return "ok: applied";
        case Status::repeated: return "repeated: this sequence number was applied before; nothing was done again";
        case Status::unknown_command: return "unknown_command: no such command";
        case Status::bad_length: return "bad_length: the frame is longer or shorter than its command says";
        case Status::out_of_order: return "out_of_order: a frame before this one is missing, or no session was started since reset; send again from the expected sequence number, or identify";
        case Status::bad_address: return "bad_address: outside the memory, or not writable";
        case Status::bad_alignment: return "bad_alignment: address or length is no multiple of the region's word";
        case Status::bad_index: return "bad_index: index above RECORDS";
        case Status::bad_range: return "bad_range: sequence entries outside 1…SEQUENCE_DEPTH−1";
        case Status::fifo_full: return "fifo_full: fewer free places in the live FIFO than indices in the frame; nothing was pushed";
    }
    return "unknown status";
}

}  // namespace haptogram::interface
