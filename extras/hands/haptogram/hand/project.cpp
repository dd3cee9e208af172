// SPDX-License-Identifier: Apache-2.0
#include "haptogram/hand/project.hpp"

#include <fmt/format.h>

#include "haptogram/base/file.hpp"
#include "haptogram/format/schedule.hpp"
#include "haptogram/hand/recording.hpp"
#include "haptogram/perception/magnitude.hpp"
#include "haptogram/verbs/pattern.hpp"

namespace haptogram {
namespace {

const HandSource& hand_of(const Project& project) {
    if (!project.hand) throw bad_argument("hand", "the project has no [hand]; add one with a 'recording'");
    return *project.hand;
}

/// The raster of a region as triangles.
void add_skin(std::vector<std::array<Vec3, 3>>& triangles, const SkinRegion& region) {
    for (std::size_t row = 0; row + 1 < region.rows; ++row)
        for (std::size_t column = 0; column + 1 < region.columns; ++column) {
            const Vec3 &a = region.point(row, column), &b = region.point(row, column + 1),
                       &c = region.point(row + 1, column), &d = region.point(row + 1, column + 1);
            triangles.push_back({a, b, c});
            triangles.push_back({b, d, c});
        }
}

void add_lines(HandView& view, const Rendered& rendered, double least_force_n) {
    for (const Voice& voice : rendered.touch->voices)
        for (const Leg& leg : voice.legs)
            if (!leg.silent)
                (is_weak(leg, *view.report, least_force_n) ? view.weak : view.strong)
                    .push_back({leg.from.position, leg.to.position});
    for (const PathStep& step : rendered.path.steps)
        for (const Focus& focus : step.foci) view.foci.push_back(focus.position);
}

}  // namespace

PathMakers path_makers() {
    return {[](const Project& project, const ProjectInstrument& instrument) -> RenderedPath {
                return render(project, instrument);
            },
            path_of_pattern,
            [](Path& path, const Project& project, const Array& array) {
                return perception::give_magnitude(path, project, array);
            }};
}

std::vector<std::array<Vec3, 3>> drawn_skin(const std::vector<SkinRegion>& regions) {
    std::vector<std::array<Vec3, 3>> triangles;
    for (const SkinRegion& region : regions) add_skin(triangles, region);
    return triangles;
}

SkinOptions drawn_skin_options() {
    SkinOptions options;
    options.cell_m = 3e-3;
    return options;
}

RenderOptions render_options(const Project& project) {
    const HandSource& hand = hand_of(project);
    RenderOptions options;
    options.algorithm = algorithm_of(hand.algorithm);
    if (project.pace.speed_m_s || project.pace.frequency_hz) options.touch.pace = project.pace;
    options.touch.jump = project.jump;
    options.touch.feature.seed = options.touch.grain.seed = project.seed;
    options.frame = hand.frame;
    if (hand.frame) options.points = project.points;
    options.am = project.am;
    options.am_folder = project.folder;
    options.am_law = project.am_law;
    options.magnitude = project.magnitude;
    options.amplitude = project.amplitude;
    return options;
}

void open_hand(Project& project, const FileReader& read) {
    (void)hand_of(project);
    HandSource& hand = *project.hand;
    const FileReader reader =
        read ? read : [&](const std::filesystem::path& file) { return read_file(project.folder / file); };
    if (!hand.hands)
        hand.hands =
            std::make_shared<const HandRecording>(open_hands(hand.recording, hand.model, hand.rate_hz, reader));
    if (!hand.touched) hand.object.readers = project.makers.readers;
    if (!hand.touched) hand.touched = std::make_shared<const TouchObject>(open_object(hand.object, reader));
}

Rendered render(const Project& project, const ProjectInstrument& instrument, const Progress& progress) {
    Project opened = project;
    open_hand(opened);
    const double carrier_hz = choose_timer(instrument.array, instrument.core).carrier_hz();
    return render(*opened.hand->touched, *opened.hand->hands, instrument.array, carrier_hz, render_options(opened),
                  progress);
}

HandView hand_view(const Project& project, const ProjectInstrument& instrument) {
    Project opened = project;
    open_hand(opened);
    const HandSource& hand = *opened.hand;
    const std::vector<HandFrame>& frames = hand.hands->frames;
    if (!hand.frame || *hand.frame > frames.size() || *hand.frame == 0)
        throw bad_argument("frame", hand.frame ? fmt::format("found {}, expected 1 to {}", *hand.frame, frames.size())
                                               : fmt::format("is missing; expected 1 to {}", frames.size()));
    HandView view;
    view.frame = *hand.frame;
    view.frames = frames.size();
    const HandFrame& frame = frames[view.frame - 1];
    view.time_s = frame.time_s;
    view.end_s = frames.back().time_s;
    if (!frame.hands.empty()) view.skin = drawn_skin(skin_of(*hand.hands, view.frame, drawn_skin_options()));
    try {
        Rendered rendered = render(opened, instrument);
        view.report = rendered.frames.front();
        add_lines(view, rendered, render_options(opened).least_force_n);
        view.lines = std::move(rendered.touch->lines);
        view.pass_s = static_cast<double>(rendered.path.periods()) / rendered.carrier_hz;
        view.warnings = std::move(rendered.warnings);
    } catch (const Error& error) {
        if (error.code() != ErrorCode::bad_input) throw;  // settings that make no sense in any frame
        view.nothing = error;
    }
    return view;
}

}  // namespace haptogram
