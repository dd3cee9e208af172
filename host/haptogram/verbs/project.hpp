// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "haptogram/format/waveform.hpp"
#include "haptogram/shape/draw.hpp"
#include "haptogram/shape/key_frames.hpp"
#include "haptogram/shape/place.hpp"
#include "haptogram/shape/primitives.hpp"
#include "haptogram/verbs/hand_source.hpp"
#include "haptogram/verbs/live_table.hpp"
#include "haptogram/verbs/path_makers.hpp"
#include "haptogram/verbs/trigger_table.hpp"

namespace haptogram {

/// Where a shape comes from: a file, a file's content that is already in memory, or a built-in shape.
struct ShapeSource {
    std::string file;                    ///< path; with `content`, a name for messages whose ending tells the format
    std::optional<std::string> content;  ///< takes the place of reading the file
    std::string unit = "mm";             ///< of the file's coordinates: mm, cm, m or inch
    std::optional<std::string> up{};     ///< which of the file's axes points upwards, y or z; z when it is not said
    PrimitiveSpec primitive;             ///< when `file` is empty; metres
    Placement placement{};               ///< of this shape alone, before that of the whole
};

/// What an image holds: records of timings that the host has computed, or foci that the board computes.
enum class ImageKind { records, foci };

/// A tactile object and how it is played: all that shapes an image. Command line options, a project file and a page are
/// three ways to fill one in; the same settings give the same bytes.
struct Project {
    std::vector<ShapeSource> shapes;  ///< drawn together, except shapes that a key frame names
    std::string path;                 ///< a path file instead, which has its own places and times
    std::string set;                  ///< parameters of an AdapTics pattern, as parameters_of() reads them
    std::optional<HandSource> hand;   ///< or a hand that feels an object
    Placement placement;              ///< of the whole; built-in shapes alone stand at (0, 0, 130 mm), unless it or one
                                      ///< of them has a centre
    std::vector<KeyFrame> key_frames;  ///< between which the shapes move; empty: they stay
    std::size_t points = 200;          ///< focal points to take from a surface, a curve or a larger cloud, samples of
                                       ///< an AdapTics pattern, or steps of the pass of a hand's one frame
    std::uint64_t seed = 1;            ///< of the sampling
    bool clip = false;                 ///< leave out points that the array cannot reach
    double rate_hz = 10.0;             ///< passes over the shape a second, when there is no pace
    Pace pace;                         ///< draw the shape at a speed or a frequency instead; at most one is given
    Jump jump = Jump::hop;             ///< between the curves that are drawn
    bool even = false;                 ///< dwells that make all points feel alike, instead of equal ones
    std::string am;                    ///< waveform of the amplitude, as modulation_of() reads it; empty: none
    AmplitudeLaw am_law = AmplitudeLaw::pressure;  ///< what the waveform's values are
    double amplitude = 1.0;  ///< of all that is played, of the most that the array can make there: above 0, at most 1
    std::optional<Fade> fade{};        ///< weaker towards one side of the shapes, as they were placed
    std::optional<double> magnitude;   ///< how strong each focus feels under that waveform (perception/magnitude.hpp)
    std::string quantise;              ///< device on whose segments pulses lie (segments_of()); empty: none
    std::optional<ImageKind> image;    ///< by default foci, where the board computes them and pulses need not lie on a
                                       ///< device's segments, and records elsewhere
    std::uint16_t loops = 0;           ///< passes when the image is played by itself; 0 is for ever
    std::optional<std::string> array;  ///< file or shipped array; by default the board's, or tile-10x10
    std::optional<std::string> board;  ///< file, shipped board or configuration; by default what the array's file says
    std::vector<LiveSetting> live{};   ///< of `haptogram live`; what is compiled does not depend on it
    std::vector<Trigger> triggers{};   ///< of parts of what is played; nor on these
    std::filesystem::path folder;      ///< that relative paths start from; empty: the present one
    PathMakers makers{};               ///< for a hand and a magnitude; no file names them, who compiles gives them

    /// Whether it plays shapes, not a path or what a hand feels.
    [[nodiscard]] bool is_of_shapes() const { return path.empty() && !hand; }
    /// Where a board or an array that it names is: a file from its folder on, or the name of a shipped one.
    [[nodiscard]] std::string beside(const std::string& name) const {
        return name.ends_with(".toml") ? (folder / name).string() : name;
    }
};

/// A name of an array, a board or a waveform that a command line gives for a project's: a file is looked for from the
/// working folder on, not beside the project.
[[nodiscard]] std::string from_here(const std::string& name);

/// The project file of a name: itself, or that in a bundle (base/bundle.hpp).
[[nodiscard]] std::filesystem::path project_file(const std::filesystem::path& path);

/// The files that a project names, as it names them.
[[nodiscard]] std::vector<std::string> files_of(const Project& project);

/// Reads a project file (TOML), or the one in a bundle; host/haptogram/verbs/README.md describes its keys.
/// @throws Error{bad_input} naming the file, the line and the key, also for unknown keys, and for a bundle that names
/// files outside
[[nodiscard]] Project load_project(const std::filesystem::path& path);
/// @param where  names the text in messages
[[nodiscard]] Project project_from_toml(std::string_view text, const std::string& where);

/// The file's text: what project_from_toml() reads back. Settings that have their default are left out.
/// @throws Error{bad_argument} for a shape whose content is only in memory
[[nodiscard]] std::string to_toml(const Project& project);

/// Whether a name is that of a project file, or of a bundle, rather than of an image.
[[nodiscard]] bool is_project(const std::string& path);

}  // namespace haptogram
