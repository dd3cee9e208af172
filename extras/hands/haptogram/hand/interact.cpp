// SPDX-License-Identifier: Apache-2.0
#include "haptogram/hand/interact.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/format/timer.hpp"
#include "haptogram/hand/open.hpp"
#include "haptogram/hand/render.hpp"
#include "haptogram/shape/path_file.hpp"
#include "haptogram/shape/reach.hpp"
#include "haptogram/verbs/compile.hpp"

namespace haptogram {

using nlohmann::ordered_json;

MarkerTrack open_marker(const std::string& name, double noise_px, std::uint64_t seed, double carrier_hz) {
    if (name.ends_with(".csv")) {
        MarkerTrack track;
        std::uint64_t periods = 0;
        for (const PathStep& step : path_from_csv(read_file(name), name, carrier_hz).steps) {
            if (step.foci.empty())
                ++track.unseen;
            else
                track.samples.push_back({static_cast<double>(periods) / carrier_hz, step.foci.front().position});
            periods += step.periods;
        }
        return track;
    }
    MarkerTracker tracker = usual_tracker();
    tracker.noise_px = noise_px;
    tracker.seed = seed;
    return track_marker(open_hands(name), tracker);
}

InteractionOnArray interact(const InteractionRequest& request) {
    Project project;
    project.array = request.array;
    project.board = request.board;
    const ProjectInstrument instrument = instrument_of(project);
    InteractionOnArray made;
    made.array = instrument.array;
    made.carrier_hz = choose_timer(instrument.array, instrument.core).carrier_hz();
    InteractionOptions options = request.options;
    if (request.grid) options.grid = interaction_grid();
    options.modulation = modulation_of(request.am, request.am_law, made.carrier_hz).modulation;
    made.track = open_marker(request.hand, request.noise_px, options.seed, made.carrier_hz);
    made.played = interact(content_of(request.content), made.track.samples, options, made.carrier_hz);
    if (!(made.played.felt_s > 0.0))
        throw bad_input(request.hand, fmt::format("nothing touches the palm where the device reaches ({:.3g} s are out "
                                                  "of its reach); move the hand to heights of {:g} to {:g} mm",
                                                  made.played.out_of_range_s, options.lowest_m / millimetre,
                                                  options.highest_m / millimetre));
    require_reachable(made.played.path, made.array);
    if (made.played.out_of_range_s > 0.0)
        made.warnings.push_back(fmt::format("for {:.3g} s the focus would be out of the device's reach, and is silent",
                                            made.played.out_of_range_s));
    if (made.track.unseen > 0)
        made.warnings.push_back(fmt::format("a camera does not see the marker in {} of {} pictures", made.track.unseen,
                                            made.track.unseen + made.track.samples.size()));
    return made;
}

std::string to_json_lines(const std::vector<SceneMoment>& scene) {
    const auto in_mm = [](Vec3 p) { return ordered_json{p.x / millimetre, p.y / millimetre, p.z / millimetre}; };
    std::string text;
    for (const SceneMoment& moment : scene) {
        ordered_json line = {{"time_s", moment.time_s}, {"things_mm", ordered_json::array()}};
        if (moment.palm) line["palm_mm"] = in_mm(*moment.palm);
        for (const Vec3& thing : moment.things) line["things_mm"].push_back(in_mm(thing));
        if (moment.focus) line["focus_mm"] = in_mm(*moment.focus);
        text += line.dump() + "\n";
    }
    return text;
}

}  // namespace haptogram
