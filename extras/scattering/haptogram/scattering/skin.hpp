// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <complex>
#include <cstdint>
#include <span>
#include <vector>

#include "haptogram/acoustics/finger_sound.hpp"
#include "haptogram/array/medium.hpp"
#include "haptogram/scattering/shells.hpp"

namespace haptogram::scattering {

/// The values of acoustics/finger_sound.hpp for one size, by boundary elements: a capsule of seven radii, whose other
/// end stands for the hand, in one plane wave a tilt.
/// @param size      wave number times radius
/// @param elements  triangles a wavelength
[[nodiscard]] FingerSound::Values finger_sound_by_elements(const FingerSound::Grid& grid, double size, double elements);

/// The surface of a rigid body, on which the pressure is known at the panels' centres. It refers to the body.
class Skin {
public:
    explicit Skin(const Body& body);

    /// Time-averaged radiation pressure on each panel, Pa, inwards: the potential energy's less that of the kinetic
    /// one,
    /// (|p|² − |∇p|²/k²)/(4ρc²), where the gradient is along the skin (King 1934). A plane
    /// wave that meets a plane at right angles gives Hoshi's eq. 1 with α = 2. It is negative where the air's speed
    /// along the skin is higher than belongs to its pressure.
    /// @param pressure  total, Pa, one a panel
    [[nodiscard]] std::vector<float> radiation_pressure(std::span<const std::complex<float>> pressure,
                                                        double wave_number, const Medium& medium) const;
    /// The force of it on the whole body, N.
    [[nodiscard]] Vec3 force(std::span<const float> radiation) const;

private:
    /// What a neighbour's difference of pressure adds to the gradient, in two directions along the panel.
    struct Share {
        std::uint32_t panel;
        float along, across;
    };
    void add_shares(std::uint32_t panel, const std::vector<std::uint32_t>& near);

    const std::vector<Panel>& panels_;
    std::vector<std::vector<Share>> shares_;
};

}  // namespace haptogram::scattering
