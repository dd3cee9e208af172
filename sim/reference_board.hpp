// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "board.hpp"
#include "clock.hpp"
#include "reference_drive_player.hpp"
#include "reference_frames.hpp"
#include "reference_guard.hpp"
#include "reference_line.hpp"
#include "reference_player.hpp"
#include "reference_pulses.hpp"
#include "reference_ring.hpp"
#include "reference_schedule.hpp"
#include "reference_source.hpp"
#include "reference_stream.hpp"
#include "reference_sync.hpp"
#include "reference_trigger.hpp"

namespace haptogram::sim {

/// The number of a region is the upper four bits of its addresses.
[[nodiscard]] constexpr std::uint32_t region_of(std::uint32_t address) { return address >> 28; }

/// What the Verilog of rtl/ does, computed from events instead of clock by clock: a byte has arrived, a frame is
/// carried out, a record is committed, a pulse begins. Its replies and its pins are those of the Verilated core, at the
/// same clocks (tests/reference compares them). Time in which nothing happens costs nothing, and pulses only cost
/// something while somebody looks at them, or while they could merge to what the guard must notice.
///
/// Each event is worked out in the order in which the core's registers see each other: what reads a value comes before
/// what changes it in the same clock.
///
/// The clock is in reference_board.cpp, from bytes to commands in reference_commands.cpp, their replies in
/// reference_replies.cpp.
class ReferenceBoard final : public Board {
public:
    /// @param configuration  a name in tools/interface.toml, such as "tile-100"
    /// @throws Error{bad_argument} when there is none of that name
    explicit ReferenceBoard(std::string_view configuration, unsigned reset_clocks = 4);
    /// @param configuration  parameters in the ranges of interface::core_parameters
    explicit ReferenceBoard(const interface::CoreConfiguration& configuration, unsigned reset_clocks = 4);

    void run(std::uint64_t clocks) override;
    void reset(unsigned clocks = 4) override;
    [[nodiscard]] std::uint64_t now() const override { return now_; }
    [[nodiscard]] const interface::CoreConfiguration& configuration() const override { return configuration_; }
    [[nodiscard]] const Model::Outputs& outputs() override;
    [[nodiscard]] Present present() const override { return {index_, guard_.enabled()}; }
    void send(std::span<const std::uint8_t> bytes) override { line_in_.send(bytes); }
    [[nodiscard]] std::vector<std::uint8_t> receive() override { return std::exchange(arrived_, {}); }
    [[nodiscard]] std::size_t received() const override { return arrived_.size(); }
    [[nodiscard]] bool line_idle() const override { return line_in_.idle(); }
    void force_line(std::optional<bool> level) override { line_in_.force(now_, level); }
    void unplug() override { line_in_.unplug(now_); }
    void network_break() override { line_in_.break_network(now_); }
    void network_stop() override { line_in_.stop_network(now_); }
    void network_lost() override { line_in_.lose_network(now_); }
    void network_end() override { line_in_.end_network(now_); }
    void press_stop(bool pressed) override;
    void drive_sync(bool level) override { sync_.wire(now_, level); }
    void drive_trigger(bool level) override {
        if (p_.trigger != 0) trigger_.drive(now_, level);
    }
    void on_edge(std::function<void(const Edge&)> callback) override;
    [[nodiscard]] std::span<std::uint16_t> primary_memory() override { return primary_; }
    [[nodiscard]] std::span<std::uint32_t> sequence_memory() override { return sequence_; }

private:
    using Command = interface::Command;
    using Status = interface::Status;

    enum class Carries { nothing, identity, status, memory };

    /// What rtl/INTERFACE.md says of a command.
    struct Shape {
        std::uint32_t arguments = 0;
        bool tail = false;  // data words follow the arguments
        Carries carries = Carries::nothing;
    };
    [[nodiscard]] static std::optional<Shape> shape_of(Command command);

    /// The frames that were sent before outputs were switched off, or before a STOP. They count as answered, not as
    /// done.
    class Stale {
    public:
        [[nodiscard]] bool active(Clock clock) const { return from_ <= clock && (waits_ || clock <= to_); }
        /// @param frames  that wait; all of them are stale
        void begin(Clock clock, const std::deque<Frame>& frames) {
            if (!active(clock)) from_ = clock + 1;
            to_ = clock + 1;
            waits_ = !frames.empty();
            if (waits_) last_ = frames.back().number;
        }
        [[nodiscard]] bool waits() const { return waits_; }
        /// @return whether it was the last of them
        bool done(Clock clock, std::uint64_t frame) {
            if (!waits_ || frame != last_) return false;
            waits_ = false;
            to_ = std::max(to_, clock);
            return true;
        }

