// SPDX-License-Identifier: Apache-2.0
#include "reference_drive_player.hpp"

#include <algorithm>
#include <utility>

namespace haptogram::sim {
namespace {

namespace field = interface::parameters_field;

constexpr std::uint32_t lead_beside_channels = 44;

// Of a record, from the clock in which its entry is taken.
constexpr Clock drive_clocks = 4;  // until its drives are whole, beside one for each word
constexpr Clock base_clocks = 2;   // until a focus record's place is worked out, in two clocks
constexpr Clock place_clocks = 3;
// Of a focus record, from the clock in which its words are there.
constexpr Clock engine_clocks = 35;  // until its drives are whole, beside one for each focus and channel

// Of a period's words, from the clock in which they are begun.
constexpr Clock sample_clocks =
    4;                             // until its sample is there, and the slew limiter knows whether the pins were silent
constexpr Clock slew_clocks = 18;  // until the slew limiter has its share
constexpr Clock word_clocks = 14;  // until a word is there
constexpr Clock between_periods = 4;

}  // namespace

DrivePlayer::DrivePlayer(const interface::CoreParameters& p, const std::vector<std::uint16_t>& primary,
                         EntrySource& source, PulseTrain& train)
    : Player(p, primary, source, train),
      settings(carrier_period(p)),
      modulation(p.modulation_depth),
      geometry(p.channels),
      lead_(p.channels + lead_beside_channels),
      drives_(p.channels),
      model_(p.channels, p.timing_bits, p.width_bits, p.min_pulse_clocks) {}

void DrivePlayer::reset(Clock, Clock last) {
    sweep_.reset();
    quiet_pins_ = true;
    firing_.reset();
    reader_.drop();
    loaded_ = prepared_ = bent_ = missed_ = changed_ = go_ = never;
    idle_ = last + 1;
    foci_.clear();
    given_ = owed_ = busy_ = taken_ = plays_ = again_ = false;
    raw_ = silent_ = true;
    mute_ = false;
    entry_ = {};
    lengths_ = {0, 1};
    quiet_from_ = 0;
    const std::uint32_t period = carrier_period(p_);
    const std::uint32_t room = period - period / 4;
    wait_ticks_ = room > lead_ ? room - lead_ : 0;
    modulation.reset();
    cycle_.reset(last);
    seen_ = last;
    moved_ = true;
}

Clock DrivePlayer::next(bool waits) const {
    if (moved_) return seen_ + 1;
    Clock found = cycle_.next(waits, taken_ ? prepared_ : never);
    const auto consider = [&](Clock clock) {
        if (clock > seen_) found = std::min(found, clock);
    };
    if (reader_.holds()) {
        consider(reader_.taken() + base_clocks);
        consider(reader_.taken() + place_clocks);
        consider(reader_.ready());
        consider(loaded_);
        if (loaded_ != never) consider(loaded_ - 1);
    } else {
        consider(std::max({seen_ + 1, idle_, source_.offered()}));
    }
    if (sweep_) {
        consider(sweep_->begins);
        consider(sweep_->prepared);
    }
    for (const Clock clock : {go_, quiet_from_, prepared_, bent_, missed_, cycle_.settled_from()}) consider(clock);
    return found;
}

Player::Counted DrivePlayer::at(Clock clock, const Now& now) {
    Counted counted;
    fade_ = now.fade;
    go_on_loading(clock, now.common, counted);
    if (sweep_ && sweep_->begins == clock && std::exchange(quiet_pins_, false)) model_.start_from_silence();
    if (now.off) quiet_pins_ = true;
    if (sweep_ && sweep_->prepared == clock) end_sweep(clock);
    counted.bent = bent_ == clock && !now.off;

    // The cycle.
    const bool preempt = source_.drops(clock);
    const bool settled = cycle_.settled(clock);
    const bool prepared = prepared_ <= clock;
    const bool cycle_starts = clock == cycle_.begun() + 1;
    const Clock ticks = cycle_.prescaler();
    const bool follows = cycle_.follows(clock), asked = cycle_.asked(clock);
    const CarrierCycle::End end = cycle_.look(clock, now.waits, now.hold, prepared && taken_);
    const bool commits = end.commits();
    const bool renewed = end.ends && prepared && !taken_ && settled;

    // What the next period plays.
    const bool quiet = clock >= quiet_from_ && !owed_ && !cycle_starts;
    const bool wanted = loaded_ <= clock && follows && !preempt;
    const bool goes = quiet && ((go_ <= clock && !given_) || (!now.waits && asked && wanted));
    const bool period = (goes && !given_) || (owed_ && clock >= quiet_from_);
    const bool idle = !busy_ && settled;
    counted.goes = goes && !given_;
    const bool promptly = idle && !plays_ && !now.streams && wanted && (next_.silent || !next_.amplitudes);
    const bool takes_over = promptly || (idle && goes && wanted);
    const bool renews = idle && goes && plays_ && !wanted;
    const bool drops = preempt && taken_ && raw_ && !plays_ && !commits;
    moved_ = end.held || end.ends || cycle_starts || goes || period || takes_over || drops || preempt;

    // From here on registers change.
    if (end.held) cycle_.hold(clock);
    if (commits)
        cycle_.commit(clock, entry_, silent_ ? std::nullopt : std::optional<CarrierCycle::Lengths>(lengths_), firing_);
    else if (end.ends)
        counted.underrun = renewed ? cycle_.go_on(clock, end.ready, firing_) : cycle_.go_on(clock, end.ready);
    if (preempt || (commits && again_)) cycle_.ask(clock);
    if (now.off && !commits && !renewed) cycle_.settle(clock);

    counted.underrun = counted.underrun || missed_ == clock;
    if (cycle_starts && plays_ && changed_ != clock - 1) missed_ = clock + 1;
    if (cycle_starts) go_ = clock + 1 + wait_ticks_ * ticks;
    if (commits && !silent_) {
        const bool short_ticks = lengths_.prescaler == 1;
        const std::uint32_t lead = short_ticks ? lead_ : lead_ / 2 + 1;
        const std::uint32_t room = short_ticks ? lengths_.cycle - lengths_.cycle / 4 : lengths_.cycle;
        wait_ticks_ = room > lead ? room - lead : 0;
    }
    if (cycle_starts && !given_)
        owed_ = true;
    else if (period)
        owed_ = false;
    if (cycle_starts)
        given_ = false;
    else if (goes)
        given_ = true;
    if (period) {
        counted.samples = modulation.period(clock);
        quiet_from_ = clock + between_periods;
    }

    if (commits)
        again_ = false;
    else if (preempt && taken_ && !drops)
        again_ = true;
    if (commits) plays_ = !raw_;
    if (commits || renewed) changed_ = clock;
    if (drops) {
        quiet_pins_ = true;
        cycle_.drop();
    }
    if (drops || commits || renewed) {
        busy_ = taken_ = false;
        prepared_ = never;
        firing_.reset();
        sweep_.reset();
    } else if (takes_over || renews) {
        busy_ = true;
        taken_ = takes_over;
    }
    if (takes_over) take_over(clock);
    if (renews) begin_sweep(clock, false);

    // The loader.
    if (preempt || takes_over || source_.drops_silence(clock)) {
        free_loader(clock);
    } else if (!reader_.holds() && std::max(idle_, source_.offered()) <= clock) {
        const EntrySource::Entry entry = source_.take(clock);
        reader_.take(clock, entry, is_focus(entry));
        moved_ = true;
    }
    seen_ = clock;
    return counted;
}

// ---- Once a record

void DrivePlayer::free_loader(Clock clock) {
    reader_.drop();
    loaded_ = never;
    foci_.clear();
    idle_ = clock + 1;
}

void DrivePlayer::go_on_loading(Clock clock, bool common, Counted& counted) {
    if (!reader_.holds()) return;
    if (reader_.seeks() && clock == reader_.taken() + base_clocks) base_ = field::foci_base.get(settings.at(clock));
    if (reader_.seeks() && clock == reader_.taken() + place_clocks) place(clock);
    if (clock == reader_.ready()) counted.refused = finish(clock, common);
    if (!foci_.empty() && clock + 1 == loaded_) counted.far = compute_foci(clock);
}

/// rtl/amplitudes/focus_place.v
void DrivePlayer::place(Clock clock) {
    const auto set = settings.at(clock);
    const std::uint32_t number = (reader_.entry().index - p_.records - 1U) & 0xffffU;
    const std::uint32_t words = 4 * (field::foci_last.get(set) + 1);
    const std::uint32_t first = 4 * base_ + number * words;
    foci_cycle_ = field::foci_cycle.get(set);
    if (number >= field::foci_count.get(set) ||
        first + words > p_.records * (p_.channels + interface::record_header_words))
        reader_.refuse();
    else
        reader_.place(first, words);
}

/// @return whether the record is refused
bool DrivePlayer::finish(Clock clock, bool common) {
    next_ = {};
    loaded_ = clock;
    if (!reader_.reads_words()) return reader_.entry().index != 0;
    if (is_focus(reader_.entry()))
        load_foci(reader_.words(), common);
    else
        load_words(reader_.words(), common);
    return next_.silent;
}

bool DrivePlayer::has_room(std::uint32_t cycle) const {
    const std::uint32_t widest = std::min((1U << p_.width_bits) - 1, longest_pulse_clocks(p_));
    return cycle >= 2 * lead_ && cycle <= 2 * widest;
}

/// rtl/record_header.v
void DrivePlayer::load_words(std::span<const std::uint16_t> words, bool common) {
    const Header header = Header::of(words);
    const bool amplitudes = header.kind == static_cast<unsigned>(interface::Kind::amplitudes);
    const std::uint32_t ticks = 1U << p_.timing_bits;
    const bool fits = amplitudes ? header.pulse == 0 && header.prescaler == 1 && has_room(header.cycle_length)
                                 : header.cycle_length <= ticks || header.cycle_length >= ticks + (1U << p_.width_bits);
    const bool known = amplitudes || header.kind == static_cast<unsigned>(interface::Kind::timings);
    if (!known || !fits || !header.in_bounds(p_) || (common && header.cycle_clocks() != carrier_period(p_))) return;
    next_ = {false, amplitudes, {header.cycle_length, header.prescaler}, header.pulse, {}};
    next_.drives.reserve(p_.channels);
    for (const std::uint16_t word : words.subspan(interface::record_header_words))
        next_.drives.push_back(
            amplitudes ? Emission{static_cast<std::uint16_t>((word >> 8) * 257), static_cast<std::uint16_t>(word << 8)}
                       : Emission{0xffff, word});
    loaded_ = std::max(reader_.ready(), reader_.taken() + drive_clocks + words.size());
}

void DrivePlayer::load_foci(std::span<const std::uint16_t> words, bool common) {
    bool reserved = false;
    for (std::size_t word = 3; word < words.size(); word += 4) reserved = reserved || (words[word] & 0xc0U) != 0;
    if (reserved || !has_room(foci_cycle_) || (common && foci_cycle_ != carrier_period(p_))) return;
    next_ = {false, true, {foci_cycle_, 1}, 0, {}};
    for (std::size_t word = 0; word < words.size(); word += 4)
        foci_.push_back({words[word], words[word + 1], words[word + 2], words[word + 3]});
    loaded_ = reader_.ready() + engine_clocks + p_.channels * foci_.size();
}

/// @return whether a focus was too far from a channel
bool DrivePlayer::compute_foci(Clock clock) {
    const auto set = settings.at(clock);
    if (!std::ranges::equal(set, computed_by_) || geometry != computed_for_) {
        std::ranges::copy(set, computed_by_.begin());
        computed_for_ = geometry;
        computed_.clear();
    }
    const std::size_t number = reader_.entry().index - p_.records - 1U;
    if (number >= computed_.size()) computed_.resize(number + 1);
    Computed& known = computed_[number];
    if (known.foci != foci_) {
        known = {foci_, false, {}};
        known.drives.reserve(p_.channels);
        for (const ChannelDrive& drive :
             engine_outputs(geometry, field::wave_number.get(set), static_cast<std::uint16_t>(field::gain.get(set)),
                            foci_, field::foci_whole.get(set) != 0)) {
            known.drives.push_back({drive.amplitude, drive.phase});
            known.far = known.far || drive.far;
        }
    }
    next_.drives = known.drives;
    return known.far;
}

// ---- Once a carrier period

/// A record of timings is made once and needs no sample; silence after one needs no words. Silence after a record of
/// amplitudes is that record with all amplitudes at 0.
void DrivePlayer::take_over(Clock clock) {
    entry_ = reader_.entry();
    silent_ = next_.silent && raw_;
    mute_ = next_.silent;
    if (!next_.silent) {
        raw_ = !next_.amplitudes;
        lengths_ = next_.lengths;
        drives_ = std::move(next_.drives);
        raw_pulse_ = next_.pulse;
    }
    if (silent_)
        prepared_ = clock + 1;
    else
        begin_sweep(clock, true);
}

void DrivePlayer::begin_sweep(Clock clock, bool new_target) {
    const auto set = settings.at(clock);
    Sweep& sweep = sweep_.emplace();
    sweep.first = clock + 1;
    sweep.begins = raw_ ? never : clock + sample_clocks;
    if (!raw_) sweep.first += sample_clocks + (p_.slew != 0 ? slew_clocks : 0);
    sweep.prepared = sweep.first + p_.channels + word_clocks;
    const std::uint32_t mode = fade_ ? static_cast<unsigned>(Slew::rate) : field::slew.get(set);
    const bool limits = p_.slew != 0 && mode <= static_cast<unsigned>(Slew::arrive);
    sweep.period = {
        .cycle_ticks = lengths_.cycle,
        .modulation = 255,  // the sample of each channel is the one of its own clock
        .new_target = new_target,
        .raw = raw_,
        .raw_ticks = raw_pulse_,
        .slew = {
            .mode = limits ? static_cast<Slew>(mode) : Slew::none,
            .phase_rate = static_cast<std::uint16_t>(fade_ ? field::phase_rate.most() : field::phase_rate.get(set)),
            .amplitude_rate = fade_.value_or(static_cast<std::uint16_t>(field::amplitude_rate.get(set))),
            .arrival_periods = static_cast<std::uint16_t>(std::max(field::arrival.get(set), 1U))}};
}

std::vector<EmissionWord> DrivePlayer::words_of(const Sweep& sweep) {
    std::vector<Emission> emissions = drives_;
    if (!sweep.period.raw)
        for (std::uint32_t channel = 0; channel < p_.channels; ++channel) {
            const std::uint32_t sample = modulation.sample(sweep.first + channel + 1);
            const std::uint64_t amplitude = mute_ ? 0 : emissions[channel].amplitude;
            emissions[channel].amplitude = static_cast<std::uint16_t>(amplitude * (257 * sample + 1) >> 16);
        }
    return model_.as_played(emissions, sweep.period);
}

void DrivePlayer::end_sweep(Clock clock) {
    const std::vector<EmissionWord> words = words_of(*sweep_);
    auto firing = std::make_shared<Firing>(p_.channels);
    for (std::uint32_t channel = 0; channel < p_.channels; ++channel) {
        const EmissionWord& word = words[channel];
        if (word.bent) bent_ = clock;
        if (word.width == 0) continue;
        if (word.early)
            firing->add_early(channel, word.rise, word.width, word.fall);
        else
            firing->add(channel, word.rise, word.width);
    }
    firing->centred = !raw_;
    if (firing->pulse > 0) firing_ = std::move(firing);
    cycle_.prepare(clock, lengths_.cycle, firing_);
    prepared_ = sweep_->prepared;
    sweep_.reset();
}

}  // namespace haptogram::sim
