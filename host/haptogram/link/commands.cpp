// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/commands.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/base/text.hpp"
#include "haptogram/link/transport.hpp"

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

Bytes followed_by(Bytes payload, std::span<const std::uint16_t> words) {
    payload.reserve(payload.size() + 2 * words.size());
    for (const std::uint16_t word : words) append(payload, word);
    return payload;
}

/// @throws Error{device} when a block is too short to be taken apart
void require_words(const Bytes& block, unsigned words) {
    if (block.size() < std::size_t{2} * words)
        throw device_error(
            fmt::format("its reply is too short, {} bytes instead of {}; it speaks another version of "
                        "the protocol",
                        block.size(), 2 * words));
}

/// A board that lied here would have buffers of no length and divisions by 0 made for it.
void require_possible(const Identity& identity) {
    const interface::CoreParameters core = identity.core();
    for (const interface::ParameterDescription& one : interface::core_parameters) {
        using Core = interface::CoreParameters;
        if (one.member == &Core::baud || one.member == &Core::watchdog_ms || one.member == &Core::max_high_clocks)
            continue;  // it does not tell them
        if (!one.allows(core))
            throw device_error(fmt::format("it says that its {} is {}, expected {} to {}{}{}; is it a Haptogram?",
                                           one.name, core.*one.member, one.lowest(core), one.highest(core),
                                           one.power_of_two ? ", a power of two" : "", one.optional ? ", or 0" : ""));
    }
    const std::uint32_t least_frame = 2 * (identity.channels + interface::record_header_words) + 6;
    const auto require = [](const char* name, std::uint32_t value, std::uint32_t least, std::uint32_t most) {
        if (value < least || value > most)
            throw device_error(fmt::format("it says that its {} is {}, expected {} to {}; is it a Haptogram?", name,
                                           value, least, most));
    };
    require("frame_bytes", identity.frame_bytes, least_frame, 0xffff);
    require("max_pulse_clocks", identity.max_pulse_clocks, 1, 0xffff);
    require("max_cycle_clocks", identity.max_cycle_clocks, 1, identity.clock_hz);
}

}  // namespace

std::size_t expected_bytes(const Request& request, const Identity& identity) {
    switch (request.command) {
        case Command::identify: return std::size_t{2} * interface::identity_words;
        case Command::status:
            return std::size_t{2} * (interface::has(identity.features, interface::Feature::stream)
                                         ? interface::status_words
                                     : interface::has(identity.features, interface::Feature::schedule)
                                         ? interface::status_unstreamed_words
                                         : interface::status_untimed_words);
        case Command::digest: return 4;
        case Command::read: return request.payload.size() < 6 ? 0 : request.payload[4] | request.payload[5] << 8U;
        default: return 0;
    }
}

Identity to_identity(const Bytes& block) {
    namespace field = interface::identity_field;
    // Name and version come first in every version of the protocol; what follows them may be shorter in another one.
    require_words(block, field::version_major.offset / 16 + 1);
    Identity identity;
    for (std::size_t i = 0; i < 16 && block[i] != 0; ++i) identity.name += static_cast<char>(block[i]);
    identity.version_major = field::version_major.get(block);
    identity.version_minor = field::version_minor.get(block);
    if (identity.name != interface::name || identity.version_major != interface::version_major)
        throw device_error(fmt::format("it says it is '{}' {}.{}, expected '{}' {}.x", printable(identity.name),
                                       identity.version_major, identity.version_minor, interface::name,
                                       interface::version_major));
    if (block.size() != std::size_t{2} * interface::identity_words)
        throw device_error(fmt::format("its identity has {} bytes, expected {}; is it a Haptogram of version {}.{}?",
                                       block.size(), 2 * interface::identity_words, interface::version_major,
                                       interface::version_minor));
    identity.channels = field::channels.get(block);
    identity.records = field::records.get(block);
    identity.sequence_depth = field::sequence_depth.get(block);
    identity.live_depth = field::live_depth.get(block);
    identity.timing_bits = field::timing_bits.get(block);
    identity.pulse_bits = field::pulse_bits.get(block);
    identity.clock_hz = field::clock_hz.get(block);
    identity.features = field::features.get(block);
    identity.frame_bytes = field::frame_bytes.get(block);
    identity.min_pulse_clocks = field::min_pulse_clocks.get(block);
    identity.max_pulse_clocks = field::max_pulse_clocks.get(block);
    identity.max_duty_256 = field::max_duty_256.get(block);
    identity.max_cycle_clocks = field::max_cycle_clocks.get(block);
    identity.width_bits = field::width_bits.get(block);
    identity.foci = field::foci.get(block);
    identity.modulation_words = field::modulation_words.get(block);
    require_possible(identity);
    return identity;
}

