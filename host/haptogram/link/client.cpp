// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/client.hpp"

#include <fmt/core.h>

#include <utility>

#include "haptogram/base/error.hpp"

namespace haptogram::link {
namespace {

using interface::Command;
using interface::Status;

constexpr std::size_t window = 16;  // frames under way
constexpr unsigned most_tries = 8;  // without any progress
constexpr unsigned most_strange = 4;
constexpr std::size_t asking_bytes = 12;  // that a request for data takes in the board's ring of frames

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

template <class Word>
std::uint16_t word_of(const Bytes& data, Word word) {
    const std::size_t at = 2 * static_cast<std::size_t>(word);
    if (at + 1 >= data.size())
        throw device_error("board", "its reply is too short; it speaks another version of the protocol");
    return static_cast<std::uint16_t>(data[at] | data[at + 1] << 8);
}

bool applied(const Reply& reply) { return reply.status == Status::ok || reply.status == Status::repeated; }

}  // namespace

void Client::submit(Request request, std::function<void(const Reply&)> done) {
    queue_.push_back({std::move(request), std::move(done)});
}

void Client::wait(std::size_t most_unanswered) {
    std::vector<Reply> arrived;
    while (queue_.size() > most_unanswered) {
        transmit();
        const Bytes bytes = transport_.read(patience_);
        arrived.clear();
        decoder_.feed(bytes, arrived);
        for (const Reply& reply : arrived) take(reply);
        if (!bytes.empty()) continue;
        if (++tries_ > most_tries) {
            const Command command = queue_.front().request.command;
            forget();
            in_doubt_ = true;
            throw LinkLost(
                "board",
                fmt::format(
                    "no answer to {} after {} tries; check the cable, the baud rate and that the board runs Haptogram",
                    to_string(command), most_tries));
        }
        send_again();
    }
}

void Client::transmit() {
    std::size_t asking = 0;
    for (std::size_t i = 0; i < sent_; ++i) asking += replies(queue_[i].request.command) ? 1 : 0;
    for (; sent_ < std::min(queue_.size(), window); ++sent_) {
        const Request& request = queue_[sent_].request;
        if (replies(request.command) && ++asking > most_asking_) return;
        const auto number = static_cast<std::uint8_t>(next_ + sent_);
        transport_.write(encode_request(number, request.command, request.payload));
        on_line_.push_back({number, round_});
        if (sent_ < farthest_) ++retransmissions_;
        farthest_ = std::max(farthest_, sent_ + 1);
    }
}

void Client::take(const Reply& reply) {
    const auto sent = std::ranges::find(on_line_, reply.sequence, &Sent::number);
    if (sent == on_line_.end()) return;  // an answer to somebody before us
    const bool of_this_round = sent->round == round_;
    on_line_.erase(on_line_.begin(), sent + 1);
    const auto place = static_cast<std::uint8_t>(reply.sequence - next_);
    if (place >= std::min(queue_.size(), window) || reply.command != queue_[place].request.command) return;
    if (applied(reply)) {
        // What lies before it was applied, too, and only its reply was lost.
        for (std::size_t i = 0; i < place; ++i) {
            const Request& before = queue_.front().request;
            if (replies(before.command)) return send_again();
            finish({next_, before.command, Status::ok, reply.expected, reply.live_level, {}});
        }
        // An answer to a frame that has been sent again since: that was too early.
        patience_ =
            of_this_round ? std::max(patience_ * 15 / 16, least_patience_) : std::min(2 * patience_, most_patience_);
        finish(reply);
    } else if (reply.status == Status::out_of_order) {
        if (!of_this_round) return;  // it has been sent again since
        // A frame before it was lost. But before the first of the queue there is none: the board knows nothing of us.
        if (place == 0 && ++strange_ > most_strange) {
            forget();
            in_doubt_ = true;
            throw LinkLost("board", "it has lost the session, as after a reset; identify it again");
        }
        send_again();
    } else {
        next_ = reply.sequence;  // it was not applied, so its number is still to be used
        forget();
        throw device_error(fmt::format("command {}", to_string(reply.command)),
                           fmt::format("the board refused it: {}", to_string(reply.status)));
    }
}

void Client::finish(const Reply& reply) {
    const Pending pending = std::move(queue_.front());
    queue_.pop_front();
    ++next_;
    sent_ -= sent_ > 0 ? 1 : 0;
    farthest_ -= farthest_ > 0 ? 1 : 0;
    tries_ = strange_ = 0;
    if (pending.done) pending.done(reply);
}

void Client::send_again() {
    sent_ = 0;
    ++round_;
    transport_.write(Bytes{0});  // ends whatever half frame the line left
}

void Client::forget() {
    queue_.clear();
    on_line_.clear();
    sent_ = farthest_ = 0;
    tries_ = strange_ = 0;
}

std::vector<Reply> Client::pipeline(std::vector<Request> requests, const Progress& progress) {
    std::vector<Reply> replies(requests.size());
    std::size_t done = 0;
    for (Request& request : requests) {
        submit(std::move(request), [&](const Reply& reply) {
            replies[done++] = reply;
            progress(static_cast<double>(done) / static_cast<double>(replies.size()));
        });
    }
    wait();
    return replies;
}

Reply Client::request(Request request) {
    if (in_doubt_ && request.command != Command::identify) identify();
    Reply answer;
    submit(std::move(request), [&](const Reply& reply) { answer = reply; });
    wait();
    return answer;
}

Identity Client::identify() {
    forget();
    if (in_doubt_) next_ = static_cast<std::uint8_t>(next_ + 128);  // far from what may still be under way
    transport_.write(Bytes{0});
    const Bytes data = request({Command::identify, {}}).data;
    in_doubt_ = false;
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
    most_asking_ = std::max<std::size_t>(1, identity.frame_bytes / asking_bytes);
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
    Bytes payload = little_endian(address & 0xffffU, address >> 16);
    payload.insert(payload.end(), bytes.begin(), bytes.end());
    request({Command::write, std::move(payload)});
}

Bytes Client::read(std::uint32_t address, std::uint16_t bytes) {
    Bytes payload = little_endian(address & 0xffffU, address >> 16);
    payload.push_back(static_cast<std::uint8_t>(bytes));
    payload.push_back(static_cast<std::uint8_t>(bytes >> 8));
    return request({Command::read, std::move(payload)}).data;
}

}  // namespace haptogram::link
