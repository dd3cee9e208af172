// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "haptogram/array/array.hpp"
#include "haptogram/format/waveform.hpp"
#include "haptogram/hand/interaction.hpp"
#include "haptogram/hand/marker.hpp"

namespace haptogram {

/// Something that touches a recorded hand, as a user names it.
struct InteractionRequest {
    std::string content;                       ///< ball, rain or creature
    std::string hand = "synthetic:slide:220";  ///< a recording as open_hands() takes it, or a .csv file of the marker
    double noise_px = 0.5;                     ///< of the marker in each camera's picture
    InteractionOptions options;                ///< but for its grid and modulation; its seed is the noise's, too
    bool grid = false;                         ///< only the positions of interaction_grid()
    std::string am = "square:200";
    AmplitudeLaw am_law = AmplitudeLaw::pressure;
    std::optional<std::string> array, board;  ///< as a project has them
};

/// The path and the scene, and for what they were made.
struct InteractionOnArray {
    PlayedInteraction played;
    MarkerTrack track;
    Array array;
    double carrier_hz = 0.0;
    std::vector<std::string> warnings;  ///< whole sentences
    [[nodiscard]] double seconds() const { return static_cast<double>(played.path.periods()) / carrier_hz; }
};

/// Where a marker is over time: rows of a .csv file (time_ms, x_mm, y_mm, z_mm), or what two simulated cameras see of a
/// recorded hand.
/// @param carrier_hz  in whose periods a file's times count
/// @throws Error{bad_input} for files that cannot be used, and when the marker is never seen
[[nodiscard]] MarkerTrack open_marker(const std::string& name, double noise_px, std::uint64_t seed, double carrier_hz);

/// The interaction demo of Hoshi et al. 2010 (section 5) on a recording.
/// @throws Error{bad_argument} for names and measures that make no sense, Error{bad_input} when nothing touches the
/// palm where the device reaches, or the array cannot reach a place
[[nodiscard]] InteractionOnArray interact(const InteractionRequest& request);

/// What a display would show: a line of JSON for each moment, with time_s, things_mm, and palm_mm and focus_mm when
/// there are any.
[[nodiscard]] std::string to_json_lines(const std::vector<SceneMoment>& scene);

}  // namespace haptogram
