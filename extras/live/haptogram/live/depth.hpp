// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "haptogram/array/rig.hpp"
#include "haptogram/hand/hand.hpp"
#include "haptogram/hand/surface.hpp"

namespace haptogram {

/// A depth camera without distortion. A pixel (u, v) of depth z is the point ((u − cx)·z/fx, (v − cy)·z/fy, z) of the
/// camera's own frame: x to the right, y down, z forward.
struct DepthCamera {
    std::uint32_t width = 640, height = 480;
    double focal_x_px = 476.007, focal_y_px = 476.007;
    double centre_x_px = 313.683, centre_y_px = 242.755;
    double unit_m = 0.125e-3;   ///< metres of a count; the count 0 is "not seen"
    double baseline_m = 50e-3;  ///< between the two eyes of a stereo camera; only the simulated noise depends on it
    Pose pose;                  ///< of the camera's frame in the array frame
};

/// @throws Error{bad_argument} naming what is not positive and finite, or a picture beyond 65,535 pixels in a direction
void require_sound(const DepthCamera& camera);

/// A camera like Intel's D435 at 848 × 480: 87° wide, a baseline of 50 mm.
[[nodiscard]] DepthCamera wide_depth_camera();

/// The pose of a camera that stands at a place and looks at a point, with its y axis as much down as that allows, or
/// along −y when it looks up or down.
/// @throws Error{bad_argument} when it stands where it looks
[[nodiscard]] Pose looking_at(Vec3 place, Vec3 target);

/// Cameras on a circle at the height of a point, which they look at, the first on the side of −y.
/// @throws Error{bad_argument} for no camera, or a distance that is not positive
[[nodiscard]] std::vector<DepthCamera> cameras_around(Vec3 target, double distance_m, std::size_t count);

/// Counts of depth, row by row, as a camera gave them.
using DepthPicture = std::vector<std::uint16_t>;

/// What all cameras saw at one time.
struct DepthShot {
    std::uint64_t number = 0;                           ///< counts up by one from shot to shot; a gap is lost shots
    double time_s = 0.0;                                ///< of the exposure
    std::vector<std::optional<DepthPicture>> pictures;  ///< one a camera; nothing where a camera gave none
};

/// Where shots come from: a recording, a simulation, or a driver.
class DepthSource {
public:
    DepthSource() = default;
    DepthSource(const DepthSource&) = delete;
    DepthSource& operator=(const DepthSource&) = delete;
    virtual ~DepthSource() = default;

    [[nodiscard]] virtual const std::vector<DepthCamera>& cameras() const = 0;
    /// Shots a second.
    [[nodiscard]] virtual double rate_hz() const = 0;
    /// The next shot, as soon as it is there; nothing when there is no further one.
    /// @throws Error{bad_input} naming a picture that cannot be read
    [[nodiscard]] virtual std::optional<DepthShot> next() = 0;

    /// Whether shots come as they are taken, each due at once; otherwise all are there, and each is due at its time.
    [[nodiscard]] virtual bool live() const { return false; }
    /// Whether next() returns at once. Of a live source it takes in what has come, so it wants to be asked often.
    /// @throws Error{bad_input} as next()
    [[nodiscard]] virtual bool ready() { return true; }
    /// How many times something came that was no shot, and why the first one was none.
    [[nodiscard]] virtual std::pair<std::uint64_t, std::string> junk() const { return {}; }
};

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
