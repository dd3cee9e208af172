// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "haptogram/array/array.hpp"
#include "haptogram/hand/ring.hpp"
#include "haptogram/hand/section.hpp"
#include "haptogram/live/cloud.hpp"
#include "haptogram/live/prediction.hpp"
#include "haptogram/live/touch_scene.hpp"
#include "haptogram/perception/path_magnitude.hpp"

namespace haptogram::live {

/// How shots become rings.
struct FingerOptions {
    CloudOptions cloud;
    SceneOptions scene;
    SectionOptions section;
    RingOptions ring;
    PredictorOptions predict;
    double rate_hz = 30.0;  ///< of shots
    /// How strong a still focus feels by the Multimodal paper's tables (perception/path_magnitude.hpp), which are of
    /// palms and of one focus that rests and is modulated.
    std::optional<double> magnitude;
};

/// What became of one shot.
struct ShotReport {
    std::uint64_t number = 0;
    double time_s = 0.0;
    std::size_t points = 0, fingers = 0, foci = 0;  ///< foci: rings that play at the same time
    std::vector<Ellipse> sections;                  ///< of these, where they were measured
    std::vector<Vec3> centres;                      ///< and where they play, predicted
    Pose object;
    double force_n = 0.0;               ///< the sum of the fingers' forces' magnitudes on the object
    double compute_s = 0.0;             ///< processor time from the pictures to the ring
    std::vector<std::string> troubles;  ///< whole sentences
};

/// Counts of shots unless said otherwise.
struct ShotCounts {
    std::uint64_t with_rings = 0;
    std::uint64_t empty = 0;                     ///< nothing in the workspace
    std::uint64_t without_camera = 0;            ///< a camera gave no picture
    std::vector<std::uint64_t> without_picture;  ///< of each camera: in which it gave none
    std::uint64_t through = 0;                   ///< a finger was behind the object's middle
    std::uint64_t no_section = 0;                ///< a finger's points were no ellipse of a finger's size
    std::uint64_t constrained = 0;               ///< a section was seen from one side
    std::uint64_t out_of_reach = 0;              ///< a finger's ring was where the array makes no focus
    std::uint64_t without_magnitude = 0;         ///< a finger's focus cannot feel as strong as it shall
};

/// The first half of the loop, which needs no device: shots in, what shall play out.
class ShotRings {
public:
    /// @throws Error{bad_argument} naming an option that makes no sense, and "magnitude" where the tables or the array
    /// do not have it
    ShotRings(const Array& array, double carrier_hz, const FingerOptions& options);

    /// @param shot    of which some camera gave a picture
    /// @param report  to be completed
    /// @return the rings of all fingers as one path, or nothing when there are none. A finger behind the object's
    /// middle, one that is no section, one out of the array's reach and one that cannot feel as strong as it shall get
    /// none; the report names it and says why
    [[nodiscard]] std::optional<Path> take(std::span<const DepthCamera> cameras, const DepthShot& shot,
                                           ShotReport& report);

    [[nodiscard]] const ShotCounts& counts() const { return counts_; }
    [[nodiscard]] const TouchScene& scene() const { return scene_; }

private:
    [[nodiscard]] std::optional<Path> ring_of(const SceneFinger& finger, const std::optional<Vec3>& sight,
                                              ShotReport& report);
    [[nodiscard]] std::optional<std::string> give_magnitude(Path& ring);
    void note_cameras(const DepthShot& shot, ShotReport& report);

    Array array_;
    double carrier_hz_;
    FingerOptions options_;
    CloudMaker clouds_;
    TouchScene scene_;
    Predictor predictor_;
    ShotCounts counts_;
    std::map<std::uint64_t, Vec3> last_start_;  ///< by finger: where its ring begins
    perception::Tables tables_;
    std::unique_ptr<perception::CommandLattice> commands_;  ///< when a magnitude is wanted
};

}  // namespace haptogram::live
