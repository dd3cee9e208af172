// SPDX-License-Identifier: Apache-2.0
#include "reference_line.hpp"

#include <algorithm>

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

void ByteInput::reset() {
    level_ = true;
    sample_at_ = never;
}

void ByteInput::level(Clock clock, bool level) {
    if (level == level_) return;
    level_ = level;
    if (level || !idle()) return;
    started_ = clock;
    bit_ = 0;
    sample_at_ = clock + bits_.middle[0];
}

ByteInput::Sample ByteInput::sample() {
    const Sample sample{bit_++, level_};
    const bool ends = sample.bit == 9 || (sample.bit == 0 && level_);  // which is too short for a start bit
    sample_at_ = ends ? never : started_ + bits_.middle[bit_];
    if (sample.bit > 0 && !ends) byte_ = static_cast<std::uint8_t>(byte_ >> 1 | (level_ ? 0x80U : 0U));
    return sample;
}

bool ChainFilter::read(const ByteInput::Sample& sample, std::uint8_t byte) {
    constexpr std::uint8_t near = 3, complement = 0xfd;  // of the nearest tile, and of all
    if (sample.bit == 0) {
        if (!sample.level) own_ = !mine_;
        return false;
    }
    if (sample.bit < 9) {
        own_ = sample.level || !mine_;
        if (place_ == 0 && sample.bit == 1) counts_ = sample.level;
        return false;
    }
    own_ = sample.level;
    if (!sample.level) {
        place_ = 0;
        mine_ = false;
        return false;
    }
    const bool begins = byte == 0 && place_ == 2 && mine_ && !counts_;
    mine_ = byte != 0 && (place_ == 1 ? near_ && byte == complement : mine_);
    near_ = byte == near || byte == interface::chain::all;
    place_ = byte == 0 ? 0 : std::min(place_ + 1, 3U);
    return begins;
}

void LineIn::force(Clock now, std::optional<bool> level) {
    forced_ = level;
    ask_at_ = now;
}

void LineIn::send(std::span<const std::uint8_t> bytes) {
    if (has_net_)
        net_.add(bytes);
    else
        sender_.send(bytes);
}

void LineIn::unplug(Clock now) {
    net_.clear();
    sender_.drop();
    ask_at_ = now;
}

void LineIn::reset(Clock last) {
    deaf_to_ = last;
    ask_at_ = last + 1;
    net_from_ = last + 1;
    net_break_at_ = net_stop_at_ = net_lost_at_ = net_end_at_ = never;
    net_.mark(PortBytes::end);
    level_ = true;
    connected_ = false;
    byte_at_ = byte_began_ = break_at_ = look_at_ = never;
    chains_at_ = unchains_at_ = tells_chain_at_ = tells_no_chain_at_ = never;
    chained_ = false;
    shared_.reset();
    own_.reset();
    filter_.reset();
}

Clock LineIn::next() const {
    if (has_net_)
        return std::min({net_.empty() ? never : net_from_, net_break_at_, net_stop_at_, net_lost_at_, net_end_at_});
    return std::min({ask_at_, sender_.next_change(), shared_.next(), own_.next(), byte_at_, break_at_, look_at_,
                     chains_at_, unchains_at_, tells_chain_at_, tells_no_chain_at_});
}

LineIn::Event LineIn::at_network(Clock clock) {
    Event event;
    event.old = net_.old();
    if (!net_.empty() && clock >= net_from_) {
        event.byte = net_.take();
        net_from_ = clock + 1;
    }
    event.broken = clock >= net_break_at_;
    event.stops = clock >= net_stop_at_;
    event.lost = clock >= net_lost_at_;
    event.ends = event.broken || event.lost || clock >= net_end_at_;
    net_break_at_ = net_stop_at_ = net_lost_at_ = net_end_at_ = never;
    if (event.broken) mark(PortBytes::off);
    if (event.stops) mark(PortBytes::stop);
    if (event.broken || event.lost) mark(PortBytes::end);
    return event;
}

std::optional<Clock> LineIn::coming() const {
    if (has_net_) return {};
    if (byte_at_ != never) return byte_began_;
    if (chained_ && (filter_.begun() || !shared_.idle())) return head_at_;
    return own_.idle() ? std::optional<Clock>() : own_.started();
}

