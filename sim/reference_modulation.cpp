// SPDX-License-Identifier: Apache-2.0
#include "reference_modulation.hpp"

#include <algorithm>

namespace haptogram::sim {
namespace {

constexpr Clock shown_after_clocks = 4;  // from a period's beginning until its sample is shown
constexpr Clock history = 2048;          // more than a sweep over the most channels takes

}  // namespace

void Modulation::ask(Clock clock, std::uint16_t divider, std::uint16_t length, std::uint16_t form) {
    const auto depth = static_cast<std::uint32_t>(samples_.size());
    asked_ = {};
    asked_.first = form & 0xfffeU;
    asked_.divider = divider;
    asked_.length = length == 0 ? depth - asked_.first : length;
    asked_.loops = (form & 1U) != 0;
    if (waiting_) waiting_->to = std::min(waiting_->to, clock);
    if (next_) next_->to = std::min(next_->to, clock);
}

void Modulation::begin(Clock clock, bool at_pass_end) {
    if (next_) waiting_ = next_;
    next_ = asked_;
    next_->at_pass_end = at_pass_end;
    next_->from = clock + 1;
}

bool Modulation::period(Clock clock) {
    bool first = false;
    if (next_ && next_->from <= clock) {
        waiting_ = next_;
        next_.reset();
    }
    if (waiting_ && waiting_->to < clock) waiting_.reset();
    const bool at_end = sample_ == last_;
    const bool pass_ends = !plays_ || ended_ || (at_end && left_ == 1);
    if (waiting_ && (!waiting_->at_pass_end || pass_ends)) {
        ended_ = false;
        plays_ = waiting_->divider != 0;
        first = plays_;
        if (plays_) {
            loops_ = waiting_->loops;
            sample_ = first_ = waiting_->first;
            last_ = (waiting_->first + waiting_->length - 1) % static_cast<std::uint32_t>(samples_.size());
            left_ = divider_ = waiting_->divider;
        }
        waiting_.reset();
    } else if (left_ != 1) {
        --left_;
    } else if (at_end && !loops_) {
        ended_ = true;
    } else {
        first = at_end && plays_ && !ended_;
        sample_ = at_end ? first_ : sample_ + 1;
        left_ = divider_;
    }
    told_ = clock;
    const std::uint8_t sample = plays_ ? samples_[sample_] : std::uint8_t{255};
    shown_.push_front({clock + shown_after_clocks, sample, plays_ && !ended_});
    while (shown_.size() > 2 && shown_[shown_.size() - 2].from + history < clock) shown_.pop_back();
    return first;
}

void Modulation::reset() {
    waiting_.reset();
    next_.reset();
    plays_ = ended_ = false;
    told_ = never - 1;
    shown_ = {{}};
}

const Modulation::Shown& Modulation::shown(Clock clock) const {
    const auto found = std::ranges::find_if(shown_, [clock](const Shown& s) { return s.from <= clock; });
    return found != shown_.end() ? *found : shown_.back();
}

std::uint16_t Modulation::word(std::uint32_t address) const {
    return static_cast<std::uint16_t>(samples_[2 * address] | samples_[2 * address + 1] << 8);
}

void Modulation::write(std::uint32_t address, std::uint16_t word) {
    samples_[2 * address] = static_cast<std::uint8_t>(word);
    samples_[2 * address + 1] = static_cast<std::uint8_t>(word >> 8);
}

}  // namespace haptogram::sim
