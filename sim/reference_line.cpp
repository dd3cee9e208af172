// SPDX-License-Identifier: Apache-2.0
#include "reference_line.hpp"

#include <algorithm>
#include <cmath>

#include "haptogram/link/frame.hpp"

namespace haptogram::sim {
namespace {

constexpr Clock synchronized = 2;  // clocks from the pin to where the board sees it
constexpr unsigned longest_run = 254;

}  // namespace

BitClock::BitClock(const interface::CoreParameters& p)
    : break_clocks(Clock{20} * (p.clock_hz / p.baud)),
      host_clocks(static_cast<double>(p.clock_hz) / static_cast<double>(p.baud)) {
    const std::uint64_t whole = 1U << 20;
    const std::uint64_t step = (p.baud * whole + p.clock_hz / 2) / p.clock_hz;
    for (std::uint64_t bit = 0; bit <= 10; ++bit) {
        begin[bit] = (bit * whole + step - 1) / step;
        middle[bit] = (bit * whole + whole / 2 + step - 1) / step;
    }
}

void LineIn::force(Clock now, std::optional<bool> level) {
    forced_ = level;
    ask_at_ = now;
}

void LineIn::unplug(Clock now) {
    sender_.drop();
    ask_at_ = now;
}

void LineIn::reset(Clock last) {
    deaf_to_ = last;
    ask_at_ = last + 1;
    level_ = true;
    connected_ = false;
    sample_at_ = byte_at_ = break_at_ = never;
}

Clock LineIn::next() const { return std::min({ask_at_, sender_.next_change(), sample_at_, byte_at_, break_at_}); }

LineIn::Event LineIn::at(Clock clock) {
    if (clock >= ask_at_ || clock >= sender_.next_change()) {
        const bool sent = sender_.level(clock);
        if (clock >= ask_at_) ask_at_ = never;
        if (clock > deaf_to_) level_is(clock, forced_.value_or(sent));
    }
    if (clock == sample_at_) sample(clock);
    Event event;
    if (clock == byte_at_) {
        event.byte = byte_;
        byte_at_ = never;
    }
    if (clock == break_at_) {
        event.broken = true;
        break_at_ = never;
    }
    return event;
}

void LineIn::level_is(Clock clock, bool level) {
    connected_ = connected_ || level;
    if (level == level_) return;
    level_ = level;
    if (level) {
        if (clock < low_since_ + bits_.break_clocks) break_at_ = never;
        return;
    }
    low_since_ = clock;
    if (connected_) break_at_ = clock + synchronized + bits_.break_clocks;
    if (sample_at_ != never) return;  // within a byte
    started_ = clock;
    bit_ = 0;
    sample_at_ = clock + bits_.middle[0];
}

void LineIn::sample(Clock clock) {
    const std::size_t bit = bit_++;
    sample_at_ = never;
    if (bit == 0 && level_) return;  // too short for a start bit
    if (bit == 9) {
        if (!level_) return;  // no stop bit
        byte_ = shift_;
        byte_at_ = clock + synchronized + 1;
        return;
    }
    if (bit > 0) shift_ = static_cast<std::uint8_t>(shift_ >> 1 | (level_ ? 0x80U : 0U));
    sample_at_ = started_ + bits_.middle[bit_];
}

Clock LineOut::collect(Clock offered, std::uint8_t byte) {
    frame_.push_back(byte);
    const Clock taken = std::max(offered, collects_from_);
    const bool run_ends = byte != 0 && run_ == longest_run;
    run_ = byte == 0 || run_ends ? 1 : run_ + 1;
    collects_from_ = taken + (run_ends ? 2 : 1);
    return taken;
}

void LineOut::close(Clock offered) {
    const std::uint16_t crc = link::crc16(frame_);
    const Clock first = collect(offered, static_cast<std::uint8_t>(crc >> 8));
    const Clock last = collect(first + 1, static_cast<std::uint8_t>(crc));
    std::vector<std::uint8_t> line = link::cobs_encode(frame_);
    line.push_back(0);
    Clock begin = std::max(last + 4, sends_from_);  // three clocks end the code and fetch its first byte
    for (const std::uint8_t byte : line) {
        sent_.push_back({begin, static_cast<Clock>(static_cast<double>(begin) + 9.5 * bits_.host_clocks), byte});
        collects_from_ = begin + 1;
        sends_from_ = begin + bits_.begin[10] + 1;
        begin = sends_from_;
    }
    frame_.clear();
    run_ = 1;
}

void LineOut::reset(Clock clock) {
    frame_.clear();
    run_ = 1;
    collects_from_ = sends_from_ = 0;
    silent_from_ = clock;
    while (!sent_.empty() && sent_.back().begin >= clock) sent_.pop_back();
    if (sent_.empty()) return;
    // What the host makes of a byte whose rest is high.
    Sent cut = sent_.back();
    sent_.pop_back();
    SerialReceiver host(bits_.host_clocks);
    const auto end = cut.begin + bits_.begin[10] + 2;
    sent_.push_back(cut);
    std::optional<Sent> seen;
    for (Clock at = cut.begin; at < end && !seen; ++at)
        if (const auto byte = host.sample(at, level(at))) seen = Sent{cut.begin, at, *byte};
    sent_.pop_back();
    if (seen) sent_.push_back(*seen);
}

std::uint8_t LineOut::arrive() {
    last_ = sent_.front();
    sent_.pop_front();
    return last_->byte;
}

bool LineOut::level(Clock clock) const {
    if (clock >= silent_from_ && sent_.empty()) return true;
    const auto level_of = [&](const Sent& sent) -> std::optional<bool> {
        if (clock < sent.begin || clock >= sent.begin + bits_.begin[10]) return {};
        if (clock >= silent_from_ && sent.begin < silent_from_) return true;
        const unsigned frame = 1U << 9 | static_cast<unsigned>(sent.byte) << 1;
        std::size_t bit = 9;
        while (clock < sent.begin + bits_.begin[bit]) --bit;
        return (frame >> bit & 1U) != 0;
    };
    if (last_)
        if (const auto found = level_of(*last_)) return *found;
    if (!sent_.empty())
        if (const auto found = level_of(sent_.front())) return *found;
    return true;
}

}  // namespace haptogram::sim
