// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/focus_image.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/format/focus_engine.hpp"

namespace haptogram {
namespace {

using RecordWords = std::vector<FocusWords>;
constexpr std::uint32_t most_indices = 65535;

void require_board(const Array& array, const Core& core, std::size_t boards) {
    const interface::CoreParameters& p = core.parameters;
    if (p.foci == 0)
        throw bad_input(core.name, "it computes no foci; compile records for it, or take a board that does",
                        {"records", "board"});
    if (array.elements.size() != p.channels * boards)
        throw bad_input(array.file.empty() ? array.name : array.file,
                        fmt::format("{} elements, but {} computes foci for all of its {} channels; take an array of as "
                                    "many elements, or compile records, in which a channel can be silent",
                                    array.elements.size(), core.name, p.channels * boards),
                        {"records", "array", "board"});
}

/// The foci of a step that sound, as the board has them, in the order of the path.
RecordWords words_of(const PathStep& step, std::size_t number, const FocusEngine& engine, const Core& core) {
    RecordWords words;
    try {
        for (const Focus& focus : step.foci) {
            const FocusWords packed = pack_focus(focus);
            if (unpack_focus(packed).amplitude > 0.0) words.push_back(packed);
        }
    } catch (const Error& error) {
        throw bad_input(fmt::format("step {} of the path", number), error.message());
    }
    // A focus of amplitude 0 at the place of one that sounds fills a step up, as it does in the records themselves.
    const auto is_null = [&](const Focus& focus) {
        return focus.amplitude == 0.0 && std::none_of(step.foci.begin(), step.foci.end(), [&](const Focus& other) {
                   return other.amplitude > 0.0 && other.position == focus.position;
               });
    };
    if (!words.empty() && std::any_of(step.foci.begin(), step.foci.end(), is_null))
        throw bad_input(fmt::format("step {} of the path", number),
                        fmt::format("a focus of amplitude 0 is a place where pressure is held down, and {} only adds "
                                    "foci up; compile records, or leave that focus out",
                                    core.name),
                        {"records"});
    if (words.size() > core.parameters.foci)
        throw bad_input(fmt::format("step {} of the path", number),
                        fmt::format("{} foci at a time, but {} computes at most {}; take fewer, or compile records",
                                    words.size(), core.name, core.parameters.foci),
                        {"records"});
    if (words.empty()) return words;
    const std::vector<ChannelDrive> drives = engine_drives(engine, words);
    if (std::any_of(drives.begin(), drives.end(), [](const ChannelDrive& drive) { return drive.far; }))
        throw bad_input(fmt::format("step {} of the path", number),
                        "a focus is 1.024 m or more away from an element in x, y or z, where the board does not count "
                        "it; move it nearer");
    return words;
}

std::vector<Focus> foci_of(const RecordWords& words) {
    std::vector<Focus> foci;
    for (const FocusWords& one : words) foci.push_back(unpack_focus(one));
    return foci;
}

RecordMeaning meaning_of(const RecordWords& words) {
    RecordMeaning meaning{foci_of(words)};
    double largest = 0.0;
    for (const Focus& focus : meaning.foci) largest = std::max(largest, focus.amplitude);
    for (Focus& focus : meaning.foci) focus.amplitude /= largest;
    meaning.amplitude = largest;
    return meaning;
}

}  // namespace

FocusImage focus_image_of(const Path& path, const Array& array, const Core& core, std::uint16_t loops,
                          std::size_t boards, FociFrom from) {
    require_board(array, core, boards);
    const interface::CoreParameters& p = core.parameters;
    FocusImage made;
    made.timer = choose_amplitude_timer(array, core);
    Image& image = made.image;
    image.channels = static_cast<std::uint32_t>(array.elements.size());
    image.clock_hz = p.clock_hz;
    image.timing_bits = p.timing_bits;
    image.pulse_bits = p.pulse_bits;
    image.min_pulse_clocks = p.min_pulse_clocks;
    image.loops = loops;
    if (!path.modulation.samples.empty()) image.modulation = sampled(path.modulation, p.modulation_depth, core.name);
    FocusRecords& foci = image.foci.emplace();
    foci.board_records = p.records;
    foci.cycle_ticks = made.timer.cycle_ticks;
    foci.engine = focus_engine(array);

    std::vector<RecordWords> records;
    std::map<RecordWords, std::size_t> places;
    for (std::size_t i = 0; i < path.steps.size(); ++i) {
        RecordWords words = words_of(path.steps[i], i + 1, foci.engine, core);
        std::uint16_t index = 0;
        if (!words.empty()) {
            const auto [entry, fresh] = places.try_emplace(words, records.size());
            if (fresh) records.push_back(std::move(words));
            foci.each = std::max(foci.each, static_cast<std::uint32_t>(entry->first.size()));
            const std::uint32_t most =
                from == FociFrom::line ? most_indices - p.records : core.most_focus_records(foci.each);
            if (records.size() > most)
                throw bad_input(core.name,
                                fmt::format("the path needs more than the {} focus records of {} foci that the board "
                                            "holds; take fewer points",
                                            most, foci.each),
                                {"points", "board", "array"});
            index = static_cast<std::uint16_t>(p.records + 1 + entry->second);
        }
        bool mark = path.steps[i].mark;
        for (std::uint32_t left = path.steps[i].periods; left > 0;) {
            const std::uint32_t dwell = std::min<std::uint32_t>(left, interface::sequence_entry_field::dwell.most());
            if (image.sequence.size() + 1 >= p.sequence_depth)
                throw bad_input(
                    core.name,
                    fmt::format("the path needs more sequence entries than the board's {}; take fewer points",
                                p.sequence_depth - 1),
                    {"points", "board", "array"});
            image.sequence.push_back({index, static_cast<std::uint16_t>(dwell), std::exchange(mark, false)});
            left -= dwell;
        }
    }
    if (records.empty())
        throw bad_argument(
            "path", "every step is silent, or so weak that its pulse would have no length; there is nothing to play");

    double longest = 1.0;
    for (const RecordWords& record : records) {
        for (const std::complex<double>& sum : summed_drives(array, foci_of(record)))
            longest = std::max(longest, std::abs(sum));
        made.records.push_back(meaning_of(record));
        foci.foci.insert(foci.foci.end(), record.begin(), record.end());
        for (std::size_t n = record.size(); n < foci.each; ++n) {
            FocusWords silent = record.front();
            silent[3] &= 0xffU;
            foci.foci.push_back(silent);
        }
    }
    made.meaning.full = longest;
    foci.engine.gain = gain_word(longest / std::sin(std::numbers::pi * made.timer.duty()));
    for (const SequenceEntry& entry : image.sequence)
        if (const auto place = place_of(image, entry.index)) made.records[*place].dwell_cycles += entry.dwell;
    // A record is read and computed while the one before it plays.
    if (const std::uint32_t clocks = load_clocks(p, foci.each); clocks > foci.cycle_ticks)
        made.warnings.push_back(
            fmt::format("the board needs {} clocks for a record of {} foci, and a carrier period has {}; foci that "
                        "last less than {} "
                        "periods come late and count as underruns",
                        clocks, foci.each, foci.cycle_ticks, (clocks + foci.cycle_ticks - 1) / foci.cycle_ticks));
    return made;
}

}  // namespace haptogram
