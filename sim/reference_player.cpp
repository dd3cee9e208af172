// SPDX-License-Identifier: Apache-2.0
#include "reference_player.hpp"

#include <algorithm>
#include <utility>

namespace haptogram::sim {

Header Header::of(std::span<const std::uint16_t> words) {
    namespace field = interface::record_field;
    return {field::cycle_length.get(words), field::prescaler.get(words), field::pulse_length.get(words),
            field::kind.get(words)};
}

bool Header::in_bounds(const interface::CoreParameters& p) const {
    const std::uint64_t pulse_clocks = std::uint64_t{pulse} * prescaler;
    return pulse < 1U << p.pulse_bits && std::uint64_t{pulse} * 256 <= std::uint64_t{cycle_length} * p.max_duty_256 &&
           cycle_clocks() >= least_cycle_clocks(p) && cycle_clocks() <= p.clock_hz &&
           pulse_clocks <= longest_pulse_clocks(p) && (pulse == 0 || pulse_clocks >= p.min_pulse_clocks);
}

void RecordPlayer::reset(Clock, Clock last) {
    reader_.drop();
    record_.reset();
    idle_ = last + 1;
    cycle_.reset(last);
}

Clock RecordPlayer::take_at() const {
    return reader_.holds() ? never : std::max({idle_, cycle_.settled_from(), source_.offered()});
}

Clock RecordPlayer::next(bool waits) const {
    const Clock found = std::min(cycle_.next(waits, reader_.ready()), take_at());
    return reader_.holds() && !finished_ ? std::min(found, reader_.ready()) : found;
}

Player::Counted RecordPlayer::at(Clock clock, const Now& now) {
    Counted counted;
    if (reader_.ready() == clock) counted.refused = finish(now.common);
    const CarrierCycle::End end = cycle_.look(clock, now.waits, now.hold, reader_.ready() <= clock);
    if (end.held) cycle_.hold(clock);
    if (end.commits())
        commit(clock);
    else if (end.ends)
        counted.underrun = cycle_.go_on(clock, end.ready);
    if (source_.drops(clock)) cycle_.ask(clock);
    if (source_.drops(clock) || source_.drops_silence(clock)) {
        reader_.drop();
        idle_ = clock + 1;
    } else if (take_at() <= clock) {
        reader_.take(clock, source_.take(clock), false);
        record_.reset();
        finished_ = false;
    }
    if (now.off && !end.commits()) cycle_.settle(clock);
    return counted;
}

/// @return whether the record is refused
bool RecordPlayer::finish(bool common) {
    finished_ = true;
    const std::size_t index = reader_.entry().index;
    if (!reader_.reads_words()) return index != 0;
    record_ = load(reader_.words(), index);
    const bool refused = !record_->playable || (common && !record_->common);
    if (refused) record_.reset();
    return refused;
}

std::shared_ptr<const RecordPlayer::Loaded> RecordPlayer::load(std::span<const std::uint16_t> words,
                                                               std::size_t index) {
    auto& known = known_[index];
    if (known && std::ranges::equal(known->words, words)) return known;
    auto loaded = std::make_shared<Loaded>();
    loaded->words.assign(words.begin(), words.end());
    const Header header = Header::of(words);
    loaded->lengths = {header.cycle_length, header.prescaler};
    loaded->playable = header.kind == static_cast<unsigned>(interface::Kind::timings) && header.in_bounds(p_);
    loaded->common = header.cycle_clocks() == carrier_period(p_);
    if (loaded->playable && header.pulse > 0) {
        auto firing = std::make_shared<Firing>(p_.channels);
        const std::uint32_t no_tick = (1U << p_.timing_bits) - 1;  // and all above
        for (std::uint32_t channel = 0; channel < p_.channels; ++channel) {
            const std::uint32_t timing = words[interface::record_header_words + channel];
            if (timing < no_tick && timing < header.cycle_length) firing->add(channel, timing, header.pulse);
        }
        firing->pulse = header.pulse;  // also when no channel has one
        loaded->firing = std::move(firing);
    }
    known = loaded;
    return loaded;
}

void RecordPlayer::commit(Clock clock) {
    const EntrySource::Entry entry = reader_.entry();
    if (record_)
        cycle_.commit(clock, entry, record_->lengths, record_->firing);
    else
        cycle_.commit(clock, entry, {}, nullptr);
    reader_.drop();
    record_.reset();
    idle_ = clock + 1;
}

}  // namespace haptogram::sim
