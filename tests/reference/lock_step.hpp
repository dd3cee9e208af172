// SPDX-License-Identifier: Apache-2.0
// Two boards that are given the same things at the same clocks, and a host that gives them commands, images and faults
// at random.
#pragma once
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <deque>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "board.hpp"
#include "haptogram/link/frame.hpp"

namespace haptogram::test {

using link::Bytes;

/// What a board shows, with its clocks.
struct Seen {
    std::vector<sim::Edge> edges;
    std::vector<sim::CycleStart> cycles;
    std::vector<sim::Arrival> arrivals;
    std::vector<sim::SyncChange> sync;
    std::vector<sim::TriggerChange> triggers;

    void watch(sim::Board& board, bool pins = true) {
        if (pins) board.on_edge([this](const sim::Edge& e) { edges.push_back(e); });
        board.on_cycle_start([this](const sim::CycleStart& c) { cycles.push_back(c); });
        board.on_arrival([this](const sim::Arrival& a) { arrivals.push_back(a); });
        board.on_sync([this](const sim::SyncChange& s) { sync.push_back(s); });
        board.on_trigger([this](const sim::TriggerChange& t) { triggers.push_back(t); });
    }
    void clear() { edges.clear(), cycles.clear(), arrivals.clear(), sync.clear(), triggers.clear(); }
};

/// The wire SYNC as a master elsewhere drives it, whose crystal differs and wanders, and what can happen to the wire:
/// edges that come too early, too late or not at all, glitches, another number, silence for some while. Between those
/// it is quiet for long enough that a slave comes into step.
class Wire {
public:
    Wire(std::uint32_t period_clocks, std::uint32_t seed) : period_(period_clocks), g_(seed) {
        begin_master();
        extend();
    }

    struct Change {
        std::uint64_t clock;
        bool level;
    };
    /// The next change; it takes place before this clock.
    [[nodiscard]] const Change& next() const { return changes_.front(); }
    void pop() {
        changes_.pop_front();
        if (changes_.empty()) extend();
    }

private:
    std::uint32_t below(std::uint32_t count) { return static_cast<std::uint32_t>(g_()) % count; }

    /// Of a master's message: the mark, 42 bits, their parity, zeros.
    [[nodiscard]] std::uint32_t symbol() const {
        const std::uint64_t place = number_ % 64, upper = number_ >> 6;
        if (place == 0) return 2;
        if (place <= 42) return static_cast<std::uint32_t>(upper >> (42 - place) & 1U);
        return place == 43 ? static_cast<std::uint32_t>(std::popcount(upper) % 2) : 0;
    }

    void begin_master() {
        number_ = static_cast<std::uint64_t>(g_()) << below(16);
        offset_ = std::uniform_real_distribution<double>(-1e-4, 1e-4)(g_) * period_;
    }

    void extend() {
        if (++periods_ % 2000 == 0 && below(4) == 0) begin_master();
        const auto disturbs = [this](std::uint32_t one_in) { return periods_ % 2000 >= 1400 && below(one_in) == 0; };
        ++number_;
        at_ += period_ + 0.5 + offset_;  // every second cycle of a master is a clock longer
        if (disturbs(1000)) {
            const std::uint32_t silent = below(60);
            number_ += silent;
            at_ += silent * (period_ + 0.5 + offset_);
        }
        std::uint64_t rise = static_cast<std::uint64_t>(at_), high = 8 * (symbol() + 1ULL);
        if (disturbs(30)) rise += below(9);
        if (disturbs(30)) rise -= below(9);
        if (disturbs(100)) high = 1 + below(60);
        if (disturbs(3000)) at_ += below(40);
        add(rise, true);
        add(rise + high, false);
        if (disturbs(50)) {
            const std::uint64_t glitch = rise + high + 1 + below(period_);
            add(glitch, true);
            add(glitch + 1 + below(4), false);
        }
    }

    /// In the order of time; what would come before the last change is left out.
    void add(std::uint64_t clock, bool level) {
        if (!changes_.empty() && clock <= changes_.back().clock) return;
        changes_.push_back({clock, level});
        at_ = std::max(at_, static_cast<double>(clock) - period_ + 100.0);
    }

    std::uint32_t period_;
    std::mt19937 g_;
    double at_ = 2000.0, offset_ = 0.0;
    std::uint64_t number_ = 0, periods_ = 0;
    std::deque<Change> changes_;
};

class LockStep {
public:
    /// @param pins  whether to look at them; otherwise the reference board has no reason to compute pulses
    LockStep(sim::Board& core, sim::Board& reference, bool pins = true)
        : core_(core), reference_(reference), pins_(pins) {
        of_core_.watch(core, pins);
        of_reference_.watch(reference, pins);
    }

    /// Does the same to both.
    template <class Action>
    void both(Action&& action) {
        action(core_);
        action(reference_);
    }

