// SPDX-License-Identifier: Apache-2.0
#include "reference_board.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <deque>
#include <utility>

#include "clock.hpp"
#include "haptogram/base/error.hpp"
#include "reference_frame_player.hpp"
#include "reference_frames.hpp"
#include "reference_guard.hpp"
#include "reference_line.hpp"
#include "reference_player.hpp"
#include "reference_pulses.hpp"
#include "reference_ring.hpp"
#include "reference_schedule.hpp"
#include "reference_source.hpp"
#include "reference_sync.hpp"

namespace haptogram::sim {
namespace {

using interface::Command;
using interface::Status;

enum class Carries { nothing, identity, status, memory };

/// What rtl/INTERFACE.md says of a command.
struct Shape {
    std::uint32_t arguments = 0;
    bool tail = false;  // data words follow the arguments
    Carries carries = Carries::nothing;
};

std::optional<Shape> shape_of(Command command) {
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

/// One step of the CRC-32 of IEEE 802.3, for a word that is read from memory.
std::uint32_t crc32(std::uint32_t crc, std::uint16_t word) {
    for (int bit = 0; bit < 16; ++bit) {
        const bool odd = ((crc ^ word >> bit) & 1U) != 0;
        crc = crc >> 1 ^ (odd ? 0xedb88320U : 0U);
    }
    return crc;
}

/// The number of a region is the upper four bits of its addresses.
constexpr std::uint32_t region_of(std::uint32_t address) { return address >> 28; }
constexpr std::uint32_t primary_region = region_of(interface::primary_base);
constexpr std::uint32_t sequence_region = region_of(interface::sequence_base);
constexpr std::uint32_t identity_region = region_of(interface::identity_base);
constexpr std::uint32_t status_region = region_of(interface::status_base);
constexpr std::uint32_t parameters_region = region_of(interface::parameters_base);
constexpr std::uint32_t geometry_region = region_of(interface::geometry_base);
constexpr std::uint32_t modulation_region = region_of(interface::modulation_base);
constexpr std::uint32_t ring_region = region_of(interface::ring_base);

/// A DISABLE or STOP that has arrived and acts before its turn, until it has been carried out or refused.
class Urgent {
public:
    [[nodiscard]] bool active(Clock clock) const { return from_ <= clock && clock <= to_; }
    /// @return whether it was not active before
    bool arrives(Clock clock, std::uint64_t frame) {
        frame_ = frame;
        if (from_ <= clock && to_ == never) return false;
        from_ = clock + 1;
        to_ = never;
        return true;
    }
    void done(Clock clock, std::uint64_t frame) {
        if (frame == frame_ && to_ == never) to_ = clock;
    }

private:
    Clock from_ = never, to_ = never;
    std::uint64_t frame_ = 0;
};

const interface::CoreConfiguration& configuration_named(std::string_view name) {
    for (const auto& configuration : interface::core_configurations)
        if (configuration.name == name) return configuration;
    std::string known;
    for (const auto& configuration : interface::core_configurations)
        known += fmt::format("{}{}", known.empty() ? "" : ", ", configuration.name);
    throw bad_argument("configuration", fmt::format("there is none called {}; there are {}", name, known));
}

}  // namespace

class ReferenceBoard::Core {
public:
    Core(const interface::CoreConfiguration& asked, unsigned reset_clocks)
        : configuration(asked),
          p_(configuration.parameters),
          window_(p_.max_high_clocks / 2 - 1),
          primary(std::size_t{p_.records} * (p_.channels + interface::record_header_words)),
          sequence(p_.sequence_depth),
          line_in(p_),
          line_out_(p_),
          input_(p_),
          source_(p_, sequence),
          sync_(carrier_period(p_)),
          ring_(p_),
          train_(p_.channels, p_.width_bits != 0 ? PulseTrain::Gaps::all : PulseTrain::Gaps::at_changes, 2 * window_),
          guard_(p_) {
        if (p_.width_bits != 0) {
            auto player = std::make_unique<FramePlayer>(p_, primary, source_, train_);
            frames_ = player.get();
            player_ = std::move(player);
        } else {
            player_ = std::make_unique<RecordPlayer>(p_, primary, source_, train_);
        }
        outputs_.pins.assign((p_.channels + 31) / 32, 0);
        train_.on_change([this](Clock clock, std::uint32_t channel, bool rises) {
            if (on_edge_) on_edge_({clock, channel, index_, rises});
        });
        sync_.on_change([this](Clock clock, bool level) {
            if (on_sync) on_sync({clock, level});
        });
        reset_play(0);
        reset(reset_clocks);
    }

    void run(std::uint64_t clocks);
    void reset(unsigned clocks);
    const Model::Outputs& outputs();
    [[nodiscard]] Present present() const { return {index_, guard_.enabled()}; }
    void press_stop(bool pressed);
    void on_edge(std::function<void(const Edge&)> callback);

