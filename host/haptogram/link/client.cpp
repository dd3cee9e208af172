// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/client.hpp"

#include <fmt/core.h>

#include <utility>

#include "haptogram/base/error.hpp"

namespace haptogram::link {
namespace {

using interface::Command;
namespace policy = interface::link_policy;

bool applied(const Reply& reply) {
    return reply.status == interface::Status::ok || reply.status == interface::Status::repeated;
}

}  // namespace

void Client::submit(Request request, std::function<void(const Reply&)> done) {
    queue_.push_back({std::move(request), std::move(done), {}});
}

void Client::submit(Request request, std::function<void(const Reply&)> done,
                    std::function<void(const Error&)> refused) {
    queue_.push_back({std::move(request), std::move(done), std::move(refused)});
}

void Client::wait(std::size_t most_unanswered) {
    while (queue_.size() > most_unanswered) exchange(patience_);
}

void Client::exchange(std::chrono::microseconds at_most) {
    transmit();
    const std::chrono::microseconds slice = std::min(at_most, patience_ - waited_);
    const Bytes bytes = transport_.read(slice);
    std::vector<Reply> arrived;
    decoder_.feed(bytes, arrived);
    for (const Reply& reply : arrived) take(reply);
    waited_ = bytes.empty() && !queue_.empty() ? waited_ + slice : std::chrono::microseconds(0);
    if (waited_ < patience_) return;
    waited_ = std::chrono::microseconds(0);
    const Command command = queue_.front().request.command;
    const unsigned most_tries = command == Command::identify ? policy::first_tries : policy::tries;
    if (++tries_ > most_tries) {
        forget();
        in_doubt_ = true;
        throw LinkLost(
            "board",
            fmt::format(
                "no answer to {} after {} tries; check the cable, the baud rate and that the board runs Haptogram; a "
                "tile of a chain is named by a # and its number behind the port",
                to_string(command), most_tries));
    }
    send_again();
}

void Client::transmit() {
    std::size_t asking = 0;
    for (std::size_t i = 0; i < sent_; ++i) asking += replies(queue_[i].request.command) ? 1 : 0;
    for (; sent_ < std::min<std::size_t>(queue_.size(), policy::window); ++sent_) {
        if (hold_ && hold_()) return;
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
    if (sent == on_line_.end()) return;  // an answer to an earlier user of the port
    const bool of_this_round = sent->round == round_;
    on_line_.erase(on_line_.begin(), sent + 1);
    const auto place = static_cast<std::uint8_t>(reply.sequence - next_);
    if (place >= std::min<std::size_t>(queue_.size(), policy::window) || reply.command != queue_[place].request.command)
        return;
    if (applied(reply)) {
        if (!finish_before(reply, place)) return;
        // An answer to a frame that has been sent again since then shows that sending again was too early.
        patience_ =
            of_this_round ? std::max(patience_ * 15 / 16, least_patience_) : std::min(2 * patience_, most_patience_);
        finish(reply);
    } else if (reply.status == interface::Status::out_of_order) {
        if (!of_this_round) return;  // it has been sent again since
        // A frame before it was lost. But nothing comes before the first of the queue: the device has forgotten us.
        if (place == 0 && ++strange_ > policy::most_strange) {
            forget();
            in_doubt_ = true;
            throw LinkLost("board", "it has lost the session, as after a reset; identify it again");
        }
        send_again();
    } else if (finish_before(reply, place)) {
        refuse(reply);
    }
}

/// A device applies requests in order, so those before one that it answered were applied, too, and only their replies
/// were lost. @return false when such a reply carried data and must be asked for again
bool Client::finish_before(const Reply& reply, std::size_t place) {
    for (std::size_t i = 0; i < place; ++i) {
        const Command command = queue_.front().request.command;
        if (replies(command)) {
            send_again();
            return false;
        }
        finish({next_, command, interface::Status::ok, reply.expected, reply.live_level, {}});
    }
    return true;
}

/// The first of the queue was refused. It was not applied, so its number is still to be used, and what was sent behind
/// it was not applied either.
void Client::refuse(const Reply& reply) {
    const Error error(ErrorCode::device, fmt::format("command {}", to_string(reply.command)),
                      fmt::format("the board refused it: {}", to_string(reply.status)));
    const auto refused = std::move(queue_.front().refused);
    if (!refused) {
        forget();
        throw error;
    }
    queue_.pop_front();
    sent_ = farthest_ = 0;
    ++round_;
    tries_ = strange_ = 0;
    refused(error);
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

void Client::drop() {
    // The device may have applied what was sent, so those requests keep their numbers until they are answered.
    queue_.erase(queue_.begin() + static_cast<std::ptrdiff_t>(farthest_), queue_.end());
    for (Pending& pending : queue_) {
        pending.done = {};
        pending.refused = [](const Error&) {};
    }
}

void Client::forget() {
    queue_.clear();
    on_line_.clear();
    sent_ = farthest_ = 0;
    tries_ = strange_ = 0;
    waited_ = std::chrono::microseconds(0);
}

void Client::make_ready() {
    if (in_doubt_) identify();
}

Identity Client::identify() {
    forget();
    if (in_doubt_) next_ = static_cast<std::uint8_t>(next_ + 128);  // far from what may still be under way
    in_doubt_ = true;
    transport_.write(Bytes{0});
    Bytes block;
    submit({Command::identify, {}}, [&block](const Reply& reply) { block = reply.data; });
    try {
        wait();
    } catch (...) {
        forget();
        throw;
    }
    in_doubt_ = false;
    identity_ = to_identity(block);
    most_asking_ = std::max<std::size_t>(1, identity_.frame_bytes / policy::asking_bytes);
    return identity_;
}

void Client::shut_off() {
    forget();
    transport_.discard_output();
    next_ = static_cast<std::uint8_t>(next_ + 128);
    in_doubt_ = true;
    transport_.write(Bytes{0});
    submit({Command::identify, {}});
    submit({Command::disable, {}});
    submit({Command::stop, {}}, [this](const Reply&) { in_doubt_ = false; });
    transmit();
}

}  // namespace haptogram::link
