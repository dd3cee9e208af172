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
#include "haptogram/hand/surface.hpp"
#include "haptogram/live/cluster.hpp"
#include "haptogram/live/frame.hpp"
#include "haptogram/live/hand_feeler.hpp"
#include "haptogram/live/touch_scene.hpp"
#include "haptogram/perception/magnitude.hpp"

namespace haptogram::live {

/// How shots become rings.
struct FingerOptions {
    CloudOptions cloud;
    SceneOptions scene;
    SectionOptions section;
    RingOptions ring;
    PredictorOptions predict;
    SkinOptions skin;                                                         ///< of a tracker's hands
    double rate_hz = 30.0;                                                    ///< of shots
    FeltObject object{"object", "cube", 40e-3, {}, {.origin = {0, 0, 0.2}}};  ///< as it begins
    /// How strong a still focus feels by the Multimodal paper's tables (perception/magnitude.hpp), which are of
    /// palms and of one focus that rests and is modulated.
    std::optional<double> magnitude;
};

/// Rings around fingers that touch an object: of depth cameras' shots, or of a tracker's hands.
class ShotRings final : public Feeler {
public:
    /// @param cameras  whose shots feel() takes
    /// @throws Error{bad_argument} naming an option that makes no sense, and "magnitude" where the tables or the array
    /// do not have it
    ShotRings(const Array& array, double carrier_hz, const FingerOptions& options,
              std::vector<DepthCamera> cameras = {});

    /// @param shot    of which some camera gave a picture
    /// @param report  to be completed
    /// @return the rings of all fingers as one path, or nothing when there are none. A finger behind the object's
    /// middle, one that is no section, one out of the array's reach and one that cannot feel as strong as it shall get
    /// none; the report names it and says why
    [[nodiscard]] std::optional<Path> take(std::span<const DepthCamera> cameras, const DepthShot& shot,
                                           ShotReport& report);
    /// The same of a frame, whose hands are taken as points on their fingers.
    [[nodiscard]] std::optional<Path> feel(const Frame& frame, ShotReport& report) override;

    [[nodiscard]] ShotCounts counts() const override { return counts_; }
    /// What rings this array can make around a finger on top of the object.
    [[nodiscard]] std::string about() const override;
    [[nodiscard]] const TouchScene& scene() const { return scene_; }

private:
    [[nodiscard]] std::optional<Path> ring_of(const SceneFinger& finger, const std::optional<Vec3>& sight,
                                              ShotReport& report);
    [[nodiscard]] std::optional<std::string> give_magnitude(Path& ring);
    void weigh(Path& ring, const FingerCut& contact);
    [[nodiscard]] std::optional<Path> rings_of(std::span<const Vec3> cloud, const std::optional<Vec3>& eye,
                                               ShotReport& report);
    [[nodiscard]] std::vector<Vec3> cloud_of(const Hand& hand) const;
    void tell_object(ShotReport& report) const;
    void note_cameras(const DepthShot& shot, ShotReport& report);

    Array array_;
    double carrier_hz_;
    FingerOptions options_;
    std::vector<DepthCamera> cameras_;
    CloudMaker clouds_;
    TouchScene scene_;
    Predictor predictor_;
    RingWeigher weigher_;
    ShotCounts counts_;
    std::map<std::uint64_t, Vec3> last_start_;    ///< by finger: where its ring begins
    std::map<std::int64_t, double> last_seen_s_;  ///< by hand, of several sources
    perception::Tables tables_;
    std::unique_ptr<perception::CommandLattice> commands_;  ///< when a magnitude is wanted
};

}  // namespace haptogram::live
