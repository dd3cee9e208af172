// SPDX-License-Identifier: Apache-2.0
#include "haptogram/live/ring_player.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/format/image.hpp"
#include "haptogram/solve/drives.hpp"

namespace haptogram::live {
namespace {

constexpr std::size_t most_banks = 4;
constexpr std::size_t most_unanswered = 1;  ///< one on the line while another is answered

/// FIFO entries that must be left when the next turn is pushed: what plays while two records are on the line before it,
/// 1 ms each in the paper's ring, and 2.2 ms each for a record of 100 channels at 1 Mbaud.
constexpr std::size_t most_low_water = 7;
constexpr double low_water_s = 7e-3;  ///< longer entries need not be so many

std::size_t low_water(double entry_s) {
    const double entries = std::max(1.0, std::ceil(low_water_s / entry_s));
    return entries < static_cast<double>(most_low_water) ? static_cast<std::size_t>(entries) : most_low_water;
}

link::Bytes write_of(const Record& record, std::uint16_t index) {
    Image image;
    image.channels = static_cast<std::uint32_t>(record.timings.size());
    image.records = {record};
    const std::uint32_t address = interface::primary_base + (index - 1U) * record_words(image.channels) * 2U;
    link::Bytes payload;
    for (const unsigned shift : {0U, 8U, 16U, 24U}) payload.push_back(static_cast<std::uint8_t>(address >> shift));
    for (const std::uint16_t word : primary_words(image))
        for (const unsigned shift : {0U, 8U}) payload.push_back(static_cast<std::uint8_t>(word >> shift));
    return payload;
}

}  // namespace

/// What the last reply said of the FIFO. All replies tell its level.
struct RingPlayer::Fifo {
    std::uint64_t pushed = 0;     ///< entries, in all
    std::uint64_t under_way = 0;  ///< of these, in frames that are not answered yet
    std::uint64_t level = 0;      ///< as the last reply said
    double told_s = 0.0;          ///< when it came
    [[nodiscard]] std::uint64_t left() const { return pushed - under_way - level; }
};

RingPlayer::RingPlayer(link::Commands& device, const Clock& clock, const Array& array, std::size_t steps, Method method,
                       std::uint16_t watchdog_ms)
    : device_(device),
      clock_(clock),
      array_(array),
      steps_(steps),
      method_(method),
      timer_(choose_timer(array, Core{device.identity().name, device.identity().core()})),
      fifo_(std::make_shared<Fifo>()),
      said_s_(clock.now_s()),
      pause_s_(std::chrono::duration<double>(link::keep_alive_pause(watchdog_ms)).count()) {
    const link::Identity& board = device.identity();
    if (array.elements.size() > board.channels)
        throw bad_input("board", fmt::format("it has {} channels; the array {} has {} elements", board.channels,
                                             array.name, array.elements.size()));
    free_at_.assign(std::min<std::size_t>(most_banks, board.records / steps), 0);
    if (free_at_.size() < 3)
        throw bad_input("board", fmt::format("it has {} records; rings of {} steps need three times as many",
                                             board.records, steps));
    if (board.live_depth < steps + most_low_water + 1)
        throw bad_input("board", fmt::format("its live FIFO has {} places; rings of {} steps need {}", board.live_depth,
                                             steps, steps + most_low_water + 1));
    if (interface::has(board.features, interface::Feature::schedule))
        time_ = std::make_shared<BoardTime>(timer_.period_s());
}

RingPlayer::Ring RingPlayer::made(const Path& path, std::uint64_t shot, double shot_s) const {
    require_sound(path);
    if (path.steps.size() != steps_ || !path.modulation.samples.empty() ||
        std::any_of(path.steps.begin(), path.steps.end(),
                    [&](const PathStep& s) { return s.periods != path.steps.front().periods; }))
        throw bad_argument("ring", fmt::format("expected {} steps of equal length, without a modulation", steps_));
    Ring ring;
    ring.path = path;
    ring.about.shot = shot;
    ring.about.shot_s = shot_s;
    ring.dwell = static_cast<std::uint16_t>(path.steps.front().periods);
    return ring;
}

std::optional<std::size_t> RingPlayer::free_bank() const {
    for (std::size_t bank = 0; bank < free_at_.size(); ++bank)
        if ((!present_ || present_->bank != bank) && fifo_->left() >= free_at_[bank]) return bank;
    return {};
}

void RingPlayer::give_bank(Ring& ring, std::size_t bank) const {
    ring.bank = bank;
    std::vector<PathStep> loud;
    for (const PathStep& step : ring.path.steps)
        if (!step.foci.empty()) loud.push_back(step);
    const std::vector<double> full(loud.size(), 1.0);
    const std::vector<Record> records = records_of(array_, timer_, device_.identity().channels, loud, full, method_);
    std::size_t next = 0;
    for (std::size_t j = 0; j < steps_; ++j) {
        const auto index = static_cast<std::uint16_t>(bank * steps_ + j + 1);
        ring.indices.push_back(ring.path.steps[j].foci.empty() ? std::uint16_t{0} : index);
        if (!ring.path.steps[j].foci.empty()) ring.writes.push_back(write_of(records[next++], index));
    }
    ring.about.first_index = ring.indices[ring.first_loud()];
    std::reverse(ring.writes.begin(), ring.writes.end());
}

void RingPlayer::replace(const Path& ring, std::uint64_t shot, double shot_s) {
    fades_.clear();
    next_ = made(ring, shot, shot_s);
}

void RingPlayer::silence() {
    fades_.clear();
    next_.reset();
    if (!present_) return;
    push({0}, 0);
    free_at_[present_->bank] = fifo_->pushed + 1;
    present_.reset();
}

void RingPlayer::fade() {
    if (fading() || !present_) return;
    next_.reset();
    for (const double part : {2.0 / 3.0, 1.0 / 3.0}) {
        Path weaker = present_->path;
        for (PathStep& step : weaker.steps)
            for (Focus& focus : step.foci) focus.amplitude *= part;
        fades_.push_back(std::move(weaker));
    }
}

void RingPlayer::push(const std::vector<std::uint16_t>& indices, std::uint16_t dwell) {
    link::Bytes payload = {static_cast<std::uint8_t>(dwell), static_cast<std::uint8_t>(dwell >> 8)};
    for (const std::uint16_t index : indices)
        for (const unsigned shift : {0U, 8U}) payload.push_back(static_cast<std::uint8_t>(index >> shift));
    if (time_) time_->pushed(indices, dwell);
    fifo_->pushed += indices.size();
    fifo_->under_way += indices.size();
    submit({interface::Command::push, std::move(payload)}, indices.size());
}

void RingPlayer::submit(link::Request request, std::size_t entries) {
    device_.submit(std::move(request), [fifo = fifo_, entries, now = clock_.now_s](const link::Reply& reply) {
        fifo->under_way -= entries;
        fifo->level = reply.live_level;
        fifo->told_s = now();
    });
    device_.flush();
    said_s_ = clock_.now_s();
}

/// Entries in the FIFO now, those on their way to it among them: as the last reply said, less what has played since.
double RingPlayer::level() const {
    const double played = entry_s_ > 0.0 ? (clock_.now_s() - fifo_->told_s) / entry_s_ : 0.0;
    return std::max(0.0, static_cast<double>(fifo_->level) - played) + static_cast<double>(fifo_->under_way);
}

void RingPlayer::push_turn() {
    const double waiting = level();
    entry_s_ = timer_.period_s() * present_->dwell;
    const std::size_t first = present_->first_loud();
    const std::uint64_t entry = fifo_->pushed + first;
    push(present_->indices, present_->dwell);
    ask();
    free_at_[present_->bank] = fifo_->pushed + 1;
    if (present_->begun) return;
    present_->begun = true;
    present_->about.pushed_s = clock_.now_s();
    present_->about.expected_s = present_->about.pushed_s + (waiting + static_cast<double>(first)) * entry_s_;
    if (present_->faded) return;
    if (time_) unstamped_.emplace_back(sent_.size(), entry);
    sent_.push_back(present_->about);
}

/// Asks the device which period it is in, if it counts them.
void RingPlayer::ask() {
    if (!time_) return;
    device_.submit({interface::Command::status, {}},
                   [time = time_, fifo = fifo_, entries = fifo_->pushed, asked_s = clock_.now_s(),
                    now = clock_.now_s](const link::Reply& reply) {
                       fifo->level = reply.live_level;
                       fifo->told_s = now();
                       time->heard(link::to_status(reply.data), entries, asked_s, fifo->told_s);
                   });
    device_.flush();
    stamp(false);
}

/// Takes over when rings began. The more statuses come after a ring, the better its beginning is known.
/// @param all  also of those that have begun just now
void RingPlayer::stamp(bool all) {
    constexpr double settled_s = 0.5;
    while (!unstamped_.empty()) {
        const auto [place, entry] = unstamped_.front();
        if (!all && clock_.now_s() - sent_[place].pushed_s < settled_s) break;
        sent_[place].began_s = time_->began(entry);
        unstamped_.pop_front();
        time_->forget_before(entry);
    }
    constexpr std::uint64_t kept = 4096;  // a ring that plays on and on needs no more
    if (unstamped_.empty() && fifo_->pushed > kept) time_->forget_before(fifo_->pushed - kept);
}

void RingPlayer::settle() {
    if (!time_) return;
    ask();
    device_.wait();
    stamp(true);
}

bool RingPlayer::service() {
    if (present_ && level() <= static_cast<double>(low_water(timer_.period_s() * present_->dwell))) {
        push_turn();
        if (present_->faded && fades_.empty() && !next_) silence();  // the weakest copy plays one turn
        return true;
    }
    if (!fades_.empty() && !next_ && present_ && present_->begun) {
        next_ = made(fades_.front(), 0, 0.0);
        next_->faded = true;
    }
    if (!next_) {
        if (device_.unanswered() > 0) {
            device_.wait(device_.unanswered() - 1);
            return true;
        }
        if (clock_.now_s() - said_s_ < pause_s_) return false;
        submit({interface::Command::keep_alive, {}});
        return true;
    }
    bring();
    return true;
}

/// The next bit of bringing a ring onto the board.
void RingPlayer::bring() {
    if (next_->indices.empty()) {
        if (const std::optional<std::size_t> bank = free_bank()) {
            give_bank(*next_, *bank);
            return;
        }
        // The answers that are under way tell which bank has become free; if there are none, one is asked for.
        if (device_.unanswered() == 0) submit({interface::Command::status, {}});
        device_.wait(device_.unanswered() - 1);
    } else if (!next_->writes.empty()) {
        submit({interface::Command::write, std::move(next_->writes.back())});
        next_->writes.pop_back();
        device_.wait(most_unanswered);
    } else if (device_.unanswered() > 0) {  // only what the board has acknowledged may be played
        device_.wait(device_.unanswered() - 1);
    } else {
        present_ = std::move(next_);
        next_.reset();
        if (present_->faded) fades_.pop_front();
    }
}

}  // namespace haptogram::live
