// SPDX-License-Identifier: Apache-2.0
// What sources, feelers and players share: frames, and paths.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "haptogram/format/path.hpp"
#include "haptogram/hand/hand.hpp"
#include "haptogram/hand/surface.hpp"
#include "haptogram/live/depth.hpp"

namespace haptogram::live {

/// What cameras and trackers saw together.
struct Together {
    DepthShot shot;  ///< with the pictures of all cameras
    HandFrame hands;
};

/// What a source saw at one time: the pictures of cameras, a tracker's hands, or both.
struct Frame {
    std::uint64_t number = 0;        ///< counts up by one from frame to frame; a gap is lost frames
    double time_s = 0.0;             ///< by the source's own clock
    std::optional<double> came_s{};  ///< by the loop's clock, when that is not when the loop gets it
    std::variant<DepthShot, HandFrame, Together> seen;
};

/// Where frames come from. It knows neither the object nor what plays.
class FrameSource {
public:
    FrameSource() = default;
    FrameSource(const FrameSource&) = delete;
    FrameSource& operator=(const FrameSource&) = delete;
    virtual ~FrameSource() = default;
    /// Frames a second; of a tracker that does not say, as they have come so far.
    [[nodiscard]] virtual double rate_hz() const = 0;
    /// Whether frames come as they are taken, each due at once; otherwise each is due at its time.
    [[nodiscard]] virtual bool live() const = 0;
    /// Whether next() returns at once. Of a live source it takes in what has come, and the newest frame wins.
    [[nodiscard]] virtual bool ready() = 0;
    /// The next frame; nothing when there is no further one.
    [[nodiscard]] virtual std::optional<Frame> next() = 0;
};

/// An object as it is at the time of a frame.
struct FeltObject {
    std::string name;                  ///< by which lines of a scene move it
    std::string kind;                  ///< of object_kinds(), or a mesh file
    double size_m = 0.0;               ///< edge or diameter; of a mesh its largest extent before it was turned
    std::optional<double> height_m{};  ///< of a cone, a pyramid and a cylinder
    Pose pose;                         ///< its origin is the middle of the box around it
};

/// What became of one frame.
struct ShotReport {
    std::uint64_t number = 0;
    double time_s = 0.0;
    bool blind = false;                             ///< nothing is known of the hands
    std::size_t points = 0, fingers = 0, foci = 0;  ///< points: of clouds; foci: at the same time
    std::vector<Ellipse> sections;                  ///< of rings, where they were measured
    std::vector<Vec3> centres;                      ///< and where they play, predicted
    std::vector<std::vector<Vec3>> contacts;        ///< lines on the skin that are drawn, predicted
    std::vector<FeltObject> objects;
    double force_n = 0.0;    ///< the sum of the fingers' forces' magnitudes on the object
    double compute_s = 0.0;  ///< processor time from the frame to the path
    /// From the newest frame whose path is on the board to the beginning of that path, by the length of the FIFO.
    std::optional<double> latency_s{};
    std::vector<std::string> troubles;  ///< whole sentences
    std::vector<std::string> news;      ///< sentences that are no trouble, such as on objects that have come
};

/// Counts of frames unless said otherwise.
struct ShotCounts {
    std::uint64_t with_rings = 0;
    std::uint64_t empty = 0;                     ///< nothing in the workspace
    std::uint64_t without_camera = 0;            ///< a camera gave no picture
    std::vector<std::uint64_t> without_picture;  ///< of each camera: in which it gave none
    std::uint64_t through = 0;                   ///< a finger was behind the object's middle
    std::uint64_t no_section = 0;                ///< a finger's points were no ellipse of a finger's size
    std::uint64_t constrained = 0;               ///< a section was seen from one side
    std::uint64_t out_of_reach = 0;              ///< something that is felt was where the array makes no focus
    std::uint64_t without_magnitude = 0;         ///< a finger's focus cannot feel as strong as it shall
    std::uint64_t hidden = 0;     ///< a part of a ring was behind the finger, where no sound arrives, and was silent
    std::uint64_t unweighed = 0;  ///< a finger was of a size whose sound is unknown; its ring was not weighed
};

/// What makes a path of each frame. It needs no board.
class Feeler {
public:
    Feeler() = default;
    Feeler(const Feeler&) = delete;
    Feeler& operator=(const Feeler&) = delete;
    virtual ~Feeler() = default;
    /// @param report  to be completed
    /// @return what plays over and over until the next frame; nothing when nothing is felt, or can be made, of which
    /// the report then names the troubles
    [[nodiscard]] virtual std::optional<Path> feel(const Frame& frame, ShotReport& report) = 0;
    [[nodiscard]] virtual ShotCounts counts() const = 0;
    /// What can be felt there, to be said before it plays: sentences.
    [[nodiscard]] virtual std::string about() const { return {}; }
};

}  // namespace haptogram::live
