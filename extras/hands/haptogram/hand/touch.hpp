// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "haptogram/hand/feature.hpp"
#include "haptogram/hand/grain.hpp"
#include "haptogram/hand/object.hpp"
#include "haptogram/hand/press.hpp"
#include "haptogram/hand/surface.hpp"
#include "haptogram/hand/voice.hpp"
#include "haptogram/shape/draw.hpp"

namespace haptogram {

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