LineIn::Event LineIn::at(Clock clock) {
    if (has_net_) return at_network(clock);
    Event event;
    if (clock == chains_at_ || clock == unchains_at_) {
        chained_ = clock != unchains_at_;
        chains_at_ = unchains_at_ = never;
        look_at_ = clock;
    }
    if (clock >= ask_at_ || clock >= sender_.next_change()) {
        const bool sent = sender_.level(clock);
        if (clock >= ask_at_) ask_at_ = never;
        if (clock > deaf_to_) level_is(clock, forced_.value_or(sent));
    }
    if (clock == look_at_) {
        look_at_ = never;
        if (chained_) own_.level(clock, filter_.own());
    }
    if (!chained_) own_.level(clock, level_);
    if (clock == own_.next()) {
        const ByteInput::Sample sample = own_.sample();
        if (sample.bit == 9 && sample.level) {
            byte_ = own_.byte();
            byte_at_ = clock + synchronized + 1;
            byte_began_ = chained_ ? head_at_ : own_.started();
        }
    }
    if (has_chain_) read_shared(clock);
    if (clock == byte_at_) {
        event.byte = byte_;
        event.began = byte_began_;
        byte_at_ = never;
    }
    if (clock == break_at_) {
        event.broken = true;
        break_at_ = never;
    }
    if (clock == tells_chain_at_ || clock == tells_no_chain_at_) {
        event.chained = clock == tells_chain_at_;
        (*event.chained ? tells_chain_at_ : tells_no_chain_at_) = never;
    }
    return event;
}

/// The filter's registers change a clock after the bit that it reads.
void LineIn::read_shared(Clock clock) {
    const bool own = filter_.own();
    if (clock == shared_.next()) {
        const ByteInput::Sample sample = shared_.sample();
        if (filter_.read(sample, shared_.byte()) && unchains_at_ != clock + 1) {
            chains_at_ = clock + 1;
            tells_chain_at_ = clock + 1 + synchronized;
        }
    } else if (shared_.idle() && level_) {
        filter_.rest();
    }
    if (filter_.own() != own) look_at_ = clock + 1;
}

void LineIn::level_is(Clock clock, bool level) {
    connected_ = connected_ || level;
    if (level == level_) return;
    level_ = level;
    if (has_chain_) {
        const bool idle = shared_.idle();
        shared_.level(clock, level);
        if (idle && !shared_.idle() && !filter_.begun()) head_at_ = clock;
    }
    if (level) {
        if (clock < low_since_ + bits_.break_clocks) break_at_ = unchains_at_ = tells_no_chain_at_ = never;
        return;
    }
    low_since_ = clock;
    if (!connected_) return;
    break_at_ = clock + synchronized + bits_.break_clocks;
    if (!has_chain_) return;
    unchains_at_ = break_at_ - synchronized + 1;
    tells_no_chain_at_ = break_at_ + 1;
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
    ready_ = last + 3;  // three clocks end the code and fetch its first byte
    plan(ready_, line);
    frame_.clear();
    run_ = 1;
}

/// @param ready  from this clock on they can be taken
void LineOut::plan(Clock ready, std::span<const std::uint8_t> line) {
    constexpr std::uint8_t head[] = {3, 0xfd};  // of the nearest tile
    Clock begin = std::max(ready + 1, sends_from_);
    if (chained_) {  // a clock to choose whose frame it is
        begin = std::max(ready + 2, sends_from_);
        for (const std::uint8_t byte : head) {
            send(begin, byte, true);
            begin = sends_from_;
        }
    }
    for (const std::uint8_t byte : line) {
        send(begin, byte, false);
        collects_from_ = begin + 1;
        begin = sends_from_;
    }
}

void LineOut::send(Clock begin, std::uint8_t byte, bool heads) {
    if (has_net_) {  // the port takes a byte a clock, and is seen to have it before that clock
        sent_.push_back({begin, begin - 1, byte, heads});
        sends_from_ = begin + 1;
        return;
    }
    sent_.push_back({begin, static_cast<Clock>(static_cast<double>(begin) + 9.5 * bits_.host_clocks), byte, heads});
    sends_from_ = begin + bits_.begin[10] + 1;
}

/// What has not begun yet goes as the new state has it.
void LineOut::chain(Clock clock, bool chained) {
    chained_ = chained;
    std::vector<std::uint8_t> left;
    while (!sent_.empty() && sent_.back().begin > clock) {
        if (!sent_.back().heads) left.insert(left.begin(), sent_.back().byte);
        sent_.pop_back();
    }
    const Sent* before = !sent_.empty() ? &sent_.back() : last_ ? &*last_ : nullptr;
    sends_from_ = before != nullptr ? before->begin + bits_.begin[10] + 1 : 0;
    if (!left.empty()) plan(std::max(clock, ready_), left);
}

void LineOut::reset(Clock clock) {
    chained_ = false;
    frame_.clear();
    run_ = 1;
    collects_from_ = sends_from_ = 0;
    silent_from_ = clock;
    if (has_net_) return std::erase_if(sent_, [clock](const Sent& sent) { return sent.arrives >= clock; }), void();
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
    if (has_net_) return true;
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
