// SPDX-License-Identifier: Apache-2.0
#include "link/client.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "base/error.hpp"

namespace haptogram::link {
namespace {

using interface::Command;
using interface::Status;

constexpr std::size_t window = 8;   // frames under way
constexpr unsigned most_tries = 8;  // without any progress
constexpr unsigned most_strange = 4;

Error device_error(const std::string& where, const std::string& message) { return {ErrorCode::device, where, message}; }

template <class... Words>
Bytes little_endian(Words... words) {
    Bytes bytes;
    for (const std::uint32_t word : {static_cast<std::uint32_t>(words)...}) {
        bytes.push_back(static_cast<std::uint8_t>(word));
        bytes.push_back(static_cast<std::uint8_t>(word >> 8));
    }
    return bytes;
}

Bytes at_address(std::uint32_t address) { return little_endian(address & 0xffffU, address >> 16); }

template <class Word>
std::uint16_t word_of(const Bytes& data, Word word) {
    const std::size_t at = 2 * static_cast<std::size_t>(word);
    if (at + 1 >= data.size())
        throw device_error("board", "its reply is too short; it speaks another version of the protocol");
    return static_cast<std::uint16_t>(data[at] | data[at + 1] << 8);
}

/// What one frame carries of an image.
struct Piece {
    std::uint32_t address;
    Bytes bytes;
};

/// An image in frames: a record each, and the sequence in pieces as long.
std::vector<Piece> pieces_of(const Image& image) {
    std::vector<Piece> pieces;
    const std::size_t stride = record_words(image.channels);
    const std::vector<std::uint16_t> primary = primary_words(image);
    for (std::size_t at = 0; at < primary.size(); at += stride) {
        Piece& piece = pieces.emplace_back(Piece{interface::primary_base + static_cast<std::uint32_t>(2 * at), {}});
        for (std::size_t i = at; i < at + stride; ++i)
            for (const unsigned shift : {0U, 8U}) piece.bytes.push_back(static_cast<std::uint8_t>(primary[i] >> shift));
    }
    const std::vector<std::uint32_t> sequence = sequence_words(image);
    for (std::size_t at = 0; at < sequence.size(); at += stride / 2) {
        Piece& piece = pieces.emplace_back(Piece{interface::sequence_base + static_cast<std::uint32_t>(4 * at), {}});
        for (std::size_t i = at; i < std::min(at + stride / 2, sequence.size()); ++i)
            for (const unsigned shift : {0U, 8U, 16U, 24U})
                piece.bytes.push_back(static_cast<std::uint8_t>(sequence[i] >> shift));
    }
    return pieces;
}

bool applied(const Reply& reply) { return reply.status == Status::ok || reply.status == Status::repeated; }

}  // namespace

std::vector<Reply> Client::pipeline(const std::vector<Request>& requests, const std::function<void(double)>& progress) {
    std::vector<Reply> replies(requests.size());
    const std::uint8_t first = next_;
    const auto sequence_of = [first](std::size_t i) { return static_cast<std::uint8_t>(first + i); };
    std::size_t acknowledged = 0;
    std::size_t sent = 0;
    std::size_t farthest = 0;
    unsigned tries = 0;
    unsigned strange = 0;
    while (acknowledged < requests.size()) {
        for (; sent < requests.size() && sent < acknowledged + window; ++sent) {
            transport_.write(encode_request(sequence_of(sent), requests[sent].command, requests[sent].payload));
            if (sent < farthest) ++retransmissions_;
            farthest = std::max(farthest, sent + 1);
        }
        std::vector<Reply> arrived;
        const Bytes bytes = transport_.read(patience_);
        decoder_.feed(bytes, arrived);
        bool again = bytes.empty();
        for (Reply& reply : arrived) {
            const std::size_t i = acknowledged;
            if (i == requests.size()) break;
            const bool mine = reply.sequence == sequence_of(i) && reply.command == requests[i].command;
            if (mine && applied(reply)) {
                if (reply.status == Status::repeated) patience_ = std::min(2 * patience_, most_patience_);
                replies[i] = std::move(reply);
                ++acknowledged;
                tries = 0;
                strange = 0;
                if (progress) progress(static_cast<double>(acknowledged) / static_cast<double>(requests.size()));
            } else if (mine && reply.status != Status::out_of_order) {
                next_ = sequence_of(i);
                throw device_error(fmt::format("command {}", to_string(requests[i].command)),
                                   fmt::format("the board refused it: {}", to_string(reply.status)));
            } else if (reply.status == Status::out_of_order) {
                // A frame before it was lost. But before the first that is not acknowledged there is none: one such
                // answer may be left over from an earlier round, several mean that the board knows nothing of us.
                if (mine && ++strange > most_strange)
                    throw device_error("board", "it has lost the session, as after a reset; identify it again");
                again = true;
            }
        }
        if (!again) continue;
        if (++tries > most_tries)
            throw device_error(
                "board",
                fmt::format(
                    "no answer to {} after {} tries; check the cable, the baud rate and that the board runs Haptogram",
                    to_string(requests[acknowledged].command), most_tries));
        sent = acknowledged;
        while (!transport_.read(std::chrono::microseconds(0)).empty()) {
        }
        transport_.write(Bytes{0});  // ends whatever half frame the line left
    }
    next_ = sequence_of(requests.size());
    return replies;
}

Reply Client::request(const Request& request) { return pipeline({request}).front(); }

Identity Client::identify() {
    transport_.write(Bytes{0});
    const Bytes data = request({Command::identify, {}}).data;
    using interface::IdentityWord;
    Identity identity;
    for (std::size_t i = 0; i < 16 && i < data.size() && data[i] != 0; ++i) identity.name += static_cast<char>(data[i]);
    const std::uint16_t version = word_of(data, IdentityWord::version);
    identity.version_major = version >> 8U;
    identity.version_minor = version & 0xffU;
    if (identity.name != interface::name || identity.version_major != interface::version_major)
        throw device_error(
            "board", fmt::format("it says it is '{}' {}.{}, expected '{}' {}.x", identity.name, identity.version_major,
                                 identity.version_minor, interface::name, interface::version_major));
    identity.channels = word_of(data, IdentityWord::channels);
    identity.records = word_of(data, IdentityWord::records);
    identity.sequence_depth = word_of(data, IdentityWord::sequence_depth);
    identity.live_depth = word_of(data, IdentityWord::live_depth);
    identity.timing_bits = word_of(data, IdentityWord::bits) & 0xffU;
    identity.pulse_bits = word_of(data, IdentityWord::bits) >> 8U;
    identity.clock_hz = word_of(data, IdentityWord::clock_hz_low) |
                        static_cast<std::uint32_t>(word_of(data, IdentityWord::clock_hz_high)) << 16;
    identity.features = word_of(data, IdentityWord::features);
    identity.frame_bytes = word_of(data, IdentityWord::frame_bytes);
    return identity;
}

BoardStatus Client::status() {
    const Bytes data = request({Command::status, {}}).data;
    using interface::StatusWord;
    const std::uint16_t flags = word_of(data, StatusWord::flags);
    return {.enabled = (flags & 1U) != 0,
            .mode = flags >> 1U & 3U,
            .present_index = word_of(data, StatusWord::present_index),
            .underruns = word_of(data, StatusWord::underruns),
            .refused_records = word_of(data, StatusWord::refused_records),
            .frames_good = word_of(data, StatusWord::frames_good),
            .frames_damaged = word_of(data, StatusWord::frames_damaged),
            .frames_repeated = word_of(data, StatusWord::frames_repeated),
            .frames_refused = word_of(data, StatusWord::frames_refused),
            .watchdog_trips = word_of(data, StatusWord::watchdog_trips),
            .guard_trips = word_of(data, StatusWord::guard_trips),
            .live_level = word_of(data, StatusWord::live_level),
            .watchdog_ms = word_of(data, StatusWord::watchdog_ms)};
}

void Client::select(std::uint16_t index, std::uint16_t dwell) {
    request({Command::select, little_endian(index, dwell)});
}

std::uint16_t Client::push(const std::vector<std::uint16_t>& indices, std::uint16_t dwell) {
    Bytes payload = little_endian(dwell);
    for (const std::uint16_t index : indices) {
        payload.push_back(static_cast<std::uint8_t>(index));
        payload.push_back(static_cast<std::uint8_t>(index >> 8));
    }
    return request({Command::push, std::move(payload)}).live_level;
}

void Client::start(std::uint16_t first, std::uint16_t length, std::uint16_t loops) {
    request({Command::start, little_endian(first, length, loops)});
}

void Client::set_watchdog(std::uint16_t milliseconds) { request({Command::watchdog, little_endian(milliseconds)}); }

void Client::write(std::uint32_t address, const Bytes& bytes) {
    Bytes payload = at_address(address);
    payload.insert(payload.end(), bytes.begin(), bytes.end());
    request({Command::write, std::move(payload)});
}

Bytes Client::read(std::uint32_t address, std::uint16_t bytes) {
    Bytes payload = at_address(address);
    payload.push_back(static_cast<std::uint8_t>(bytes));
    payload.push_back(static_cast<std::uint8_t>(bytes >> 8));
    return request({Command::read, std::move(payload)}).data;
}

void Client::upload(const Image& image, const std::function<void(double)>& progress) {
    std::vector<Request> requests;
    for (const auto& [address, bytes] : pieces_of(image)) {
        Bytes payload = at_address(address);
        payload.insert(payload.end(), bytes.begin(), bytes.end());
        requests.push_back({Command::write, std::move(payload)});
    }
    pipeline(requests, progress);
}

std::string Client::compare(const Image& image, const std::function<void(double)>& progress) {
    const std::vector<Piece> pieces = pieces_of(image);
    std::vector<Request> requests;
    for (const auto& [address, bytes] : pieces) {
        Bytes payload = at_address(address);
        for (const std::uint8_t byte : little_endian(bytes.size())) payload.push_back(byte);
        requests.push_back({Command::read, std::move(payload)});
    }
    const std::vector<Reply> replies = pipeline(requests, progress);
    for (std::size_t i = 0; i < pieces.size(); ++i) {
        const auto [expected, found] = std::ranges::mismatch(pieces[i].bytes, replies[i].data);
        if (expected == pieces[i].bytes.end() && found == replies[i].data.end()) continue;
        const auto at = static_cast<std::uint32_t>(expected - pieces[i].bytes.begin());
        return fmt::format("the board's memory differs at address {:#010x}", pieces[i].address + at);
    }
    return {};
}

void require_fits(const Image& image, const Identity& board, const std::string& where) {
    const auto require = [&](bool fits, const std::string& what) {
        if (!fits)
            throw bad_input(where, what + "; compile it for this board (--array), or use the board it was made for");
    };
    require(image.channels == board.channels,
            fmt::format("the image is for {} channels, the board has {}", image.channels, board.channels));
    require(image.clock_hz == board.clock_hz,
            fmt::format("the image is for a {} Hz clock, the board has {} Hz", image.clock_hz, board.clock_hz));
    require(image.timing_bits <= board.timing_bits,
            fmt::format("the image needs {} timing bits, the board has {}", image.timing_bits, board.timing_bits));
    require(image.pulse_bits <= board.pulse_bits,
            fmt::format("the image needs {} pulse bits, the board has {}", image.pulse_bits, board.pulse_bits));
    require(image.records.size() <= board.records,
            fmt::format("the image has {} records, the board holds {}", image.records.size(), board.records));
    require(image.sequence.size() < board.sequence_depth,
            fmt::format("the image has {} sequence entries, the board holds {}", image.sequence.size(),
                        board.sequence_depth - 1));
}

}  // namespace haptogram::link
