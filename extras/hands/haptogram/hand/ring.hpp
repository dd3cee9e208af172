// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "haptogram/acoustics/finger_sound.hpp"
#include "haptogram/array/array.hpp"
#include "haptogram/format/path.hpp"
#include "haptogram/hand/surface.hpp"
#include "haptogram/hand/touch.hpp"

namespace haptogram {

/// What plays on a finger (Fingers, section 3, "Haptic feedback").
enum class FocusMotion {
    revolving,  ///< around the section's outline
    still,      ///< the paper's control: in the section's middle. A focus that does not move is only felt when it is
                ///< modulated, so it is, by a sine; the paper does not say by what
    pressing,   ///< several at once that turn slowly around the section's middle, as algorithm L has them
};

struct RingOptions {
    FocusMotion motion = FocusMotion::revolving;
    std::size_t points = 10;  ///< of a turn; of pressing foci, of each one's way to the place of the next, after which
                              ///< all is as before and can be repeated
    double turns_hz = 100.0;  ///< 10 points at 100 Hz are the paper's 1 ms each
    double still_am_hz = 200.0;  ///< of the still focus, a multiple of turns_hz below half the rate of points
    PressOptions press;
    /// Foci of each section in a step.
    [[nodiscard]] std::size_t foci() const { return motion == FocusMotion::pressing ? press.foci : 1; }
    /// How often a second the path begins anew.
    [[nodiscard]] double passes_hz() const {
        return motion == FocusMotion::pressing ? press.turns_hz * press.foci : turns_hz;
    }
};
/// The longest step of a pressing focus that is still felt as steady pressure, metres (Morisaki et al. 2022: below 1
/// mm).
inline constexpr double longest_press_step_m = 1e-3;
/// @throws Error{bad_argument} naming what makes no sense
void require_sound(const RingOptions& options);

/// What is left of the fundamental of a still focus' radiation pressure, because each step holds it: sin(π/m)/(π/m)
/// with m steps in a wave of still_am_hz.
[[nodiscard]] double held_fundamental(const RingOptions& options);

/// Points on an ellipse at equal distances along it, in the right-hand direction about its normal, the first one as
/// near as possible to `start`.
[[nodiscard]] std::vector<Vec3> ring_points(const Ellipse& ellipse, std::size_t count,
                                            const std::optional<Vec3>& start = {});

/// One pass on several fingers at once: in step j the j-th point of each, and of pressing foci all those of a finger
/// before those of the next one. All steps last equally long, in whole carrier
/// periods.
/// @param starts   of each section, where its focus is now; a place for each
/// @throws Error{bad_argument} when a step would last less than a carrier period
[[nodiscard]] Path ring_path(std::span<const Ellipse> sections, std::span<const std::optional<Vec3>> starts,
                             double carrier_hz, const RingOptions& options = {});

/// A finger as far as the sound around it needs it: half a sphere, and a cylinder behind it.
struct FingerForm {
    Vec3 tip{};      ///< the middle of the half sphere
    Vec3 to_hand{};  ///< length 1
    double radius = 0.0;
};

/// A finger in the surface of an object, as it is seen.
struct FingerCut {
    Ellipse section;  ///< where the surface cuts the finger
    Vec3 inward;      ///< into the object, length 1
    Vec3 inside;      ///< a place amid what is inside
    double deepest_m = 0.0;
};

/// What a surface makes of a finger whose form is known. @param at  a point of the surface
/// @return nothing when the surface does not cut it like a finger
[[nodiscard]] std::optional<FingerCut> contact_of(const FingerForm& finger, Vec3 at, Vec3 inward);

/// The form that a contact lets expect. A shallow section is a circle of the round end, whatever way the finger comes:
/// then it is taken to come straight. @return nothing when it is larger than a finger
[[nodiscard]] std::optional<FingerForm> form_of(const FingerCut& contact);

/// What an array can do at the places of a ring around a finger.
struct RingReach {
    std::vector<double> radiation_pa;  ///< on the skin, of a focus there with full amplitude
    std::vector<double> amplitudes;    ///< with which all places that are reached get the same; 0 where none is
    std::size_t reached = 0;           ///< places that get more of the sound aimed at them than any other of the ring
    double uneven = 0.0;               ///< the most over the least, of those that are reached
    double even_pa = 0.0;              ///< on the skin, with those amplitudes
};

/// Weighs a ring's foci by what the finger itself makes of their sound (acoustics/finger_sound.hpp): the sum over the
/// array's elements, in phase in free air. Elements that are near to each other count as one.
class RingWeigher {
public:
    explicit RingWeigher(const Array& array, const FingerSound& sound = shipped_finger_sound());

    /// @param places  on the skin, the ring's foci
    /// @return nothing for fingers of a size that the table does not have, and when no place is reached
    [[nodiscard]] std::optional<RingReach> weigh(std::span<const Vec3> places, const FingerForm& finger);
    /// Radiation pressure at places of a finger's skin of foci with full amplitude, Pa: of each focus, of each place.
    /// @return nothing for fingers of a size that the table does not have
    [[nodiscard]] std::optional<std::vector<double>> radiation_pa(std::span<const Vec3> skin,
                                                                  std::span<const Vec3> foci, const FingerForm& finger);
    /// Radii that it knows, metres.
    [[nodiscard]] std::array<double, 2> radii_m() const;

private:
    /// Elements that are near to each other, and how the sound that they send comes to the present finger.
    struct Source {
        Vec3 position{}, normal{};
        double strength = 0.0;
        std::size_t elements = 0;
        float pressure = 0.0F, tilt = 0.0F, turn = 0.0F;  ///< angles in steps of the table
    };
    /// The finger's frame.
    struct Frame {
        Vec3 across, aside;
    };
    /// Of each point, of each source: real and imaginary parts.
    struct Waves {
        std::vector<float> real, imaginary;
    };
    void add(const Element& element, double source_pa_m);
    void meet(Source& source, Vec3 middle, const FingerForm& finger, const Frame& frame) const;
    [[nodiscard]] Waves ways_to(std::span<const Vec3> points) const;
    void put_on_skin(Waves& ways, std::size_t place, Vec3 position, const FingerForm& finger, const Frame& frame);

    const FingerSound& sound_;
    double wave_number_, absorption_np_m_, per_square_pa_;
    std::vector<Source> sources_;
    std::vector<double> directivity_;  ///< over the cosine, even steps from −1 to 1
    FingerSound::Values of_size_, slice_;
};

/// In words, what a ring around a usual finger becomes that touches a place from above: straight, and aslant; empty
/// where it has none.
/// @param points  of the ring
[[nodiscard]] std::string reach_in_words(const Array& array, Vec3 place, std::size_t points);

}  // namespace haptogram
