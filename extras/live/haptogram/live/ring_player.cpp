// SPDX-License-Identifier: Apache-2.0
#include "haptogram/live/ring_player.hpp"

#include <fmt/format.h>

#include <algorithm>
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

/// The channels of a record that a part has. Those beyond its elements are silent.
Record part_of(const Record& record, std::size_t first, const DevicePart& part) {
    Record own = record;
    const auto begin = record.timings.begin() + static_cast<std::ptrdiff_t>(first);
    own.timings.assign(begin, begin + static_cast<std::ptrdiff_t>(part.elements));
    own.timings.resize(part.device.identity().channels, interface::silent_timing);
    return own;
}

link::Request write_of(const Record& record, std::uint16_t index) {
    Image image;
    image.channels = static_cast<std::uint32_t>(record.timings.size());
    image.records = {record};
    const std::uint32_t address = interface::primary_base + (index - 1U) * record_words(image.channels) * 2U;
    return link::write_request(address, primary_words(image));
}

/// A path in so many steps of equal length, which takes about as long. One that has them stays as it is.
Path in_steps(const Path& path, std::size_t count) {
    const auto is_other = [&](const PathStep& step) { return step.periods != path.steps.front().periods; };
    if (path.steps.size() == count && std::none_of(path.steps.begin(), path.steps.end(), is_other)) return path;
    const double periods = static_cast<double>(path.periods()) / static_cast<double>(count);
    const double dwell = std::clamp(std::round(periods), 1.0, 65535.0);
    Path even;
    std::size_t step = 0;
    auto end = static_cast<double>(path.steps.front().periods);
    for (std::size_t i = 0; i < count; ++i) {
        while (end <= (static_cast<double>(i) + 0.5) * periods) end += path.steps[++step].periods;
        even.steps.push_back({path.steps[step].foci, static_cast<std::uint32_t>(dwell)});
    }
    return even;
}

}  // namespace

RingPlayer::RingPlayer(link::Commands& device, link::Clock& clock, const Array& array, std::size_t steps, Method method,
                       std::uint16_t watchdog_ms, const std::vector<DevicePart>& parts)
    : Player(device, clock, choose_timer(array, Core{device.identity().name, device.identity().core()}), watchdog_ms),
      array_(array),
      parts_(parts.empty() ? one_part(device, array) : parts),
      steps_(steps),
      method_(method) {
    array.require_one_weight();
    const link::Identity& board = device.identity();
    for (const DevicePart& part : parts_)
        if (part.elements > part.device.identity().channels)
            throw bad_input("board", fmt::format("it has {} channels; the array {} has {} elements",
                                                 part.device.identity().channels, array.name, part.elements));
    free_at_.assign(std::min<std::size_t>(most_banks, board.records / steps), 0);
    if (free_at_.size() < 3)
        throw bad_input("board", fmt::format("it has {} records; rings of {} steps need three times as many",
                                             board.records, steps));
    if (board.live_depth < steps + most_low_water + 1)
        throw bad_input("board", fmt::format("its live FIFO has {} places; rings of {} steps need {}", board.live_depth,
                                             steps, steps + most_low_water + 1));
}

RingPlayer::Ring RingPlayer::made(const Path& path, std::uint64_t shot, double shot_s) const {
    require_sound(path);
    if (!path.modulation.samples.empty()) throw bad_argument("ring", "expected one without a modulation");
    Ring ring;
    ring.path = in_steps(path, steps_);
    ring.about.shot = shot;
    ring.about.shot_s = shot_s;
    ring.dwell = static_cast<std::uint16_t>(ring.path.steps.front().periods);
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
    const auto elements = static_cast<std::uint32_t>(array_.elements.size());
    const std::vector<Record> records = records_of(array_, timer_, elements, loud, full, method_);
    std::size_t next = 0;
    for (std::size_t j = 0; j < steps_; ++j) {
        const auto index = static_cast<std::uint16_t>(bank * steps_ + j + 1);
        ring.indices.push_back(ring.path.steps[j].foci.empty() ? std::uint16_t{0} : index);
        if (ring.path.steps[j].foci.empty()) continue;
        std::size_t first = 0;
        for (std::size_t k = 0; k < parts_.size(); first += parts_[k++].elements)
            ring.writes.emplace_back(k, write_of(part_of(records[next], first, parts_[k]), index));
        ++next;
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
    push(std::vector<std::uint16_t>{0}, 0);
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

void RingPlayer::push_turn() {
    const double waiting = level();
    entry_s_ = timer_.period_s() * present_->dwell;
    const std::size_t first = present_->first_loud();
    const std::uint64_t entry = fifo_->pushed + first;
    push(present_->indices, present_->dwell);
    if (time_) ask();  // which period it is in
    free_at_[present_->bank] = fifo_->pushed + 1;
    if (present_->begun) return;
    present_->begun = true;
    if (!present_->faded) begins(present_->about, entry, waiting + static_cast<double>(first));
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
    if (!next_) return idle();
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
        for (std::size_t i = 0; i < parts_.size(); ++i) {  // a record, of which each part has its own
            auto& [part, request] = next_->writes.back();
            submit_to(parts_[part].device, std::move(request));
            next_->writes.pop_back();
        }
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
