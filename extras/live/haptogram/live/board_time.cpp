// SPDX-License-Identifier: Apache-2.0
#include "haptogram/live/board_time.hpp"

#include <algorithm>
#include <cmath>

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

}  // namespace haptogram::live
