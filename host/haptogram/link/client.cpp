// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/client.hpp"

#include <fmt/core.h>

#include <utility>
#include <vector>

#include "haptogram/base/error.hpp"

namespace haptogram::link {
namespace {

using interface::Command;
namespace policy = interface::link_policy;

// A round of shutting off lasts a patience. The break comes when the first of them have brought no answer.
constexpr unsigned rounds_before_break = 2;
// After the user has asked to end: two seconds until the program has ended are promised.
constexpr unsigned rounds_when_interrupted = 4;
constexpr unsigned tries_when_interrupted = 2;
constexpr int most_alive = 4;                            // keep-alives on the line
constexpr std::chrono::milliseconds longest_listen{20};  // until an interrupt or the keep-alive is looked at again

bool applied(const Reply& reply) {
    return reply.status == interface::Status::ok || reply.status == interface::Status::repeated;
}

/// Whether this answer to an identify says that the session is its own.
bool begins(const Reply& reply) {
    return reply.status == interface::Status::repeated ? reply.expected == static_cast<std::uint8_t>(reply.sequence + 1)
                                                       : reply.status != interface::Status::session_ended;
}

/// Bytes on the line at most: number, command, CRC, delimiter and stuffing beside the payload.
std::size_t most_encoded(const Request& request) { return request.payload.size() + 8; }

/// These act whenever a copy of them arrives. So nothing may be under way behind them that a later copy would end.
bool acts_at_once(Command command) { return command == Command::disable || command == Command::stop; }

}  // namespace

void Client::set_interrupt(Interrupt interrupt) {
    interrupt_ = std::move(interrupt);
    heeded_ = given_up_ = false;
    transport_.set_interrupt(interrupt_);
}

/// @throws Interrupted the first time that the user's wish is seen
void Client::heed_interrupt() {
    if (interrupts() == 0) return;
    if (!std::exchange(heeded_, true)) throw Interrupted();
    if (given_up_) throw LinkLost("board", "it does not answer any more");
}

void Client::submit(Request request, std::function<void(const Reply&)> done) {
    submit(std::move(request), std::move(done), {});
}

void Client::submit(Request request, std::function<void(const Reply&)> done,
                    std::function<void(const Error&)> refused) {
    if (request.command == Command::enable && interrupts() > 0) throw Interrupted();
    queue_.push_back({std::move(request), std::move(done), std::move(refused)});
}

void Client::tell(Request request) {
    if (shutting_off()) return;  // the device drops it, too
    make_ready();
    heed_interrupt();
    transport_.write(encode_request(session_, request.command, request.payload));
    said_ = clock().now();
}

void Client::wait(std::size_t most_unanswered) {
    while (unanswered() > most_unanswered) exchange(patience_);
}

/// Waits for bytes. @return how long it did, in the line's own time, which need not be the machine's
std::chrono::microseconds Client::hear(std::chrono::microseconds at_most, std::vector<Reply>& arrived) {
    const auto begun = clock().now();
    const Bytes bytes = transport_.read(at_most);
    const std::size_t before = arrived.size();
    decoder_.feed(bytes, arrived);
    answers_ += arrived.size() - before;
    heard_ += bytes.size();
    if (bytes.empty()) return at_most;
    return std::min(at_most, std::chrono::duration_cast<std::chrono::microseconds>(clock().now() - begun));
}

void Client::exchange(std::chrono::microseconds at_most) {
    if (shutting_off()) return listen_for_off(at_most);
    const bool looks_up = interrupt_ || keep_alive_pause_.count() > 0;
    for (std::vector<Reply> arrived;;) {
        heed_interrupt();
        transmit();
        say_alive();
        say_first_again();
        std::chrono::microseconds slice = std::min(at_most, patience_ - waited_);
        if (looks_up) slice = std::min<std::chrono::microseconds>(slice, longest_listen);
        const std::uint64_t heard = heard_;
        const std::chrono::microseconds passed = hear(slice, arrived);
        const bool quiet = heard_ == heard;
        waited_ = queue_.empty() ? std::chrono::microseconds(0) : waited_ + passed;
        stuck_ = queue_.empty() ? std::chrono::microseconds(0) : stuck_ + passed;
        for (const Reply& reply : arrived) take(reply);
        if (waited_ >= patience_) begin_round(true);
        require_progress();
        at_most -= passed;
        if (!quiet || at_most <= std::chrono::microseconds(0)) return;
    }
}

void Client::transmit() {
    std::size_t asking = 0, under_way = 0;
    for (std::size_t i = 0; i < sent_; ++i) {
        asking += asks(queue_[i]) ? 1 : 0;
        under_way += queue_[i].reply ? 0 : most_encoded(queue_[i].request);
    }
    if (shutting_off()) return;
    for (; sent_ < std::min<std::size_t>(queue_.size(), transport_.window()); ++sent_) {
        if (!heeded_ && interrupts() > 0) return;
        if (queue_[sent_].reply) continue;
        const Request& request = queue_[sent_].request;
        if (sent_ > 0 && acts_at_once(queue_[sent_ - 1].request.command) && !acts_at_once(request.command)) return;
        if (asks(queue_[sent_]) && ++asking > most_asking_) return;
        under_way += most_encoded(request);
        if (sent_ > 0 && under_way > transport_.window_bytes()) return;
        const auto number = static_cast<std::uint8_t>(next_ + sent_);
        transport_.write(encode_request(number, request.command, request.payload));
        on_line_.push_back({number, round_, clock().now()});
        if (sent_ < farthest_)
            ++retransmissions_;
        else
            said_ = clock().now();
        farthest_ = std::max(farthest_, sent_ + 1);
    }
}

/// Only what is new keeps the watchdog quiet, so a keep-alive goes out while other answers are late. Twice as often as
/// would do: what follows a frame that was lost shows the loss, and time is left to send again.
void Client::say_alive() {
    if (keep_alive_pause_.count() == 0 || clock().now() - said_ < keep_alive_pause_ / 2) return;
    if (queue_.size() >= transport_.window() || farthest_ < queue_.size()) return;  // the next to be sent is new, too
    if (!queue_.empty() && acts_at_once(queue_.back().request.command)) return;
    // A slow board must not have to answer to this alone.
    if (std::ranges::count_if(queue_, [](const Pending& p) { return p.keeps_alive && !p.reply; }) >= most_alive) return;
    queue_.push_back({{Command::keep_alive, {}}, {}, [](const Error&) {}, true});
    ++kept_alive_;
    transmit();
}

/// While outputs are on, a frame that is lost twice must not hold up what keeps the watchdog quiet for two patiences.
/// So the first that is not answered goes again once by itself, which is no round. A slow board is spared it.
void Client::say_first_again() {
    if (keep_alive_pause_.count() == 0 || sent_ == 0 || waited_ < keep_alive_pause_) return;
    if (first_again_ || patience_ != least_patience_ || acts_at_once(queue_.front().request.command)) return;
    first_again_ = true;
    repeat(0);
}

/// Sends one frame of the queue again, and no round begins with it.
void Client::repeat(std::size_t place) {
    const auto number = static_cast<std::uint8_t>(next_ + place);
    const Request& request = queue_[place].request;
    transport_.write(encode_request(number, request.command, request.payload));
    on_line_.push_back({number, round_, clock().now()});
    ++retransmissions_;
}

void Client::take(const Reply& reply) {
    const auto sent = std::ranges::find(on_line_, reply.sequence, &Sent::number);
    if (sent == on_line_.end()) return;  // an answer to an earlier user of the port
    const bool of_this_round = sent->round == round_, since_first = sent->round > first_round_;
    const bool was_slow = clock().now() - sent->at > patience_;
    on_line_.erase(on_line_.begin(), sent + 1);
    const auto place = static_cast<std::uint8_t>(reply.sequence - next_);
    const bool wanted = place < std::min<std::size_t>(queue_.size(), transport_.window()) && !queue_[place].reply;
    // A second answer to a frame that has been sent again because none came shows that this was too early. A first one
    // does not tell to which of the two it is. The patience stays below twice what an answer took.
    if (applied(reply) && !wanted && round_is_late_ && was_slow) patience_ = std::min(2 * patience_, most_patience_);
    if (!wanted || reply.command != queue_[place].request.command) return;
    if (reply.command == Command::identify && place == 0 && !begins(reply)) return begin_anew();
    // What waits was flushed, and what came before it may have been: none of it is known, and none goes out again.
    if (reply.status == interface::Status::session_ended)
        lose("it has ended the session, as after anybody's DISABLE or a lost link, and its outputs are off");
    if (reply.status == interface::Status::out_of_order) {
        // A frame before it was lost. But nothing comes before the first of the queue: the device has forgotten us.
        if (place == 0 && (of_this_round || since_first) && ++strange_ > policy::most_strange)
            lose("it has lost the session, as after a reset; identify it again");
        if (of_this_round) send_again_soon();  // otherwise it has been sent again since
        return;
    }
    // A byte was lost or damaged, which can add a zero to a frame, or take one, and leave its CRC right.
    const bool is_damaged = reply.status == interface::Status::bad_length ||
                            (applied(reply) && reply.command != Command::identify &&
                             reply.data.size() != expected_bytes(queue_[place].request, identity_));
    if (is_damaged && (!of_this_round || ++strange_ <= policy::most_strange)) {
        if (of_this_round) send_again_soon();
        return;
    }
    if (applied(reply)) {
        require_good(reply, queue_[place].request);
        if (of_this_round) patience_ = std::max(patience_ * 15 / 16, least_patience_);
    }
    queue_[place].reply = reply;
    // A device applies requests in order, so those before it were applied, too, and only their answers were lost.
    for (std::uint8_t i = 0; i < place; ++i) {
        Pending& before = queue_[i];
        if (before.reply || replies(before.request.command)) continue;
        const auto number = static_cast<std::uint8_t>(next_ + i);
        before.reply =
            Reply{number, before.request.command, interface::Status::ok, reply.expected, reply.live_level, {}};
    }
    // What is left before it was answered in vain. What is behind it may still be on its way.
    if (of_this_round && !sent_again_)
        for (std::uint8_t i = 0; i < place; ++i)
            if (!queue_[i].reply) {
                sent_again_ = true;
                repeat(i);
            }
    finish_answered();
}

/// Every reply is looked at here and nowhere else.
void Client::require_good(const Reply& reply, const Request& request) {
    try {
        require_sound(reply, request, identity_);
    } catch (const Error&) {
        forget();
        in_doubt_ = true;
        throw;
    }
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
    pop();
    sent_ = farthest_ = 0;
    ++round_;
    refused(error);
}

/// The first of the queue is finished, and only that restarts the patience: a port that talks of other things, or an
/// answer that is lost again and again, does not.
void Client::pop() {
    if (queue_.front().keeps_alive) --kept_alive_;
    queue_.pop_front();
    first_again_ = false;
    first_round_ = round_;
    tries_ = strange_ = 0;
    sent_again_ = false;
    waited_ = stuck_ = std::chrono::microseconds(0);
    heard_ = 0;
}

void Client::finish_answered() {
    while (!queue_.empty() && queue_.front().reply) {
        const Reply reply = std::move(*queue_.front().reply);
        if (!applied(reply)) return refuse(reply);
        finish(reply);
    }
}

void Client::finish(const Reply& reply) {
    const std::function<void(const Reply&)> done = std::move(queue_.front().done);
    pop();
    ++next_;
    sent_ -= sent_ > 0 ? 1 : 0;
    farthest_ -= farthest_ > 0 ? 1 : 0;
    if (done) done(reply);
}

/// Sends again what is not answered, until that has been done too often. It is late when no answer asked for that.
void Client::begin_round(bool late) {
    round_is_late_ = late;
    waited_ = std::chrono::microseconds(0);
    sent_again_ = false;
    const Command command = queue_.front().request.command;
    const unsigned most_tries = transport_.rounds() * (heeded_                        ? tries_when_interrupted
                                                       : command == Command::identify ? policy::first_tries
                                                                                      : policy::tries);
    if (++tries_ > most_tries) {
        given_up_ = heeded_;
        lose(fmt::format("no answer to {} after {} tries{}; {}", to_string(command), most_tries,
                         heard_ == 0 ? "" : fmt::format(", only {} bytes of something else", heard_),
                         transport_.why_silent()));
    }
    sent_ = 0;
    ++round_;
    transport_.write(Bytes{0});  // ends whatever half frame the line left
}

/// Rounds may be cut short or grow long, so how long nothing was acknowledged has a limit of its own.
void Client::require_progress() {
    const std::chrono::microseconds most =
        std::max<std::chrono::microseconds>(std::chrono::milliseconds(policy::lost_ms), 2 * patience_);
    if (queue_.empty() || stuck_ < most) return;
    lose(fmt::format("no answer to {} in {:.0f} s; {}", to_string(queue_.front().request.command),
                     1e-6 * static_cast<double>(stuck_.count()), transport_.why_silent()));
}

/// An answer has shown that something was lost. At most once within a patience, or a line that always loses the same
/// would be flooded.
void Client::send_again_soon() {
    if (sent_again_ || waited_ >= patience_) return;
    const std::chrono::microseconds waited = waited_;
    begin_round(false);
    waited_ = waited;
    sent_again_ = true;
}

void Client::lose(const std::string& why) {
    forget();
    in_doubt_ = true;
    throw LinkLost("board", why);
}

void Client::drop() {
    // The device may have applied what was sent, so those requests keep their numbers until they are answered.
    queue_.erase(queue_.begin() + static_cast<std::ptrdiff_t>(farthest_), queue_.end());
    kept_alive_ = 0;
    for (Pending& pending : queue_) {
        kept_alive_ += pending.keeps_alive ? 1 : 0;
        pending.done = {};
        pending.refused = [](const Error&) {};
    }
}

void Client::forget() {
    queue_.clear();
    on_line_.clear();
    off_.reset();
    kept_alive_ = sent_ = farthest_ = 0;
    tries_ = strange_ = 0;
    sent_again_ = false;
    heard_ = 0;
    waited_ = stuck_ = std::chrono::microseconds(0);
}

void Client::make_ready() {
    if (in_doubt_) identify();
}

void Client::begin(std::function<void()> begun) {
    forget();
    next_ = static_cast<std::uint8_t>(next_ + 128);  // far from what may still be under way
    session_ = next_;
    in_doubt_ = true;
    heed_interrupt();
    transport_.write(Bytes{0});
    submit({Command::identify, {}}, [this, begun = std::move(begun)](const Reply& reply) {
        identity_ = to_identity(reply.data);
        identity_block_ = reply.data;
        in_doubt_ = false;
        most_asking_ = std::max<std::size_t>(1, identity_.frame_bytes / policy::asking_bytes);
        if (begun) begun();
    });
}

/// A device begins no session with the number of the one that it has or that has ended, which somebody else may have
/// begun: it takes that for a late copy.
void Client::begin_anew() {
    if (++strange_ > policy::most_strange) lose("it begins no session; is another program at it?");
    constexpr std::uint8_t far = 85;
    next_ = static_cast<std::uint8_t>(next_ + far);
    session_ = next_;
    on_line_.clear();
    sent_ = farthest_ = 0;
    ++round_;
}

Identity Client::identify() {
    begin({});
    try {
        wait();
    } catch (...) {
        forget();
        throw;
    }
    return identity_;
}

void Client::shut_off() {
    // The number is none that the device has had, as far as is known; it acts whatever it is.
    const auto number = static_cast<std::uint8_t>(next_ + farthest_);
    forget();
    in_doubt_ = true;
    off_ = Off{number};
    next_ = static_cast<std::uint8_t>(number + 2);
    heeded_ = heeded_ || interrupts() > 0;
    transport_.discard_output();
    say_off();
}

void Client::say_off() {
    off_->said = clock().now();
    transport_.write(Bytes{0});  // ends whatever half frame the line left
    transport_.write(encode_request(off_->number, Command::disable, {}));
    transport_.write(encode_request(static_cast<std::uint8_t>(off_->number + 1), Command::stop, {}));
}

void Client::send_break() {
    if (std::exchange(off_->broken, true)) return;
    transport_.discard_output();
    transport_.send_break();
}

std::optional<bool> Client::is_off() const {
    if (!off_) return false;
    if (off_->disabled && off_->stopped) return true;
    const unsigned wishes = interrupts();
    const unsigned most = wishes == 0 ? policy::first_tries : wishes == 1 ? rounds_when_interrupted : 0;
    return off_->rounds < most * transport_.rounds() ? std::nullopt : std::optional(false);
}

/// Any answer to a disable says that it has acted, whatever else it says.
void Client::listen_for_off(std::chrono::microseconds at_most) {
    std::vector<Reply> arrived;
    const std::chrono::microseconds patience = heeded_ ? least_patience_ : patience_;
    waited_ += hear(std::min({at_most, patience, std::chrono::microseconds(longest_listen)}), arrived);
    // Other devices may be listened to in turn.
    waited_ = std::max(waited_, std::chrono::duration_cast<std::chrono::microseconds>(clock().now() - off_->said));
    for (const Reply& reply : arrived) {
        off_->disabled |= reply.command == Command::disable && reply.sequence == off_->number;
        off_->stopped |=
            reply.command == Command::stop && reply.sequence == static_cast<std::uint8_t>(off_->number + 1);
    }
    if (off_->broken && transport_.break_has_acted()) off_->disabled = off_->stopped = true;
    if (waited_ < patience || !shutting_off()) return;
    waited_ = std::chrono::microseconds(0);
    if (++off_->rounds >= rounds_before_break) send_break();
    say_off();
}

bool Client::turn_off() {
    Client* const self = this;
    return link::shut_off({&self, 1}).front();
}

std::vector<bool> shut_off(std::span<Client* const> devices) {
    std::vector<bool> gone(devices.size());
    const auto each = [&](const auto& work) {
        for (std::size_t i = 0; i < devices.size(); ++i) {
            try {
                if (!gone[i]) work(*devices[i]);
            } catch (const Error&) {  // its port is gone: what can be done was done
                gone[i] = true;
            }
        }
    };
    each([](Client& device) { device.shut_off(); });
    for (bool waiting = true; std::exchange(waiting, false);)
        each([&](Client& device) {
            if (device.is_off()) return;
            waiting = true;
            device.exchange(std::chrono::milliseconds(devices.size() > 1 ? 1 : 20));
        });
    std::vector<bool> off(devices.size());
    for (std::size_t i = 0; i < devices.size(); ++i) off[i] = devices[i]->end_shut_off();
    return off;
}

/// A break is what is left when nothing was confirmed.
bool Client::end_shut_off() {
    const bool off = is_off().value_or(false);
    try {
        if (off_ && !off) send_break();
    } catch (const Error&) {  // the port is gone
    }
    given_up_ = heeded_ && !off;
    forget();
    return off;
}

}  // namespace haptogram::link
