// SPDX-License-Identifier: Apache-2.0
// A bench with a board that has amplitudes, small-16-wide unless another one is named, for the tests of the second
// instrument.
#pragma once
#include <functional>
#include <vector>

#include "../period_check.hpp"
#include "bench.hpp"
#include "haptogram/format/focus_engine.hpp"

namespace haptogram::test::wide {

// Of small-16-wide.
inline constexpr std::uint32_t channel_count = 16;
inline constexpr std::uint32_t records = 256;
inline constexpr std::uint32_t lead =
    channel_count + 44;  // clocks before a cycle's end at which its successor is begun
using Words = std::vector<std::uint16_t>;

class Wide : public Bench {
public:
    explicit Wide(std::string_view model = "small-16-wide") : Bench(model) {}

    void write(std::uint32_t address, const Words& words) {
        for (std::size_t done = 0; done < words.size(); done += 20) {
            Bytes bytes;
            for (std::size_t i = done; i < std::min(done + 20, words.size()); ++i) {
                bytes.push_back(static_cast<std::uint8_t>(words[i]));
                bytes.push_back(static_cast<std::uint8_t>(words[i] >> 8));
            }
            client.write(static_cast<std::uint32_t>(address + 2 * done), bytes);
        }
    }
    void write_record(std::uint32_t index, const Words& words) { write((index - 1) * 2 * (channels() + 4), words); }
    void set(interface::ParametersWord word, std::uint32_t value) {
        write(interface::parameters_base + 2 * static_cast<std::uint32_t>(word), {static_cast<std::uint16_t>(value)});
    }
    void write_sequence(const std::vector<SequenceEntry>& entries) {
        Words words = {static_cast<std::uint16_t>(entries.size()), 1};
        for (const SequenceEntry& e : entries) words.insert(words.end(), {e.index, e.dwell});
        write(interface::sequence_base, words);
    }
    /// Writes a record of random phases and amplitudes and remembers what it plays.
    void random_record(std::mt19937& g, std::uint16_t index, std::uint32_t cycle) {
        Words words;
        for (std::uint32_t k = 0; k < channels(); ++k) words.push_back(static_cast<std::uint16_t>(random(g, 0, 65535)));
        write_record(index, amplitude_record(cycle, words));
        book[index] = played(cycle, words);
    }
    void raw_record(std::mt19937& g, std::uint16_t index, std::uint32_t cycle, std::uint8_t pulse) {
        Words words = {static_cast<std::uint16_t>(cycle), static_cast<std::uint16_t>(pulse << 8), 1, 0};
        book[index] = Played{{}, cycle, true, pulse};
        for (std::uint32_t k = 0; k < channels(); ++k) {
            words.push_back(static_cast<std::uint16_t>(random(g, 0, cycle + 9)));
            book[index].emissions.push_back({65535, words.back()});
        }
        write_record(index, words);
    }

    /// Sets the focus engine up, with focus records of `foci` each from word 4 · `base` of primary memory on.
    void write_engine(const FocusEngine& engine, std::uint16_t base, std::uint16_t count, std::size_t foci,
                      bool whole) {
        Words geometry;
        for (const GeometryWords& words : engine.geometry) geometry.insert(geometry.end(), words.begin(), words.end());
        write(interface::geometry_base, geometry);
        using enum interface::ParametersWord;
        set(foci_base, base);
        set(foci_count, count);
        set(foci_form, static_cast<std::uint32_t>(foci - 1) | (whole ? 8U : 0U));
        set(wave_number_low, engine.wave_number);
        set(wave_number_high, engine.wave_number >> 16);
        set(gain, engine.gain);
    }
    /// Writes the n-th focus record, n from 1 on, and remembers what the engine makes of it.
    void write_foci(const FocusEngine& engine, std::uint16_t base, std::uint16_t n, const std::vector<FocusWords>& foci,
                    bool whole, std::uint32_t cycle = 1250) {
        Words words;
        for (const FocusWords& focus : foci) words.insert(words.end(), focus.begin(), focus.end());
        write(8U * base + 8U * static_cast<std::uint32_t>((n - 1) * foci.size()), words);
        Played one{{}, cycle};
        for (const ChannelDrive& drive : engine_drives(engine, foci, whole))
            one.emissions.push_back({drive.amplitude, drive.phase});
        book[static_cast<std::uint16_t>(board.parameters().records + n)] = one;
    }
    /// Plays one entry after the other, and returns the first measured cycle of the first one.
    std::size_t play(const std::vector<SequenceEntry>& sequence) {
        write_sequence(sequence);
        const std::size_t before = recorder.cycles().size();
        client.start(1, 0, 0);
        std::uint64_t clocks = 20'000;
        for (const SequenceEntry& e : sequence) clocks += 2100ULL * e.dwell;
        const auto found = [&] {
            std::size_t i = before;
            while (i < recorder.cycles().size() && recorder.cycles()[i].index != sequence[0].index) ++i;
            return i;
        };
        REQUIRE(board.run_until([&] { return found() < recorder.cycles().size(); }, 200'000));
        const std::size_t first = found();
        REQUIRE(board.run_until(
            [&] { return board.outputs().index == 0 && client.status().mode == interface::Mode::idle; }, clocks));
        board.run(10'000);
        for (std::size_t i = 0, c = first; i < sequence.size(); ++i)
            for (int d = 0; d < sequence[i].dwell; ++d) REQUIRE(recorder.cycles()[c++].index == sequence[i].index);
        return first;
    }

    /// Of the cycles `begin` to `end`, as compare_periods does.
    Comparison compare(std::size_t begin, std::size_t end, const std::function<Setting(std::size_t)>& setting,
                       EmissionModel& model) {
        std::vector<MeasuredCycle> cycles;
        for (const sim::CycleStart& start : recorder.cycles()) cycles.push_back({start.clock, start.index});
        return compare_periods(cycles, recorder.pulses(), book, begin, end, setting, model);
    }
    Comparison compare(std::size_t begin, std::size_t end) {
        const interface::CoreParameters& p = board.parameters();
        EmissionModel model(p.channels, p.timing_bits, p.width_bits, p.min_pulse_clocks);
        return compare(
            begin, end, [](std::size_t) { return Setting{}; }, model);
    }

    Book book;
};

inline void require_right(const Comparison& comparison, std::size_t least) {
    INFO(comparison.first);
    REQUIRE(comparison.wrong == 0);
    REQUIRE(comparison.pulses >= least);
}

/// `side` rows of channels 10 mm apart, and an engine that reaches full amplitude where `full` foci meet in phase.
inline FocusEngine square_engine(std::uint32_t side, double full) {
    FocusEngine engine;
    const double middle = 0.005 * (side - 1);
    for (std::uint32_t k = 0; k < side * side; ++k)
        engine.geometry.push_back(
            pack_geometry({0.010 * (k % side) - middle, 0.010 * (k / side) - middle, 0.0}, 0.01 * k));
    engine.wave_number = wave_number_word(343.0 / 40e3);
    engine.gain = gain_word(full);
    return engine;
}

inline FocusWords random_focus(std::mt19937& g) {
    const auto within = [&g](double low, double high) { return low + (high - low) * random(g, 0, 10'000) / 10'000; };
    return pack_focus({{within(-0.05, 0.05), within(-0.05, 0.05), within(0.06, 0.25)}, within(0.2, 1.0)});
}

}  // namespace haptogram::test::wide
