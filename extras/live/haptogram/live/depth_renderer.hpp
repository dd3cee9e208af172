// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include "haptogram/hand/hand.hpp"
#include "haptogram/hand/surface.hpp"
#include "haptogram/live/depth.hpp"

namespace haptogram {

/// What a simulated camera sees: all points no farther than a radius from a line, or from a rectangle.
struct RoundedBody {
    Vec3 middle;          ///< of the line or rectangle, metres, array frame
    Vec3 half_a, half_b;  ///< from the middle to its ends; half_b is 0 for a line, both are 0 for a ball
    double radius = 0.0;
};

/// A hand as round segments, as hand/surface.hpp measures them, and a rounded plate as the palm.
[[nodiscard]] std::vector<RoundedBody> bodies_of(const Hand& hand, const SkinOptions& skin = {});

/// What a stereo camera does to depth. Of the noise, σ_z = z²·σ_d/(f·B) with the standard deviation σ_d of the
/// disparity; pixels beside an edge are missing at random. The numbers are ours.
struct DepthNoise {
    double disparity_px = 0.08;
    double edge_loss = 0.5;  ///< the probability that a pixel within one of an edge is missing
    double edge_m = 10e-3;   ///< neighbours that differ by more are an edge
    std::uint64_t seed = 1;  ///< the same seed gives the same noise in every shot of the same number
};

/// No noise at all.
inline constexpr DepthNoise no_depth_noise{0.0, 0.0, 10e-3, 0};

/// The picture that a camera takes of bodies: in each pixel the depth of the nearest surface along the pixel's ray,
/// exact but for rounding to counts where there is no noise.
/// @param stream  tells the noise of this picture from that of others with the same seed
/// @throws Error{bad_argument} for an unsound camera, noise that is negative, or a body that is not finite
[[nodiscard]] DepthPicture render_depth(const std::vector<RoundedBody>& bodies, const DepthCamera& camera,
                                        const DepthNoise& noise = no_depth_noise, std::uint64_t stream = 0);

/// The pictures that several cameras take of bodies at a time.
/// @param number  of the shot, which also tells its noise from that of others
[[nodiscard]] DepthShot render_shot(const std::vector<RoundedBody>& bodies, const std::vector<DepthCamera>& cameras,
                                    const DepthNoise& noise, std::uint64_t number, double time_s);

/// Depth cameras that see a scene in motion.
class SyntheticDepth final : public DepthSource {
public:
    using Scene = std::function<std::vector<RoundedBody>(double time_s)>;
    /// @param seconds  how long shots come
    /// @throws Error{bad_argument} for no camera, or a rate or time that is not positive
    SyntheticDepth(std::vector<DepthCamera> cameras, Scene scene, double rate_hz, double seconds,
                   const DepthNoise& noise);

    [[nodiscard]] const std::vector<DepthCamera>& cameras() const override { return cameras_; }
    [[nodiscard]] double rate_hz() const override { return rate_hz_; }
    [[nodiscard]] std::optional<DepthShot> next() override;

private:
    std::vector<DepthCamera> cameras_;
    Scene scene_;
    double rate_hz_;
    std::uint64_t shots_, number_ = 0;
    DepthNoise noise_;
};

}  // namespace haptogram