    const interface::CoreConfiguration configuration;
    Clock now = 0;

private:
    const interface::CoreParameters& p_;
    const Clock window_;  // of the guard

public:
    std::vector<std::uint16_t> primary;
    std::vector<std::uint32_t> sequence;
    LineIn line_in;
    std::vector<std::uint8_t> arrived;
    std::function<void(const CycleStart&)> on_cycle_start;
    std::function<void(const Arrival&)> on_arrival;
    std::function<void(const SyncChange&)> on_sync;
    void drive_sync(bool level) { sync_.wire(now, level); }

private:
    [[nodiscard]] Clock next() const;
    void edge(Clock clock);
    void play(Clock clock);
    void reset_play(Clock last);
    [[nodiscard]] Clock next_judgement(Clock from) const;
    void byte_arrives(Clock clock, std::uint8_t byte);
    [[nodiscard]] std::uint64_t words_taken(Clock clock) const;

    // A frame from its first word to its answer.
    enum class Step { waiting, begin, settle, judge, write, close, execute, answered };
    void await_frame(Clock from);
    void go_on(Clock clock);
    void begin(Clock clock);
    void refuse(Clock clock, Status status);
    void judge(Clock clock);
    [[nodiscard]] Status verdict() const;
    [[nodiscard]] Status verdict_on_memory() const;
    void write(Clock clock);
    void close(Clock clock);
    void execute(Clock clock);
    void apply(Clock clock);
    [[nodiscard]] std::uint32_t argument(std::size_t word) const {
        return word_[1 + word];  // after the sequence number and the command
    }
    [[nodiscard]] std::uint64_t argument_period() const {
        return argument(0) | std::uint64_t{argument(1)} << 16 | std::uint64_t{argument(2)} << 32;
    }
    [[nodiscard]] std::uint32_t status_words() const {
        return p_.schedule != 0 ? interface::status_words : interface::status_untimed_words;
    }
    [[nodiscard]] bool pushing(Clock clock) const {
        if (command_ == Command::push_foci) return !foci_pushed_.empty();
        return step_ == Step::close && command_ == Command::push && second_run_ <= clock;
    }
    /// Words of the command's region that a host may write, or read.
    [[nodiscard]] std::size_t region_words(bool writes) const;
    [[nodiscard]] bool held(Clock clock) const;
    void put(Clock clock, std::uint16_t value);
    [[nodiscard]] std::uint32_t top_index() const;
    [[nodiscard]] std::uint32_t record_foci() const;
    [[nodiscard]] bool off() const;
    void open_gate(Clock clock);
    void stop(Clock clock);
    void keep_pushed(Clock clock);
    void drop_starts();
    void start(Clock clock, const Schedule::Arguments& arguments);
    void modulate(Clock clock);

    // Its reply.
    void begin_reply(Clock clock);
    void reply(Clock clock);
    void read_word(Clock clock);
    void end_reply(Clock clock);
    Clock collect(Clock offered, std::uint32_t word);
    [[nodiscard]] std::uint16_t memory_word() const;
    [[nodiscard]] std::uint16_t status_word(std::uint32_t word) const;

    LineOut line_out_;
    FrameInput input_;
    EntrySource source_;
    Schedule schedule_;
    CarrierSync sync_;
    FocusRing ring_;
    PulseTrain train_;
    std::unique_ptr<Player> player_;
    FramePlayer* frames_ = nullptr;  // the same, of boards with amplitudes
    Guard guard_;
    bool off_ = true;  // the pins are cleared

    // The stop input, as the board sees it two clocks later.
    bool stop_pressed_ = false, stopped_ = true;
    struct StopChange {
        Clock clock;
        bool stopped;
    };
    std::deque<StopChange> stop_changes_;

    // Commands.
    Step step_ = Step::waiting;
    Clock step_at_ = never, free_from_ = 0;
    std::uint64_t taken_before_ = 0;  // words of earlier frames
    Clock first_run_ = 0, second_run_ = 0;
    std::uint64_t first_words_ = 0, second_words_ = 0;
    std::vector<std::uint16_t> word_;         // of the frame: sequence number and command, arguments, data
    std::size_t data_ = 0;                    // number of the first data word
    std::size_t written_ = 0;                 // data words
    std::vector<std::uint16_t> foci_pushed_;  // indices of the focus records that a PUSH_FOCI has written
    std::uint16_t low_half_ = 0;              // of a word of sequence memory
    std::uint32_t live_free_ = 0;
    Command command_{};
    Shape shape_;
    Status status_{};
    std::uint8_t number_ = 0, expected_ = 0;
    bool session_ = false;
    std::uint32_t region_ = 0, address_ = 0;  // of a 16-bit word
    bool cut_ = false;                        // what the present PUSH has written so far is gone
    std::uint64_t told_period_ = 0;           // by the present reply
    Urgent urgent_disable_, urgent_stop_;
    Clock urgent_stop_at_ = never;           // the clock in which it begins to act
    bool enable_ = false, disable_ = false;  // what happens in the present clock