void require_sound(const Reply& reply, const Request& request, const Identity& identity) {
    const std::size_t expected = expected_bytes(request, identity);
    // Another version may describe itself at another length; to_identity() says so, or takes what it knows.
    if (request.command != Command::identify && reply.data.size() != expected)
        throw device_error(fmt::format("its reply to {} has {} bytes of data, expected {}; is it a Haptogram?",
                                       to_string(request.command), reply.data.size(), expected));
    if (request.command == Command::identify) return;
    const std::uint32_t level = std::max<std::uint32_t>(
        reply.live_level, request.command == Command::status ? to_status(reply.data).live_level : 0);
    if (level > identity.live_depth)
        throw device_error(
            fmt::format("it says that {} indices wait in its live FIFO, expected 0 to {}", level, identity.live_depth));
}

Status to_status(const Bytes& block) {
    namespace field = interface::status_field;
    require_words(block, interface::status_untimed_words);
    const bool timed = block.size() >= std::size_t{2} * interface::status_unstreamed_words;
    const bool streamed = block.size() >= std::size_t{2} * interface::status_words;
    if (const auto role = field::role.get(block); role > static_cast<unsigned>(Role::slave))
        throw device_error(fmt::format("it says that its role is {}, expected 0 to 2; is it a Haptogram?", role));
    if (const auto flash = field::flash.get(block); flash > static_cast<unsigned>(Flash::broken))
        throw device_error(fmt::format("it says that its flash is {}, expected 0 to 2; is it a Haptogram?", flash));
    const auto word = [&block](const interface::BitField& f) { return static_cast<std::uint16_t>(f.get(block)); };
    return {.enabled = field::enabled.get(block) != 0,
            .stopped = field::stopped.get(block) != 0,
            .modulated = field::modulated.get(block) != 0,
            .waiting = field::waiting.get(block) != 0,
            .mode = static_cast<Mode>(field::mode.get(block)),
            .present_index = word(field::present_index),
            .underruns = word(field::underruns),
            .refused_records = word(field::refused_records),
            .frames_good = word(field::frames_good),
            .frames_damaged = word(field::frames_damaged),
            .frames_repeated = word(field::frames_repeated),
            .frames_refused = word(field::frames_refused),
            .watchdog_trips = word(field::watchdog_trips),
            .guard_trips = word(field::guard_trips),
            .bent_periods = word(field::bent_periods),
            .far_foci = word(field::far_foci),
            .role = static_cast<Role>(field::role.get(block)),
            .in_step = field::in_step.get(block) != 0,
            .numbered = field::numbered.get(block) != 0,
            .sync_misses = word(field::sync_misses),
            .sync_losses = word(field::sync_losses),
            .live_level = word(field::live_level),
            .watchdog_ms = word(field::watchdog_ms),
            .late_changes = timed ? word(field::late_changes) : std::uint16_t{0},
            .period = timed ? std::optional(std::uint64_t{field::period_high.get(block)} << field::period.width |
                                            field::period.get(block))
                            : std::nullopt,
            .stream = streamed ? std::optional(StreamCounts{.playing = field::streaming.get(block) != 0,
                                                            .late = word(field::stream_late),
                                                            .lost = word(field::stream_lost),
                                                            .early = word(field::stream_early),
                                                            .repeated = word(field::stream_repeated)})
                               : std::nullopt,
            .flash = static_cast<Flash>(field::flash.get(block))};
}

When When::at_period(std::uint64_t period) {
    if (period == 0 || period >= at_trigger().gate)
        throw bad_argument("period", fmt::format("{}, expected 1 to {}", period, at_trigger().gate - 1));
    return {period};
}

