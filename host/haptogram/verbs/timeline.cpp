// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/timeline.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>

#include "haptogram/acoustics/drive.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/solve/segments.hpp"
#include "haptogram/verbs/focus_check.hpp"
#include "haptogram/verbs/measure.hpp"

namespace haptogram {
namespace {

using Complexes = std::vector<std::complex<double>>;

constexpr std::uint64_t most_periods = 10'000'000;  ///< some minutes

/// A pulse within a carrier period: channel, and clocks of its edges from the period's beginning.
using Edges = std::vector<std::tuple<std::uint32_t, std::int64_t, std::int64_t>>;

void require_of_manifest(const Manifest& manifest, const std::vector<Pulse>& pulses, const std::string& name) {
    if (pulses.empty()) throw bad_input(name, "no pulses in it; expected what a simulation measured");
    for (const Pulse& pulse : pulses) {
        if (pulse.channel >= manifest.array.elements.size())
            throw bad_input(
                name,
                fmt::format("a pulse on channel {}, but the array has {} elements; these pulses are another array's",
                            pulse.channel, manifest.array.elements.size()));
        (void)place_of(manifest, pulse, name);
    }
}

void scale(Complexes& drives, double factor) {
    for (std::complex<double>& drive : drives) drive *= factor;
}

/// The root of the mean square of the board's modulation; 1 without.
double modulation_rms(const Manifest& manifest) {
    if (!manifest.modulation) return 1.0;
    double sum = 0.0;
    for (const std::uint8_t sample : manifest.modulation->samples) sum += sample * sample / (255.0 * 255.0);
    return std::sqrt(sum / static_cast<double>(manifest.modulation->samples.size()));
}

Complexes exact_drives_of(const Timeline& timeline, std::size_t place) {
    Complexes drives = asked_drives(timeline.manifest, timeline.manifest.records[place]);
    if (timeline.segments.empty()) return drives;
    const Segments segments = segments_of(timeline.segments);
    const double full = timeline.manifest.array.transducer.source_pa_m;
    for (std::complex<double>& drive : drives) drive = full * drive_of(segment_pulse(drive / full, segments), segments);
    return drives;
}

/// Of one record under one sample of the board's modulation.
Complexes drives_of(const Timeline& timeline, std::size_t place, std::uint8_t sample) {
    if (timeline.image) return drives_of(timeline.manifest, *timeline.image, place, sample);
    Complexes drives = exact_drives_of(timeline, place);
    scale(drives, sample / 255.0);
    return drives;
}

/// Of one record that was not measured, with the root of the mean square of the modulation.
Complexes mean_drives_of(const Timeline& timeline, std::size_t place) {
    Complexes drives = drives_of(timeline, place, 255);
    scale(drives, modulation_rms(timeline.manifest));
    return drives;
}

Complexes drives_of(const Edges& edges, const Manifest& manifest) {
    Complexes drives(manifest.array.elements.size());
    const double clock_s = 1.0 / manifest.timer.clock_hz;
    for (const auto& [channel, rise, fall] : edges) {
        const DrivePulse pulse{static_cast<double>(rise) * clock_s, static_cast<double>(fall) * clock_s};
        drives[channel] += manifest.array.transducer.source_pa_m *
                           carrier_component({&pulse, 1}, manifest.timer.carrier_hz(), manifest.timer.period_s());
    }
    return drives;
}

std::vector<Vec3> positions(const std::vector<Focus>& foci) {
    std::vector<Vec3> found;
    for (const Focus& focus : foci)
        if (focus.amplitude > 0.0) found.push_back(focus.position);
    return found;
}

/// What a pass has beside its records, carrier periods: a manifest says how long it is, not when it is silent.
std::uint64_t silence_of(const Manifest& manifest) {
    std::uint64_t sounding = 0;
    for (const RecordMeaning& meaning : manifest.records) sounding += meaning.dwell_cycles;
    const double pass = manifest.rate_hz > 0.0 ? std::round(manifest.timer.carrier_hz() / manifest.rate_hz) : 0.0;
    return static_cast<std::uint64_t>(std::max(0.0, pass - static_cast<double>(sounding)));
}

std::vector<double> weights_of(const Manifest& manifest) {
    std::vector<double> weights;
    for (const RecordMeaning& meaning : manifest.records) weights.push_back(meaning.dwell_cycles);
    return weights;
}

/// Records, and the weight of silence behind them, in whatever unit.
struct Weighed {
    std::vector<Complexes> drives;
    std::vector<double> weights;
    double silence = 0.0;
};

Weighed weighed_image(const Timeline& timeline) {
    Weighed found;
    const Image& image = *timeline.image;
    for (const std::uint64_t clocks : record_clocks(image)) found.weights.push_back(static_cast<double>(clocks));
    for (const SequenceEntry& entry : image.sequence)
        if (entry.index == 0)
            found.silence += static_cast<double>(entry.dwell * timeline.manifest.timer.cycle_clocks());
    return found;
}

/// What pulses last, in carrier periods. Silence behind the last one cannot be seen, so whole repetitions are taken; of
/// less than one, whole rounds of the modulation.
Weighed weighed_pulses(const Timeline& timeline) {
    const Manifest& manifest = timeline.manifest;
    const auto [first, last] = std::minmax_element(timeline.pulses.begin(), timeline.pulses.end(),
                                                   [](const Pulse& a, const Pulse& b) { return a.rise < b.rise; });
    const std::uint64_t period = manifest.timer.cycle_clocks();
    std::uint64_t periods = (last->rise - first->rise) / period + 1;
    std::uint64_t whole = manifest.repeat_periods();
    if (manifest.modulation && whole > periods)
        whole = std::uint64_t{manifest.modulation->divider} * manifest.modulation->samples.size();
    std::vector<Pulse> inside = timeline.pulses;
    if (whole > 0 && periods >= whole) {
        periods = periods / whole * whole;
        std::erase_if(inside, [&, begin = first->rise](const Pulse& p) { return p.rise >= begin + periods * period; });
    }
    Weighed found;
    bool passed = true;  // each record has played for as long as a pass has it
    std::vector<MeasuredRecord> measured = measure(manifest, inside, timeline.name);
    for (std::size_t i = 0; i < measured.size(); ++i) {
        passed = passed && measured[i].cycles >= manifest.records[i].dwell_cycles;
        found.weights.push_back(static_cast<double>(measured[i].cycles));
        found.drives.push_back(measured[i].cycles > 0 ? std::move(measured[i].root_mean_square) : Complexes());
    }
    if (periods < whole && (passed || manifest.modulation)) periods = whole;
    found.silence = static_cast<double>(periods) - std::accumulate(found.weights.begin(), found.weights.end(), 0.0);
    return found;
}

Weighed weighed(const Timeline& timeline) {
    if (!timeline.pulses.empty()) return weighed_pulses(timeline);
    Weighed found;
    if (timeline.image)
        found = weighed_image(timeline);
    else
        found = {{}, weights_of(timeline.manifest), static_cast<double>(silence_of(timeline.manifest))};
    for (std::size_t place = 0; place < timeline.manifest.records.size(); ++place)
        found.drives.push_back(mean_drives_of(timeline, place));
    return found;
}

/// Indices and dwells of one pass.
std::vector<SequenceEntry> pass_of(const Timeline& timeline) {
    if (timeline.image) return timeline.image->sequence;
    std::vector<SequenceEntry> pass;
    const auto add = [&pass](std::uint32_t index, std::uint64_t periods) {
        for (; periods > 0; periods -= pass.back().dwell)
            pass.push_back({static_cast<std::uint16_t>(index),
                            static_cast<std::uint16_t>(std::min<std::uint64_t>(periods, 65535))});
    };
    for (std::size_t place = 0; place < timeline.manifest.records.size(); ++place)
        add(timeline.manifest.index_of(place), timeline.manifest.records[place].dwell_cycles);
    add(0, silence_of(timeline.manifest));
    return pass;
}

DriveSequence sequence_of_pass(const Timeline& timeline) {
    const Manifest& manifest = timeline.manifest;
    DriveSequence sequence;
    sequence.carrier_hz = manifest.timer.carrier_hz();
    sequence.drives.emplace_back(manifest.array.elements.size());  // silence
    const SampledModulation modulation = manifest.modulation.value_or(SampledModulation{1, {255}});
    std::map<std::pair<std::size_t, std::uint8_t>, std::size_t> sets;  // of a place and a sample
    const auto set_of = [&](std::optional<std::size_t> place, std::uint8_t sample) -> std::size_t {
        if (!place) return 0;
        const auto [at, is_new] = sets.try_emplace({*place, sample}, sequence.drives.size());
        if (is_new) sequence.drives.push_back(drives_of(timeline, *place, sample));
        return at->second;
    };
    const std::vector<SequenceEntry> entries = pass_of(timeline);
    std::uint64_t pass = 0;
    for (const SequenceEntry& entry : entries) pass += entry.dwell;
    const std::uint64_t round = std::uint64_t{modulation.divider} * modulation.samples.size();
    const std::uint64_t end = manifest.modulation ? std::lcm(pass, round) : pass;
    if (end > most_periods)
        throw bad_input(timeline.name,
                        fmt::format("the sequence of {} carrier periods and the modulation of {} meet again after {} "
                                    "only, and a spectrum has at most {}; take a rate that divides the modulation's "
                                    "frequency",
                                    pass, round, end, most_periods));
    for (std::uint64_t now = 0; now < end;) {
        for (const SequenceEntry& entry : entries) {
            const auto place = manifest.place_of(entry.index);
            const std::uint64_t until = now + entry.dwell;
            while (now < until) {
                const std::uint64_t sample = now / modulation.divider;
                const std::uint64_t next =
                    manifest.modulation ? std::min(until, (sample + 1) * modulation.divider) : until;
                sequence.steps.push_back(
                    {set_of(place, modulation.samples[sample % modulation.samples.size()]), next - now, entry.index});
                now = next;
            }
        }
    }
    return sequence;
}

DriveSequence sequence_of_pulses(const Manifest& manifest, const std::vector<Pulse>& pulses) {
    const std::uint64_t cycle = manifest.timer.cycle_clocks();
    const auto [earliest, latest] = std::minmax_element(pulses.begin(), pulses.end(),
                                                        [](const Pulse& a, const Pulse& b) { return a.rise < b.rise; });
    const std::uint64_t first = earliest->rise;
    std::vector<Edges> periods((latest->rise - first) / cycle + 1);
    std::vector<std::uint32_t> records(periods.size());
    for (const Pulse& pulse : pulses) {
        const std::uint64_t period = (pulse.rise - first) / cycle;
        const auto from = static_cast<std::int64_t>(first + period * cycle);
        periods[period].emplace_back(pulse.channel, static_cast<std::int64_t>(pulse.rise) - from,
                                     static_cast<std::int64_t>(pulse.fall) - from);
        records[period] = pulse.index;
    }
    DriveSequence sequence;
    sequence.carrier_hz = manifest.timer.carrier_hz();
    const std::size_t pass = manifest.repeat_periods();
    sequence.repeats = pass > 0 && periods.size() >= 2 * pass;
    // The last pulses may rise within a period that is not whole.
    const std::size_t begin = sequence.repeats ? pass : 0;
    const std::size_t end = sequence.repeats ? periods.size() / pass * pass : periods.size();
    std::map<Edges, std::size_t> sets;
    for (std::size_t i = begin; i < end; ++i) {
        std::sort(periods[i].begin(), periods[i].end());
        const auto [at, is_new] = sets.try_emplace(std::move(periods[i]), sequence.drives.size());
        if (is_new) sequence.drives.push_back(drives_of(at->first, manifest));
        DriveSequence::Step* const before = sequence.steps.empty() ? nullptr : &sequence.steps.back();
        if (before != nullptr && before->set == at->second && before->record == records[i])
            ++before->periods;
        else
            sequence.steps.push_back({at->second, 1, records[i]});
    }
    return sequence;
}

/// One stretch of a record, or of silence.
struct PlayedEntry {
    std::optional<std::size_t> place;
    std::uint64_t periods = 0;
};

std::vector<PlayedEntry> played_by(const Timeline& timeline) {
    std::vector<PlayedEntry> played;
    if (timeline.pulses.empty())
        for (const SequenceEntry& entry : pass_of(timeline))
            played.push_back({timeline.manifest.place_of(entry.index), entry.dwell});
    else
        for (const DriveSequence::Step& step : sequence_of_pulses(timeline.manifest, timeline.pulses).steps)
            played.push_back({timeline.manifest.place_of(step.record), step.periods});
    return played;
}

/// The record that plays last before a stretch, or next after it, round and round. @param way  1, or −1 as size − 1
std::optional<std::size_t> neighbour(const std::vector<PlayedEntry>& played, std::size_t at, std::size_t way) {
    for (std::size_t i = 0; i < played.size(); ++i) {
        at = (at + way) % played.size();
        if (played[at].place) return played[at].place;
    }
    return {};
}

/// Roots of the means of squares over the records of each set of foci.
void add_drives(std::vector<FocusDrives>& found, const std::vector<std::size_t>& owner, const Weighed& all) {
    std::vector<double> strongest(found.size()), time(found.size());
    std::vector<std::vector<double>> squares(found.size());
    for (std::size_t place = 0; place < owner.size(); ++place) {
        const Complexes& drives = all.drives[place];
        if (drives.empty() || !(all.weights[place] > 0.0)) continue;
        const std::size_t i = owner[place];
        squares[i].resize(drives.size());
        double strength = 0.0;
        for (std::size_t m = 0; m < drives.size(); ++m) {
            squares[i][m] += all.weights[place] * std::norm(drives[m]);
            strength += std::norm(drives[m]);
        }
        time[i] += all.weights[place];
        if (found[i].drives.empty() || strength > strongest[i]) found[i].drives = drives;
        strongest[i] = std::max(strongest[i], strength);
    }
    for (std::size_t i = 0; i < found.size(); ++i)
        for (std::size_t m = 0; m < found[i].drives.size(); ++m)
            found[i].drives[m] = std::polar(std::sqrt(squares[i][m] / time[i]), std::arg(found[i].drives[m]));
}

}  // namespace

Timeline timeline_of(const Bundle& bundle) {
    return {bundle.manifest,
            bundle.image,
            {},
            {},
            bundle.name,
            fmt::format("{}, {} points in turn", bundle.name, bundle.image.record_count())};
}

Timeline timeline_of(Manifest manifest, const std::string& name) {
    return {std::move(manifest), {}, {}, {}, name, name + ", exact phases"};
}

Timeline timeline_of(Manifest manifest, std::vector<Pulse> pulses, const std::string& name) {
    require_of_manifest(manifest, pulses, name);
    return {std::move(manifest), {}, std::move(pulses), {}, name, name + ", as measured at the pins"};
}

Timeline timeline_of(const Array& array, const Core& core, Vec3 focus) {
    if (const std::string why = array.unreachable(focus); !why.empty()) throw bad_argument("focus", why);
    constexpr std::uint32_t ticks = 1250;  // of a carrier and a duty that need no rounding
    Manifest manifest;
    manifest.array = array;
    manifest.core = core;
    manifest.timer.clock_hz = array.carrier_hz * ticks;
    manifest.timer.prescaler = 1;
    manifest.timer.cycle_ticks = ticks;
    manifest.timer.pulse_ticks = ticks / 2;
    manifest.records = {{{{focus, 1.0}}, 1.0, 1}};
    const std::string name =
        fmt::format("({:g},{:g},{:g}) mm", focus.x / millimetre, focus.y / millimetre, focus.z / millimetre);
    return {std::move(manifest), {}, {}, {}, name, fmt::format("{}, exact phases for {}", array.name, name)};
}

std::vector<FocusDrives> foci_of(const Timeline& timeline) {
    const Manifest& manifest = timeline.manifest;
    std::vector<FocusDrives> found;
    std::vector<std::size_t> owner;  // of each record
    std::map<std::vector<std::array<double, 4>>, std::size_t> known;
    for (std::size_t place = 0; place < manifest.records.size(); ++place) {
        std::vector<Focus> foci = without_factor(manifest.records[place].foci);
        const auto [at, is_new] = known.try_emplace(key_of(foci), found.size());
        if (is_new) found.push_back({manifest.index_of(place), std::move(foci), 0, {}});
        owner.push_back(at->second);
    }
    add_drives(found, owner, weighed(timeline));
    const std::vector<PlayedEntry> played = played_by(timeline);
    std::vector<double> sounding(found.size());
    for (std::size_t i = 0; i < played.size(); ++i) {
        const auto before = neighbour(played, i, played.size() - 1), after = neighbour(played, i, 1);
        const auto place = played[i].place ? played[i].place : before;
        if (!place || (!played[i].place && owner[*before] != owner[*after])) continue;
        found[owner[*place]].periods += played[i].periods;
        if (played[i].place) sounding[owner[*place]] += static_cast<double>(played[i].periods);
    }
    for (std::size_t i = 0; i < found.size(); ++i)
        if (found[i].periods > 0)
            scale(found[i].drives, std::sqrt(sounding[i] / static_cast<double>(found[i].periods)));
    return found;
}

Excitation excitation_of(const Timeline& timeline, std::uint32_t record) {
    const Manifest& manifest = timeline.manifest;
    if (record > manifest.records.size())
        throw bad_argument("record", fmt::format("{} has {}, not {}", timeline.name, manifest.records.size(), record));
    if (record > 0) {
        const std::size_t place = record - 1;
        Complexes drives =
            timeline.pulses.empty() ? mean_drives_of(timeline, place) : std::move(weighed(timeline).drives[place]);
        if (drives.empty())
            throw bad_argument("record", fmt::format("{} has no pulse of record {}", timeline.name, record));
        return {manifest.array,
                {std::move(drives)},
                {1.0},
                positions(manifest.records[place].foci),
                fmt::format("{}, record {}", timeline.name, record)};
    }
    Weighed all = weighed(timeline);
    Excitation found{manifest.array, {}, {}, manifest.points(), timeline.title};
    for (std::size_t place = 0; place < all.drives.size(); ++place) {
        if (all.drives[place].empty()) continue;
        found.drives.push_back(std::move(all.drives[place]));
        found.weights.push_back(all.weights[place]);
    }
    if (all.silence > 0.0) {
        found.drives.emplace_back(manifest.array.elements.size());
        found.weights.push_back(all.silence);
    }
    return found;
}

DriveSequence sequence_of(const Timeline& timeline) {
    return timeline.pulses.empty() ? sequence_of_pass(timeline)
                                   : sequence_of_pulses(timeline.manifest, timeline.pulses);
}

Path places_of(const Manifest& manifest, const DriveSequence& sequence) {
    Path path;
    for (const DriveSequence::Step& step : sequence.steps)
        add_places(
            path,
            step.record > 0 ? manifest.records.at(manifest.place_of(step.record).value()).foci : std::vector<Focus>(),
            static_cast<std::uint32_t>(step.periods));
    return path;
}

Path places_of(const Timeline& timeline) { return places_of(timeline.manifest, pass_of(timeline)); }

}  // namespace haptogram
