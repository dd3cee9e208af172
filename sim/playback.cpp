// SPDX-License-Identifier: Apache-2.0
#include "playback.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <limits>

#include "haptogram/base/error.hpp"
#include "haptogram/link/intensity.hpp"
#include "haptogram/link/outputs.hpp"
#include "haptogram/link/transfer.hpp"
#include "simulated_board.hpp"
#include "simulated_transport.hpp"

namespace haptogram::sim {
namespace {

class Stopwatch {
public:
    [[nodiscard]] double seconds() const {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - begun_).count();
    }

private:
    std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
};

std::uint64_t clocks_per_pass(const Image& image) {
    std::uint64_t clocks = 0;
    std::uint64_t cycle = 0;
    for (const SequenceEntry& entry : image.sequence) {
        if (const auto place = place_of(image, entry.index)) cycle = cycle_clocks(image, *place);
        clocks += cycle * entry.dwell;
    }
    return clocks;
}

/// Contracts 2 and 6: the sequence's entries in order, each for its dwell. Neighbouring entries of one index look like
/// one.
void check_dwells(const Image& image, const std::vector<Dwell>& dwells, std::uint32_t passes, Playback& playback) {
    std::vector<SequenceEntry> expected;
    std::vector<std::uint64_t> cycles;
    for (std::uint32_t pass = 0; pass < passes; ++pass) {
        for (const SequenceEntry& entry : image.sequence) {
            if (!expected.empty() && expected.back().index == entry.index)
                cycles.back() += entry.dwell;
            else {
                expected.push_back(entry);
                cycles.push_back(entry.dwell);
            }
        }
    }
    std::vector<Dwell> seen = dwells;
    if (!image.sequence.empty() && image.sequence.front().index != 0)
        while (!seen.empty() && seen.front().index == 0) seen.erase(seen.begin());
    for (std::size_t i = 0; i < expected.size(); ++i) {
        if (expected[i].index == 0 && (i == 0 || i + 1 == expected.size()))
            continue;  // silence between entries looks the same as not playing
        if (i < seen.size() && seen[i].index == expected[i].index && seen[i].cycles == cycles[i]) continue;
        ++playback.violation_count;
        playback.violations.push_back(
            i < seen.size()
                ? fmt::format("step {} of the sequence: expected record {} for {} cycles, measured record {} for {}",
                              i + 1, expected[i].index, cycles[i], seen[i].index, seen[i].cycles)
                : fmt::format("step {} of the sequence: record {} was not played", i + 1, expected[i].index));
        return;  // the entries after a wrong one are shifted, and would be reported for the same reason
    }
    for (std::size_t i = expected.size(); i < seen.size(); ++i) {
        if (seen[i].index == 0) continue;
        ++playback.violation_count;
        playback.violations.push_back(fmt::format("record {} was played after the sequence's end", seen[i].index));
        return;
    }
}

void check_status(const link::Status& status, Playback& playback) {
    const auto expect_none = [&](std::uint16_t count, const char* what) {
        if (count == 0) return;
        playback.violation_count += count;
        playback.violations.push_back(fmt::format("the board counts {} {}", count, what));
    };
    expect_none(status.underruns, "underruns: a record was not loaded in time");
    expect_none(status.refused_records, "refused records");
    expect_none(status.frames_damaged, "damaged frames on a clean line");
    expect_none(status.watchdog_trips, "watchdog trips");
    expect_none(status.far_foci, "focus records with a focus too far from a channel to count");
    expect_none(status.guard_trips, "output guard trips: a pin was high for too long");
}

/// The span in which pulses can be compared: from the second cycle that began with outputs enabled, to the last cycle
/// start.
std::pair<std::uint64_t, std::uint64_t> comparable(const std::vector<CycleStart>& cycles) {
    for (std::size_t i = 1; i < cycles.size(); ++i)
        if (cycles[i - 1].enabled && cycles[i].enabled) return {cycles[i].clock, cycles.back().clock};
    return {0, 0};
}

/// Whether any of the records has amplitudes.
/// The same as check_pulses() with a modulation. Its first sample is played in the next cycle whose words are not begun
/// yet when the command acts (contract 9), between its sending and its answer; so it is looked for there.
/// @param from_cycle, to_cycle  how many cycles there were at these two times
PulseReport check_modulated(const Image& image, const std::vector<CycleStart>& cycles, const std::vector<Pulse>& pulses,
                            std::uint64_t begin, std::uint64_t end, std::size_t from_cycle, std::size_t to_cycle) {
    constexpr std::size_t begun_ahead = 2;  // cycles at the pins, whose words were made before the command acted
    PulseReport best;
    best.violations = std::numeric_limits<std::uint64_t>::max();
    for (std::size_t i = from_cycle; i < std::min(cycles.size(), to_cycle + begun_ahead) && best.violations > 0; ++i) {
        PulseReport report = check_pulses(image, cycles, pulses, begin, end, image.channels, cycles[i].clock);
        if (report.violations < best.violations) best = std::move(report);
    }
    if (best.violations == std::numeric_limits<std::uint64_t>::max()) return {0, 1, {"the modulation did not start"}};
    return best;
}

}  // namespace

