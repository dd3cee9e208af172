// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/excitation.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/verbs/focus_check.hpp"
#include "haptogram/verbs/measure.hpp"

namespace haptogram {
namespace {

void require_record(std::uint32_t record, std::size_t records, const char* owner) {
    if (record > records) throw bad_argument("record", fmt::format("the {} has {}, not {}", owner, records, record));
}

/// The root of the mean square of the board's modulation; 1 without.
double modulation_rms(const Manifest& manifest) {
    if (!manifest.modulation) return 1.0;
    double sum = 0.0;
    for (const std::uint8_t sample : manifest.modulation->samples) sum += sample * sample / (255.0 * 255.0);
    return std::sqrt(sum / static_cast<double>(manifest.modulation->samples.size()));
}

/// The time in which nothing is driven, as one more set of drives behind the others.
void add_silence(Excitation& excitation, double weight) {
    if (!(weight > 0.0)) return;
    excitation.drives.emplace_back(excitation.array.elements.size());
    excitation.weights.push_back(weight);
}

std::vector<Vec3> positions(const std::vector<Focus>& foci) {
    std::vector<Vec3> found;
    for (const Focus& focus : foci)
        if (focus.amplitude > 0.0) found.push_back(focus.position);
    return found;
}

}  // namespace

std::vector<WeightedDrives> Excitation::sequence() const {
    std::vector<WeightedDrives> found;
    for (std::size_t i = 0; i < drives.size(); ++i) found.push_back({weights[i], drives[i]});
    return found;
}

void weaken(Excitation& excitation, double factor) {
    for (std::vector<std::complex<double>>& drives : excitation.drives)
        for (std::complex<double>& drive : drives) drive *= factor;
}

Excitation excitation_of(const Array& array, Vec3 focus) {
    if (const std::string why = array.unreachable(focus); !why.empty()) throw bad_argument("focus", why);
    return {array,
            {ideal_drives(array, focus)},
            {1.0},
            {focus},
            fmt::format("{}, exact phases for ({:g},{:g},{:g}) mm", array.name, focus.x / millimetre,
                        focus.y / millimetre, focus.z / millimetre)};
}

Excitation in_segments(const Excitation& excitation, const Segments& segments) {
    Excitation made = excitation;
    const double full = made.array.transducer.source_pa_m;
    for (auto& drives : made.drives)
        for (std::complex<double>& drive : drives)
            drive = full * drive_of(segment_pulse(drive / full, segments), segments);
    made.title += fmt::format(", in the segments of {}", segments.name);
    return made;
}

Excitation excitation_of(const Bundle& bundle, std::uint32_t record) {
    const Image& image = bundle.image;
    const std::size_t records = image.record_count();
    require_record(record, records, "image");
    const double modulated = modulation_rms(bundle.manifest);
    Excitation found{bundle.manifest.array, {}, {}, {}, {}};
    if (record > 0) {
        found.drives = {drives_of(bundle.manifest, image, record - 1)};
        weaken(found, modulated);
        found.weights = {1.0};
        found.foci = positions(bundle.manifest.records[record - 1].foci);
        found.title = fmt::format("{}, record {}", bundle.name, record);
        return found;
    }
    std::uint64_t silent = 0;
    for (const std::uint64_t clocks : record_clocks(image)) found.weights.push_back(static_cast<double>(clocks));
    for (std::size_t place = 0; place < records; ++place)
        found.drives.push_back(drives_of(bundle.manifest, image, place));
    weaken(found, modulated);
    for (const SequenceEntry& entry : image.sequence)
        if (entry.index == 0) silent += entry.dwell * bundle.manifest.timer.cycle_clocks();
    add_silence(found, static_cast<double>(silent));
    found.foci = bundle.manifest.points();
    found.title = fmt::format("{}, {} points in turn", bundle.name, records);
    return found;
}

Excitation only(const Excitation& excitation, std::size_t place) {
    if (place >= excitation.drives.size())
        throw bad_argument("record",
                           fmt::format("there are {} sets of drives, not {}", excitation.drives.size(), place + 1));
    return {excitation.array, {excitation.drives[place]}, {1.0}, {}, excitation.title};
}

Excitation excitation_of(const Manifest& manifest, const std::string& name, std::uint32_t record) {
    require_record(record, manifest.records.size(), "manifest");
    Excitation found{manifest.array, {}, {}, manifest.points(), name + ", exact phases"};
    for (std::size_t i = 0; i < manifest.records.size(); ++i) {
        if (record > 0 && i + 1 != record) continue;
        const RecordMeaning& meaning = manifest.records[i];
        found.drives.push_back(asked_drives(manifest, meaning));
        found.weights.push_back(meaning.dwell_cycles);
    }
    weaken(found, modulation_rms(manifest));
    if (record > 0) found.foci = positions(manifest.records[record - 1].foci);
    return found;
}

Excitation excitation_of(const Manifest& manifest, const std::vector<Pulse>& pulses, const std::string& name) {
    if (pulses.empty()) throw bad_input(name, "no pulses in it; expected what a simulation measured");
    Excitation found{manifest.array, {}, {}, manifest.points(), name + ", as measured at the pins"};
    const auto [first, last] = std::minmax_element(pulses.begin(), pulses.end(),
                                                   [](const Pulse& a, const Pulse& b) { return a.rise < b.rise; });
    const std::uint64_t period = manifest.timer.cycle_clocks();
    // Silence behind the last pulse cannot be seen, so whole repetitions are taken; of less than one, whole rounds of
    // the modulation.
    std::uint64_t periods = (last->rise - first->rise) / period + 1;
    std::uint64_t whole = manifest.repeat_periods();
    if (manifest.modulation && whole > periods)
        whole = std::uint64_t{manifest.modulation->divider} * manifest.modulation->samples.size();
    std::vector<Pulse> inside = pulses;
    if (whole > 0 && periods >= whole) {
        periods = periods / whole * whole;
        std::erase_if(inside, [&](const Pulse& p) { return p.rise >= first->rise + periods * period; });
    }
    double sounding = 0.0;
    bool passed = true;  // each record has played for as long as a pass has it
    const std::vector<MeasuredRecord> measured = measure(manifest, inside, name);
    for (std::size_t i = 0; i < measured.size(); ++i) {
        passed = passed && measured[i].cycles >= manifest.records[i].dwell_cycles;
        if (measured[i].cycles == 0) continue;
        found.drives.push_back(measured[i].root_mean_square);
        found.weights.push_back(static_cast<double>(measured[i].cycles));
        sounding += found.weights.back();
    }
    if (periods < whole && (passed || manifest.modulation)) periods = whole;
    add_silence(found, static_cast<double>(periods) - sounding);
    return found;
}

}  // namespace haptogram
