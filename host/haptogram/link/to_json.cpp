// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/to_json.hpp"

#include <fmt/core.h>

namespace haptogram::link {

using nlohmann::ordered_json;

ordered_json to_json(const Identity& i) {
    return {{"name", i.name},
            {"version", fmt::format("{}.{}", i.version_major, i.version_minor)},
            {"channels", i.channels},
            {"records", i.records},
            {"sequence_depth", i.sequence_depth},
            {"live_depth", i.live_depth},
            {"timing_bits", i.timing_bits},
            {"pulse_bits", i.pulse_bits},
            {"clock_hz", i.clock_hz},
            {"frame_bytes", i.frame_bytes},
            {"min_pulse_clocks", i.min_pulse_clocks},
            {"max_pulse_clocks", i.max_pulse_clocks},
            {"max_duty_256", i.max_duty_256},
            {"max_cycle_clocks", i.max_cycle_clocks},
            {"width_bits", i.width_bits},
            {"modulation_words", i.modulation_words},
            {"foci", i.foci},
            {"features", i.features}};
}

ordered_json to_json(const Status& s) {
    ordered_json json{{"outputs", s.enabled ? "on" : "off"},
                      {"stop_input", s.stopped ? "active" : "released"},
                      {"mode", to_string(s.mode)},
                      {"index", s.present_index},
                      {"live_level", s.live_level},
                      {"watchdog_ms", s.watchdog_ms},
                      {"underruns", s.underruns},
                      {"refused_records", s.refused_records},
                      {"frames_good", s.frames_good},
                      {"frames_damaged", s.frames_damaged},
                      {"frames_repeated", s.frames_repeated},
                      {"frames_refused", s.frames_refused},
                      {"watchdog_trips", s.watchdog_trips},
                      {"guard_trips", s.guard_trips},
                      {"modulated", s.modulated},
                      {"bent_periods", s.bent_periods},
                      {"far_foci", s.far_foci},
                      {"waiting", s.waiting},
                      {"role", to_string(s.role)},
                      {"in_step", s.in_step},
                      {"numbered", s.numbered},
                      {"sync_misses", s.sync_misses},
                      {"sync_losses", s.sync_losses},
                      {"flash", to_string(s.flash)}};
    if (s.period) json.update({{"late_changes", s.late_changes}, {"period", *s.period}});
    if (s.stream)
        json["stream"] = {{"playing", s.stream->playing},
                          {"late", s.stream->late},
                          {"lost", s.stream->lost},
                          {"early", s.stream->early},
                          {"repeated", s.stream->repeated}};
    return json;
}

ordered_json to_json(const TriggerSettings& s) {
    return {{"out", to_string(s.event)},           {"every", s.every_periods},  {"pulse_ms", 1e3 * s.pulse_s},
            {"in", s.active_low ? "low" : "high"}, {"level", s.by_level},       {"gate", s.gates},
            {"settle_ms", 1e3 * s.settle_s},       {"test", to_string(s.test)}, {"channel", s.channel}};
}

ordered_json to_json(const TriggerTimes& t, std::uint32_t clock_hz) {
    return {{"clock_hz", clock_hz}, {"clock", t.now},         {"out_count", t.out_count},
            {"out_clock", t.out},   {"in_count", t.in_count}, {"in_clock", t.in}};
}

ordered_json to_json(const std::vector<PortInfo>& ports) {
    ordered_json json = ordered_json::array();
    for (const PortInfo& port : ports) json.push_back({{"port", port.port}, {"name", port.name}});
    return json;
}

ordered_json to_json(const UploadReport& r) {
    return {{"records", r.records},         {"sequence_entries", r.sequence_entries},
            {"frames", r.frames},           {"frames_written", r.frames_written},
            {"seconds", r.seconds},         {"retransmissions", r.retransmissions},
            {"link_losses", r.link_losses}, {"verified", r.verified}};
}

ordered_json played_to_json(const Played& p) {
    return {{"underruns", p.underruns},
            {"refused_records", p.refused_records},
            {"watchdog_trips", p.watchdog_trips},
            {"guard_trips", p.guard_trips},
            {"interrupted", p.interrupted}};
}

ordered_json to_json(const RigPlayed& p) {
    return {{"period", p.period},
            {"attempts", p.attempts},
            {"underruns", p.underruns},
            {"refused_records", p.refused_records},
            {"watchdog_trips", p.watchdog_trips},
            {"guard_trips", p.guard_trips},
            {"lost", p.lost},
            {"interrupted", p.interrupted}};
}

ordered_json streamed_to_json(const Played& p) {
    return {{"sent", p.sent},
            {"underruns", p.underruns},
            {"refused_records", p.refused_records},
            {"interrupted", p.interrupted}};
}

ordered_json to_json(const PlayedPatterns& p) {
    return {{"sent", p.sent},
            {"late", p.late},
            {"lost", p.lost},
            {"early", p.early},
            {"repeated", p.repeated},
            {"lead_periods", p.lead},
            {"interrupted", p.interrupted}};
}

ordered_json streamed_to_json(const RigPlayed& p) {
    ordered_json json{{"sent", p.sent}};
    json.update(to_json(p));
    return json;
}

}  // namespace haptogram::link
