// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <complex>
#include <cstdint>
#include <span>
#include <vector>

#include "haptogram/array/array.hpp"
#include "haptogram/format/path.hpp"

namespace haptogram {

// The FPGA's focus engine (rtl/amplitudes/focus_engine.v): the words that it takes, and the words that it gives, to the
// last bit.

inline constexpr double focus_unit_m = millimetre / 128.0;  ///< in which the engine counts lengths
inline constexpr std::size_t most_record_foci = 8;          ///< of a record

/// A channel's place, x, y and z in units; then the offset that is added to its phase, of a turn times 256, in bits
/// 15:8, and what its amplitude lacks of full, times 255, in bits 7:0.
using GeometryWords = std::array<std::uint16_t, 4>;
/// A focus: the lower halves of x, y and z in units; then the amplitude in bits 15:8, 0 in bits 7:6, and the upper bits
/// of z, y and x in 5:4, 3:2 and 1:0.
using FocusWords = std::array<std::uint16_t, 4>;

/// What the engine is set up with.
struct FocusEngine {
    std::vector<GeometryWords> geometry;  ///< one a channel
    std::uint32_t wave_number = 0;        ///< turns a unit times 2^27, 18 bits
    std::uint16_t gain = 0;               ///< of the amplitude
    friend bool operator==(const FocusEngine&, const FocusEngine&) = default;
};

/// What the engine computes for a channel.
struct ChannelDrive {
    std::uint16_t phase = 0;      ///< where in the carrier period the middle of the pulse lies, times 2^16: a nearer
                                  ///< channel plays later. 0 where the amplitude is 0; the FPGA's is then undefined
    std::uint16_t amplitude = 0;  ///< 65535: full
    bool far = false;             ///< a focus was too far from the channel to count, 1.024 m or more in a coordinate
    friend bool operator==(const ChannelDrive&, const ChannelDrive&) = default;
};

/// @param position      metres, in the array's frame, each coordinate from −256 mm to less than 256 mm
/// @param offset_turns  of the carrier period; whole turns do not count
/// @param weight        of full amplitude, 0 to 1
/// @throws Error{bad_input} when a number is out of its range or not finite
[[nodiscard]] GeometryWords pack_geometry(Vec3 position, double offset_turns = 0.0, double weight = 1.0);

/// Whether a channel lacks some of its amplitude, of which boards of protocol 2.4 know nothing: they add the whole word
/// to the phase.
[[nodiscard]] bool weighs(std::span<const GeometryWords> geometry);

/// @param focus  each coordinate from −1.024 m to less than 1.024 m, the amplitude from 0 to 1
/// @throws Error{bad_input} when a number is out of its range
[[nodiscard]] FocusWords pack_focus(const Focus& focus);

/// @param wavelength_m  more than 4 mm, because the word has 18 bits
/// @throws Error{bad_input} when it is not
[[nodiscard]] std::uint32_t wave_number_word(double wavelength_m);

/// The gain with which a sum of foci has full amplitude when its length is `full`; longer sums are cut off there. A
/// lone focus of amplitude 1 has length 1, eight that meet in phase have 8.
/// @param full  0.61 to 8
/// @throws Error{bad_input} when it is not
[[nodiscard]] std::uint16_t gain_word(double full);

/// The focus that such words stand for, rounded as they are.
[[nodiscard]] Focus unpack_focus(const FocusWords& words);

/// The sums that the engine rounds: Σ amplitude · e^{jkR} over the foci, one an element, R being an element's distance
/// from a focus, less its response's phase, also of dead ones. At the length of the gain's `full`, amplitude is full
/// for the weight 1.
[[nodiscard]] std::vector<std::complex<double>> summed_drives(const Array& array, std::span<const Focus> foci);

/// The engine for an array, element k on channel k; offsets take the phases of the elements' responses away, and
/// dead ones are silent.
/// @throws Error{bad_input} when an element is too far from the array's origin, or as gain_word and wave_number_word do
[[nodiscard]] FocusEngine focus_engine(const Array& array, double full = 1.0);

/// What the FPGA computes, bit by bit, by the arithmetic that focus_phase.v, phasor_sum.v and polar.v describe.
/// @param foci   1 to 8
/// @param whole  all channels at full amplitude, whatever the length of their sums, except sums of length 0
/// @return one a channel
/// @throws Error{bad_input} when there are no channels, no foci or more than 8, or when a word has bits where 0 must be
[[nodiscard]] std::vector<ChannelDrive> engine_drives(const FocusEngine& engine, std::span<const FocusWords> foci,
                                                      bool whole = false);
/// The same for words that have been looked at, with the phases that the FPGA's registers have where the amplitude is
/// 0.
[[nodiscard]] std::vector<ChannelDrive> engine_outputs(std::span<const GeometryWords> geometry,
                                                       std::uint32_t wave_number, std::uint16_t gain,
                                                       std::span<const FocusWords> foci, bool whole);

}  // namespace haptogram
