// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/live_focus.hpp"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <utility>
#include <vector>

#include "haptogram/base/error.hpp"
#include "haptogram/format/focus_engine.hpp"
#include "haptogram/link/focus_ring.hpp"
#include "haptogram/link/live_feed.hpp"

namespace haptogram::link {
namespace {

constexpr std::chrono::milliseconds between_statuses{20};  // which tell whether the board has run dry
constexpr double growth = 1.5;                             // of the lead, each time that it has
constexpr double most_step_periods = 1024;                 // 26 ms

/// How far ahead of the board the host keeps, and in which steps: as much as host and line need, found by trying.
class Pace {
public:
    Pace(const LiveFocusSettings& settings, double carrier_hz)
        : most_lead_s_(settings.most_lead_s),
          period_s_(1.0 / carrier_hz),
          step_s_(period_s_ * std::clamp(std::round(settings.step_s * carrier_hz), 1.0, most_step_periods)),
          lead_s_(settings.lead_s) {}

    [[nodiscard]] std::size_t foci() const {
        return std::max<std::size_t>(2, static_cast<std::size_t>(std::ceil(lead_s_ / step_s_)));
    }
    [[nodiscard]] std::uint16_t dwell() const { return static_cast<std::uint16_t>(std::lround(step_s_ / period_s_)); }
    [[nodiscard]] double step_s() const { return step_s_; }
    [[nodiscard]] double lead_s() const { return lead_s_; }

    void learn(std::uint16_t underruns) {
        if (std::exchange(underruns_, underruns) == underruns) return;
        if (lead_s_ < most_lead_s_)
            lead_s_ = std::min(most_lead_s_, growth * lead_s_);
        else
            step_s_ = std::min(period_s_ * most_step_periods, 2.0 * step_s_);
    }

private:
    double most_lead_s_, period_s_, step_s_, lead_s_;
    std::uint16_t underruns_ = 0;
};

}  // namespace

void FocusMailbox::put(const Focus& focus) {
    try {
        const auto words = std::bit_cast<std::uint64_t>(pack_focus(focus));
        put_at_ = clock_.now().count();
        words_ = words;
    } catch (const Error&) {
        clear();
        throw;
    }
}

std::uint64_t FocusMailbox::newest(std::chrono::milliseconds most_age) const {
    const std::uint64_t words = words_;
    return most_age.count() > 0 && clock_.now() - Clock::Time(put_at_) > most_age ? 0 : words;
}

Played play_live_focus(Commands& device, const LiveFocusSettings& settings, const FocusMailbox& mailbox,
                       const std::function<bool(const LiveFocusPlaying&)>& watch) {
    const std::size_t each = make_ring(device).each;
    Pace pace(settings, device_carrier_hz(device));
    Clock& clock = device.clock();
    const Status before = device.status();
    LiveFocusPlaying now{.step_s = pace.step_s(), .lead_s = pace.lead_s(), .status = before};
    while_on(device, settings.watchdog_ms, [&] {
        LiveFeed fifo(device, device.identity(), each);
        for (auto asked = clock.now(); watch(now);) {
            if (clock.now() - asked > between_statuses) {
                now.status = device.status();
                fifo.learn(now.status);
                require_on(now.status, &before);
                pace.learn(counted(before, now.status).underruns);
                now.step_s = pace.step_s();
                now.lead_s = pace.lead_s();
                asked = clock.now();
            }
            const std::size_t level = fifo.level(), wanted = pace.foci();
            const std::size_t count = std::min(fifo.room(), wanted - std::min(wanted, level));
            if (count > 0) {
                std::vector<std::uint16_t> words;
                const auto focus = std::bit_cast<FocusWords>(mailbox.newest(settings.most_age));
                for (std::size_t i = 0; i < count; ++i) add_record(words, focus, each);
                fifo.push_foci(words, pace.dwell());
                now.sent += count;
            } else if (device.unanswered() == 0) {
                clock.rest(Clock::time(0.5 * pace.step_s()));
            }
            fifo.refresh();
        }
    });
    Played played = counted(before, now.status);
    played.sent = now.sent;
    played.interrupted = true;
    return played;
}

}  // namespace haptogram::link
