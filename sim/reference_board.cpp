// SPDX-License-Identifier: Apache-2.0
#include "reference_board.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/format/core.hpp"

namespace haptogram::sim {
namespace {

const interface::CoreConfiguration& configuration_named(std::string_view name) {
    if (const auto* found = interface::find_configuration(name)) return *found;
    throw bad_argument("configuration",
                       fmt::format("there is none called {}; there are {}", name, configuration_names()));
}

}  // namespace

ReferenceBoard::ReferenceBoard(std::string_view configuration, unsigned reset_clocks)
    : ReferenceBoard(configuration_named(configuration), reset_clocks) {}

ReferenceBoard::ReferenceBoard(const interface::CoreConfiguration& configuration, unsigned reset_clocks)
    : configuration_(configuration),
      p_(configuration_.parameters),
      window_(p_.max_high_clocks / 2 - 1),
      primary_(std::size_t{p_.records} * (p_.channels + interface::record_header_words)),
      sequence_(p_.sequence_depth),
      line_in_(p_),
      line_out_(p_),
      input_(p_),
      source_(p_, sequence_),
      sync_(carrier_period(p_)),
      ring_(p_),
      stream_(p_),
      trigger_(p_),
      train_(p_.channels, p_.width_bits != 0 ? PulseTrain::Gaps::all : PulseTrain::Gaps::at_changes, 2 * window_),
      guard_(p_) {
    if (p_.width_bits != 0) {
        auto player = std::make_unique<DrivePlayer>(p_, primary_, source_, train_);
        frames_ = player.get();
        player_ = std::move(player);
    } else {
        player_ = std::make_unique<RecordPlayer>(p_, primary_, source_, train_);
    }
    outputs_.pins.assign((p_.channels + 31) / 32, 0);
    train_.on_change([this](Clock clock, std::uint32_t channel, bool rises) {
        if (on_edge_) on_edge_({clock, channel, index_, rises});
    });
    schedule_.has_trigger = p_.trigger != 0;
    trigger_.on_change([this](Clock clock, bool level) {
        if (on_trigger_) on_trigger_({clock, level});
    });
    sync_.on_change([this](Clock clock, bool level) {
        if (on_sync_) on_sync_({clock, level});
    });
    reset_play(0);
    reset(reset_clocks);
}

Clock ReferenceBoard::next() const {
    return std::min({step_at_, reply_at_, old_stop_at_, line_in_.next(), line_out_.next(), source_.next(),
                     schedule_.next(), player_->next(guard_.allows() || sync_.together()), sync_.next(), guard_.next(),
                     stops_at_, reset_at_, judge_at_, stream_.next(), stream_wakes_,
                     p_.trigger != 0 ? trigger_.next() : never,
                     stop_changes_.empty() ? never : stop_changes_.front().clock});
}

void ReferenceBoard::run(std::uint64_t clocks) {
    const Clock end = now_ + clocks;
    for (Clock clock = std::max(now_, next()); clock < end; clock = std::max(now_, next())) {
        now_ = clock;
        edge(clock);
        now_ = clock + 1;
    }
    now_ = end;
    if (train_.awake() && now_ > 0) train_.advance(now_ - 1);
}

void ReferenceBoard::edge(Clock clock) {
    while (!stop_changes_.empty() && stop_changes_.front().clock <= clock) {
        stopped_ = stop_changes_.front().stopped;
        stop_changes_.pop_front();
    }
    if (p_.trigger != 0) schedule_.trigger(trigger_.comes(clock));
    if (clock == reply_at_) reply(clock);
    while (line_out_.next() <= clock) {
        const Arrival arrival{line_out_.next(), line_out_.arrive()};
        arrived_.push_back(arrival.byte);
        if (on_arrival_) on_arrival_(arrival);
    }
    enable_ = disable_ = false;
    if (line_in_.next() <= clock) {
        const LineIn::Event event = line_in_.at(clock);
        if (event.byte) byte_arrives(clock, *event.byte, event.began);
        // A break ends a frame, and a board that plays by itself needs no network.
        if (event.broken && p_.net == 0) byte_arrives(clock, 0, never);
        if (event.old != 0) old_bytes(clock, event.old);
        disable_ = event.broken || (event.lost && !source_.alone());
        if (disable_ || event.stops) source_.host_takes_over();
        if (event.stops) {
            unplayed_.begin(clock, input_.frames);
            old_[PortBytes::stop] = old_[PortBytes::stop] || input_.arriving();
            stops_at_ = clock + 1;
        }
        if (event.ends) end_session(clock);
        if (event.chained) line_out_.chain(clock, *event.chained);
    }
    if (clock == stops_at_) {
        stops_at_ = never;
        stop(clock);
    }
    if (clock == old_stop_at_) {
        old_stop_at_ = never;
        if (!unplayed_.waits()) stops_at_ = std::min(stops_at_, clock + 1);
    }
    while (clock == step_at_) go_on(clock);  // what is not answered ends in the clock in which the next frame begins
    if (clock == reset_at_)
        reset_play(reset_last_);
    else if (clock > began_)
        play(clock);
    if (p_.trigger != 0) trigger(clock);
}

/// What this clock does to the trigger pins, and what they do from the next one on.
void ReferenceBoard::trigger(Clock clock) {
    const bool mute = trigger_.mute();
    ports_.enabled = guard_.enabled();
    ports_.playing = guard_.enabled() && index_ != 0;
    ports_.index = index_;
    trigger_.edge(clock, ports_);
    ports_.starts = ports_.mark = ports_.pass = ports_.samples = false;
    if (trigger_.mute() != mute) guard_.wake_at(clock + 1);
}

/// Nothing waits for the trigger while outputs are off.
void ReferenceBoard::disarm(Clock clock) {
    if (!schedule_.by_trigger()) return;
    if (!disable_ && !stopped_ && !stale_.active(clock) && !sync_.out_of_step() && !guard_.acts(clock)) return;
    static_cast<void>(schedule_.take_start());
    schedule_.modulation_waits(false);
}

/// What plays and supervises, after the commands of this clock.
void ReferenceBoard::play(Clock clock) {
    if (clock == judge_at_) {
        // A pin that was high through a whole window, as the guard sees it one clock after the pin, trips it.
        train_.advance(clock - 1);
        if (train_.any_high_since(clock - window_)) guard_.trip_at(clock + 2);
        judge_at_ += window_;
    }
    disarm(clock);
    if (schedule_.opens(clock)) open_gate(clock);
    const bool unplayed = unplayed_.active(clock), stale = stale_.active(clock),
               identified = std::exchange(identified_, false), moved = std::exchange(moved_, false);
    if (p_.stream != 0) stream_turn(clock);
    const bool starts = source_.at(clock);
    if (starts) {
        guard_.set_watchdog(clock, 0);
        enable_ = true;
    }
    const bool out_of_step = sync_.out_of_step(), together = sync_.together();
    const CarrierSync::Step step = sync_.step(clock, player_->cycle().last(clock), schedule_.period(clock));
    if (sync_.out_of_step() != out_of_step) guard_.wake_at(clock + 1);
    const Guard::Verdict verdict = guard_.at(
        clock, enable_, disable_ || stopped_ || stale_.active(clock) || out_of_step, step.lost, trigger_.mute());
    const bool by_itself = stopped_ || verdict.expired || verdict.tripped || step.lost;
    if (disable_ || by_itself) switched_off(clock, by_itself);
    count_.missed = static_cast<std::uint16_t>(count_.missed + step.missed);
    count_.lost = static_cast<std::uint16_t>(count_.lost + step.lost);
    count_.watchdog = static_cast<std::uint16_t>(count_.watchdog + verdict.expired);
    count_.guard = static_cast<std::uint16_t>(count_.guard + verdict.tripped);

    const bool was_off = std::exchange(off_, off());
    const Player::Counted counted =
        player_->at(clock, {.waits = guard_.allows() || together,
                            .off = off_,
                            .hold = step.holds,
                            .common = together,
                            .streams = source_.streams(clock) || source_.drops_stream(clock),
                            .fade = fades_from_ <= clock ? std::optional(stream_.fade()) : std::nullopt});
    if (waits_for_memory_ && (source_.drops(clock) || source_.drops_silence(clock))) reply_at_ = clock + 1;
    const bool followed = source_.followed();
    if (followed) schedule_.drop_starts();
    if (p_.stream != 0)
        stream(clock, counted.goes,
               source_.supplanted(clock) || followed || unplayed || disable_ || stale || verdict.expired ||
                   verdict.tripped || identified || moved);
    source_.passed(clock);
    count_.underruns = static_cast<std::uint16_t>(count_.underruns + counted.underrun);
    count_.refused_records = static_cast<std::uint16_t>(count_.refused_records + counted.refused);
    count_.bent = static_cast<std::uint16_t>(count_.bent + counted.bent);
    count_.far = static_cast<std::uint16_t>(count_.far + counted.far);
    ports_.samples = counted.samples;
    if (off_ && !player_->cycle().settled(clock + 1)) guard_.wake_at(clock + 1);

    const bool wanted = on_edge_ || clock < pulses_asked_to_ || clock < player_->cycle().may_merge_to();
    if (wanted && !train_.awake()) {
        train_.wake(clock - 1);
        judge_at_ = next_judgement(clock + 1);
    } else if (!wanted && train_.awake()) {
        train_.sleep();
        judge_at_ = never;
    }
    if (const auto start = player_->cycle().starts_at_pins(clock)) {
        if (train_.awake()) train_.advance(clock - 1);
        index_ = start->index;
        started_at_ = clock;
        ports_.starts = true;
        ports_.mark = start->mark;
        ports_.pass = start->pass;
        if (p_.sync == 0) schedule_.period_begins(clock);
        if (on_cycle_start_) on_cycle_start_({clock, index_, guard_.enabled()});
    }
    if (step.load) schedule_.load(clock, *step.load);
    if (step.ends && p_.sync != 0) schedule_.period_begins(clock);  // boards in step count the ends of cycles
    if (off_ && !was_off) train_.stop(clock);
    if (!off_ && was_off) train_.resume(clock);
}

/// What the period plays whose turn it is.
void ReferenceBoard::stream_turn(Clock clock) {
    const bool plays = source_.streams(clock);
    const PatternStream::Turn turn = stream_.turn(clock, plays);
    count_.stream_lost = static_cast<std::uint16_t>(count_.stream_lost + turn.lost);
    if (turn.index && !plays) {
        if (!source_.supplanted(clock)) {
            cut_ = cut_ || pushing(clock);
            schedule_.drop_pushed();
        }
        source_.stream_begins(clock);
        fades_from_ = never;
    }
    if (turn.index) source_.stream_offers(clock, *turn.index);
    if (turn.ends) {
        source_.stream_ends(clock);
        fades_from_ = clock + 1;
    }
}

/// @param forgets  something happens in this clock that ends a stream in the next one
void ReferenceBoard::stream(Clock clock, bool goes, bool forgets) {
    if (goes) stream_.go(clock, schedule_.period(clock));
    const bool ends = stream_.forgets(clock);
    if (source_.streams(clock) && (goes || ends)) source_.stream_withdraws(clock);
    if (source_.streams(clock) && ends) source_.stream_ends(clock);
    if (ends) fades_from_ = never;
    const bool held = stopped_ || sync_.out_of_step();
    stream_.end(clock, forgets, held);
    stream_wakes_ = forgets || (held && (source_.streams(clock) || fades_from_ != never)) ? clock + 1 : never;
}

/// With amplitudes, the pins are let go a clock earlier.
bool ReferenceBoard::off() const { return frames_ != nullptr ? !guard_.pulses() : guard_.off(); }

/// @param last  clock of the reset; from the next one on they go on
void ReferenceBoard::reset_play(Clock last) {
    if (train_.awake()) train_.advance(now_ - 1);  // what came before still belongs to the record
    index_ = 0;
    started_at_ = never;
    count_ = {};
    guard_.reset();
    off_ = true;
    source_.reset(last);
    schedule_.reset();
    const Clock first = reset_at_ == never ? last : reset_at_;
    if (p_.stream != 0) {
        stream_.end(last, true, stopped_);
        stream_wakes_ = last + 1;
        if (last > first && source_.streams(last)) source_.stream_ends(last);
    }
    sync_.reset(first, last, std::exchange(next_role_, interface::Role::alone));
    player_->reset(first, last);
    reset_at_ = never;
    began_ = last;
    if (judge_at_ != never) judge_at_ = next_judgement(last);
    if (waits_for_memory_) reply_at_ = last + 1;
}

/// The last clock of each window, from this clock on.
Clock ReferenceBoard::next_judgement(Clock from) const {
    from = std::max(from, began_);
    return began_ + ((from - began_) / window_ + 1) * window_ - 1;
}

/// The reset input, high for so many clocks from now on. What plays is reset a clock later, and off at once.
void ReferenceBoard::reset(unsigned clocks) {
    if (clocks == 0) return;
    const Clock last = now_ + clocks - 1;
    // What is under way in its first clock still takes place, as far as it is not reset.
    enable_ = false;
    if (now_ == step_at_) go_on(now_);
    disable_ = true;
    if (now_ > began_) play(now_);
    trigger_.reset(now_, last);
    if (p_.trigger != 0) trigger(now_);
    step_ = Step::waiting;
    reply_ = Reply::idle;
    step_at_ = reply_at_ = stops_at_ = never;
    free_from_ = last + 1;
    taken_before_ = first_words_ = second_words_ = 0;
    session_ = false;
    stale_ = unplayed_ = ended_ = {};
    old_ = {};
    old_began_ = old_stop_at_ = session_ends_at_ = never;
    session_ended_ = false;
    input_.reset();
    line_in_.reset(last);
    if (line_in_.next() <= now_) static_cast<void>(line_in_.at(now_));  // the host goes on sending
    line_out_.reset(now_);
    waits_for_memory_ = false;
    reset_at_ = now_ + 1;
    reset_last_ = last + 1;
    next_role_ = interface::Role::alone;
    // The input is sampled twice, and says stopped during reset.
    stop_changes_ = {{now_ + 1, true}, {last + 3, stop_pressed_}};
    ++now_;
    run(clocks - 1);
}

const Model::Outputs& ReferenceBoard::outputs() {
    const Clock last = now_ - 1;
    if (!train_.awake()) {
        train_.wake(last);
        judge_at_ = next_judgement(now_);
    }
    pulses_asked_to_ = now_ + 2 * window_;
    train_.advance(last);
    outputs_.tx = line_out_.level(last);
    outputs_.enabled = guard_.enabled();
    outputs_.alive = last > began_ && (last - began_) / window_ % 2 == 1;
    outputs_.playing = guard_.enabled() && index_ != 0;
    outputs_.fault = guard_.fault();
    outputs_.sync = sync_.driven();
    outputs_.cycle_start = started_at_ == last;
    outputs_.trigger = trigger_.level();
    outputs_.index = index_;
    outputs_.pins = train_.pins();
    outputs_.test = trigger_.test(last, [this](std::uint32_t channel) {
        return channel < p_.channels && (outputs_.pins[channel / 32] >> channel % 32 & 1U) != 0;
    });
    return outputs_;
}

void ReferenceBoard::press_stop(bool pressed) {
    stop_pressed_ = pressed;
    while (!stop_changes_.empty() && stop_changes_.back().clock >= now_ + 2) stop_changes_.pop_back();
    stop_changes_.push_back({now_ + 2, pressed});
    guard_.wake_at(now_ + 2);
}

void ReferenceBoard::on_edge(std::function<void(const Edge&)> callback) {
    static_cast<void>(outputs());  // finds the state from which on changes are told
    on_edge_ = std::move(callback);
}

}  // namespace haptogram::sim
