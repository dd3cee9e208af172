// SPDX-License-Identifier: Apache-2.0
#include "haptogram/live/player.hpp"

#include <algorithm>
#include <chrono>

#include "haptogram/format/interface.hpp"

namespace haptogram::live {

Line measured_line(link::Commands& device, link::Clock& clock) {
    constexpr std::uint16_t few = 16, many = 192;
    constexpr double around = 20.0;   // bytes beside them: of the question, and of the answer's frame
    constexpr double least_s = 1e-6;  // of a line that is faster than can be measured
    constexpr double line_part =
        0.5;  // of the longer answer's time, at least, is the line's: a busy machine hides the rest
    const auto seconds = [&](std::uint16_t bytes) {
        double least = 1.0;
        for (int i = 0; i < 5; ++i) {
            const double began = clock.now_s();
            static_cast<void>(device.read(interface::primary_base, bytes));
            least = std::min(least, clock.now_s() - began);
        }
        return std::max(least, least_s);
    };
    const double short_s = seconds(few), long_s = seconds(many);
    const double byte_s = std::max((long_s - short_s) / (many - few), line_part * long_s / (many + around));
    return {1.0 / byte_s, std::max(0.0, short_s - (few + around) * byte_s)};
}

Player::Player(link::Commands& device, link::Clock& clock, const Timer& timer, std::uint16_t watchdog_ms)
    : device_(device),
      clock_(clock),
      timer_(timer),
      fifo_(std::make_shared<Fifo>()),
      said_s_(clock.now_s()),
      pause_s_(std::chrono::duration<double>(link::keep_alive_pause(watchdog_ms)).count()) {
    if (interface::has(device.identity().features, interface::Feature::schedule))
        time_ = std::make_shared<BoardTime>(timer_.period_s());
}

void Player::push(std::span<const std::uint16_t> indices, std::uint16_t dwell) {
    send_entries(link::push_request(indices, dwell), indices, dwell);
}

void Player::send_entries(link::Request request, std::span<const std::uint16_t> indices, std::uint16_t dwell) {
    if (time_) time_->pushed(indices, dwell);
    fifo_->pushed += indices.size();
    fifo_->under_way += indices.size();
    submit(std::move(request), indices.size());
}

void Player::submit_to(link::Commands& device, link::Request request, std::size_t entries) {
    device.submit(std::move(request), [fifo = fifo_, entries, clock = &clock_](const link::Reply& reply) {
        fifo->under_way -= entries;
        fifo->level = reply.live_level;
        fifo->told_s = clock->now_s();
    });
    device.flush();
    said_s_ = clock_.now_s();
}

bool Player::idle() {
    if (device_.unanswered() > 0) {
        device_.wait(device_.unanswered() - 1);
        return true;
    }
    if (clock_.now_s() - said_s_ < pause_s_) return false;
    submit({interface::Command::keep_alive, {}});
    return true;
}

/// Entries in the FIFO now, those on their way to it among them: as the last reply said, less what has played since.
double Player::level() const {
    const double played = entry_s_ > 0.0 ? (clock_.now_s() - fifo_->told_s) / entry_s_ : 0.0;
    return std::max(0.0, static_cast<double>(fifo_->level) - played) + static_cast<double>(fifo_->under_way);
}

void Player::begins(SentRing about, std::uint64_t entry, double waiting) {
    about.pushed_s = clock_.now_s();
    about.expected_s = about.pushed_s + waiting * entry_s_;
    if (time_) unstamped_.emplace_back(sent_.size(), entry);
    sent_.push_back(about);
}

void Player::ask() {
    device_.submit({interface::Command::status, {}},
                   [time = time_, fifo = fifo_, entries = fifo_->pushed, asked_s = clock_.now_s(),
                    clock = &clock_](const link::Reply& reply) {
                       fifo->level = reply.live_level;
                       fifo->told_s = clock->now_s();
                       const link::Status status = link::to_status(reply.data);
                       fifo->underruns = status.underruns;
                       if (time) time->heard(status, entries, asked_s, fifo->told_s);
                   });
    device_.flush();
    if (time_) stamp(false);
}

/// Takes over when paths began. The more statuses come after one, the better its beginning is known.
/// @param all  also of those that have begun just now
void Player::stamp(bool all) {
    constexpr double settled_s = 0.5;
    while (!unstamped_.empty()) {
        const auto [place, entry] = unstamped_.front();
        if (!all && clock_.now_s() - sent_[place].pushed_s < settled_s) break;
        sent_[place].began_s = time_->began(entry);
        unstamped_.pop_front();
        time_->forget_before(entry);
    }
    constexpr std::uint64_t kept = 4096;  // a path that plays on and on needs no more
    if (unstamped_.empty() && fifo_->pushed > kept) time_->forget_before(fifo_->pushed - kept);
}

void Player::settle() {
    if (!time_) return;
    ask();
    device_.wait();
    stamp(true);
}

}  // namespace haptogram::live
