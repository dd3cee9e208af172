// SPDX-License-Identifier: Apache-2.0
// What makes or changes a project's path by knowledge that the core does not have: hands that feel an object, and how
// strong a focus feels. Who compiles passes it in.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "haptogram/array/array.hpp"
#include "haptogram/format/path.hpp"
#include "haptogram/shape/readers.hpp"

namespace haptogram {

struct Project;
struct ProjectInstrument;

/// The commands that a path got so that its foci feel alike, each a factor on the amplitude of a focus.
struct PathMagnitude {
    double least_command = 0.0, most_command = 0.0;
    bool moves = false;  ///< the path has several places; what is known of magnitudes is of a focus that rests
};

/// A path that lets a hand feel an object.
struct RenderedPath {
    Path path;
    double carrier_hz = 0.0;                 ///< in whose periods the path counts
    std::optional<PathMagnitude> magnitude;  ///< the commands, when a magnitude was asked for
    std::vector<std::string> warnings;       ///< whole sentences
};

/// compile() refuses projects that need one which is empty.
struct PathMakers {
    /// The path of a project with a hand (hand/project.hpp has one).
    std::function<RenderedPath(const Project& project, const ProjectInstrument& instrument)> of_hand{};
    /// The path of a project with an AdapTics pattern, whose text is given (verbs/pattern.hpp has one).
    std::function<RenderedPath(const Project& project, std::string_view text, const std::string& where,
                               double carrier_hz)>
        of_pattern{};
    /// Multiplies the amplitudes of a path so that every focus feels as strong as the project's magnitude says
    /// (perception/magnitude.hpp has one).
    std::function<PathMagnitude(Path& path, const Project& project, const Array& array)> of_magnitude{};
    ShapeReaders readers{};  ///< of formats that the core does not read (formats/readers.hpp has them)
};

}  // namespace haptogram
