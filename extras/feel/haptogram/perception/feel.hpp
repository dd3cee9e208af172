// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "haptogram/acoustics/drive.hpp"
#include "haptogram/acoustics/skin_force.hpp"
#include "haptogram/array/array.hpp"
#include "haptogram/base/progress.hpp"
#include "haptogram/format/path.hpp"
#include "haptogram/perception/verdict.hpp"
#include "haptogram/verbs/timeline.hpp"

namespace haptogram::perception {

/// Skin as a damped membrane on a soft foundation: w'' = c²∇²w − 2γw' − ω₀²w + P/m. It explains why a focus that moves
/// about as fast as waves in the skin is felt best (Frier et al. 2018). The parameters are ours, chosen so that the
/// deflection is largest between 5 and 7 m/s; nobody measured this membrane.
struct SkinMembrane {
    double wave_speed_m_s = 6.0;    ///< c; shear waves in skin travel at 3 to 7 m/s
    double damping_1_s = 300.0;     ///< γ
    double foundation_hz = 60.0;    ///< ω₀/2π
    double focus_width_m = 8.6e-3;  ///< full width at half maximum of the radiation pressure, a Gaussian
};

inline constexpr double fastest_wave_m_s = 12.0;  ///< up to which the model is used

/// The largest deflection under a focus that moves along a straight line at one speed, over that of a focus that rests.
/// In Fourier space W(k) = P(k)/(ω₀² + c²k² − (k·v)² + 2jγ(k·v)); it is summed on a square of 400 mm with 512 × 512
/// points. By symmetry the largest deflection is on the line.
/// @throws Error{bad_argument} naming "speed" outside of 0 to 12 m/s
[[nodiscard]] double deflection_over_static(double speed_m_s, const SkinMembrane& skin = {});

/// How much a sequence is likely to be heard, beside a reference.
///
/// Air makes sound of the envelope E of strong ultrasound in proportion to d²(E²)/dt² (Berktay 1965). E² is taken as
/// the sum of |drive|² over the elements after the transducers' bandwidth, so that steps of the phase, at which a
/// carrier dips, make noise as changes of the amplitude do. Directions and the room are left out: differences between
/// sequences of one array mean something, and the level at an ear does not follow.
struct Noise {
    double relative_db = 0.0;  ///< A-weighted, 20 Hz to 16 kHz, over that of every element at full drive under a sine
                               ///< from 0 to 1 at 200 Hz; −∞ for a steady drive
    double loudest_hz = 0.0;   ///< the strongest line; 0 for a steady drive
    double largest_step_deg = 0.0;  ///< of any element's phase from one carrier period to the next
    std::vector<Line> lines;        ///< A-weighted second derivatives of E², in the unit of the reference's sum
};
/// @throws Error{bad_input} for a sequence of nothing
[[nodiscard]] Noise noise_of(const Array& array, const DriveSequence& sequence);

/// What reaches a listener.
struct Exposure {
    Vec3 ear;              ///< metres, array frame
    double mean_db = 0.0;  ///< of the mean square over the sequence, dB SPL
    double most_db = 0.0;  ///< of the loudest set of drives, if it stayed
};
/// Ultrasound at an ear, in a free field: without head, hand and walls.
/// @throws Error{bad_input} when the ear coincides with an element
[[nodiscard]] std::vector<Exposure> exposure(const Array& array, const DriveSequence& sequence,
                                             std::span<const Vec3> ears);

/// The largest mean level on a hemisphere in front of the array, around its centre, looked at every 2 degrees.
[[nodiscard]] Exposure loudest_around(const Array& array, const DriveSequence& sequence, double radius_m = 0.5);

}  // namespace haptogram::perception

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
    std::optional<double> level_pa_m;  ///< source strength of an element, in place of the expected one
    std::optional<double> supply_v;    ///< of the drivers; by default as expected_level() has it
    bool sound = true;                 ///< also what an ear hears
};

/// A focus that passes a place now and then is felt as it passes: the force's spectrum is that of the so long part of
/// the sequence that has the most force. Ours: as long as the channel that feels vibrations sums them, about.
inline constexpr double felt_within_s = 0.2;

/// What one place of the skin feels.
struct FeltPlace {
    SkinPlace place;
    perception::Region region = perception::Region::palm;
    std::string part;                        ///< of a hand: palm, thumb, index, …; empty without one
    double off_skin_m = 0.0;                 ///< how far what was asked for is from the hand's skin
    SkinForce force;                         ///< at the level of the feeling
    double mean_pa = 0.0, most_pa = 0.0;     ///< radiation pressure at the place
    double mean_n = 0.0;                     ///< force
    double depth = 0.0;                      ///< of the force's modulation, 0…1
    std::vector<perception::Line> spectrum;  ///< of the force, N
    perception::Felt felt;
    perception::Verdict verdict;
};

/// What a hand is expected to feel and an ear to hear, by models. Nothing of it was measured on people by this project.
struct Feeling {
    double seconds = 0.0;  ///< that were looked at: one pass, or what was measured
    ExpectedLevel level;   ///< that pressures and forces are at. What an ear hears is at the nominal one
    std::vector<FeltPlace> places;
    std::vector<perception::Verdict> verdicts;  ///< of the places
    double mean_pa = 0.0, spread = 0.0;  ///< over the places: the time-averaged pressure, and standard deviation/mean
    std::optional<double> speed_m_s;     ///< of the focus, where it moves less than its width at a time
    std::optional<double> wave_gain;     ///< by waves in the skin at that speed (perception/feel.hpp)
    double extent_m = 0.0;               ///< diagonal of the box around all foci
    std::optional<double> nearest_m;     ///< between two foci that sound at the same time
    perception::Noise noise;
    std::vector<perception::Exposure> ears;
    perception::Exposure loudest;       ///< on a hemisphere of 0.5 m
    std::vector<std::string> warnings;  ///< whole sentences
};

/// @throws Error{bad_input} when nothing is played, Error{bad_argument} for options that make no sense
[[nodiscard]] Feeling feel(const Timeline& timeline, const FeelOptions& options, const Progress& progress = {});

/// What a palm that faces the array feels at the foci of what plays, as `haptogram feel` without options says it; no
/// sound. Nothing when there are no foci.
[[nodiscard]] std::optional<Feeling> feeling_at_foci(const Timeline& timeline);

/// The verdict that it comes to, and the level that it is of: the line with which `compile` ends, and what a report
/// says.
[[nodiscard]] std::string verdict_on(const std::optional<Feeling>& at_foci);
[[nodiscard]] std::string verdict_on(const Timeline& timeline);
[[nodiscard]] std::string verdict_on(const Timeline& timeline);

/// Draws the strongest place: radiation pressure over time, and the force's spectrum beside what is felt; all places;
/// and what is heard.
/// @param path  .png
/// @throws Error{bad_input} when it cannot be drawn
void draw_feeling(const std::string& path, const Timeline& timeline, const FeelOptions& options,
                  const Feeling& feeling);

}  // namespace haptogram
