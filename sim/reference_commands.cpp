// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <span>
#include <utility>

#include "reference_board.hpp"

namespace haptogram::sim {

using interface::Command;
using interface::Status;

std::optional<ReferenceBoard::Shape> ReferenceBoard::shape_of(Command command) {
    switch (command) {
        case Command::identify: return Shape{0, false, Carries::identity};
        case Command::write: return Shape{2, true, Carries::nothing};
        case Command::read:
        case Command::digest: return Shape{3, false, Carries::memory};
        case Command::select: return Shape{2, false, Carries::nothing};
        case Command::push: return Shape{1, true, Carries::nothing};
        case Command::start: return Shape{3, false, Carries::nothing};
        case Command::watchdog: return Shape{1, false, Carries::nothing};
        case Command::modulate:
        case Command::gate: return Shape{3, false, Carries::nothing};
        case Command::stream: return Shape{3, true, Carries::nothing};
        case Command::push_foci: return Shape{1, true, Carries::nothing};
        case Command::sync: return Shape{1, false, Carries::nothing};
        case Command::status: return Shape{0, false, Carries::status};
        case Command::enable:
        case Command::disable:
        case Command::stop:
        case Command::keep_alive:
        case Command::reset: return Shape{0, false, Carries::nothing};
    }
    return {};
}

/// @param began  when the byte did on a serial line
void ReferenceBoard::byte_arrives(Clock clock, std::uint8_t byte, Clock began) {
    if (byte != 0 && !input_.arriving() && began != never && began == old_began_) old_[PortBytes::off] = true;
    const FrameInput::Outcome outcome = input_.byte(clock, byte, words_taken(clock));
    if (outcome == FrameInput::Outcome::damaged) ++count_.damaged;
    if (outcome == FrameInput::Outcome::good) ++count_.good;
    const bool good = outcome == FrameInput::Outcome::good;
    const bool disables = input_.urgent(Command::disable), stops = input_.urgent(Command::stop);
    if (disables || stops) source_.host_takes_over();
    if (disables || (old_[PortBytes::off] && good)) {
        stale_.begin(clock, input_.frames);
        guard_.wake_at(clock + 1);
    }
    if (stops || (old_[PortBytes::stop] && good)) unplayed_.begin(clock, input_.frames);
    if (old_[PortBytes::end] && good) ended_.begin(clock, input_.frames);
    if (stops) stops_at_ = clock + 1;
    if (!input_.arriving()) old_ = {};
    if (good && step_ == Step::waiting) await_frame(free_from_);
}

/// What comes from a network port in this clock was sent before something.
void ReferenceBoard::old_bytes(Clock clock, std::uint8_t old) {
    const auto is = [old](PortBytes::Event event) { return (old >> event & 1U) != 0; };
    if (is(PortBytes::off)) {
        stale_.begin(clock, input_.frames);
        guard_.wake_at(clock + 1);
    }
    if (is(PortBytes::stop)) {
        unplayed_.begin(clock, input_.frames);
        old_stop_at_ = clock + 1;
    }
    if (is(PortBytes::end)) end_session(clock);
    for (const PortBytes::Event event : {PortBytes::off, PortBytes::stop, PortBytes::end})
        old_[event] = old_[event] || (is(event) && input_.arriving());
}

/// By anything but a DISABLE: what was sent before does not switch on again.
void ReferenceBoard::switched_off(Clock clock, bool by_itself) {
    stale_.begin(clock, input_.frames);
    if (input_.arriving())
        old_[PortBytes::off] = true;
    else if (const auto began = line_in_.coming())
        old_began_ = *began;
    if (by_itself) line_in_.mark(PortBytes::off);
}

void ReferenceBoard::end_session(Clock clock) {
    ended_.begin(clock, input_.frames);
    old_[PortBytes::end] = old_[PortBytes::end] || input_.arriving();
    if (session_ends_at_ == never) session_ends_at_ = clock + 1;
}

/// What ended before this clock's end is no session any more.
void ReferenceBoard::pass_session(Clock clock) {
    if (session_ends_at_ > clock) return;
    session_ended_ = session_ended_ || session_;
    session_ = false;
    session_ends_at_ = never;
}

std::uint64_t ReferenceBoard::words_taken(Clock clock) const {
    const auto of_run = [clock](Clock begin, std::uint64_t words) {
        return clock <= begin ? 0 : std::min(clock - begin, words);
    };
    return taken_before_ + of_run(first_run_, first_words_) +
           (step_ == Step::write ? written_ : of_run(second_run_, second_words_));
}

void ReferenceBoard::await_frame(Clock from) {
    free_from_ = from;
    step_ = input_.frames.empty() ? Step::waiting : Step::begin;
    step_at_ = input_.frames.empty() ? never : std::max(from, input_.frames.front().readable);
}

void ReferenceBoard::go_on(Clock clock) {
    switch (step_) {
        case Step::waiting:
        case Step::answered: return;
        case Step::begin: return begin(clock);
        case Step::settle:
            live_free_ = source_.live_free();
            if (is_message()) stream_.begin(clock, argument_period());
            step_ = Step::judge;
            step_at_ = clock + 1;
            return;
        case Step::judge: return judge(clock);
        case Step::write: return write(clock);
        case Step::close: return close(clock);
        case Step::execute: return execute(clock);
    }
}

/// The first word is taken: a word a clock up to the last argument, two clocks for the checks, then the verdict.
void ReferenceBoard::begin(Clock clock) {
    const std::vector<std::uint8_t>& bytes = input_.frames.front().bytes;
    word_.clear();
    for (std::size_t at = 0; at + 1 < bytes.size(); at += 2)
        word_.push_back(static_cast<std::uint16_t>(bytes[at] | bytes[at + 1] << 8));
    number_ = bytes[0];
    command_ = static_cast<Command>(bytes[1]);
    const std::optional<Shape> shape = shape_of(command_);
    shape_ = shape.value_or(Shape{});
    first_run_ = clock;
    first_words_ = 2;
    second_words_ = 0;
    written_ = 0;
    data_ = 1 + shape_.arguments;
    const std::size_t payload = bytes.size() - 2;
    const bool fits =
        payload % 2 == 0 && (shape_.tail ? payload > 2 * shape_.arguments : payload == 2 * shape_.arguments);
    if (!shape || !fits) return refuse(clock + 2, shape ? Status::bad_length : Status::unknown_command);
    first_words_ += shape_.arguments;
    region_ = shape_.carries == Carries::identity ? identity_region : status_region;
    address_ = 0;
    if (command_ == Command::write || shape_.carries == Carries::memory) {
        region_ = argument(1) >> 12;
        address_ = ((argument(1) << 16 & 0xfffffffU) | argument(0)) >> 1;
    }
    if (command_ == Command::push_foci) {
        region_ = primary_region;
        ring_.begin();
        address_ = ring_.address();
    }
    if (is_message()) region_ = primary_region;
    step_ = Step::settle;
    step_at_ = clock + 3 + shape_.arguments;
}

/// What is left of the frame is taken, a word a clock.
void ReferenceBoard::refuse(Clock clock, Status status) {
    status_ = status;
    second_run_ = clock + 1;
    second_words_ = input_.frames.front().words() - first_words_;
    step_ = Step::close;
    step_at_ = clock + 2 + second_words_;
}

void ReferenceBoard::judge(Clock clock) {
    if (ended_.active(clock)) return refuse(clock, Status::session_ended);
    pass_session(clock);
    const bool begins = command_ == Command::identify, its_own = number_ == session_number_;
    if (session_ended_ && (!begins || its_own)) return refuse(clock, Status::session_ended);
    const std::uint8_t ahead = static_cast<std::uint8_t>(number_ - expected_);
    const bool in_order = begins ? !session_ || !its_own : ahead == 0 && session_;
    const bool repeated = session_ && (begins ? its_own : ahead >= 0x80);
    if (is_message() ? !session_ || !its_own : !in_order && !repeated) return refuse(clock, Status::out_of_order);
    if (!is_message() && repeated && shape_.carries == Carries::nothing) return refuse(clock, Status::repeated);
    const Status found = verdict();
    if (found != Status::ok || !shape_.tail)
        return refuse(clock, found != Status::ok ? found : repeated ? Status::repeated : Status::ok);
    status_ = Status::ok;
    second_run_ = clock + 1;
    cut_ = false;
    foci_pushed_.clear();
    if (command_ == Command::write || command_ == Command::push_foci || is_message()) {
        step_ = Step::write;
        step_at_ = clock + 1;
        return;
    }
    second_words_ = word_.size() - data_;
    step_ = Step::close;
    step_at_ = clock + 3 + second_words_;
    for (std::size_t i = data_; i < word_.size(); ++i)
        if (word_[i] > top_index()) status_ = Status::bad_index;
}

interface::Status ReferenceBoard::verdict() const {
    switch (command_) {
        case Command::write:
        case Command::read:
        case Command::digest: return verdict_on_memory();
        case Command::select: return argument(0) > top_index() ? Status::bad_index : Status::ok;
        case Command::push:
            if (schedule_.takes_no_push()) return Status::bad_range;
            return word_.size() - data_ > live_free_ ? Status::fifo_full : Status::ok;
        case Command::start: {
            const bool good = argument(1) == 0 ? source_.header_valid()
                                               : argument(0) > 0 && argument(0) + argument(1) <= p_.sequence_depth;
            return good ? Status::ok : Status::bad_range;
        }
        case Command::enable:
            return stopped_ ? Status::stopped : sync_.out_of_step() ? Status::out_of_step : Status::ok;
        case Command::gate:
            if (p_.schedule == 0) return Status::unknown_command;
            if (schedule_.busy(argument_period())) return Status::gate_busy;
            return p_.trigger != 0 && stopped_ && argument_period() == Schedule::at_trigger ? Status::stopped
                                                                                            : Status::ok;
        case Command::sync:
            if (p_.sync == 0) return Status::unknown_command;
            return argument(0) > static_cast<unsigned>(interface::Role::slave) ? Status::bad_range : Status::ok;
        case Command::modulate: {
            if (p_.modulation_depth == 0) return Status::unknown_command;
            const std::uint32_t length = argument(1), form = argument(2);
            const bool beyond = p_.schedule == 0 ? length > p_.modulation_depth || form > 1
                                                 : (form & ~1U) + std::max(length, 1U) > p_.modulation_depth;
            return argument(0) != 0 && beyond ? Status::bad_range : Status::ok;
        }
        case Command::push_foci:
            if (p_.foci == 0) return Status::unknown_command;
            if (!ring_.usable(record_foci(), top_index()) || schedule_.takes_no_push()) return Status::bad_range;
            return word_.size() - data_ > std::size_t{4} * live_free_ * record_foci() ? Status::fifo_full : Status::ok;
        case Command::stream:
            if (p_.stream == 0) return Status::unknown_command;
            return stream_.usable(frames_->settings.at(now_), top_index()) ? Status::ok : Status::bad_range;
        default: return Status::ok;
    }
}

std::uint32_t ReferenceBoard::record_foci() const {
    return interface::parameters_field::foci_last.get(frames_->settings.at(now_)) + 1;
}

std::uint32_t ReferenceBoard::top_index() const {
    if (p_.foci == 0) return p_.records;
    const std::uint32_t count = interface::parameters_field::foci_count.get(frames_->settings.at(now_));
    return std::min(p_.records + count, 0xffffU);
}

std::size_t ReferenceBoard::region_words(bool writes) const {
    if (region_ == primary_region) return primary_.size();
    if (region_ == sequence_region) return 2 * sequence_.size();
    if (region_ == identity_region && !writes) return interface::identity_words;
    if (region_ == status_region && !writes) return status_words();
    if (region_ == parameters_region && p_.width_bits != 0) return interface::parameters_words;
    if (region_ == geometry_region && writes && p_.foci != 0) return std::size_t{4} * p_.channels;
    if (region_ == modulation_region) return p_.modulation_depth / 2;
    if (region_ == ring_region && p_.foci != 0) return interface::ring_words;
    if (region_ == stream_region && p_.stream != 0) return interface::stream_words;
    if (region_ == trigger_region && p_.trigger != 0)
        return writes ? interface::trigger_settings : interface::trigger_words;
    return 0;
}

interface::Status ReferenceBoard::verdict_on_memory() const {
    const bool writes = command_ == Command::write;
    const std::size_t words = writes ? word_.size() - data_ : argument(2) / 2;
    const bool odd = argument(0) % 2 != 0 || (!writes && argument(2) % 2 != 0);
    if (words == 0 || (!writes && words > p_.channels + interface::record_header_words)) return Status::bad_length;
    if (address_ + words > region_words(writes)) return Status::bad_address;
    if (odd || (region_ == sequence_region && (address_ % 2 != 0 || words % 2 != 0))) return Status::bad_alignment;
    return Status::ok;
}

/// Whether what plays reads the word that is to be written, or all of its region.
bool ReferenceBoard::held(Clock clock) const {
    if (region_ == primary_region) return player_->reader().reads(clock, address_);
    if (region_ == modulation_region) return frames_->modulation.fetching(clock);
    return region_ == sequence_region && source_.fetching(clock);
}

/// One word a clock, but none in a clock in which the player reads it.
void ReferenceBoard::write(Clock clock) {
    step_at_ = clock + 1;
    if (is_message()) return write_pattern(clock);
    if (held(clock)) return;
    put(clock, word_[data_ + written_]);
    ++address_;
    if (command_ == Command::push_foci) {
        if (const std::uint16_t index = ring_.wrote(record_foci()); index != 0) foci_pushed_.push_back(index);
        address_ = ring_.address();
    }
    if (data_ + ++written_ < word_.size()) return;
    if (command_ == Command::push_foci && ring_.split()) status_ = Status::bad_length;
    written(clock);
}

/// Likewise, but those of a pattern that is not kept are only taken.
void ReferenceBoard::write_pattern(Clock clock) {
    if (!stream_.ready(clock)) return;
    const auto parameters = frames_->settings.at(clock);
    if (const auto place = stream_.place(parameters)) {
        address_ = *place;
        if (held(clock)) return;
        put(clock, word_[data_ + written_]);
    }
    const PatternStream::Counted counted = stream_.take(clock, parameters);
    count_.stream_late = static_cast<std::uint16_t>(count_.stream_late + counted.late);
    count_.stream_early = static_cast<std::uint16_t>(count_.stream_early + counted.early);
    count_.stream_repeated = static_cast<std::uint16_t>(count_.stream_repeated + counted.repeated);
    if (data_ + ++written_ < word_.size()) return;
    if (stream_.split()) status_ = Status::bad_length;
    written(clock);
}

void ReferenceBoard::written(Clock clock) {
    second_words_ = written_;
    second_run_ = clock + 1 - written_;
    step_ = Step::close;
    step_at_ = clock + 3;
}

void ReferenceBoard::put(Clock clock, std::uint16_t value) {
    switch (region_) {
        case primary_region:
            if (address_ >= primary_.size()) return;
            player_->reader().written(clock, address_, value);
            primary_[address_] = value;
            return;
        case sequence_region:
            if (address_ == 0) source_.header_written(clock, value);
            if (address_ % 2 == 0)
                low_half_ = value;
            else
                sequence_[address_ / 2] = static_cast<std::uint32_t>(value) << 16 | low_half_;
            return;
        case parameters_region:
            frames_->settings.write(clock, address_, value);
            moved_ = moved_ || address_ < 3;  // where foci lie
            return;
        case geometry_region: frames_->geometry[address_ / 4][address_ % 4] = value; return;
        case modulation_region: frames_->modulation.write(address_, value); return;
        case ring_region: ring_.set(address_, value); return;
        case stream_region: stream_.set(clock, address_, value); return;
        case trigger_region: trigger_.write(address_, value); return;
        default: return;
    }
}

void ReferenceBoard::close(Clock clock) {
    pass_session(clock);
    if (status_ == Status::ok && !is_message()) {
        session_ = !ended_.active(clock);
        session_ended_ = session_ended_ && !session_;
        if (command_ == Command::identify) session_number_ = number_;
        expected_ = static_cast<std::uint8_t>(number_ + 1);
        if (command_ == Command::push_foci) ring_.keep();
        const bool pushes = command_ == Command::push || command_ == Command::push_foci;
        if (pushes && unplayed_.active(clock)) schedule_.forget();
        if (pushes && !unplayed_.active(clock)) keep_pushed(clock);
    }
    taken_before_ += input_.frames.front().words();
    first_words_ = second_words_ = 0;
    step_ = Step::execute;
    step_at_ = clock + 1;
}

void ReferenceBoard::keep_pushed(Clock clock) {
    const Schedule::Use use = schedule_.use(clock);
    count_.late = static_cast<std::uint16_t>(count_.late + use.late);
    if (cut_) return;
    const bool behind = schedule_.push_is_waiting();
    const bool opens = behind && schedule_.opens(clock);
    if (use.turn == Schedule::Turn::waits) {
        schedule_.push_waits();
        static_cast<void>(schedule_.take_start());  // the later one stays
    }
    std::vector<EntrySource::Entry> entries;
    const auto dwell = static_cast<std::uint16_t>(argument(0));
    for (const std::uint16_t index : command_ == Command::push_foci ? std::span<const std::uint16_t>(foci_pushed_)
                                                                    : std::span(word_).subspan(data_))
        entries.push_back({index, dwell});
    const bool closed = behind || use.turn == Schedule::Turn::waits;
    if (!closed && source_.mode() != interface::Mode::live) drop_starts();
    source_.push(clock, entries, closed && !opens);
}

/// What waits for a period goes on: a START empties the live FIFO, also of what a PUSH is writing there.
void ReferenceBoard::open_gate(Clock clock) {
    if (schedule_.take_modulation()) frames_->modulation.begin(clock, false);
    if (const auto start = schedule_.take_start()) {
        cut_ = cut_ || pushing(clock);
        drop_starts();
        schedule_.drop_pushed();
        source_.start(clock, (*start)[0], (*start)[1], (*start)[2]);
    }
    if (!schedule_.push_is_waiting()) return;
    schedule_.drop_pushed();
    if (source_.mode() != interface::Mode::live) drop_starts();
    source_.open(clock);
}

void ReferenceBoard::drop_starts() {
    schedule_.drop_starts();
    source_.drop_follower();
}

void ReferenceBoard::stop(Clock clock) {
    drop_starts();
    schedule_.drop_pushed();
    schedule_.modulation_waits(false);
    schedule_.forget();
    source_.stop(clock);
}

void ReferenceBoard::modulate(Clock clock) {
    const auto word = [this](std::size_t i) { return static_cast<std::uint16_t>(argument(i)); };
    frames_->modulation.ask(clock, word(0), word(1), word(2));
    const Schedule::Use use = schedule_.use(clock);
    count_.late = static_cast<std::uint16_t>(count_.late + use.late);
    schedule_.modulation_waits(use.turn == Schedule::Turn::waits);
    if (use.turn != Schedule::Turn::waits) frames_->modulation.begin(clock, use.turn == Schedule::Turn::follows);
}

void ReferenceBoard::start(Clock clock, const Schedule::Arguments& arguments) {
    const Schedule::Use use = schedule_.use(clock);
    count_.late = static_cast<std::uint16_t>(count_.late + use.late);
    drop_starts();
    switch (use.turn) {
        case Schedule::Turn::waits: schedule_.start_waits(arguments); break;
        case Schedule::Turn::follows:
            schedule_.start_follows();
            source_.follow(clock, {arguments[0], arguments[1], arguments[2]});
            break;
        case Schedule::Turn::now:
            schedule_.drop_pushed();
            source_.start(clock, arguments[0], arguments[1], arguments[2]);
            break;
    }
}

void ReferenceBoard::execute(Clock clock) {
    if (status_ == Status::ok)
        apply(clock);
    else
        ++(status_ == Status::repeated ? count_.repeated : count_.refused);
    const std::uint64_t frame = input_.frames.front().number;
    stale_.done(clock, frame);
    ended_.done(clock, frame);
    if (unplayed_.done(clock, frame) && old_stop_at_ != clock + 1) stops_at_ = clock + 1;
    input_.frames.pop_front();
    if (is_message()) return await_frame(clock);
    step_ = Step::answered;
    step_at_ = never;
    begin_reply(clock);
}

void ReferenceBoard::apply(Clock clock) {
    if (command_ != Command::identify) guard_.kick(clock);
    if (shape_.carries == Carries::nothing) source_.host_takes_over();
    const bool may_play = !unplayed_.active(clock);  // otherwise a STOP that was sent later has acted already
    const auto word = [this](std::size_t i) { return static_cast<std::uint16_t>(argument(i)); };
    switch (command_) {
        case Command::enable: enable_ = !stale_.active(clock) && !ended_.active(clock); break;
        case Command::watchdog: guard_.set_watchdog(clock, word(0)); break;
        case Command::identify:
            schedule_.forget();
            identified_ = true;
            break;
        case Command::gate: schedule_.gate(argument_period()); break;
        case Command::modulate: modulate(clock); break;
        case Command::select:
            if (!may_play) break;
            drop_starts();
            schedule_.drop_pushed();
            source_.select(clock, {word(0), word(1)});
            break;
        case Command::start:
            if (may_play)
                start(clock, {word(0), word(1), word(2)});
            else
                schedule_.forget();
            break;
        case Command::sync: next_role_ = static_cast<interface::Role>(argument(0)); [[fallthrough]];
        case Command::reset: reset_at_ = reset_last_ = clock + 1; break;
        default: break;
    }
}

}  // namespace haptogram::sim
