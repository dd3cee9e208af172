// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/commands.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "haptogram/base/error.hpp"

namespace haptogram::link {
namespace {

using interface::Command;

Error device_error(const std::string& message) { return {ErrorCode::device, "board", message}; }

void append(Bytes& bytes, std::uint32_t word) {
    bytes.push_back(static_cast<std::uint8_t>(word));
    bytes.push_back(static_cast<std::uint8_t>(word >> 8));
}

template <class... Words>
Bytes payload_of(Words... words) {
    Bytes bytes;
    (append(bytes, static_cast<std::uint32_t>(words)), ...);
    return bytes;
}

template <class Word>
std::uint16_t word_of(const Bytes& block, Word word) {
    const std::size_t at = 2 * static_cast<std::size_t>(word);
    if (at + 1 >= block.size()) throw device_error("its reply is too short; it speaks another version of the protocol");
    return static_cast<std::uint16_t>(block[at] | block[at + 1] << 8);
}

}  // namespace

std::string_view to_string(Mode mode) {
    constexpr std::string_view names[] = {"idle", "single", "sequence", "live"};
    return names[static_cast<unsigned>(mode) & 3U];
}

Identity to_identity(const Bytes& block) {
    using interface::IdentityWord;
    Identity identity;
    for (std::size_t i = 0; i < 16 && i < block.size() && block[i] != 0; ++i)
        identity.name += static_cast<char>(block[i]);
    const std::uint16_t version = word_of(block, IdentityWord::version);
    identity.version_major = version >> 8U;
    identity.version_minor = version & 0xffU;
    if (identity.name != interface::name || identity.version_major != interface::version_major)
        throw device_error(fmt::format("it says it is '{}' {}.{}, expected '{}' {}.x", identity.name,
                                       identity.version_major, identity.version_minor, interface::name,
                                       interface::version_major));
    identity.channels = word_of(block, IdentityWord::channels);
    identity.records = word_of(block, IdentityWord::records);
    identity.sequence_depth = word_of(block, IdentityWord::sequence_depth);
    identity.live_depth = word_of(block, IdentityWord::live_depth);
    identity.timing_bits = word_of(block, IdentityWord::bits) & 0xffU;
    identity.pulse_bits = word_of(block, IdentityWord::bits) >> 8U;
    identity.clock_hz = word_of(block, IdentityWord::clock_hz_low) |
                        static_cast<std::uint32_t>(word_of(block, IdentityWord::clock_hz_high)) << 16;
    identity.features = word_of(block, IdentityWord::features);
    identity.frame_bytes = word_of(block, IdentityWord::frame_bytes);
    return identity;
}

Status to_status(const Bytes& block) {
    using interface::StatusWord;
    const std::uint16_t flags = word_of(block, StatusWord::flags);
    return {.enabled = (flags & 1U) != 0,
            .mode = static_cast<Mode>(flags >> 1U & 3U),
            .present_index = word_of(block, StatusWord::present_index),
            .underruns = word_of(block, StatusWord::underruns),
            .refused_records = word_of(block, StatusWord::refused_records),
            .frames_good = word_of(block, StatusWord::frames_good),
            .frames_damaged = word_of(block, StatusWord::frames_damaged),
            .frames_repeated = word_of(block, StatusWord::frames_repeated),
            .frames_refused = word_of(block, StatusWord::frames_refused),
            .watchdog_trips = word_of(block, StatusWord::watchdog_trips),
            .guard_trips = word_of(block, StatusWord::guard_trips),
            .live_level = word_of(block, StatusWord::live_level),
            .watchdog_ms = word_of(block, StatusWord::watchdog_ms)};
}

Reply Commands::request(Request request) {
    make_ready();
    Reply answer;
    try {
        submit(std::move(request), [&answer](const Reply& reply) { answer = reply; });
        wait();
    } catch (...) {
        drop();  // nobody may tell of answers to variables that are gone
        throw;
    }
    return answer;
}

std::vector<Reply> Commands::pipeline(std::vector<Request> requests, const Progress& progress) {
    make_ready();
    std::vector<Reply> replies(requests.size());
    std::size_t done = 0;
    try {
        for (Request& request : requests) {
            submit(std::move(request), [&](const Reply& reply) {
                replies[done++] = reply;
                progress(static_cast<double>(done) / static_cast<double>(replies.size()));
            });
        }
        wait();
    } catch (...) {
        drop();
        throw;
    }
    return replies;
}

Status Commands::status() { return to_status(request({Command::status, {}}).data); }

void Commands::select(std::uint16_t index, std::uint16_t dwell) {
    request({Command::select, payload_of(index, dwell)});
}

std::uint16_t Commands::push(const std::vector<std::uint16_t>& indices, std::uint16_t dwell) {
    Bytes payload = payload_of(dwell);
    for (const std::uint16_t index : indices) append(payload, index);
    return request({Command::push, std::move(payload)}).live_level;
}

void Commands::start(std::uint16_t first, std::uint16_t length, std::uint16_t loops) {
    request({Command::start, payload_of(first, length, loops)});
}

void Commands::set_watchdog(std::uint16_t milliseconds) { request({Command::watchdog, payload_of(milliseconds)}); }

void Commands::write(std::uint32_t address, const Bytes& bytes) {
    Bytes payload = payload_of(address, address >> 16);
    payload.insert(payload.end(), bytes.begin(), bytes.end());
    request({Command::write, std::move(payload)});
}

Bytes Commands::read(std::uint32_t address, std::uint16_t bytes) {
    return request({Command::read, payload_of(address, address >> 16, bytes)}).data;
}

std::chrono::milliseconds keep_alive_pause(std::uint16_t watchdog_ms) {
    using namespace interface::link_policy;
    const unsigned within_watchdog = watchdog_ms / keep_alive_share + 1;
    return std::chrono::milliseconds(watchdog_ms == 0 ? keep_alive_ms : std::min(keep_alive_ms, within_watchdog));
}

}  // namespace haptogram::link
