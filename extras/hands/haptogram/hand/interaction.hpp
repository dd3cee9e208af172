// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "haptogram/array/array.hpp"
#include "haptogram/format/path.hpp"
#include "haptogram/format/waveform.hpp"
#include "haptogram/hand/feature.hpp"
#include "haptogram/hand/marker.hpp"
#include "haptogram/hand/movement.hpp"

namespace haptogram {

/// What floats above the array and touches the palm in the interaction system of Hoshi et al. 2010 (section 5). The
/// paper names the three and gives no rules; these are ours.
enum class Content {
    ball,      ///< bounces on the palm without loss, and is felt while it touches
    rain,      ///< drops at random times and places on the palm, each felt for a moment
    creature,  ///< walks about on the palm, and is felt where it is
};
/// @throws Error{bad_argument} for other names than ball, rain and creature
[[nodiscard]] Content content_of(std::string_view name);

struct InteractionOptions {
    Vec3 palm_from_marker{0, -0.045, 0};      ///< what the calibration by hand finds
    double palm_radius_m = 0.04;              ///< the palm is a horizontal disc
    double lowest_m = 0.15, highest_m = 0.3;  ///< where the device has foci (section 5)
    std::optional<PositionGrid> grid;         ///< the focus stays on these positions
    double spacing_m = 0.5e-3;                ///< the focus stays until it would be farther off than this
    double longest_gap_s = 0.1;               ///< without a sight of the marker, before the hand counts as lost
    double ball_height_m = 0.1;               ///< above the palm, from which a ball falls
    double ball_contact_s = 0.03;             ///< that a bounce takes; the ball is as soft as this needs
    double rain_hz = 5.0;                     ///< drops a second on the palm, on average
    double drop_s = 0.03;                     ///< that one is felt
    double creature_m_s = 0.03;               ///< speed on the palm
    std::uint64_t seed = 1;                   ///< of rain and creature
    Modulation modulation;                    ///< of the path; the paper has 200 Hz
};

/// One of the three in time. It knows the palm and nothing of the array, so a live loop can ask it as well as a
/// recording.
class Interaction {
public:
    /// @throws Error{bad_argument} for lengths, times and rates that are not positive and finite
    Interaction(Content content, const InteractionOptions& options);

    /// Goes on by some time, in which the palm comes to a new place.
    /// @param seconds  at most a few ms, or a ball's bounce is coarse
    /// @param palm     its centre, metres
    /// @return where the content touches the palm now; nothing when it does not
    std::optional<Vec3> advance(double seconds, Vec3 palm);

    /// What is to be drawn now, metres: the ball, the falling drops, or the creature.
    [[nodiscard]] const std::vector<Vec3>& things() const { return things_; }
    /// How often something has begun to touch the palm.
    [[nodiscard]] std::size_t touches() const { return touches_; }

private:
    std::optional<Vec3> bounce(double seconds, Vec3 palm);
    std::optional<Vec3> rain(double seconds, Vec3 palm);
    std::optional<Vec3> walk(double seconds, Vec3 palm);
    void fall_anew(Vec3 palm);
    Vec3 random_place();

    struct Drop {
        Vec3 place;            ///< on the palm, from its centre
        double until_s = 0.0;  ///< it hits
    };

    Content content_;
    InteractionOptions options_;
    KeyedRandom random_;
    std::vector<Vec3> things_;
    std::size_t touches_ = 0;
    bool begun_ = false, touching_ = false;
    Vec3 place_, velocity_;  ///< of the ball, or of the creature from the palm's centre
    Vec3 last_palm_;
    std::vector<Drop> drops_;                 ///< on their way
    Vec3 hit_;                                ///< where the last drop fell, from the palm's centre
    double next_s_ = 0.0;                     ///< until the next drop begins to fall, or the creature turns otherwise
    double felt_s_ = 0.0;                     ///< for which the last drop is still felt
    double heading_ = 0.0, turn_rate_ = 0.0;  ///< of the creature, rad and rad/s
};

/// A moment of what a display would show.
struct SceneMoment {
    double time_s = 0.0;
    std::optional<Vec3> palm;  ///< when there is a hand
    std::vector<Vec3> things;
    std::optional<Vec3> focus;  ///< that plays
};

struct PlayedInteraction {
    Path path;
    std::vector<SceneMoment> scene;  ///< every 10 ms
    std::size_t touches = 0;
    double felt_s = 0.0;          ///< for which a focus plays
    double out_of_range_s = 0.0;  ///< for which there should be one, but it is lower or higher than the device reaches,
                                  ///< or outside the grid; it is silent
    double lost_s = 0.0;          ///< without a hand
};

/// A recording of a marker as a path: the content reacts to the palm in steps of 1 ms, the marker moves straight
/// between its samples.
/// @param carrier_hz  in whose periods the path counts
/// @throws Error{bad_argument} as Interaction, Error{bad_input} for fewer than two samples, or times that do not rise
[[nodiscard]] PlayedInteraction interact(Content content, std::span<const MarkerSample> marker,
                                         const InteractionOptions& options, double carrier_hz);

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
