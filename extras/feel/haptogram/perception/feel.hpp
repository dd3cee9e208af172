// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "haptogram/acoustics/drive_sequence.hpp"
#include "haptogram/acoustics/skin_force.hpp"
#include "haptogram/base/progress.hpp"
#include "haptogram/format/path.hpp"
#include "haptogram/perception/felt.hpp"
#include "haptogram/perception/sound.hpp"
#include "haptogram/verbs/timeline.hpp"

namespace haptogram {

/// A place of a hand's skin.
struct HandSkin {
    Vec3 position, normal;
    std::string part;  ///< palm, thumb, index, …
};

struct FeelOptions {
    std::vector<Vec3> at;         ///< places on the skin; empty: at the foci
    Vec3 normal{0.0, 0.0, -1.0};  ///< of the skin, at all places
    /// The skin of a hand nearest to a place: each place moves there, and has its normal and its region, instead of
    /// those given here.
    std::function<HandSkin(Vec3)> skin;
    std::size_t most_places = 8;           ///< of the foci, evenly chosen
    double contact_m = default_contact_m;  ///< diameter of the skin that a force is of
    std::vector<Vec3> ears;                ///< of listeners
    perception::Region region = perception::Region::palm;
    double grip_n = 1.0;  ///< that the hand holds at the same time; of a bare hand 1 N is an upper bound
    perception::Tables tables;
};

/// What one place of the skin feels.
struct FeltPlace {
    SkinPlace place;
    perception::Region region = perception::Region::palm;
    std::string part;         ///< of a hand: palm, thumb, index, …; empty without one
    double off_skin_m = 0.0;  ///< how far what was asked for is from the hand's skin
    SkinForce force;
    double mean_pa = 0.0, most_pa = 0.0;     ///< radiation pressure at the place
    double mean_n = 0.0;                     ///< force
    double depth = 0.0;                      ///< of the force's modulation, 0…1
    std::vector<perception::Line> spectrum;  ///< of the force, N
    perception::Felt felt;
    [[nodiscard]] bool expected() const { return !felt.lines.empty() && felt.lines.front().over_db > 0.0; }
};

/// What a hand is expected to feel and an ear to hear, by models. Nothing of it was measured on people by this project.
struct Feeling {
    double seconds = 0.0;  ///< that were looked at: one pass, or what was measured
    std::vector<FeltPlace> places;
    double mean_pa = 0.0, spread = 0.0;  ///< over the places: the time-averaged pressure, and standard deviation/mean
    std::optional<double> speed_m_s;     ///< of the focus, where it moves less than its width at a time
    std::optional<double> wave_gain;     ///< by waves in the skin at that speed (perception/skin_wave.hpp)
    double extent_m = 0.0;               ///< diagonal of the box around all foci
    std::optional<double> nearest_m;     ///< between two foci that sound at the same time
    perception::Noise noise;
    std::vector<perception::Exposure> ears;
    perception::Exposure loudest;       ///< on a hemisphere of 0.5 m
    std::vector<std::string> warnings;  ///< whole sentences
};

/// @throws Error{bad_input} when nothing is played, Error{bad_argument} for options that make no sense
[[nodiscard]] Feeling feel(const Timeline& timeline, const FeelOptions& options, const Progress& progress = {});

/// Draws the strongest place: radiation pressure over time, and the force's spectrum beside what is felt; all places;
/// and what is heard.
/// @param path  .png
/// @throws Error{bad_input} when it cannot be drawn
void draw_feeling(const std::string& path, const Timeline& timeline, const FeelOptions& options,
                  const Feeling& feeling);

}  // namespace haptogram
