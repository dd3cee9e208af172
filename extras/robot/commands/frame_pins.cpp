// SPDX-License-Identifier: Apache-2.0
#include "frame_pins.hpp"

#include <algorithm>

#include "haptogram/verbs/compile.hpp"
#include "pins.hpp"

namespace haptogram::cli {

PinsOfFrame pins_of(const fusion::Frame& frame, const Array& array, const Core& core,
                    const perception::Tables& tables) {
    const Bundle bundle =
        compile(frame.path, array, core, 1, "frame", Method::gauss_newton, {}, ImageKind::records).bundle;
    const Manifest& manifest = bundle.manifest;
    const sim::ImageAtPins measured = sim::measure_pins(bundle);
    PinsOfFrame pins;
    pins.violations = measured.violations;
    pins.pulses = measured.pulses;
    pins.frequency_hz = measured.burst_hz;
    for (const fusion::FramePoint& point : frame.points)
        for (std::size_t i = 0; i < measured.records.size(); ++i) {
            if (manifest.records[i].foci.front().position != point.position || measured.records[i].cycles == 0)
                continue;
            PinsOfFrame::Point found;
            found.position = point.position;
            found.asked = point.setting.command;
            found.measured = measured.records[i].full_share;
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
