// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "haptogram/acoustics/finger_sound.hpp"
#include "haptogram/array/array.hpp"
#include "haptogram/hand/section.hpp"

namespace haptogram {

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
