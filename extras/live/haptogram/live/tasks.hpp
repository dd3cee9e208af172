// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <random>
#include <vector>

#include "haptogram/format/path.hpp"
#include "haptogram/hand/ring.hpp"
#include "haptogram/live/shot_rings.hpp"
#include "haptogram/live/source.hpp"
#include "haptogram/perception/tables.hpp"

namespace haptogram::live {

/// How sure a finger feels. The thresholds are those of the tables (perception/felt.hpp); these are ours.
struct SenseOptions {
    double contact_m = 10e-3;      ///< across the skin whose force counts as one
    double grip_n = 1.0;           ///< of the thresholds: a bare hand feels a little more
    double threshold_sd_db = 2.0;  ///< from one look to the next
    double place_sd_m = 1.5e-3;    ///< of where on the finger something is felt, along each direction
};

/// Something that a finger felt.
struct Sensed {
    Vec3 place;            ///< where it seems to be
    double over_db = 0.0;  ///< the strongest vibration over the least that is felt
};

/// A finger's skin under what is played: radiation pressure on it (hand/ring.hpp), its vibration at each
/// place beside the threshold, and noise. A path that does not vibrate anywhere on the skin is not felt.
class SkinSense {
public:
    /// @throws Error{bad_argument} naming "grip" as perception/tables.hpp does
    SkinSense(const Array& array, const SenseOptions& options);

    /// @param path    plays over and over, in steps of equal length; foci of one step count each by itself
    /// @return nothing when it is not felt, and for fingers of a size whose sound is unknown
    [[nodiscard]] std::optional<Sensed> feel(const Path& path, const FingerForm& finger, std::mt19937_64& random);

private:
    struct Patch {
        Vec3 place;
        double area = 0.0;
    };
    [[nodiscard]] std::vector<std::vector<double>> pressures(const Path& path, const std::vector<Patch>& skin,
                                                             const FingerForm& finger);
    static std::vector<Patch> skin_of(const FingerForm& finger);