Request write_request(std::uint32_t address, std::span<const std::uint16_t> words) {
    return {Command::write, followed_by(payload_of(address, address >> 16), words)};
}

Request write_request(std::uint32_t address, const Bytes& bytes) {
    Bytes payload = payload_of(address, address >> 16);
    payload.insert(payload.end(), bytes.begin(), bytes.end());
    return {Command::write, std::move(payload)};
}

Request asking_request(Command command, std::uint32_t address, std::size_t bytes) {
    return {command, payload_of(address, address >> 16, bytes)};
}

Request push_request(std::span<const std::uint16_t> indices, std::uint16_t dwell) {
    return {Command::push, followed_by(payload_of(dwell), indices)};
}

Request push_foci_request(std::span<const std::uint16_t> words, std::uint16_t dwell) {
    return {Command::push_foci, followed_by(payload_of(dwell), words)};
}

Request select_request(std::uint16_t index, std::uint16_t dwell) { return {Command::select, payload_of(index, dwell)}; }

Request start_request(std::uint16_t first, std::uint16_t length, std::uint16_t loops) {
    return {Command::start, payload_of(first, length, loops)};
}

Request gate_request(When when) { return {Command::gate, payload_of(when.gate, when.gate >> 16, when.gate >> 32)}; }

Request modulate_request(std::uint16_t divider, std::uint16_t length, bool loop, std::uint32_t first) {
    if (first % 2 != 0 || first > 0xffff)
        throw bad_argument("first", fmt::format("sample {}, expected an even number up to 65534", first));
    return {Command::modulate, payload_of(divider, length, first | (loop ? 1U : 0U))};
}

Request watchdog_request(std::uint16_t milliseconds) { return {Command::watchdog, payload_of(milliseconds)}; }

Request stream_request(std::uint64_t period, std::span<const std::uint16_t> patterns) {
    return {Command::stream, followed_by(payload_of(period, period >> 16, period >> 32), patterns)};
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

void Commands::select(std::uint16_t index, std::uint16_t dwell) { request(select_request(index, dwell)); }

Reply Commands::request(Request wanted, When when) {
    if (when == When::at_once()) return request(std::move(wanted));
    if (!interface::has(identity().features, interface::Feature::schedule))
        throw device_error("its changes cannot wait; that takes a board with the parameter SCHEDULE");
    if (when == When::at_trigger() && !interface::has(identity().features, interface::Feature::trigger))
        throw device_error("it has no trigger input; that takes a board with the parameter TRIGGER");
    request(gate_request(when));
    try {
        return request(std::move(wanted));
    } catch (const LinkLost&) {
        throw;
    } catch (const Error&) {
        request(gate_request(When::at_once()));  // or the next command would wait in the place of this one
        throw;
    }
}

std::uint16_t Commands::push(const std::vector<std::uint16_t>& indices, std::uint16_t dwell, When when) {
    return request(push_request(indices, dwell), when).live_level;
}

std::uint16_t Commands::push_foci(std::span<const std::uint16_t> words, std::uint16_t dwell) {
    return request(push_foci_request(words, dwell)).live_level;
}

void Commands::start(std::uint16_t first, std::uint16_t length, std::uint16_t loops, When when) {
    request(start_request(first, length, loops), when);
}

void Commands::modulate(std::uint16_t divider, std::uint16_t length, bool loop, std::uint32_t first, When when) {
    request(modulate_request(divider, length, loop, first), when);
}

void Commands::set_watchdog(std::uint16_t milliseconds) { request(watchdog_request(milliseconds)); }

void Commands::set_role(Role role) { request({Command::sync, payload_of(static_cast<std::uint16_t>(role))}); }

void Commands::write(std::uint32_t address, const Bytes& bytes) { request(write_request(address, bytes)); }

Bytes Commands::read(std::uint32_t address, std::uint16_t bytes) {
    return request(asking_request(Command::read, address, bytes)).data;
}

std::chrono::milliseconds keep_alive_pause(std::uint16_t watchdog_ms) {
    using namespace interface::link_policy;
    const unsigned within_watchdog = watchdog_ms / keep_alive_share + 1;
    return std::chrono::milliseconds(watchdog_ms == 0 ? keep_alive_ms : std::min(keep_alive_ms, within_watchdog));
}

}  // namespace haptogram::link