std::string_view model_for(const Image& image, const std::string& where,
                           std::span<const interface::CoreConfiguration> models) {
    const bool amplitudes = link::can_be_modulated(image);
    std::vector<interface::CoreConfiguration> able;
    for (const interface::CoreConfiguration& model : models) {
        const interface::CoreParameters& p = model.parameters;
        if ((amplitudes && p.width_bits == 0) || (image.modulation && p.modulation_depth == 0)) continue;
        if (image.foci && (p.foci == 0 || p.records != image.foci->board_records)) continue;
        able.push_back(model);
    }
    const auto model =
        find_model(able, image.clock_hz, image.channels, static_cast<std::uint32_t>(image.records.size()),
                   static_cast<std::uint32_t>(image.sequence.size() + 1), image.timing_bits);
    if (model) return *model;
    std::string known;
    for (const auto& [name, p] : models)
        known += fmt::format("\n  {}: {} channels, {} records, {} sequence entries, {} timing bits, {} Hz{}", name,
                             p.channels, p.records, p.sequence_depth - 1, p.timing_bits, p.clock_hz,
                             p.foci > 0 ? ", with foci" : "");
    throw bad_input(
        where,
        fmt::format(
            "no simulated board has {} channels, {} records, {} sequence entries, {} timing "
            "bits at {} Hz{}; there are:{}\n"
            "compile for one of these, or add a configuration to tools/interface.toml and its name to sim/models.cmake",
            image.channels, image.records.size(), image.sequence.size(), image.timing_bits, image.clock_hz,
            image.foci ? fmt::format(", with focus records behind index {}", image.foci->board_records)
            : amplitudes || image.modulation ? ", with amplitudes and modulation"
                                             : "",
            known));
}

void load_directly(Board& board, const Image& image) {
    std::ranges::copy(primary_words(image), board.primary_memory().begin());
    std::ranges::copy(sequence_words(image), board.sequence_memory().begin());
    if (!image.foci && !image.modulation) return;
    SimulatedTransport line(board);
    link::Client client(line);
    client.identify();
    link::write_settings(client, image);
    board.reset();
}

Playback play(const Image& image, const PlaybackOptions& options, const std::string& where) {
    const Stopwatch whole;
    SimulatedBoard board(model_for(image, where));
    if (!options.trace.empty()) board.trace(options.trace);
    PulseRecorder recorder(board);
    SimulatedTransport line(board);
    haptogram::require_fits(image, board.parameters(), where);
    if (!options.load_by_uart) load_directly(board, image);
    link::Client client(line);
    const link::Identity identity = client.identify();
    link::require_fits(image, identity, where);
    if (options.load_by_uart) link::upload(client, image, options.progress.in_stage("upload"));

    Playback playback;
    const double clock_hz = identity.clock_hz;
    const auto entries = static_cast<std::uint16_t>(image.sequence.size());
    const std::uint64_t pass = clocks_per_pass(image);
    const auto wanted =
        options.duration_s ? static_cast<std::uint64_t>(*options.duration_s * clock_hz) : pass * options.passes;
    client.enable();
    const std::uint64_t cycle = cycle_clocks(image, 0);
    board.run(2 * cycle);
    const std::size_t modulates_from = recorder.cycles().size();
    link::start_modulation(client, image);
    const std::size_t modulates_to = recorder.cycles().size();
    const std::uint64_t begun = board.now();
    const Stopwatch playing;
    client.start(1, entries, options.duration_s ? std::uint16_t{0} : static_cast<std::uint16_t>(options.passes));
    // The watchdog stays on, as with a real board. So the host gives signs of life while the sequence plays.
    const double watchdog_s = 1e-3 * board.parameters().watchdog_ms;
    const auto slice =
        static_cast<std::uint64_t>(clock_hz * (watchdog_s > 0.0 ? std::min(0.1, watchdog_s / 4.0) : 0.1));
    while (board.now() - begun < wanted) {
        board.run(std::min(slice, wanted - (board.now() - begun)));
        options.progress(static_cast<double>(board.now() - begun) / static_cast<double>(wanted), "play");
        if (board.now() - begun < wanted) playback.status = client.status();
    }
    if (options.duration_s) client.stop();
    // The last cycle, and some of silence after it. Record 0 alone is no end: a sequence may have silence in its
    // middle.
    const std::uint64_t limit = board.now() + 2 * pass + static_cast<std::uint64_t>(0.1 * clock_hz);
    bool ended = false;
    while (!ended && board.now() < limit) {
        board.run(cycle);
        ended = recorder.cycles().back().index == 0 && link::is_over(client.status());
    }
    board.run(4 * cycle);
    playback.playing_clocks = board.now() - begun;
    playback.playing_seconds = playing.seconds();
    playback.status = client.status();

    if (!ended) {
        ++playback.violation_count;
        playback.violations.emplace_back("the sequence did not end");
    }
    if (board.any_pin()) {
        ++playback.violation_count;
        playback.violations.emplace_back("a pin is still high after the sequence");
    }
    check_status(playback.status, playback);
    playback.pulses = recorder.pulses();
    playback.dwells = recorder.dwells();
    if (!options.duration_s) check_dwells(image, playback.dwells, options.passes, playback);
    const auto [from, to] = comparable(recorder.cycles());
    if (image.modulation)
        playback.pulse_report =
            check_modulated(image, recorder.cycles(), playback.pulses, from, to, modulates_from, modulates_to);
    else
        playback.pulse_report = check_pulses(image, recorder.cycles(), playback.pulses, from, to, image.channels);
    const bool fires = link::can_be_modulated(image) || std::any_of(image.records.begin(), image.records.end(),
                                                                    [](const Record& r) { return r.pulse_length > 0; });
    if (fires && playback.pulse_report.checked == 0) {
        ++playback.violation_count;
        playback.violations.emplace_back(
            "no pulse could be compared with the image: none was measured, or playing was too short");
    }
    playback.violation_count += playback.pulse_report.violations;
    playback.violations.insert(playback.violations.end(), playback.pulse_report.first.begin(),
                               playback.pulse_report.first.end());
    playback.clocks = board.now();
    playback.seconds = whole.seconds();
    return playback;
}

}  // namespace haptogram::sim
