// SPDX-License-Identifier: Apache-2.0
#include "haptogram/live/player.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "haptogram/format/interface.hpp"

namespace haptogram::live {
namespace {

/// A status takes its words one after another, so its period and its record may be a period apart.
constexpr double slack_periods = 1.0;
constexpr double drift = 1e-4;    ///< between the clocks of host and device, for crystals
constexpr double window_s = 1.0;  ///< statuses farther from an entry say little about its time

}  // namespace

void BoardTime::pushed(std::span<const std::uint16_t> indices, std::uint16_t dwell) {
    for (const std::uint16_t index : indices) {
        entries_.push_back({index, dwell, periods_});
        periods_ += dwell;
        if (dwell == 0) rows_.push_back({entries(), {}});  // what comes after it begins whenever it is pushed
    }
}

/// The entry that plays: that with the status' index that is nearest to the last one which has left the FIFO.
std::optional<std::uint64_t> BoardTime::playing(const link::Status& status, std::uint64_t entries) const {
    constexpr std::int64_t reach = 3;  ///< the device loads a record before it plays
    if (status.present_index == 0 || status.live_level > entries) return {};
    const auto left = static_cast<std::int64_t>(entries - status.live_level) - 1;
    for (std::int64_t away = 0; away <= reach; ++away)
        for (const std::int64_t at : {left - away, left + away}) {
            const std::int64_t place = at - static_cast<std::int64_t>(first_);
            if (place < 0 || place >= static_cast<std::int64_t>(entries_.size())) continue;
            const Entry& entry = entries_[static_cast<std::size_t>(place)];
            if (entry.index == status.present_index && entry.dwell > 0) return static_cast<std::uint64_t>(at);
        }
    return {};
}

void BoardTime::heard(const link::Status& status, std::uint64_t entries, double asked_s, double answered_s) {
    if (!status.period) return;
    const auto period = static_cast<double>(*status.period);
    heard_.push_back({asked_s, answered_s, period});
    while (heard_.front().answered_s < answered_s - 2.0 * window_s) heard_.pop_front();
    const std::optional<std::uint64_t> entry = playing(status, entries);
    const bool ran_empty = underruns_ && *underruns_ != status.underruns;
    underruns_ = status.underruns;
    if (!entry) return;
    const Entry& at = entries_[*entry - first_];
    const double least = period - at.dwell - slack_periods - static_cast<double>(at.before),
                 most = period + slack_periods - static_cast<double>(at.before);
    auto row = std::find_if(rows_.rbegin(), rows_.rend(), [&](const Row& r) { return r.first <= *entry; });
    if (row == rows_.rend()) return;
    if (ran_empty || most < row->least || least > row->most) {
        rows_.insert(row.base(), Row{*entry, *entry, least, most});
        return;
    }
    row->least = std::max(row->least, least);
    row->most = std::min(row->most, most);
    row->last = std::max(row->last.value_or(0), *entry);
}

std::optional<Between> BoardTime::began(std::uint64_t entry) const {
    if (entry < first_ || entry >= entries()) return {};
    const auto row = std::find_if(rows_.rbegin(), rows_.rend(), [&](const Row& r) { return r.first <= entry; });
    if (row == rows_.rend() || !row->last || *row->last < entry) return {};
    const auto before = static_cast<double>(entries_[entry - first_].before);
    const Between periods{row->least + before, row->most + before};
    // The host's time of period 0, from statuses that were heard about when the entry began.
    Between zero{-HUGE_VAL, HUGE_VAL};
    for (const Heard& h : heard_) {
        const double away_s = std::abs(h.period - periods.middle()) * period_s_;
        if (away_s > window_s) continue;
        zero.least = std::max(zero.least, h.asked_s - (h.period + slack_periods) * period_s_ - drift * away_s);
        zero.most = std::min(zero.most, h.answered_s - h.period * period_s_ + drift * away_s);
    }
    if (!std::isfinite(zero.least) || !std::isfinite(zero.most) || zero.least > zero.most) return {};
    return Between{zero.least + periods.least * period_s_, zero.most + periods.most * period_s_};
}

void BoardTime::forget_before(std::uint64_t entry) {
    while (first_ < entry && !entries_.empty()) {
        entries_.pop_front();
        ++first_;
    }
    while (rows_.size() > 1 && rows_[1].first <= first_) rows_.pop_front();
}

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