    /// Runs both for so many clocks and compares what they show.
    /// @return the first difference in words; empty when there is none
    [[nodiscard]] std::string run(std::uint64_t clocks) {
        const std::uint64_t end = core_.now() + clocks;
        for (; wire != nullptr && wire->next().clock < end; wire->pop()) {
            const Wire::Change change = wire->next();
            both([change](sim::Board& board) {
                if (change.clock > board.now()) board.run(change.clock - board.now());
                board.drive_sync(change.level);
            });
        }
        both([end](sim::Board& board) { board.run(end - board.now()); });
        std::string difference = first_difference("edge", of_core_.edges, of_reference_.edges, [](const sim::Edge& e) {
            return fmt::format("{} of channel {} at {}, record {}", e.rises ? "rise" : "fall", e.channel, e.clock,
                               e.index);
        });
        if (difference.empty())
            difference = first_difference("cycle", of_core_.cycles, of_reference_.cycles, [](const sim::CycleStart& c) {
                return fmt::format("begins at {}, record {}, {}", c.clock, c.index, c.enabled ? "on" : "off");
            });
        if (difference.empty())
            difference = first_difference(
                "trigger", of_core_.triggers, of_reference_.triggers,
                [](const sim::TriggerChange& t) { return fmt::format("{} at {}", t.level ? "high" : "low", t.clock); });
        if (difference.empty())
            difference = first_difference("byte", of_core_.arrivals, of_reference_.arrivals, [](const sim::Arrival& a) {
                return fmt::format("0x{:02x} at {}", a.byte, a.clock);
            });
        if (difference.empty())
            difference = first_difference("SYNC", of_core_.sync, of_reference_.sync, [](const sim::SyncChange& s) {
                return fmt::format("{} at {}", s.level ? "high" : "low", s.clock);
            });
        if (difference.empty() && pins_) difference = difference_of_outputs();
        edges += of_core_.edges.size();
        cycles += of_core_.cycles.size();
        for (const sim::CycleStart& cycle : of_core_.cycles)
            focus_cycles += cycle.index > core_.parameters().records && cycle.enabled ? 1 : 0;
        bytes += of_core_.arrivals.size();
        triggers += of_core_.triggers.size();
        received_ = of_core_.arrivals;
        of_core_.clear();
        of_reference_.clear();
        static_cast<void>(core_.receive());
        static_cast<void>(reference_.receive());
        return difference;
    }

    [[nodiscard]] const std::vector<sim::Arrival>& received() const { return received_; }
    [[nodiscard]] sim::Board& core() { return core_; }

    std::uint64_t edges = 0, cycles = 0, bytes = 0, focus_cycles = 0, triggers = 0;
    Wire* wire = nullptr;

private:
    template <class T, class Describe>
    [[nodiscard]] std::string first_difference(const char* what, const std::vector<T>& core,
                                               const std::vector<T>& reference, Describe&& describe) const {
        for (std::size_t i = 0; i < std::max(core.size(), reference.size()); ++i) {
            if (i < core.size() && i < reference.size() && core[i] == reference[i]) continue;
            return fmt::format("{}: core {}; reference {}", what, i < core.size() ? describe(core[i]) : "none",
                               i < reference.size() ? describe(reference[i]) : "none");
        }
        return {};
    }

    [[nodiscard]] std::string difference_of_outputs() const {
        const sim::Model::Outputs& a = core_.outputs();
        const sim::Model::Outputs& b = reference_.outputs();
        const auto describe = [](const sim::Model::Outputs& o) {
            std::string pins;
            for (const std::uint32_t word : o.pins) pins += fmt::format(" {:08x}", word);
            return fmt::format(
                "tx {} enabled {} alive {} playing {} fault {} cycle start {} sync {} trigger {} test {} index "
                "{} pins{}",
                o.tx, o.enabled, o.alive, o.playing, o.fault, o.cycle_start, o.sync, o.trigger, o.test, o.index, pins);
        };
        const std::string core = describe(a);
        const std::string reference = describe(b);
        if (core == reference) return {};
        return fmt::format("after clock {}: core {}; reference {}", core_.now() - 1, core, reference);
    }

    sim::Board& core_;
    sim::Board& reference_;
    bool pins_;
    Seen of_core_, of_reference_;
    std::vector<sim::Arrival> received_;
};

/// A host that does anything, most of it sensible.
class RandomHost {
public:
    RandomHost(LockStep& boards, std::uint32_t seed) : boards_(boards), p_(boards.core().parameters()), g_(seed) {}

    /// Beside the link and at reset, as a bitstream brings it.
    void new_image() {
        ++images;
        reset();
        sticky_ = p_.sync == 0 && one_in(8);  // which boards in step refuse
        for (std::uint32_t index = 0; index < std::min(p_.records, 40U); ++index) {
            const auto words = record();
            boards_.both([&](sim::Board& board) {
                std::ranges::copy(words,
                                  board.primary_memory().begin() + static_cast<std::ptrdiff_t>(index * words.size()));
            });
        }
        foci_ = p_.foci == 0 ? 0 : between(1, one_in(3) ? p_.foci : 3);
        for (std::size_t i = 0; i < p_.sequence_depth; ++i) {
            const std::uint32_t word = i == 0 ? header() : entry();
            boards_.both([&](sim::Board& board) { board.sequence_memory()[i] = word; });
        }
        for (std::uint32_t word = first_focus(); foci_ != 0 && word + 4 <= p_.records * record_words(); word += 4) {
            const auto words = focus();
            boards_.both([&](sim::Board& board) { std::ranges::copy(words, board.primary_memory().begin() + word); });
        }
    }

