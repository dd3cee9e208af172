// SPDX-License-Identifier: Apache-2.0
#include "pins.hpp"

#include <algorithm>

#include "haptogram/analysis/envelope.hpp"
#include "haptogram/analysis/measure.hpp"
#include "haptogram/instrument/compile.hpp"
#include "playback.hpp"

namespace haptogram::cli {

PinsOfFrame pins_of(const fusion::Frame& frame, const Array& array, const Core& core,
                    const perception::Tables& tables) {
    const Compiled compiled =
        compile(frame.path, array, core, 1, "frame", Method::gauss_newton, {}, ImageKind::records);
    const Manifest& manifest = compiled.bundle.manifest;
    sim::PlaybackOptions options;
    options.load_by_uart = false;
    const sim::Playback played = sim::play(compiled.bundle.image, options, "frame");
    PinsOfFrame pins;
    pins.violations = played.violations;
    pins.pulses = played.pulse_report.checked;
    const std::uint64_t cycle = std::uint64_t{manifest.timer.cycle_ticks} * manifest.timer.prescaler;
    pins.frequency_hz = envelope_of(played.pulses, manifest.timer.clock_hz, cycle).frequency_hz;
    const std::vector<MeasuredRecord> measured = measure(manifest, played.pulses, "frame");
    for (const fusion::FramePoint& point : frame.points)
        for (std::size_t i = 0; i < measured.size(); ++i) {
            if (manifest.records[i].foci.front().position != point.position || measured[i].cycles == 0) continue;
            PinsOfFrame::Point found;
            found.position = point.position;
            found.asked = point.setting.command;
            found.measured = share_of_full_drive(array, measured[i].drives, point.position);
            found.magnitude = fusion::magnitude_of(tables, frame.frequency_hz, point, found.measured);
            found.ticks_off =
                manifest.timer.cycle_ticks * (perception::pulse_duty(std::min(found.measured, 1.0), array.duty) -
                                              perception::pulse_duty(found.asked, array.duty));
            pins.points.push_back(found);
            break;
        }
    return pins;
}

}  // namespace haptogram::cli
