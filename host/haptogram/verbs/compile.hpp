// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "haptogram/base/progress.hpp"
#include "haptogram/format/bundle.hpp"
#include "haptogram/format/path.hpp"
#include "haptogram/shape/draw.hpp"
#include "haptogram/shape/shape.hpp"
#include "haptogram/shape/shape_path.hpp"
#include "haptogram/solve/even.hpp"
#include "haptogram/solve/solver.hpp"
#include "haptogram/verbs/project.hpp"

namespace haptogram {

struct ProjectInstrument;

/// How a drawing came out, in whole carrier periods.
struct DrawnPace {
    double length_m = 0.0;   ///< of what is drawn
    double jumps_m = 0.0;    ///< of the jumps between curves
    double speed_m_s = 0.0;  ///< of the focus on its way
    double frequency_hz = 0.0;
    double spacing_m = 0.0;  ///< from one point to the next
};

/// What dwells chosen for an even feeling did, in whole carrier periods. Both are with cross-talk between the foci.
struct Evened {
    Evenness before, after;
};

/// An image with its manifest, and what became of the shape on the way.
struct Compiled {
    Bundle bundle;
    Path path;                               ///< what the image plays
    TouredPoints points;                     ///< of a shape; empty for a path
    std::optional<DrawnPace> pace;           ///< of a shape that is drawn at a speed or a frequency
    std::optional<Evened> evened;            ///< of a shape whose points shall feel alike
    std::vector<double> am_hz;               ///< frequencies of the modulation, as they came out
    std::optional<PathMagnitude> magnitude;  ///< of foci that shall feel with a magnitude
    PressureLeft pressure_left;              ///< by the transducers' bandwidth
    std::vector<std::string> warnings;       ///< whole sentences
    std::vector<TriggeredPart> parts{};      ///< that the project's triggers start

    /// The least time that any focus lasts, s.
    [[nodiscard]] double shortest_dwell_s() const;
};

/// @throws Error{bad_argument} when both say how strong foci are
void require_one_strength(const std::optional<double>& magnitude, double amplitude);

/// What a 1 in a file of shapes means. @param unit  "mm", "cm", "m" or "inch"
/// @throws Error{bad_argument} naming "unit" for any other
[[nodiscard]] double metres_per_unit(const std::string& unit);

/// Array and core that a project is for.
struct ProjectInstrument {
    Array array;
    Core core;
    std::size_t boards = 1;  ///< alike, that share the array's elements: those of a rig (verbs/rig.hpp)
};
/// @throws Error{bad_input} for files that cannot be read, or an array that is too large for the board
[[nodiscard]] ProjectInstrument instrument_of(const Project& project);

/// The union of a project's shapes at its place in the array frame, metres: what compile() samples. Empty for a path,
/// and for a hand.
/// @throws Error naming what is wrong with the shapes or their placement
[[nodiscard]] Shape shape_of(const Project& project);

/// That a focus is left before its full pressure is there, as a sentence of `warnings`; empty when none is.
[[nodiscard]] std::string short_dwell_warning(const Compiled& compiled);

/// From shapes to the memories' contents: reads and places the shapes, samples them, orders the points into a short
/// tour, gives each its share of the time, and focuses the array on each.
/// @param name  of the image, for messages
/// @param shape  if given, gets what shape_of() makes, so that who also draws the shape need not read its files twice
/// @throws Error naming what is wrong with the project, and the settings that would mend it
[[nodiscard]] Compiled compile(const Project& project, const std::string& name = "image", const Progress& progress = {},
                               Shape* shape = nullptr);

/// The same on an array and a core that the project does not name. When several boards share the array, the image is of
/// all elements, a channel each, within what the records and the sequence of one board hold; format/rig_bundle.hpp cuts
/// it.
[[nodiscard]] Compiled compile(const ProjectInstrument& instrument, const Project& project, const std::string& name,
                               const Progress& progress = {});

/// The same for an image whose sequence is streamed, and so may be longer than the board's memory.
[[nodiscard]] Compiled compile_for_stream(const Project& project, const std::string& name);

/// The same from a path on. Steps with the same foci share a record; amplitudes and the modulation become pulse lengths
/// of whole records, so that each strength of a focus that occurs is a record of its own. When the modulation does not
/// end with the path, one pass of the image is as many passes of the path as it takes until both end together.
/// @param loops   passes of the image when it is played by itself; 0 is for ever
/// @param solver    for steps of several foci, in records
/// @param quantise  device on whose segments all pulses shall lie, as segments_of() knows it; empty: none
/// @param kind      what the image holds (focus_image.hpp for foci); by default as of a project
/// @throws Error{bad_argument} for a path that makes no sense, Error{bad_input} naming the numbers when the core cannot
/// hold the records or the sequence
[[nodiscard]] Compiled compile(const Path& path, const Array& array, const Core& core, std::uint16_t loops = 0,
                               const std::string& name = "image", Method solver = Method::gauss_newton,
                               const std::string& quantise = {}, std::optional<ImageKind> kind = {});
[[nodiscard]] Compiled compile(const Path& path, const ProjectInstrument& instrument, std::uint16_t loops,
                               const std::string& name, Method solver, const std::string& quantise,
                               std::optional<ImageKind> kind);

}  // namespace haptogram
