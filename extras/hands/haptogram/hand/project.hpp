// SPDX-License-Identifier: Apache-2.0
// A project whose subject is a hand that feels an object.
#pragma once
#include <array>
#include <optional>
#include <vector>

#include "haptogram/base/error.hpp"
#include "haptogram/hand/recording.hpp"
#include "haptogram/hand/render.hpp"
#include "haptogram/verbs/compile.hpp"
#include "haptogram/verbs/project.hpp"

namespace haptogram {

/// What lets compile() take projects with a hand, by render(), and with a magnitude.
[[nodiscard]] PathMakers path_makers();

/// What a project's settings are for render(). A frame's pass has the project's points; a whole recording has the
/// algorithm's usual dwell.
/// @throws Error{bad_argument} for a project without a hand
[[nodiscard]] RenderOptions render_options(const Project& project);

/// Opens recording and object of a project's hand, unless they are open.
/// @param read  gets files' contents; by default from the disk, relative names from the project's folder
/// @throws Error as open_hands() and open_object()
void open_hand(Project& project, const FileReader& read = {});

/// What a project's hand feels, on the array and the carrier that `haptogram render` takes.
/// @throws Error as open_hand() and render()
[[nodiscard]] Rendered render(const Project& project, const ProjectInstrument& instrument,
                              const Progress& progress = {});

/// One frame of a project's hand, for a view. Metres.
struct HandView {
    std::size_t frame = 0, frames = 0;  ///< from 1; how many the recording has
    double time_s = 0.0, end_s = 0.0;   ///< of the frame, and of the last one
    std::vector<std::array<Vec3, 3>> skin;
    std::vector<std::array<Vec3, 2>> strong, weak;  ///< what the foci draw, and of it what is too weak to be felt
    std::vector<Vec3> foci;                         ///< of the pass
    std::vector<SkinLine> lines;
    double pass_s = 0.0;
    std::optional<FrameReport> report;
    std::vector<std::string> warnings;
    std::optional<Error> nothing;  ///< why the frame has no lines: render()'s error
};

/// A hand's palmar skin as a view draws it: triangles of rasters with cells of 3 mm.
[[nodiscard]] std::vector<std::array<Vec3, 3>> drawn_skin(const std::vector<SkinRegion>& regions);
[[nodiscard]] SkinOptions drawn_skin_options();

/// @throws Error{bad_argument} naming "frame" when the project names none, or one that the recording does not have; and
/// as render() for all that is not of this frame
[[nodiscard]] HandView hand_view(const Project& project, const ProjectInstrument& instrument);

}  // namespace haptogram
