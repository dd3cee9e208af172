// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "haptogram/array/pose.hpp"
#include "haptogram/hand/hand.hpp"
#include "haptogram/hand/recording.hpp"

namespace haptogram {

/// Where a tracker or a camera is, in the array's frame: a file of `position_mm`, `right` and `forward`, its x and z
/// axes.
/// @param where  names the text in messages
/// @throws Error{bad_input} naming the line; for axes that are not of length 1 and at right angles to 1e-3
[[nodiscard]] Pose mounting_from_toml(std::string_view text, const std::string& where);
/// @param about  sentences for its first lines
[[nodiscard]] std::string mounting_to_toml(const Pose& pose, const std::vector<std::string>& about);

/// A frame of a tracker that is mounted so, in the array's frame.
[[nodiscard]] HandFrame mounted(HandFrame frame, const Pose& pose);

/// A point that is known, and where a tracker saw it: metres, in the array's frame and in the tracker's.
struct SeenPoint {
    Vec3 known, seen;
};

/// Points of a text, three numbers a line in millimetres, with blanks or commas between; # begins a remark.
/// @throws Error{bad_input} naming the line
[[nodiscard]] std::vector<Vec3> known_points_from(std::string_view text, const std::string& where);
/// The same with six numbers: the known ones, and then the seen ones.
[[nodiscard]] std::vector<SeenPoint> seen_points_from(std::string_view text, const std::string& where);

/// The mounting that explains what was seen best.
struct Alignment {
    Pose pose;
    std::vector<double> residuals_m;  ///< of each point: how far what was seen is from what is known
    /// Of each point: the same without that point, which a wrong one does not pull to itself.
    std::vector<double> residuals_without_m;
    double rms_m = 0.0;  ///< of the residuals
    std::optional<double>
        noise_m;  ///< standard deviation of a coordinate that follows; three points tell nothing of it
};

/// Least squares (Umeyama 1991, eq. 34 to 43, without scale), by Eigen.
/// @throws Error{bad_input} for fewer than three points, and for points that lie on a line, within a twentieth of its
/// length, which leave the turn about it open
[[nodiscard]] Alignment align(std::span<const SeenPoint> points, const std::string& where);

/// Within what the mounting is right in 95 of 100 cases: in the middle of the points, and by how much it is turned.
struct Sureness {
    double place_m = 0.0, angle_rad = 0.0;
};
/// @param noise_m  standard deviation of each coordinate
/// @param learned  whether the noise was estimated from the points, and is not known
[[nodiscard]] Sureness sureness_of(std::span<const Vec3> known, double noise_m, bool learned);

/// Where to touch next, of some places: where the turn about the axis that is known worst becomes surest.
/// @param touched  none of which is taken again
[[nodiscard]] Vec3 next_touch(std::span<const Vec3> touched, std::span<const Vec3> places);

/// The places where the tip of a finger stayed: within `still_m` for `still_s` or longer.
/// @param finger  0 is the thumb
[[nodiscard]] std::vector<Vec3> touches_in(const HandRecording& recording, std::size_t finger = 1, double still_s = 0.7,
                                           double still_m = 3e-3);

}  // namespace haptogram
