// SPDX-License-Identifier: Apache-2.0
#include "pins.hpp"

#include "haptogram/verbs/focus_analysis.hpp"
#include "haptogram/verbs/measure.hpp"
#include "playback.hpp"

namespace haptogram::sim {

ImageAtPins measure_pins(const Bundle& bundle) {
    const Manifest& manifest = bundle.manifest;
    PlaybackOptions options;
    options.load_by_uart = false;
    const Playback played = play(bundle.image, options, bundle.name);
    ImageAtPins pins;
    pins.violations = played.violations;
    pins.pulses = played.pulse_report.checked;
    pins.burst_hz = envelope_of(played.pulses, manifest.timer.clock_hz, manifest.timer.cycle_clocks()).frequency_hz;
    const std::vector<MeasuredRecord> measured = measure(manifest, played.pulses, bundle.name);
    for (std::size_t i = 0; i < measured.size(); ++i) {
        RecordAtPins record;
        record.cycles = measured[i].cycles;
        if (record.cycles > 0)
            record.full_share =
                share_of_full_drive(manifest.array, measured[i].drives, manifest.records[i].foci.front().position);
        pins.records.push_back(record);
    }
    return pins;
}

}  // namespace haptogram::sim
