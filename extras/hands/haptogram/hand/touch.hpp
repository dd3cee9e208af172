// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "haptogram/array/array.hpp"
#include "haptogram/format/path.hpp"
#include "haptogram/hand/contour.hpp"
#include "haptogram/hand/feature.hpp"
#include "haptogram/hand/object.hpp"
#include "haptogram/hand/surface.hpp"
#include "haptogram/shape/draw.hpp"

#pragma once

namespace haptogram {

/// Foci that turn slowly on a small circle, evenly around it and at the same time: felt as steady pressure instead of
/// vibration (Morisaki et al. 2022; slow lateral modulation).
struct PressOptions {
    double turns_hz = 5.0;
    double radius_m = 3e-3;
    unsigned foci = 4;  ///< on each circle
};

/// A part of what a focus does: the way from one place of the skin to another, or silence for as long.
struct Leg {
    SkinPoint from, to;
    double seconds = 0.0;
    bool silent = false;
    std::size_t line = 0;  ///< the number of the line that it is on
};

/// What one focus does, over and over. Several voices play at the same time.
struct Voice {
    std::vector<Leg> legs;
    double am_hz = 0.0;  ///< of its own amplitude, a sine from 0 to 1; 0: none
    [[nodiscard]] double seconds() const;
};

/// One focus that draws lines at a pace, in their order.
/// @throws Error{bad_argument} unless the pace has exactly one positive number
[[nodiscard]] Voice drawn(const std::vector<SkinLine>& lines, const Pace& pace, Jump jump);

/// What became of the voices when they were played.
struct Played {
    std::size_t foci = 0;          ///< that were asked for, one a step and voice
    std::size_t out_of_reach = 0;  ///< of these; they stay silent
    std::string why;               ///< the first of them is out of reach
    std::size_t lines_missed = 0;  ///< too short for the distance between steps, so that no focus is on them
};

/// Turns voices into a path. A focus is where its voice is in the middle of the step. What the array cannot reach is
/// silent.
class PathPen {
public:
    /// @param dwell  carrier periods of a step, at least 1
    /// @throws Error{bad_argument} for a dwell of 0
    PathPen(const Array& array, double carrier_hz, std::uint32_t dwell);

    /// Plays voices until a time. Each goes on at the share of its pass at which the last one of its number stopped.
    /// Steps are not cut, so the next voices begin up to a dwell late, and end in time all the same.
    /// @param until_s  since the path's beginning; voices may be empty: silence
    /// @param amplitude  of all foci
    Played play(const std::vector<Voice>& voices, double until_s, double amplitude = 1.0);

    /// Plays one pass of the first voice, in this many steps, or in steps as near to the dwell as fill it evenly. The
    /// others take as many whole passes as come nearest to their pace, and their modulation whole periods, so that the
    /// path can be repeated.
    /// @throws Error{bad_input} when a step would last less than a carrier period
    Played play_pass(const std::vector<Voice>& voices, std::optional<std::size_t> points = {});

    [[nodiscard]] Path path() const { return path_of(stretches_); }

private:
    void play_step(const std::vector<Focus>& foci, double periods);
    void add(std::vector<Focus>& foci, const Leg& leg, Vec3 position, double am_hz, double time_s,
             Played& played) const;

    const Array& array_;
    double carrier_hz_;
    std::uint32_t dwell_;
    double at_periods_ = 0.0;  ///< what has been played
    std::vector<double> shares_;
    std::vector<Stretch> stretches_;
};

/// How a hand feels an object. A to J are those of Shapes, section IV; K and L came later.
enum class Algorithm {
    intersection,           ///< A: where the object's surface cuts the skin
    features,               ///< B: edges and corners
    deepest,                ///< C: A, and at the same time a second focus at the deepest point, amplitude-modulated
    solid,                  ///< D: A, and a second contour near the deepest point
    random_grain,           ///< E: short random lines inside the object
    fixed_grain,            ///< F: the same, as a function of space
    blobs,                  ///< G: circles on fingertips and palm that grow with the depth
    features_intersection,  ///< H: B and A
    features_solid,         ///< I: B and D
    features_blobs,         ///< J: B and G
    pointer,                ///< K: a modulated focus that goes slowly along A and waits at corners (Hajas et al. 2020)
    press,  ///< L: foci that turn slowly on small circles, felt as steady pressure (Morisaki et al. 2022)
};

struct AlgorithmName {
    char letter;
    const char* name;
    const char* about;
};
[[nodiscard]] std::span<const AlgorithmName> algorithm_names();
/// @param name  a letter from A to L, in either case, or a name of algorithm_names()
/// @throws Error{bad_argument} naming those that there are
[[nodiscard]] Algorithm algorithm_of(const std::string& name);
[[nodiscard]] const AlgorithmName& name_of(Algorithm algorithm);

/// What yields where features and other lines meet (Shapes, algorithm H).
enum class Priority {
    gap,     ///< other lines keep a distance from features
    finger,  ///< a finger, or the palm, that has a feature gets no other lines
};

/// Parameters of all algorithms. Shapes gives the speed and 200 Hz; the other measures are ours where nothing is said.
struct TouchOptions {
    std::optional<Pace> pace;  ///< by default 7 m/s; of K the speed, and of L the frequency below
    Jump jump = Jump::hop;     ///< between lines
    FeatureOptions feature;
    GrainOptions grain;
    double solid_level = 0.8;                          ///< of D: the second contour's depth over the deepest point's
    bool two_foci = false;                             ///< of D: both contours at the same time
    double am_hz = 200.0;                              ///< of C's second focus and of K
    double blob_finger_m = 9e-3, blob_palm_m = 25e-3;  ///< of G: the largest radii
    double blob_palm_gain = 2.0;                       ///< of G: radius over depth on the palm; it is 1 on fingers
    Priority priority = Priority::gap;
    double gap_m = 10e-3;  ///< more than the width of a focus
    double pointer_speed_m_s = 0.1, pointer_wait_s = 0.3;
    double pointer_turn_deg = 45.0;  ///< where the outline turns by more within pointer_window_m, it has a corner
    double pointer_window_m = 4e-3;
    PressOptions press;  ///< L's, on each region that is touched
};

/// What the foci do for a hand at one time.
struct Touch {
    std::vector<SkinLine> lines;  ///< everything that is drawn, in the order of the voices
    std::vector<Voice> voices;    ///< at the same time; none when nothing is touched
    double am_hz = 0.0;           ///< of everything that is played; 0: none
};

/// @param skin    regions of one hand, or of several
/// @param time_s  since the beginning, for what moves or is random
/// @throws Error{bad_argument} naming a parameter that makes no sense
[[nodiscard]] Touch touch_of(Algorithm algorithm, const TouchObject& object, const std::vector<SkinRegion>& skin,
                             double time_s = 0.0, const TouchOptions& options = {});

/// Carrier periods of a step for which a path of the algorithm has enough points and not too many: 10, and 400 for the
/// slow ones, which keeps the steps of L below a millimetre.
[[nodiscard]] std::uint32_t usual_dwell(Algorithm algorithm);

}  // namespace haptogram