    /// What must not change while focus records are loaded: where the channels are, and what the engine is set up with.
    /// Over the link, when nothing plays. @return the first difference between the boards in words
    [[nodiscard]] std::string new_foci() {
        if (foci_ == 0) return {};
        namespace field = interface::parameters_field;
        say({Command::identify, {}});
        say({Command::stop, {}});
        std::vector<std::uint16_t> geometry;
        for (std::uint32_t k = 0; k < p_.channels; ++k)
            for (int word = 0; word < 4; ++word)
                geometry.push_back(one_in(20) ? any_word() : static_cast<std::uint16_t>(any_word() / 8));
        for (std::uint32_t k = 0; k < geometry.size(); k += record_words())
            say(writes(
                interface::geometry_base + 2 * k,
                {geometry.begin() + k, geometry.begin() + std::min<std::size_t>(k + record_words(), geometry.size())}));
        std::array<std::uint16_t, interface::parameters_words> parameters{};
        field::foci_base.set(parameters, first_focus() / 4);
        field::foci_count.set(parameters, focus_records());
        field::foci_last.set(parameters, foci_ - 1);
        field::foci_whole.set(parameters, below(2));
        field::foci_cycle.set(parameters, amplitude_cycle());
        field::wave_number.set(parameters, one_in(4) ? below(1U << 18) : 122'000);
        field::gain.set(parameters, one_in(4) ? any_word() : 39953 / between(1, 8));
        field::slew.set(parameters, below(4));
        field::phase_rate.set(parameters, one_in(10) ? 0 : below(3000));
        field::amplitude_rate.set(parameters, one_in(10) ? 0 : below(20000));
        field::arrival.set(parameters, below(30));
        say(writes(interface::parameters_base, {parameters.begin(), parameters.end()}));
        const std::uint32_t before = below(10);  // focus records that are not of the ring
        say(writes(interface::ring_base, {word(first_focus() / 4 + before * foci_), word(p_.records + 1 + before),
                                          word(one_in(8) ? p_.live_depth : p_.live_depth + between(1, 20))}));
        for (int i = 0; i < 500 && !boards_.core().line_idle(); ++i)
            if (std::string difference = run(1000); !difference.empty()) return difference;
        return run(2000);
    }

    /// One command, fault or pause. @return the first difference between the boards in words; empty when there is none
    [[nodiscard]] std::string step() {
        if (images == 0 || (!keeps_role && one_in(100))) {
            new_image();
            if (std::string difference = new_foci(); !difference.empty()) return difference;
        }
        if (!keeps_role && one_in(300)) reset();
        if (p_.width_bits != 0 && !chained_ && one_in(80))
            if (std::string difference = still_plays(); !difference.empty()) return difference;
        if (p_.stream != 0 && one_in(15))
            if (std::string difference = stream(); !difference.empty()) return difference;
        if (one_in(60)) press_stop();
        if (p_.trigger != 0 && one_in(8))
            if (std::string difference = move_trigger(); !difference.empty()) return difference;
        // Who leaves a chain, or begins one, waits for the answers before; the reference board's may come late
        // otherwise.
        if (p_.chain != 0 && one_in(chained_ ? 100 : 40)) {
            if (std::string difference = drain(); !difference.empty()) return difference;
            chained_ = !chained_;
            if (chained_)
                send({interface::chain::all, all_but(interface::chain::all), 0});
            else if (std::string difference = send_break(); !difference.empty())
                return difference;
        }
        if (!chained_ && one_in(150)) disturb_line();
        if (one_in(60)) send(noise());
        send_frame();
        return pause();
    }

    std::uint64_t commands = 0, images = 0, replies = 0, applied = 0, waits = 0;
    std::uint64_t in_step = 0, numbered = 0, losses = 0, modulated = 0, bent = 0, far = 0;  // of replies to STATUS
    std::uint64_t pushed_foci = 0;                                                          // frames
    std::uint64_t streaming = 0, late = 0, lost = 0, early = 0, repeated = 0;               // of replies to STATUS
    std::uint64_t quick_records = 0;  // behind which another one was asked for
    bool keeps_role = false;          // nothing is reset

private:
    using Command = interface::Command;

    std::uint32_t below(std::uint32_t count) { return static_cast<std::uint32_t>(g_()) % count; }
    std::uint32_t between(std::uint32_t low, std::uint32_t high) { return low + below(high - low + 1); }
    bool one_in(std::uint32_t count) { return below(count) == 0; }
    std::uint16_t any_word() { return static_cast<std::uint16_t>(g_()); }
    static std::uint16_t word(std::uint32_t value) { return static_cast<std::uint16_t>(value); }

    // Where things lie in primary memory: records first, then foci.
    [[nodiscard]] std::uint32_t record_words() const { return p_.channels + interface::record_header_words; }
    [[nodiscard]] std::uint32_t used_records() const { return std::min(p_.records, 40U); }
    [[nodiscard]] std::uint32_t first_focus() const { return 4 * (used_records() * record_words() / 4 + 1); }
    /// Some of the last ones reach beyond the memory.
    [[nodiscard]] std::uint32_t focus_records() const {
        return (p_.records * record_words() - first_focus()) / (4 * foci_) + 2;
    }
    /// Of a record of any kind; one that is there, or will be.
    std::uint32_t index() {
        if (foci_ != 0 && one_in(2)) return p_.records + 1 + below(std::min(focus_records() + 1, 400U));
        return 1 + below(used_records());
    }

    void send(const Bytes& bytes) {
        boards_.both([&](sim::Board& board) { board.send(bytes); });
    }

    // ---- A chain of one

    /// What stands behind the first byte of a frame, and shows whether one of the two was damaged.
    static std::uint8_t all_but(unsigned first) { return static_cast<std::uint8_t>(~(first & 0xfeU)); }

    /// For this tile, for all, or for another one.
    Bytes addressed(const Bytes& frame) {
        if (!chained_) return frame;
        const unsigned first = one_in(5) ? interface::chain::all : one_in(20) ? below(256) : 3;
        Bytes whole = {static_cast<std::uint8_t>(first), one_in(40) ? static_cast<std::uint8_t>(g_()) : all_but(first)};
        whole.insert(whole.end(), frame.begin(), frame.end());
        return whole;
    }

    Bytes addressed_here(const Bytes& frame) const {
        if (!chained_) return frame;
        Bytes whole = {3, all_but(3)};
        whole.insert(whole.end(), frame.begin(), frame.end());
        return whole;
    }

    std::string drain() {
        for (int i = 0; i < 1000 && !boards_.core().line_idle(); ++i)
            if (std::string difference = run(1000); !difference.empty()) return difference;
        return run(40 * (2 * record_words() + 20) * (p_.clock_hz / p_.baud));
    }

    std::string send_break() {
        boards_.both([](sim::Board& board) { board.force_line(false); });
        std::string difference = run(25 * p_.clock_hz / p_.baud);
        boards_.both([](sim::Board& board) { board.force_line({}); });
        return difference.empty() ? run(1000) : difference;
    }

    /// Equal boards can both be stuck. Whatever came before, a record of amplitudes that is selected begins soon;
    /// behind records with cycles of a few clocks, too, whether these are refused or played.
    std::string still_plays() {
        const auto settle = [this](std::uint32_t clocks) {
            for (int i = 0; i < 1000 && !boards_.core().line_idle(); ++i)
                if (std::string difference = run(1000); !difference.empty()) return difference;
            return run(clocks);
        };
        const std::uint32_t period = p_.clock_hz / 40'000;
        std::vector<std::uint16_t> quick(record_words()), good(record_words());
        interface::record_field::cycle_length.set(quick, between(1, 9));
        interface::record_field::pulse_length.set(quick, below(3));
        interface::record_field::prescaler.set(quick, one_in(3) ? between(1, 3) : 1);
        interface::record_field::kind.set(quick, static_cast<unsigned>(interface::Kind::timings));
        interface::record_field::cycle_length.set(good, period);
        interface::record_field::pulse_length.set(good, 0);
        interface::record_field::prescaler.set(good, 1);
        interface::record_field::kind.set(good, static_cast<unsigned>(interface::Kind::amplitudes));
        for (std::size_t k = interface::record_header_words; k < good.size(); ++k) good[k] = any_word();
        // The zero ends what noise began, STOP what waits to play. A long cycle ends at once while outputs are off.
        send({0});
        say({Command::identify, {}});
        say({Command::disable, {}});
        say({Command::stop, {}});
        say(writes(interface::primary_base, quick));
        say(writes(interface::primary_base + 2 * record_words(), good));
        say({Command::select, {1, word(below(3))}});
        if (std::string difference = settle(between(1, 3 * period)); !difference.empty()) return difference;
        selected_ = false;
        selecting_ = number_;
        say({Command::select, {2, 0}});
        // Requests that wait before it may take long to answer.
        for (int i = 0; i < 1000 && !selected_; ++i)
            if (std::string difference = run(1000); !difference.empty()) return difference;
        if (!selected_) return {};  // what was on the way before took its number
        if (std::string difference = run(8 * period); !difference.empty()) return difference;
        ++quick_records;
        if (const auto index = boards_.core().outputs().index; index != 2)
            return fmt::format("record 2 was selected, and {} plays", index);
        return {};
    }

    // ---- Records and images

    /// Lengths of cycle and pulse: usual ones, and those at the limits. In some images all pulses leave gaps of one
    /// tick, which are filled at changes: they merge until the guard trips.
    std::vector<std::uint16_t> record() {
        std::uint32_t cycle = between(100, 400);
        std::uint32_t prescaler = one_in(3) ? between(1, 6) : 1;
        std::uint32_t pulse = between(1, std::min(cycle / 2, 255U));
        switch (below(12)) {
            case 0: cycle = between(1, one_in(3) ? 5 : 40), pulse = between(0, cycle - 1); break;
            case 1: cycle = between(100, 256), pulse = cycle - 1; break;
            case 2: cycle = between(200, 260), pulse = between(cycle / 2, 255); break;
            case 3: cycle = between(4000, 6000), pulse = 255; break;
            case 4: prescaler = between(20, 60), cycle = between(20, 60), pulse = between(0, 10); break;
            case 5: pulse = 0; break;
            case 6: cycle = 250, pulse = 125, prescaler = 5; break;
            default: break;
        }
        // The cycle of boards that are in step.
        if (p_.sync != 0 && !one_in(3)) {
            const std::uint32_t of_period[] = {1, 1, 2, 5, 10, 25, 50, 125, 250, 625};
            prescaler = of_period[below(10)];
            cycle = p_.clock_hz / 40'000 / prescaler;
            pulse = std::min(one_in(3) ? below(cycle) : cycle / 2, 255U);
        }
        if (p_.width_bits != 0 && !sticky_ && !one_in(3)) return amplitudes();
        if (sticky_) cycle = 20, pulse = 19, prescaler = 90;
        std::vector<std::uint16_t> words(p_.channels + interface::record_header_words);
        interface::record_field::cycle_length.set(words, one_in(60) ? below(1U << 24) : cycle);
        interface::record_field::pulse_length.set(words, pulse & 0xffU);
        interface::record_field::prescaler.set(words, one_in(60) ? below(1U << 24) : prescaler);
        if (one_in(60)) interface::record_field::kind.set(words, 1 + below(255));
        const std::uint32_t kind = sticky_ ? 0 : below(6);
        const std::uint32_t common = sticky_ ? 3 : below(cycle);
        for (std::size_t k = interface::record_header_words; k < words.size(); ++k) {
            std::uint32_t timing = kind == 0 ? common : kind == 1 ? common + below(3) : below(cycle);
            if (kind == 2 && one_in(2)) timing = cycle - 1 - below(3);
            if (kind == 3 && one_in(2)) timing = below(3);
            if (one_in(20)) timing = cycle + below(4);
            if (one_in(20)) timing = (1U << p_.timing_bits) - 2 + below(3);
            words[k] = static_cast<std::uint16_t>(one_in(20) ? interface::silent_timing : timing);
        }
        return words;
    }

    /// Of a record of amplitudes, mostly of the same length, so that they follow each other in the same ticks.
    std::uint32_t amplitude_cycle() {
        const std::uint32_t period = p_.clock_hz / 40'000, least = 2 * (p_.channels + 44);
        if (p_.sync != 0 && !one_in(4)) return period;
        if (one_in(30)) return between(least - 2, least + 1);
        if (one_in(30)) return between(2 * 999 - 1, 2 * 1023 + 1);
        return one_in(3) ? between(least, period) : one_in(3) ? period : 2 * least;
    }

    std::vector<std::uint16_t> amplitudes() {
        std::vector<std::uint16_t> words(record_words());
        interface::record_field::cycle_length.set(words, amplitude_cycle());
        interface::record_field::prescaler.set(words, one_in(60) ? 2 : 1);
        interface::record_field::pulse_length.set(words, one_in(60) ? below(256) : 0);
        interface::record_field::kind.set(words, static_cast<unsigned>(interface::Kind::amplitudes));
        const std::uint32_t kind = below(5), common = below(256);
        for (std::size_t k = interface::record_header_words; k < words.size(); ++k) {
            std::uint32_t phase = kind == 0 ? common : kind == 1 ? common + below(3) : below(256);
            if (kind == 2) phase = one_in(2) ? 250 + below(12) : below(64);  // whose pulses lie about the cycle's end
            const std::uint32_t amplitude = one_in(4) ? 255 : one_in(6) ? below(3) : below(256);
            words[k] = word(amplitude << 8 | (phase & 0xffU));
        }
        return words;
    }

    std::array<std::uint16_t, 4> focus() {
        std::array<std::uint16_t, 4> words{};
        for (int axis = 0; axis < 3; ++axis) words[static_cast<std::size_t>(axis)] = word(below(40'000));
        words[3] = word((one_in(5)   ? 0
                         : one_in(2) ? 255
                                     : below(256))
                            << 8 |
                        (one_in(15) ? below(64) : 0) | (one_in(100) ? between(1, 3) << 6 : 0));
        return words;
    }

    std::uint32_t entry() {
        return (one_in(15) ? below(p_.records + 3) : index()) |
               (one_in(30)  ? 0
                : one_in(3) ? between(2, 6)
                            : 1)
                   << 16 |
               (p_.trigger != 0 && one_in(5) ? 0x8000U : 0U);
    }

    std::uint32_t header() {
        return (one_in(20) ? below(0x8000) : between(1, p_.sequence_depth - 1)) | (one_in(2) ? 0x8000U : 0U) |
               below(4) << 16;
    }

    // ---- Frames

    struct Request {
        Command command;
        std::vector<std::uint16_t> words;
    };

    static Request writes(std::uint32_t address, const std::vector<std::uint16_t>& data) {
        Request request{Command::write, {word(address), word(address >> 16)}};
        request.words.insert(request.words.end(), data.begin(), data.end());
        return request;
    }

    /// What boards with amplitudes have beside records and sequence: samples, settings that may change while they are
    /// in use, the ring; and foci in primary memory.
    std::pair<std::uint32_t, std::vector<std::uint16_t>> setting() {
        const auto of = [](const interface::BitField& field) { return field.offset / 16; };
        namespace field = interface::parameters_field;
        std::vector<std::uint16_t> data;
        switch (below(foci_ != 0 ? 8 : 3)) {
            case 0:
            case 1:
                for (std::uint32_t i = between(1, 12); i > 0; --i) data.push_back(any_word());
                return {interface::modulation_base + 2 * below(p_.modulation_depth / 2 + 1), data};
            case 2: {
                const std::uint16_t values[] = {word(below(4)), word(one_in(10) ? 0 : below(3000)), word(below(20000)),
                                                word(below(30))};
                const std::uint32_t which = below(4);
                return {interface::parameters_base + 2 * (of(field::slew) + which), {values[which]}};
            }
            case 3:
                return {interface::parameters_base + 2 * of(field::foci_base),
                        {word(first_focus() / 4 + (one_in(3) ? below(3) : 0)),
                         word(one_in(3) ? below(40) : focus_records())}};
            case 4: return {interface::parameters_base + 2 * of(field::foci_cycle), {word(amplitude_cycle())}};
            case 5: return {interface::ring_base + 2 * below(4), {any_word()}};
            default:
                for (std::uint32_t i = between(1, 4); i > 0; --i)
                    for (const std::uint16_t w : focus()) data.push_back(w);
                return {interface::primary_base + 2 * (first_focus() + 4 * below(200)), data};
        }
    }

    Request memory_command(Command command) {
        if (p_.width_bits != 0 && one_in(2)) {
            auto [address, data] = setting();
            if (command == Command::write) return writes(address, data);
            return {command, {word(address), word(address >> 16), word(2 * static_cast<std::uint32_t>(data.size()))}};
        }
        const std::uint32_t record_words = this->record_words();
        std::uint32_t address = interface::primary_base + 2 * record_words * below(used_records());
        std::uint32_t words = record_words;
        std::vector<std::uint16_t> data = record();
        switch (below(8)) {
            case 0:
                address = interface::sequence_base + 4 * below(p_.sequence_depth);
                words = 2 * between(1, 4);
                data.clear();
                for (std::uint32_t i = 0; i < words; i += 2) {
                    const std::uint32_t word = address == interface::sequence_base && i == 0 ? header() : entry();
                    data.push_back(static_cast<std::uint16_t>(word));
                    data.push_back(static_cast<std::uint16_t>(word >> 16));
                }
                break;
            case 1: address += 2 * below(record_words), words = between(1, 4); break;
            case 2:
                address = one_in(2) ? interface::identity_base : interface::status_base;
                address += 2 * below(4), words = between(1, 8);
                break;
            case 3:
                if (one_in(4)) address = static_cast<std::uint32_t>(g_()), words = below(2 * record_words);
                break;
            default: break;
        }
        if (one_in(40)) ++address;
        data.resize(words, 7);
        Request request{command, {static_cast<std::uint16_t>(address), static_cast<std::uint16_t>(address >> 16)}};
        if (command == Command::write)
            request.words.insert(request.words.end(), data.begin(), data.end());
        else
            request.words.push_back(static_cast<std::uint16_t>(2 * words + (one_in(40) ? 1 : 0)));
        return request;
    }

    Request request() {
        const auto w = word;
        switch (below(32)) {
            case 0:
            case 1:
            case 2: return {Command::enable, {}};
            case 3: return {Command::disable, {}};
            case 4: return {Command::stop, {}};
            case 5: return {Command::keep_alive, {}};
            case 6: return {!keeps_role && one_in(4) ? Command::reset : Command::status, {}};
            case 7: return p_.trigger != 0 ? trigger() : Request{Command::status, {}};
            case 8: return {Command::status, {}};
            case 9: return {Command::watchdog, {w(one_in(3) ? 0 : one_in(10) ? any_word() : between(1, 3))}};
            case 10:
            case 11: return {Command::select, {w(one_in(15) ? below(p_.records + 4) : index()), w(below(4))}};
            case 12:
            case 13: {
                const std::uint32_t first = 1 + below(p_.sequence_depth - 1);
                const std::uint32_t length = one_in(4) ? 0 : 1 + below(p_.sequence_depth - first);
                return {Command::start, {w(one_in(20) ? any_word() : first), w(length), w(below(3))}};
            }
            case 14:
            case 15:
            case 16: {
                Request push{Command::push, {w(one_in(10) ? 0 : between(1, 3))}};
                for (std::uint32_t i = between(1, 6); i > 0; --i)
                    push.words.push_back(w(one_in(40)   ? p_.records + 1 + below(3)
                                           : foci_ != 0 ? index()
                                                        : below(p_.records + 1)));
                return push;
            }
            case 17:
            case 18: return memory_command(Command::read);
            case 19: return memory_command(Command::digest);
            case 20: return {static_cast<Command>(one_in(2) ? below(256) : 0), {}};
            case 21: return {Command::identify, {}};
            case 27:
                if (keeps_role) return {Command::status, {}};
                return {Command::sync, {w(below(4))}};
            case 22: return modulate();
            case 23:
            case 24:
            case 25: return gate();
            case 26: {  // nor this one
                Request push{Command::push_foci, {w(one_in(10) ? 0 : between(1, 3))}};
                for (std::uint32_t i = std::max(foci_, 1U) * between(1, 8); i > 0; --i)
                    for (const std::uint16_t part : focus()) push.words.push_back(part);
                if (one_in(20)) push.words.resize(push.words.size() - between(1, 4));
                return push;
            }
            default: return p_.width_bits != 0 && one_in(4) ? modulate() : memory_command(Command::write);
        }
    }

    /// Some boards have no such command.
    Request modulate() {
        if (p_.modulation_depth == 0) return {Command::modulate, {word(below(3)), word(below(70)), word(below(3))}};
        const std::uint32_t first = below(p_.modulation_depth), most = p_.modulation_depth - first;
        return {
            Command::modulate,
            {word(one_in(5) ? 0 : between(1, one_in(4) ? 100 : 3)),
             word(one_in(10) ? below(2 * p_.modulation_depth) : below(most)), word(one_in(3) ? first : first | 1U)}};
    }

    /// Patterns for about now, of this session or another one, among other commands.
    std::string stream() {
        if (one_in(2)) {
            const std::uint32_t first =
                foci_ != 0 && one_in(2) ? p_.records + 1 + below(focus_records()) : 1 + below(30);
            say(writes(interface::stream_base,
                       {word(one_in(20) ? any_word() : first), word(one_in(20) ? below(7) : between(1, 4)),
                        word(below(6)), word(one_in(20) ? 0 : between(1, 30'000))}));
            stream_words_ = first > p_.records ? 4 * foci_ : p_.channels;
        }
        if (one_in(2)) say({Command::enable, {}});
        for (std::uint32_t round = between(2, 12); round > 0; --round) {
            if (!one_in(3)) say({Command::status, {}});
            if (std::string difference = run(between(500, 3000)); !difference.empty()) return difference;
            const std::uint64_t period = period_ + below(16) - 2;
            Request request{Command::stream,
                            {word(period & 0xffffU), word(period >> 16 & 0xffffU), word(period >> 32 & 0xffffU)}};
            const std::uint32_t most = (484 - 8) / 2 / stream_words_;
            std::uint32_t words = stream_words_ * between(1, most) - (one_in(10) ? between(1, 3) : 0);
            while (words-- > 0) request.words.push_back(stream_words_ != p_.channels && one_in(4) ? 0 : any_word());
            send(encoded(static_cast<std::uint8_t>(session_ + (one_in(20) ? 1 : 0)), request));
            if (one_in(30)) send_frame();
            if (std::string difference = run(between(100, 3000)); !difference.empty()) return difference;
        }
        return {};
    }

    /// The trigger pins' settings, and what they tell, also where nothing can be written.
    Request trigger() {
        const std::uint32_t first = below(interface::trigger_settings), most = interface::trigger_words - first;
        const std::uint32_t address = interface::trigger_base + 2 * first;
        if (one_in(2)) return {Command::read, {word(address), word(address >> 16), word(2 * between(1, most))}};
        const std::uint16_t values[interface::trigger_settings] = {
            word(one_in(20) ? any_word() : below(6)), word(below(4)),
            word(one_in(3) ? below(4) : below(3000)), word(one_in(60) ? 1 : 0),
            word(one_in(20) ? any_word() : below(8)), word(one_in(3) ? below(400) : below(4)),
            word(one_in(20) ? any_word() : below(4)), word(one_in(20) ? any_word() : below(p_.channels))};
        Request request = writes(address, {});
        const std::uint32_t words = one_in(20) ? most : between(1, std::min(3U, interface::trigger_settings - first));
        for (std::uint32_t i = 0; i < words; ++i)
            request.words.push_back(first + i < interface::trigger_settings ? values[first + i] : any_word());
        return request;
    }

    /// The trigger input: some changes, of a few clocks or longer, and what waits for them.
    std::string move_trigger() {
        if (one_in(3)) {
            say({Command::gate, {0xfffe, 0xffff, 0xffff}});
            if (std::string difference = run(between(400, 2000)); !difference.empty()) return difference;
            say(request());
            if (std::string difference = run(between(400, 2000)); !difference.empty()) return difference;
        }
        for (std::uint32_t i = between(1, 4); i > 0; --i) {
            moved_ = !moved_;
            boards_.both([this](sim::Board& board) { board.drive_trigger(moved_); });
            if (std::string difference = run(one_in(3) ? between(1, 800) : between(1, 8)); !difference.empty())
                return difference;
        }
        return {};
    }

    /// For soon, the end, or nothing; on some boards there is no such command.
    Request gate() {
        std::uint64_t period = period_ + below(200);
        if (one_in(3)) period = one_in(4) ? 0 : ~std::uint64_t{0};
        if (one_in(60)) period = g_();
        if (p_.trigger != 0 && one_in(4)) period = ~std::uint64_t{1};
        const auto part = [period](unsigned shift) { return static_cast<std::uint16_t>(period >> shift); };
        return {Command::gate, {part(0), part(16), part(32)}};
    }

    /// As it is, and in its turn.
    void say(const Request& request) { send(addressed_here(encoded(number_++, request))); }

    static Bytes encoded(std::uint8_t number, const Request& request) {
        Bytes payload;
        for (const std::uint16_t word : request.words) {
            payload.push_back(static_cast<std::uint8_t>(word));
            payload.push_back(static_cast<std::uint8_t>(word >> 8));
        }
        return link::encode_request(number, request.command, payload);
    }

    void send_frame() {
        ++commands;
        Request request = this->request();
        if (lost_ > 3 || commands == 1) request = {Command::identify, {}};
        if (one_in(60)) request.words.resize(below(8), any_word());
        Bytes payload;
        for (const std::uint16_t word : request.words) {
            payload.push_back(static_cast<std::uint8_t>(word));
            payload.push_back(static_cast<std::uint8_t>(word >> 8));
        }
        if (one_in(80)) payload.push_back(static_cast<std::uint8_t>(g_()));
        std::uint8_t number = number_;
        if (request.command == Command::identify) {
            if (one_in(3)) number = static_cast<std::uint8_t>(g_());
            lost_ = 0;
        } else if (one_in(25)) {  // applied before, or a frame is missing before it
            number = static_cast<std::uint8_t>(number + (one_in(4) ? between(1, 3) : 256 - between(1, 20)));
        }
        Bytes frame = link::encode_request(number, request.command, payload);
        const bool damaged = one_in(25);
        if (damaged) damage(frame);
        send(addressed(frame));
        if (!damaged && (number == number_ || request.command == Command::identify))
            number_ = static_cast<std::uint8_t>(number + 1);
    }

    void damage(Bytes& frame) {
        const std::size_t at = below(static_cast<std::uint32_t>(frame.size()));
        switch (below(5)) {
            case 0: frame[at] = static_cast<std::uint8_t>(frame[at] ^ 1U << below(8)); break;
            case 1: frame.erase(frame.begin() + static_cast<std::ptrdiff_t>(at)); break;
            case 2: frame.resize(at); break;
            case 3: frame.insert(frame.begin() + static_cast<std::ptrdiff_t>(at), frame[at]); break;
            default: {
                const Bytes more(2 * p_.channels + 2 * below(2 * p_.channels), 0x55);
                frame.insert(frame.begin() + static_cast<std::ptrdiff_t>(at), more.begin(), more.end());
            }
        }
    }

    Bytes noise() {
        Bytes bytes(1 + below(40));
        const std::uint32_t values = one_in(2) ? 256 : 4;
        for (auto& byte : bytes) byte = static_cast<std::uint8_t>(below(values));
        return bytes;
    }

    // ---- The rest of the world

    void reset() {
        const unsigned clocks = between(1, 6);
        boards_.both([clocks](sim::Board& board) { board.reset(clocks); });
        chained_ = false;
        lost_ = 4;
    }

    void press_stop() {
        pressed_ = !pressed_ && one_in(2);
        boards_.both([this](sim::Board& board) { board.press_stop(pressed_); });
    }

    void disturb_line() {
        if (one_in(3)) {
            boards_.both([](sim::Board& board) { board.unplug(); });
            return;
        }
        if (p_.net != 0) {
            // Rarely enough that something plays between them.
            switch (below(16)) {
                case 0: boards_.both([](sim::Board& board) { board.network_break(); }); break;
                case 1: boards_.both([](sim::Board& board) { board.network_lost(); }); break;
                case 2: boards_.both([](sim::Board& board) { board.network_end(); }); break;
                case 3: boards_.both([](sim::Board& board) { board.network_stop(); }); break;
                default: break;
            }
            return;
        }
        const bool level = one_in(4);
        boards_.both([level](sim::Board& board) { board.force_line(level); });
        forced_for_ = one_in(2) ? between(1, 60) : between(1, 30 * p_.clock_hz / p_.baud);
    }

    std::string pause() {
        if (forced_for_ > 0) {
            std::string difference = run(std::exchange(forced_for_, 0U));
            boards_.both([](sim::Board& board) { board.force_line({}); });
            if (!difference.empty()) return difference;
        }
        // A network brings a byte a clock: frames come one at a time, with the pause that a datagram of their own would
        // have, or some wait in the port.
        if (p_.net != 0 && one_in(4)) return run(between(1, 40));
        if (p_.net != 0) return run(between(400, one_in(4) ? 20'000 : 4'000));
        const std::uint32_t byte_clocks = 10 * p_.clock_hz / p_.baud;
        switch (below(6)) {
            case 0: return {};  // the next frame follows at once
            case 1: return run(between(1, 4));
            case 2: return run(between(1, byte_clocks));
            case 3: return run(between(1, 30 * byte_clocks));
            default: break;
        }
        if (one_in(400)) return run(between(1, 4 * (p_.clock_hz / 1000)));
        // Until the line is idle, so that not too much waits in it.
        for (int i = 0; i < 50 && !boards_.core().line_idle(); ++i)
            if (std::string difference = run(8 * byte_clocks); !difference.empty()) return difference;
        return run(between(1, 12 * byte_clocks));
    }

    std::string run(std::uint64_t clocks) {
        std::string difference = boards_.run(clocks);
        Bytes bytes;
        for (const sim::Arrival& arrival : boards_.received()) {
            if (!chained_ || place_ >= 2) bytes.push_back(arrival.byte);
            place_ = arrival.byte == 0 ? 0 : place_ + 1;
        }
        std::vector<link::Reply> found;
        decoder_.feed(bytes, found);
        for (const link::Reply& reply : found) {
            ++replies;
            selected_ = selected_ || (reply.command == Command::select && reply.sequence == selecting_ &&
                                      reply.status == interface::Status::ok);
            const bool strange = reply.status == interface::Status::out_of_order;
            lost_ = strange ? lost_ + 1 : 0;
            applied += reply.status == interface::Status::ok ? 1 : 0;
            if (reply.command == Command::status && reply.data.size() >= 2 * interface::status_unstreamed_words)
                period_ = interface::status_field::period.get(reply.data);
            if (reply.command == Command::status && reply.data.size() >= 2 * interface::status_untimed_words) {
                in_step += interface::status_field::in_step.get(reply.data);
                numbered += interface::status_field::numbered.get(reply.data);
                losses = std::max<std::uint64_t>(losses, interface::status_field::sync_losses.get(reply.data));
                modulated += interface::status_field::modulated.get(reply.data);
                bent += interface::status_field::bent_periods.get(reply.data) > 0 ? 1 : 0;
                far += interface::status_field::far_foci.get(reply.data) > 0 ? 1 : 0;
                streaming += interface::status_field::streaming.get(reply.data);
                late += interface::status_field::stream_late.get(reply.data) > 0 ? 1 : 0;
                lost += interface::status_field::stream_lost.get(reply.data) > 0 ? 1 : 0;
                early += interface::status_field::stream_early.get(reply.data) > 0 ? 1 : 0;
                repeated += interface::status_field::stream_repeated.get(reply.data) > 0 ? 1 : 0;
            }
            if (reply.command == Command::identify) session_ = reply.sequence;
            pushed_foci += reply.command == Command::push_foci && reply.status == interface::Status::ok ? 1 : 0;
            waits += reply.command == Command::gate && reply.status == interface::Status::ok ? 1 : 0;
        }
        return difference;
    }

    LockStep& boards_;
    const interface::CoreParameters& p_;
    std::mt19937 g_;
    std::uint8_t number_ = 0, session_ = 0;
    std::uint32_t stream_words_ = 16;  // of a pattern
    unsigned lost_ = 0;
    std::uint8_t selecting_ = 0;  // number of the SELECT whose record is waited for
    bool selected_ = false;       // a reply to it says so
    bool pressed_ = false;
    bool moved_ = false;  // the level at the trigger input
    bool chained_ = false;
    unsigned place_ = 0;  // in the answer that arrives
    bool sticky_ = false;
    std::uint32_t foci_ = 0;    // of a focus record of the present image
    std::uint64_t period_ = 0;  // as the board said last
    std::uint32_t forced_for_ = 0;
    link::ReplyDecoder decoder_;
};

}  // namespace haptogram::test