    // Replies.
    enum class Reply { idle, level, words };
    Reply reply_ = Reply::idle;
    Clock reply_at_ = never;
    std::uint32_t words_left_ = 0, digest_ = 0;
    bool waits_for_memory_ = false;  // until the player has read its record, or drops it

    // Supervision.
    struct Counters {
        std::uint16_t underruns, refused_records, good, damaged, repeated, refused, watchdog, guard, missed, lost, late,
            bent, far;
    } count_{};
    Clock reset_at_ = never, reset_last_ = 0;  // of what plays and supervises: when it begins, and its last clock
    Clock began_ = 0;                          // the last clock of the reset before
    interface::Role next_role_ = interface::Role::alone;  // from the next reset on
    Clock judge_at_ = never;                              // the guard looks at a window
    Clock pulses_asked_to_ = 0;

    // The pins.
    std::uint16_t index_ = 0;
    Clock started_at_ = never;
    std::function<void(const Edge&)> on_edge_;
    Model::Outputs outputs_;
};

// ---- The clock

Clock ReferenceBoard::Core::next() const {
    return std::min({step_at_, reply_at_, line_in.next(), line_out_.next(), source_.next(), schedule_.next(),
                     player_->next(guard_.allows() || sync_.together()), sync_.next(), guard_.next(), urgent_stop_at_,
                     reset_at_, judge_at_, stop_changes_.empty() ? never : stop_changes_.front().clock});
}

void ReferenceBoard::Core::run(std::uint64_t clocks) {
    const Clock end = now + clocks;
    for (Clock clock = std::max(now, next()); clock < end; clock = std::max(now, next())) {
        now = clock;
        edge(clock);
        now = clock + 1;
    }
    now = end;
    if (train_.awake() && now > 0) train_.advance(now - 1);
}

void ReferenceBoard::Core::edge(Clock clock) {
    while (!stop_changes_.empty() && stop_changes_.front().clock <= clock) {
        stopped_ = stop_changes_.front().stopped;
        stop_changes_.pop_front();
    }
    if (clock == reply_at_) reply(clock);
    while (line_out_.next() <= clock) {
        const Arrival arrival{line_out_.next(), line_out_.arrive()};
        arrived.push_back(arrival.byte);
        if (on_arrival) on_arrival(arrival);
    }
    enable_ = disable_ = false;
    if (line_in.next() <= clock) {
        const LineIn::Event event = line_in.at(clock);
        if (event.byte) byte_arrives(clock, *event.byte);
        disable_ = event.broken;
        if (event.chained) line_out_.chain(clock, *event.chained);
    }
    if (clock == urgent_stop_at_) {
        urgent_stop_at_ = never;
        stop(clock);
    }
    if (clock == step_at_) go_on(clock);
    if (clock == reset_at_)
        reset_play(reset_last_);
    else if (clock > began_)
        play(clock);
}

/// What plays and supervises, after the commands of this clock.
void ReferenceBoard::Core::play(Clock clock) {
    if (clock == judge_at_) {
        // A pin that was high through a whole window, as the guard sees it one clock after the pin, trips it.
        train_.advance(clock - 1);
        if (train_.any_high_since(clock - window_)) guard_.trip_at(clock + 2);
        judge_at_ += window_;
    }
    if (schedule_.opens(clock)) open_gate(clock);
    const bool starts = source_.at(clock);
    if (starts) {
        guard_.set_watchdog(clock, 0);
        enable_ = true;
    }
    const bool out_of_step = sync_.out_of_step(), together = sync_.together();
    const CarrierSync::Step step = sync_.step(clock, player_->cycle().last(clock), schedule_.period(clock));
    if (sync_.out_of_step() != out_of_step) guard_.wake_at(clock + 1);
    const Guard::Verdict verdict =
        guard_.at(clock, enable_, disable_ || stopped_ || urgent_disable_.active(clock) || out_of_step, step.lost);
    count_.missed = static_cast<std::uint16_t>(count_.missed + step.missed);
    count_.lost = static_cast<std::uint16_t>(count_.lost + step.lost);
    count_.watchdog = static_cast<std::uint16_t>(count_.watchdog + verdict.expired);
    count_.guard = static_cast<std::uint16_t>(count_.guard + verdict.tripped);

    const bool was_off = std::exchange(off_, off());
    const Player::Counted counted =
        player_->at(clock, {.waits = guard_.allows() || together, .off = off_, .hold = step.holds, .common = together});
    if (waits_for_memory_ && source_.drops(clock)) reply_at_ = clock + 1;
    if (source_.followed()) schedule_.drop_starts();
    source_.passed(clock);
    count_.underruns = static_cast<std::uint16_t>(count_.underruns + counted.underrun);
    count_.refused_records = static_cast<std::uint16_t>(count_.refused_records + counted.refused);
    count_.bent = static_cast<std::uint16_t>(count_.bent + counted.bent);
    count_.far = static_cast<std::uint16_t>(count_.far + counted.far);
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
        if (p_.sync == 0) schedule_.period_begins(clock);
        if (on_cycle_start) on_cycle_start({clock, index_, guard_.enabled()});
    }
    if (step.load) schedule_.load(clock, *step.load);
    if (step.ends && p_.sync != 0) schedule_.period_begins(clock);  // boards in step count the ends of cycles
    if (off_ && !was_off) train_.stop(clock);
    if (!off_ && was_off) train_.resume(clock);
}

/// With amplitudes, the pins are let go a clock earlier.
bool ReferenceBoard::Core::off() const { return frames_ != nullptr ? !guard_.allows() : guard_.off(); }

/// @param last  clock of the reset; from the next one on they go on
void ReferenceBoard::Core::reset_play(Clock last) {
    if (train_.awake()) train_.advance(now - 1);  // what came before still belongs to the record
    index_ = 0;
    started_at_ = never;
    count_ = {};
    guard_.reset();
    off_ = true;
    source_.reset(last);
    schedule_.reset();
    const Clock first = reset_at_ == never ? last : reset_at_;
    sync_.reset(first, last, std::exchange(next_role_, interface::Role::alone));
    player_->reset(first, last);
    reset_at_ = never;
    began_ = last;
    if (judge_at_ != never) judge_at_ = next_judgement(last);
    if (waits_for_memory_) reply_at_ = last + 1;
}

/// The last clock of each window, from this clock on.
Clock ReferenceBoard::Core::next_judgement(Clock from) const {
    from = std::max(from, began_);
    return began_ + ((from - began_) / window_ + 1) * window_ - 1;
}

/// The reset input, high for so many clocks from now on. What plays is reset a clock later, and off at once.
void ReferenceBoard::Core::reset(unsigned clocks) {
    if (clocks == 0) return;
    const Clock last = now + clocks - 1;
    // What is under way in its first clock still takes place, as far as it is not reset.
    enable_ = false;
    if (now == step_at_) go_on(now);
    disable_ = true;
    if (now > began_) play(now);
    step_ = Step::waiting;
    reply_ = Reply::idle;
    step_at_ = reply_at_ = urgent_stop_at_ = never;
    free_from_ = last + 1;
    taken_before_ = first_words_ = second_words_ = 0;
    session_ = false;
    urgent_disable_ = urgent_stop_ = {};
    input_.reset();
    line_in.reset(last);
    if (line_in.next() <= now) static_cast<void>(line_in.at(now));  // the host goes on sending
    line_out_.reset(now);
    waits_for_memory_ = false;
    reset_at_ = now + 1;
    reset_last_ = last + 1;
    next_role_ = interface::Role::alone;
    // The input is sampled twice, and says stopped during reset.
    stop_changes_ = {{now + 1, true}, {last + 3, stop_pressed_}};
    ++now;
    run(clocks - 1);
}

const Model::Outputs& ReferenceBoard::Core::outputs() {
    const Clock last = now - 1;
    if (!train_.awake()) {
        train_.wake(last);
        judge_at_ = next_judgement(now);
    }
    pulses_asked_to_ = now + 2 * window_;
    train_.advance(last);
    outputs_.tx = line_out_.level(last);
    outputs_.enabled = guard_.enabled();
    outputs_.alive = last > began_ && (last - began_) / window_ % 2 == 1;
    outputs_.playing = guard_.enabled() && index_ != 0;
    outputs_.fault = guard_.fault();
    outputs_.sync = sync_.driven();
    outputs_.cycle_start = started_at_ == last;
    outputs_.index = index_;
    outputs_.pins = train_.pins();
    return outputs_;
}

void ReferenceBoard::Core::press_stop(bool pressed) {
    stop_pressed_ = pressed;
    while (!stop_changes_.empty() && stop_changes_.back().clock >= now + 2) stop_changes_.pop_back();
    stop_changes_.push_back({now + 2, pressed});
    guard_.wake_at(now + 2);
}

void ReferenceBoard::Core::on_edge(std::function<void(const Edge&)> callback) {
    static_cast<void>(outputs());  // finds the state from which on changes are told
    on_edge_ = std::move(callback);
}

// ---- From bytes to commands

void ReferenceBoard::Core::byte_arrives(Clock clock, std::uint8_t byte) {
    switch (input_.byte(clock, byte, words_taken(clock), session_, expected_)) {
        case FrameInput::Outcome::nothing: return;
        case FrameInput::Outcome::damaged: ++count_.damaged; return;
        case FrameInput::Outcome::good: ++count_.good; break;
    }
    const std::uint64_t frame = input_.frames.back().number;
    if (input_.urgent(Command::disable) && urgent_disable_.arrives(clock, frame)) guard_.wake_at(clock + 1);
    if (input_.urgent(Command::stop) && urgent_stop_.arrives(clock, frame)) urgent_stop_at_ = clock + 1;
    if (step_ == Step::waiting) await_frame(free_from_);
}

std::uint64_t ReferenceBoard::Core::words_taken(Clock clock) const {
    const auto of_run = [clock](Clock begin, std::uint64_t words) {
        return clock <= begin ? 0 : std::min(clock - begin, words);
    };
    return taken_before_ + of_run(first_run_, first_words_) +
           (step_ == Step::write ? written_ : of_run(second_run_, second_words_));
}

void ReferenceBoard::Core::await_frame(Clock from) {
    free_from_ = from;
    step_ = input_.frames.empty() ? Step::waiting : Step::begin;
    step_at_ = input_.frames.empty() ? never : std::max(from, input_.frames.front().readable);
}

void ReferenceBoard::Core::go_on(Clock clock) {
    switch (step_) {
        case Step::waiting:
        case Step::answered: return;
        case Step::begin: return begin(clock);
        case Step::settle:
            live_free_ = source_.live_free();
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
void ReferenceBoard::Core::begin(Clock clock) {
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
    step_ = Step::settle;
    step_at_ = clock + 3 + shape_.arguments;
}

/// What is left of the frame is taken, a word a clock.
void ReferenceBoard::Core::refuse(Clock clock, Status status) {
    status_ = status;
    second_run_ = clock + 1;
    second_words_ = input_.frames.front().words() - first_words_;
    step_ = Step::close;
    step_at_ = clock + 2 + second_words_;
}

void ReferenceBoard::Core::judge(Clock clock) {
    const std::uint8_t ahead = static_cast<std::uint8_t>(number_ - expected_);
    const bool in_order = (ahead == 0 && session_) || command_ == Command::identify;
    const bool repeated = !in_order && ahead >= 0x80 && session_;
    if (!in_order && !repeated) return refuse(clock, Status::out_of_order);
    if (repeated && shape_.carries == Carries::nothing) return refuse(clock, Status::repeated);
    const Status found = verdict();
    if (found != Status::ok || !shape_.tail)
        return refuse(clock, found != Status::ok ? found : repeated ? Status::repeated : Status::ok);
    status_ = Status::ok;
    second_run_ = clock + 1;
    cut_ = false;
    foci_pushed_.clear();
    if (command_ == Command::write || command_ == Command::push_foci) {
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

Status ReferenceBoard::Core::verdict() const {
    switch (command_) {
        case Command::write:
        case Command::read:
        case Command::digest: return verdict_on_memory();
        case Command::select: return argument(0) > top_index() ? Status::bad_index : Status::ok;
        case Command::push:
            if (schedule_.for_the_end()) return Status::bad_range;
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
            return schedule_.busy(argument_period()) ? Status::gate_busy : Status::ok;
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
            if (!ring_.usable(record_foci(), top_index()) || schedule_.for_the_end()) return Status::bad_range;
            return word_.size() - data_ > std::size_t{4} * live_free_ * record_foci() ? Status::fifo_full : Status::ok;
        default: return Status::ok;
    }
}

std::uint32_t ReferenceBoard::Core::record_foci() const {
    return interface::parameters_field::foci_last.get(frames_->settings.at(now)) + 1;
}

std::uint32_t ReferenceBoard::Core::top_index() const {
    if (p_.foci == 0) return p_.records;
    const std::uint32_t count = interface::parameters_field::foci_count.get(frames_->settings.at(now));
    return std::min(p_.records + count, 0xffffU);
}

std::size_t ReferenceBoard::Core::region_words(bool writes) const {
    if (region_ == primary_region) return primary.size();
    if (region_ == sequence_region) return 2 * sequence.size();
    if (region_ == identity_region && !writes) return interface::identity_words;
    if (region_ == status_region && !writes) return status_words();
    if (region_ == parameters_region && p_.width_bits != 0) return interface::parameters_words;
    if (region_ == geometry_region && writes && p_.foci != 0) return std::size_t{4} * p_.channels;
    if (region_ == modulation_region) return p_.modulation_depth / 2;
    if (region_ == ring_region && p_.foci != 0) return interface::ring_words;
    return 0;
}

Status ReferenceBoard::Core::verdict_on_memory() const {
    const bool writes = command_ == Command::write;
    const std::size_t words = writes ? word_.size() - data_ : argument(2) / 2;
    const bool odd = argument(0) % 2 != 0 || (!writes && argument(2) % 2 != 0);
    if (words == 0 || (!writes && words > p_.channels + interface::record_header_words)) return Status::bad_length;
    if (address_ + words > region_words(writes)) return Status::bad_address;
    if (odd || (region_ == sequence_region && (address_ % 2 != 0 || words % 2 != 0))) return Status::bad_alignment;
    return Status::ok;
}

/// Whether what plays reads the word that is to be written, or all of its region.
bool ReferenceBoard::Core::held(Clock clock) const {
    if (region_ == primary_region) return player_->reader().reads(clock, address_);
    if (region_ == modulation_region) return frames_->modulation.fetching(clock);
    return region_ == sequence_region && source_.fetching(clock);
}

/// One word a clock, but none in a clock in which the player reads it.
void ReferenceBoard::Core::write(Clock clock) {
    step_at_ = clock + 1;
    if (held(clock)) return;
    put(clock, word_[data_ + written_]);
    ++address_;
    if (command_ == Command::push_foci) {
        if (const std::uint16_t index = ring_.wrote(record_foci()); index != 0) foci_pushed_.push_back(index);
        address_ = ring_.address();
    }
    if (data_ + ++written_ < word_.size()) return;
    if (command_ == Command::push_foci && ring_.split()) status_ = Status::bad_length;
    second_words_ = written_;
    second_run_ = clock + 1 - written_;
    step_ = Step::close;
    step_at_ = clock + 3;
}

void ReferenceBoard::Core::put(Clock clock, std::uint16_t value) {
    switch (region_) {
        case primary_region:
            if (address_ >= primary.size()) return;
            player_->reader().written(clock, address_, value);
            primary[address_] = value;
            return;
        case sequence_region:
            if (address_ == 0) source_.header_written(clock, value);
            if (address_ % 2 == 0)
                low_half_ = value;
            else
                sequence[address_ / 2] = static_cast<std::uint32_t>(value) << 16 | low_half_;
            return;
        case parameters_region: frames_->settings.write(clock, address_, value); return;
        case geometry_region: frames_->geometry[address_ / 4][address_ % 4] = value; return;
        case modulation_region: frames_->modulation.write(address_, value); return;
        case ring_region: ring_.set(address_, value); return;
        default: return;
    }
}

void ReferenceBoard::Core::close(Clock clock) {
    if (status_ == Status::ok) {
        session_ = true;
        expected_ = static_cast<std::uint8_t>(number_ + 1);
        if (command_ == Command::push_foci) ring_.keep();
        const bool pushes = command_ == Command::push || command_ == Command::push_foci;
        if (pushes && !urgent_stop_.active(clock)) keep_pushed(clock);
    }
    taken_before_ += input_.frames.front().words();
    first_words_ = second_words_ = 0;
    step_ = Step::execute;
    step_at_ = clock + 1;
}

void ReferenceBoard::Core::keep_pushed(Clock clock) {
    const Schedule::Use use = schedule_.use(clock);
    count_.late = static_cast<std::uint16_t>(count_.late + use.late);
    if (cut_) return;
    const bool behind = schedule_.push_is_waiting();
    const bool opens = behind && schedule_.opens(clock);
    if (use.turn == Schedule::Turn::waits) schedule_.push_waits();
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
void ReferenceBoard::Core::open_gate(Clock clock) {
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

void ReferenceBoard::Core::drop_starts() {
    schedule_.drop_starts();
    source_.drop_follower();
}

void ReferenceBoard::Core::stop(Clock clock) {
    drop_starts();
    schedule_.drop_pushed();
    schedule_.modulation_waits(false);
    schedule_.forget();
    source_.stop(clock);
}

void ReferenceBoard::Core::modulate(Clock clock) {
    const auto word = [this](std::size_t i) { return static_cast<std::uint16_t>(argument(i)); };
    frames_->modulation.ask(clock, word(0), word(1), word(2));
    const Schedule::Use use = schedule_.use(clock);
    count_.late = static_cast<std::uint16_t>(count_.late + use.late);
    schedule_.modulation_waits(use.turn == Schedule::Turn::waits);
    if (use.turn != Schedule::Turn::waits) frames_->modulation.begin(clock, use.turn == Schedule::Turn::follows);
}

void ReferenceBoard::Core::start(Clock clock, const Schedule::Arguments& arguments) {
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

void ReferenceBoard::Core::execute(Clock clock) {
    if (status_ == Status::ok)
        apply(clock);
    else
        ++(status_ == Status::repeated ? count_.repeated : count_.refused);
    const std::uint64_t frame = input_.frames.front().number;
    urgent_disable_.done(clock, frame);
    urgent_stop_.done(clock, frame);
    input_.frames.pop_front();
    step_ = Step::answered;
    step_at_ = never;
    begin_reply(clock);
}

void ReferenceBoard::Core::apply(Clock clock) {
    if (command_ != Command::identify) guard_.kick(clock);
    if (shape_.carries == Carries::nothing) source_.host_takes_over();
    const bool may_play = !urgent_stop_.active(clock);  // otherwise a STOP that was sent later has acted already
    const auto word = [this](std::size_t i) { return static_cast<std::uint16_t>(argument(i)); };
    switch (command_) {
        case Command::enable: enable_ = true; break;
        case Command::disable: disable_ = true; break;
        case Command::watchdog: guard_.set_watchdog(clock, word(0)); break;
        case Command::stop: stop(clock); break;
        case Command::identify: schedule_.forget(); break;
        case Command::gate: schedule_.gate(argument_period()); break;
        case Command::modulate: modulate(clock); break;
        case Command::select:
            if (!may_play) break;
            drop_starts();
            schedule_.drop_pushed();
            source_.select(clock, {word(0), word(1)});
            break;
        case Command::start:
            if (may_play) start(clock, {word(0), word(1), word(2)});
            break;
        case Command::sync: next_role_ = static_cast<interface::Role>(argument(0)); [[fallthrough]];
        case Command::reset: reset_at_ = reset_last_ = clock + 1; break;
        default: break;
    }
}

// ---- Replies

Clock ReferenceBoard::Core::collect(Clock offered, std::uint32_t word) {
    const Clock low = line_out_.collect(offered, static_cast<std::uint8_t>(word));
    return line_out_.collect(low + 1, static_cast<std::uint8_t>(word >> 8));
}

void ReferenceBoard::Core::begin_reply(Clock clock) {
    const bool carries = status_ == Status::ok || status_ == Status::repeated;
    words_left_ = 0;
    told_period_ = schedule_.period(clock);
    if (carries && shape_.carries == Carries::identity) words_left_ = interface::identity_words;
    if (carries && shape_.carries == Carries::status) words_left_ = status_words();
    if (carries && shape_.carries == Carries::memory) words_left_ = argument(2) / 2;
    digest_ = ~0U;
    const Clock head =
        collect(clock + 1, static_cast<std::uint32_t>((static_cast<unsigned>(command_) | 0x80U) << 8 | number_));
    reply_at_ = collect(head + 1, static_cast<std::uint32_t>(expected_ << 8 | static_cast<unsigned>(status_)));
    reply_ = Reply::level;
}

void ReferenceBoard::Core::reply(Clock clock) {
    if (reply_ == Reply::words) return read_word(clock);
    const Clock head = collect(clock + 1, source_.live_level());
    if (words_left_ == 0) return end_reply(head);
    reply_ = Reply::words;
    reply_at_ = head + 1;
}

void ReferenceBoard::Core::read_word(Clock clock) {
    waits_for_memory_ = region_ == primary_region && player_->reader().reads(clock);
    if (waits_for_memory_) {
        reply_at_ = player_->reader().reads_to() + 1;
        return;
    }
    if ((region_ == sequence_region && source_.fetching(clock)) ||
        (region_ == modulation_region && frames_->modulation.fetching(clock))) {
        reply_at_ = clock + 1;
        return;
    }
    constexpr Clock arrives = 3;  // until a word can be sent, or its first bit folded into the digest
    constexpr Clock folded = 16;  // clocks for its bits
    const std::uint16_t word = memory_word();
    ++address_;
    --words_left_;
    if (command_ != Command::digest) {
        const Clock sent = collect(clock + arrives, word);
        if (words_left_ == 0) return end_reply(sent);
        reply_at_ = sent + 1;
        return;
    }
    digest_ = crc32(digest_, word);
    reply_at_ = clock + arrives + folded;
    if (words_left_ > 0) return;
    const Clock low = collect(reply_at_ + 1, ~digest_ & 0xffffU);
    end_reply(collect(low + 2, ~digest_ >> 16));
}

/// @param clock  in which the last word was collected; its CRC follows
void ReferenceBoard::Core::end_reply(Clock clock) {
    line_out_.close(clock + 1);
    reply_ = Reply::idle;
    reply_at_ = never;
    await_frame(clock + 1);
}

std::uint16_t ReferenceBoard::Core::memory_word() const {
    if (region_ == primary_region) return primary[address_];
    if (region_ == sequence_region) return static_cast<std::uint16_t>(sequence[address_ / 2] >> address_ % 2 * 16);
    if (region_ == status_region) return status_word(address_);
    if (region_ == parameters_region) return frames_->settings.at(now)[address_];
    if (region_ == modulation_region) return frames_->modulation.word(address_);
    if (region_ == ring_region) return ring_.words()[address_];
    std::array<std::uint16_t, interface::identity_words> identity{};
    for (std::size_t i = 0; i < interface::name.size(); ++i)
        identity[i / 2] =
            static_cast<std::uint16_t>(identity[i / 2] | static_cast<unsigned char>(interface::name[i]) << i % 2 * 8);
    namespace field = interface::identity_field;
    using interface::Feature;
    std::uint32_t features = 0;
    const auto has = [&features](Feature feature, bool is_there = true) {
        if (is_there) features |= 1U << static_cast<unsigned>(feature);
    };
    has(Feature::sequence);
    has(Feature::live);
    has(Feature::watchdog);
    has(Feature::guard);
    has(Feature::amplitude, p_.width_bits != 0);
    has(Feature::slew, p_.slew != 0);
    has(Feature::modulation, p_.modulation_depth != 0);
    has(Feature::foci, p_.foci != 0);
    has(Feature::live_foci, p_.foci != 0);
    has(Feature::sync, p_.sync != 0);
    has(Feature::schedule, p_.schedule != 0);
    has(Feature::chain, p_.chain != 0);
    field::version_minor.set(identity, interface::version_minor);
    field::version_major.set(identity, interface::version_major);
    field::channels.set(identity, p_.channels);
    field::records.set(identity, p_.records);
    field::sequence_depth.set(identity, p_.sequence_depth);
    field::live_depth.set(identity, p_.live_depth);
    field::timing_bits.set(identity, p_.timing_bits);
    field::pulse_bits.set(identity, p_.pulse_bits);
    field::clock_hz.set(identity, p_.clock_hz);
    field::features.set(identity, features);
    field::frame_bytes.set(identity, longest_frame(p_));
    field::min_pulse_clocks.set(identity, p_.min_pulse_clocks);
    // More than the field holds is said as its largest value: what a host then keeps to, the board plays.
    field::max_pulse_clocks.set(identity, std::min(longest_pulse_clocks(p_), field::max_pulse_clocks.most()));
    field::max_duty_256.set(identity, p_.max_duty_256);
    field::max_cycle_clocks.set(identity, p_.clock_hz);
    field::width_bits.set(identity, p_.width_bits);
    field::foci.set(identity, p_.foci);
    field::modulation_words.set(identity, p_.modulation_depth / 2);
    return identity[address_];
}

std::uint16_t ReferenceBoard::Core::status_word(std::uint32_t word) const {
    std::array<std::uint16_t, interface::status_words> block{};
    namespace field = interface::status_field;
    field::enabled.set(block, guard_.enabled() ? 1 : 0);
    field::mode.set(block, static_cast<unsigned>(source_.mode()));
    field::stopped.set(block, stopped_ ? 1 : 0);
    field::modulated.set(block, frames_ != nullptr && frames_->modulation.running(now) ? 1 : 0);
    field::bent_periods.set(block, count_.bent);
    field::far_foci.set(block, count_.far);
    field::present_index.set(block, index_);
    field::underruns.set(block, count_.underruns);
    field::refused_records.set(block, count_.refused_records);
    field::frames_good.set(block, count_.good);
    field::frames_damaged.set(block, count_.damaged);
    field::frames_repeated.set(block, count_.repeated);
    field::watchdog_trips.set(block, count_.watchdog);
    field::guard_trips.set(block, count_.guard);
    field::live_level.set(block, source_.live_level());
    field::watchdog_ms.set(block, guard_.watchdog_ms());
    field::frames_refused.set(block, count_.refused);
    field::waiting.set(block, schedule_.waiting() ? 1 : 0);
    field::role.set(block, static_cast<unsigned>(sync_.role()));
    field::in_step.set(block, sync_.in_step() ? 1 : 0);
    field::numbered.set(block, sync_.numbered(now) ? 1 : 0);
    field::sync_misses.set(block, count_.missed);
    field::sync_losses.set(block, count_.lost);
    field::late_changes.set(block, count_.late);
    field::period.set(block, told_period_ & field::period.most());
    field::period_high.set(block, told_period_ >> field::period.width);
    return block[word];
}

// ---- The board

ReferenceBoard::ReferenceBoard(std::string_view configuration, unsigned reset_clocks)
    : ReferenceBoard(configuration_named(configuration), reset_clocks) {}
ReferenceBoard::ReferenceBoard(const interface::CoreConfiguration& configuration, unsigned reset_clocks)
    : core_(std::make_unique<Core>(configuration, reset_clocks)) {}
ReferenceBoard::~ReferenceBoard() = default;

void ReferenceBoard::run(std::uint64_t clocks) { core_->run(clocks); }
void ReferenceBoard::reset(unsigned clocks) { core_->reset(clocks); }
std::uint64_t ReferenceBoard::now() const { return core_->now; }
const interface::CoreConfiguration& ReferenceBoard::configuration() const { return core_->configuration; }
const Model::Outputs& ReferenceBoard::outputs() const { return core_->outputs(); }
Board::Present ReferenceBoard::present() const { return core_->present(); }
void ReferenceBoard::send(std::span<const std::uint8_t> bytes) { core_->line_in.send(bytes); }
std::vector<std::uint8_t> ReferenceBoard::receive() { return std::exchange(core_->arrived, {}); }
std::size_t ReferenceBoard::received() const { return core_->arrived.size(); }
bool ReferenceBoard::line_idle() const { return core_->line_in.idle(); }
void ReferenceBoard::force_line(std::optional<bool> level) { core_->line_in.force(core_->now, level); }
void ReferenceBoard::unplug() { core_->line_in.unplug(core_->now); }
void ReferenceBoard::drive_sync(bool level) { core_->drive_sync(level); }
void ReferenceBoard::press_stop(bool pressed) { core_->press_stop(pressed); }
void ReferenceBoard::on_edge(std::function<void(const Edge&)> callback) { core_->on_edge(std::move(callback)); }
void ReferenceBoard::on_cycle_start(std::function<void(const CycleStart&)> callback) {
    core_->on_cycle_start = std::move(callback);
}
void ReferenceBoard::on_arrival(std::function<void(const Arrival&)> callback) {
    core_->on_arrival = std::move(callback);
}
void ReferenceBoard::on_sync(std::function<void(const SyncChange&)> callback) { core_->on_sync = std::move(callback); }
std::span<std::uint16_t> ReferenceBoard::primary_memory() { return core_->primary; }
std::span<std::uint32_t> ReferenceBoard::sequence_memory() { return core_->sequence; }

}  // namespace haptogram::sim