    private:
        Clock from_ = never, to_ = 0;
        bool waits_ = false;
        std::uint64_t last_ = 0;
    };

    static constexpr std::uint32_t primary_region = region_of(interface::primary_base);
    static constexpr std::uint32_t sequence_region = region_of(interface::sequence_base);
    static constexpr std::uint32_t identity_region = region_of(interface::identity_base);
    static constexpr std::uint32_t status_region = region_of(interface::status_base);
    static constexpr std::uint32_t parameters_region = region_of(interface::parameters_base);
    static constexpr std::uint32_t geometry_region = region_of(interface::geometry_base);
    static constexpr std::uint32_t modulation_region = region_of(interface::modulation_base);
    static constexpr std::uint32_t ring_region = region_of(interface::ring_base);
    static constexpr std::uint32_t stream_region = region_of(interface::stream_base);
    static constexpr std::uint32_t trigger_region = region_of(interface::trigger_base);

    [[nodiscard]] Clock next() const;
    void edge(Clock clock);
    void play(Clock clock);
    void stream(Clock clock, bool goes, bool forgets);
    void stream_turn(Clock clock);
    void trigger(Clock clock);
    void disarm(Clock clock);
    void reset_play(Clock last);
    [[nodiscard]] Clock next_judgement(Clock from) const;
    void byte_arrives(Clock clock, std::uint8_t byte, Clock began);
    void old_bytes(Clock clock, std::uint8_t old);
    void switched_off(Clock clock, bool by_itself);
    void end_session(Clock clock);
    void pass_session(Clock clock);
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
    void write_pattern(Clock clock);
    void written(Clock clock);
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
        return p_.stream != 0     ? interface::status_words
               : p_.schedule != 0 ? interface::status_unstreamed_words
                                  : interface::status_untimed_words;
    }
    /// Whether the present command is STREAM, which is not answered.
    [[nodiscard]] bool is_message() const { return p_.stream != 0 && command_ == Command::stream; }
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

    const interface::CoreConfiguration configuration_;
    Clock now_ = 0;
    const interface::CoreParameters& p_;
    const Clock window_;  // of the guard
    std::vector<std::uint16_t> primary_;
    std::vector<std::uint32_t> sequence_;
    LineIn line_in_;
    std::vector<std::uint8_t> arrived_;
    LineOut line_out_;
    FrameInput input_;
    EntrySource source_;
    Schedule schedule_;
    CarrierSync sync_;
    FocusRing ring_;
    PatternStream stream_;
    TriggerPins trigger_;
    TriggerPins::Ports ports_;  // of which strobes are those of the present clock
    Clock stream_wakes_ = never, fades_from_ = never;
    PulseTrain train_;
    std::unique_ptr<Player> player_;
    DrivePlayer* frames_ = nullptr;  // the same, of boards with amplitudes
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
    bool session_ended_ = false;  // and none has begun since
    Clock session_ends_at_ = never;
    std::uint8_t session_number_ = 0;         // of the IDENTIFY that began it
    bool moved_ = false;                      // foci, likewise
    bool identified_ = false;                 // in the present clock
    std::uint32_t region_ = 0, address_ = 0;  // of a 16-bit word
    bool cut_ = false;                        // what the present PUSH has written so far is gone
    std::uint64_t told_period_ = 0;           // by the present reply
    Stale stale_, unplayed_, ended_;
    // Outputs were switched off, a STOP came, or the session ended since the frame began that is arriving.
    std::array<bool, 3> old_{};
    Clock old_began_ = never;                // a byte was arriving then that may begin a frame: when it began
    Clock old_stop_at_ = never;              // the last old byte since a STOP came in the clock before
    Clock stops_at_ = never;                 // the clock in which a STOP acts
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
            bent, far, stream_late, stream_lost, stream_early, stream_repeated;
    } count_{};
    Clock reset_at_ = never, reset_last_ = 0;  // of what plays and supervises: when it begins, and its last clock
    Clock began_ = 0;                          // the last clock of the reset before
    interface::Role next_role_ = interface::Role::alone;  // from the next reset on
    Clock judge_at_ = never;                              // the guard looks at a window
    Clock pulses_asked_to_ = 0;

    // The pins.
    std::uint16_t index_ = 0;
    Clock started_at_ = never;
    Model::Outputs outputs_;
};

}  // namespace haptogram::sim
