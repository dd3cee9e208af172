// SPDX-License-Identifier: Apache-2.0
#include "haptogram/hand/movement_request.hpp"

#include <set>
#include <tuple>

#include "haptogram/format/timer.hpp"
#include "haptogram/shape/reach.hpp"
#include "haptogram/verbs/compile.hpp"

namespace haptogram {

MovementOnArray movement(const MovementRequest& request) {
    Project project;
    project.array = request.array;
    project.board = request.board;
    const ProjectInstrument instrument = instrument_of(project);
    MovementOnArray moved;
    moved.array = instrument.array;
    moved.carrier_hz = choose_timer(instrument.array, instrument.core).carrier_hz();
    MovementOptions options = request.options;
    if (request.grid) {
        options.grid = PositionGrid{};
        options.grid->lowest_m = options.centre.z;
    }
    options.modulation = modulation_of(request.am, request.am_law, moved.carrier_hz).modulation;
    moved.made = movement_path(movement_of(request.movement), options, moved.carrier_hz);
    require_reachable(moved.made.path, moved.array);
    std::set<std::tuple<double, double, double>> different;
    for (const PathStep& step : moved.made.path.steps) {
        const Vec3 p = step.foci.front().position;
        different.insert({p.x, p.y, p.z});
    }
    moved.places = different.size();
    return moved;
}

}  // namespace haptogram