    double carrier_hz_;
    SenseOptions options_;
    RingWeigher weigher_;
    perception::Tables tables_;
};

/// What the fingers get to feel.
enum class Felt {
    dynamic,  ///< rings
    still,    ///< the still focus
    nothing,
};

/// The second task of Fingers: a cube is to be lifted by at least 50 mm for 1.5 s, with two fingers, seen (procedure 1)
/// or hidden behind a wall (procedure 2). The numbers that the paper does not print are ours.
struct LiftOptions {
    FingerOptions fingers;  ///< scene: overwritten from what is below
    CameraOptions cameras;  ///< around the middle of the room
    Felt felt = Felt::dynamic;
    bool seen = true;
    double edge_m = 40e-3;
    double x_m = 0.0, y_m = 0.0, turn_deg = 0.0;  ///< where the cube stands on the floor, which is 100 mm high
    double lift_m = 50e-3, hold_s = 1.5;
    double at_most_s = 12.0;     ///< then the trial has failed
    double squeeze_m = 10e-3;    ///< how far the fingers go in beyond the first touch
    double guess_m = 60e-3;      ///< between the fingertips and the middle, when they begin to close
    double closing_m_s = 60e-3;  ///< speed of each finger
    double lifting_m_s = 80e-3;
    std::size_t looks = 3;  ///< shots in which a finger feels where on it the face is, before the hand turns
    SenseOptions sense{};
    std::uint64_t person_seed = 1;  ///< of what is felt by chance
};

/// Draws a cube as the paper does, at random: 30 to 50 mm, in any place of the floor and at any angle. A hidden one
/// stands before the hand, within 15 mm along the fingers' way, 5 mm across it and 20°, because the scripted hand does
/// not search for it.
void draw_cube(LiftOptions& options, std::mt19937_64& random);

struct LiftReport {
    bool done = false;
    std::uint64_t shots = 0;
    std::uint64_t touched_shots = 0;  ///< of these, in which a finger touched the cube
    std::uint64_t felt_shots = 0;     ///< of those, in which the skin of one felt something
    std::size_t tries = 1;            ///< how often the fingers closed
    double first_touch_s = 0.0;       ///< of the cube by any finger
    double time_s = 0.0;              ///< from then to the end of the task
    double lifted_m = 0.0;            ///< at most
    double most_force_n = 0.0;        ///< of both fingers together
    double mean_force_n = 0.0;        ///< while it was held up
    double energy_made_j = 0.0;  ///< by how much the energy less the fingers' work ever grew; see TouchScene::work()
    ShotCounts counts;
};

/// A hand of two opposite fingers that carries out the task by a script. It feels by the skin (skin_sense.hpp) and, of
/// a seen cube, sees through the simulated cameras and the scene:
/// - A seen cube: it closes the fingers on the cube's middle, across two opposite faces, until it feels or sees each of
///   them in, and then by `squeeze_m` more. It lifts and holds.
/// - A hidden cube: it closes along x about the room's middle. The first finger that feels stays for `looks` shots: how
///   far off its middle, sideways, it feels says how the face is turned, and the hand turns about that round fingertip
///   so that it meets the face squarely. Then the other one closes. With nothing to feel, both close to half of the
///   smallest cube's width.
/// Fingers that meet each other, or that rise without the cube, open and try again.
/// @throws Error{bad_argument} for measures that are not positive, and as ShotRings
[[nodiscard]] LiftReport lift(const Array& array, const LiftOptions& options,
                              const std::function<void(const ShotReport&)>& told = {});

/// The first task of Fingers: the angle and the height of a surface are to be found by touch alone. The surface is felt
/// on a disc only. The numbers that the paper does not print are ours.
struct SurfaceOptions {
    FingerOptions fingers;   ///< scene: overwritten from what is below
    CameraOptions cameras;   ///< one, below the surface, as in the paper's experiment
    double angle_deg = 0.0;  ///< about y, which is the direction in which the person looks
    double height_m = 0.0;   ///< over the middle of its range
    Vec3 middle{0, 0, 0.2};
    double disc_m = 10e-3;   ///< radius
    std::size_t places = 5;  ///< where the finger comes down, evenly over the disc
    double lowering_m_s = 40e-3;
    double press_m = 3e-3;                 ///< how far it goes on when it feels
    std::size_t stay = 3;                  ///< shots for which it stays there
    double at_most_s = 30.0;               ///< then the trial has failed
    double key_deg = 0.5, key_m = 0.5e-3;  ///< what a key of the answer changes
    bool nothing = false;                  ///< no ring is played
    /// A person who feels by the skin; without, the finger knows exactly where the rings are, which tells the errors of
    /// cameras and sections.
    std::optional<SenseOptions> sense{};
    double hand_sd_m = 5e-3;        ///< of a person: how far off the own hand's height is thought to be, a trial
    std::uint64_t person_seed = 1;  ///< of all that a person does by chance
};

/// Draws angle and height as the paper does, in steps of the keys: -45° to 45°, and -10 to 10 mm.
void draw_surface(SurfaceOptions& options, std::mt19937_64& random);

struct SurfaceReport {
    bool done = false;     ///< the finger felt the surface at two places at least
    bool guessed = false;  ///< a person who felt less answered by chance
    std::size_t felt_places = 0;
    std::uint64_t shots = 0;
    double time_s = 0.0;                                 ///< from the first touch to the answer
    double angle_deg = 0.0, height_m = 0.0;              ///< the answer, in steps of the keys
    double angle_error_deg = 0.0, height_error_m = 0.0;  ///< the answer less the truth
    ShotCounts counts;
};

/// A finger that comes down at several places, stays where it feels its ring, and goes on to the next. The answer is
/// the line of least squares through what it felt. A person (`sense`) who felt it at less than two places guesses
/// within the range of draw_surface().
/// @throws Error{bad_argument} for measures that make no sense, and as ShotRings
[[nodiscard]] SurfaceReport find_surface(const Array& array, const SurfaceOptions& options,
                                         const std::function<void(const ShotReport&)>& told = {});

}  // namespace haptogram::live
