// SPDX-License-Identifier: Apache-2.0
#include "haptogram/live/to_json.hpp"

#include <algorithm>

namespace haptogram::live {
namespace {

using Json = nlohmann::ordered_json;

Json in_mm(Vec3 p) { return {1e3 * p.x, 1e3 * p.y, 1e3 * p.z}; }
Json as_list(Vec3 d) { return {d.x, d.y, d.z}; }

}  // namespace

Json to_json(const ShotReport& shot) {
    Json sections = Json::array();
    for (std::size_t i = 0; i < shot.sections.size(); ++i) {
        const Ellipse& e = shot.sections[i];
        sections.push_back({{"centre_mm", in_mm(e.centre)},
                            {"played_at_mm", in_mm(shot.centres[i])},
                            {"half_axes_mm", {1e3 * e.half_major, 1e3 * e.half_minor}},
                            {"major", as_list(e.major)},
                            {"normal", as_list(e.normal)}});
    }
    return {{"shot", shot.number},
            {"time_s", shot.time_s},
            {"points", shot.points},
            {"fingers", shot.fingers},
            {"sections", sections},
            {"object_mm", in_mm(shot.object.origin)},
            {"object_x", as_list(shot.object.x)},
            {"object_z", as_list(shot.object.z)},
            {"force_n", shot.force_n},
            {"compute_ms", 1e3 * shot.compute_s},
            {"troubles", shot.troubles}};
}

Json to_json(const LoopReport& report, const Latency& latency) {
    std::vector<double> compute = report.compute_s;
    std::sort(compute.begin(), compute.end());
    Json json = {{"shots", report.shots},
                 {"with_rings", report.with_rings},
                 {"rings", report.rings.size()},
                 {"lost", report.lost},
                 {"out_of_order", report.out_of_order},
                 {"empty", report.empty},
                 {"without_camera", report.without_camera},
                 {"through", report.through},
                 {"no_section", report.no_section},
                 {"constrained", report.constrained},
                 {"out_of_reach", report.out_of_reach},
                 {"missed", report.missed},
                 {"fades", report.fades},
                 {"underruns", report.underruns}};
    if (!compute.empty())
        json["compute_ms"] = {{"least", 1e3 * compute.front()},
                              {"median", 1e3 * compute[compute.size() / 2]},
                              {"most", 1e3 * compute.back()}};
    if (latency.rings > 0)
        json["latency_ms"] = {{"least", 1e3 * latency.least_s},
                              {"median", 1e3 * latency.median_s},
                              {"most", 1e3 * latency.most_s},
                              {"rings", latency.rings}};
    return json;
}

}  // namespace haptogram::live
