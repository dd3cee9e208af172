// SPDX-License-Identifier: Apache-2.0
#include "haptogram/format/focus_engine.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include "haptogram/base/error.hpp"

namespace haptogram {
namespace {

constexpr double turn = 2.0 * std::numbers::pi;

/// A length in units, as a signed word of `bits`.
std::int32_t units(const char* of, char axis, double metres, int bits) {
    const double limit = std::ldexp(1.0, bits - 1);
    const double rounded = std::round(metres / focus_unit_m);
    if (!(rounded >= -limit && rounded < limit))  // also for NaN
        throw bad_input("focus engine",
                        fmt::format("{} at {} = {} mm; expected {} mm or more and less than {} mm; move it nearer to "
                                    "the array's origin",
                                    of, axis, metres / millimetre, -limit / 128.0, limit / 128.0));
    return static_cast<std::int32_t>(rounded);
}

std::uint16_t low_half(std::int32_t value) { return static_cast<std::uint16_t>(value & 0xffff); }

// ---- What the FPGA does. Each function names the module that it follows.

constexpr int cordic_steps = 14;
constexpr int cordic_settled = 7;

struct Tables {
    std::array<std::int32_t, 1024> sine{};                 ///< of a quarter turn, rounded down (phasor_sum.v)
    std::array<std::uint32_t, cordic_steps> arctangent{};  ///< of a turn times 2^18 (polar.v)

    // No value is nearer than 0.0006 to one that would be rounded otherwise, so every machine has these tables.
    Tables() {
        for (std::size_t i = 0; i < sine.size(); ++i)
            sine[i] = static_cast<std::int32_t>(65536.0 * std::sin((static_cast<double>(i) + 0.5) * turn / 4096.0));
        for (int i = 0; i < cordic_steps; ++i)
            arctangent[static_cast<std::size_t>(i)] =
                static_cast<std::uint32_t>(std::lround(std::atan(std::ldexp(1.0, -i)) / turn * 0x1p18));
    }
};

const Tables& tables() {
    static const Tables instance;
    return instance;
}

std::int32_t signed_16(std::uint16_t word) { return static_cast<std::int16_t>(word); }

/// A coordinate of a focus, from the lower half and the two upper bits, of which one is the sign.
std::int32_t signed_18(std::uint16_t low, std::uint32_t high) {
    return static_cast<std::int32_t>(low) + static_cast<std::int32_t>(high & 1U) * 0x10000 -
           static_cast<std::int32_t>(high >> 1U & 1U) * 0x20000;
}

struct Way {
    std::uint16_t phase = 0;
    bool far = false;
};

/// focus_phase.v
Way phase_of(const GeometryWords& place, const FocusWords& focus, std::uint32_t wave_number) {
    std::uint64_t square = 0;
    bool far = false;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::int64_t difference =
            signed_18(focus[axis], static_cast<std::uint32_t>(focus[3] >> (2 * axis) & 3)) - signed_16(place[axis]);
        far = far || std::abs(difference) >= 0x20000;
        const std::int64_t kept =
            ((difference + 0x20000) & 0x3ffff) - 0x20000;  // of a far one, which then means nothing
        square += static_cast<std::uint64_t>(kept * kept) & 0x3ffffffffU;
    }
    // In sixteenths of a unit. A double holds the square exactly, so its root, rounded down, is exact.
    const auto root = static_cast<std::uint64_t>(std::sqrt(static_cast<double>(square << 8U)));
    const std::uint64_t turns = (2U * root + 1U) * wave_number;
    return {static_cast<std::uint16_t>((place[3] & 0xff00U) - (turns >> 16U)), far};
}

/// 2^17 times the sine of a phase (phasor_sum.v)
std::int32_t sine_of(std::uint16_t phase) {
    const std::size_t index = phase >> 4U & 1023U;
    const bool falls = (phase >> 14U & 1U) != 0;
    const std::int32_t value = 2 * tables().sine[falls ? 1023 - index : index] + 1;
    return phase >> 15U != 0 ? -value : value;
}

struct Polar {
    std::uint16_t angle = 0;
    std::uint32_t length = 0;
};

/// polar.v. Signed numbers are shifted to the right with their signs, which C++20 defines.
Polar polar_of(std::int32_t re, std::int32_t im) {
    const bool left = re < 0;
    std::int32_t x = left ? ~re : re;
    std::int32_t y = left ? ~im : im;
    std::uint32_t angle = (left ? 0x20000U : 0U) + 2U;
    bool mirrored = false;
    for (int step = 0; step < cordic_steps; ++step) {
        if (y < 0) {
            y = ~y;
            mirrored = !mirrored;
        }
        const std::int32_t turn_x = y >> step;
        y -= x >> step;
        if (step < cordic_settled) x += turn_x;
        const std::uint32_t arc = tables().arctangent[static_cast<std::size_t>(step)];
        angle += mirrored ? 0U - arc : arc;
    }
    return {static_cast<std::uint16_t>(angle >> 2U), static_cast<std::uint32_t>(x)};
}

/// focus_engine.v and phasor_sum.v
ChannelDrive drive_of(const GeometryWords& place, std::span<const FocusWords> foci, std::uint32_t wave_number,
                      std::uint16_t gain, bool whole) {
    ChannelDrive drive;
    std::int32_t re = 0;
    std::int32_t im = 0;
    for (const FocusWords& focus : foci) {
        const Way way = phase_of(place, focus, wave_number);
        drive.phase = way.phase;
        drive.far = drive.far || way.far;
        const std::int32_t amplitude = way.far ? 0 : focus[3] >> 8;
        re += sine_of(static_cast<std::uint16_t>(way.phase + 0x4000)) * amplitude >> 6;
        im += sine_of(way.phase) * amplitude >> 6;
    }
    const Polar sum = polar_of(re, im);
    const std::uint64_t length = sum.length >> 5U;
    const std::uint64_t amplitude = length == 0 ? 0
                                    : whole     ? 0xffff
                                                : std::min<std::uint64_t>(length * gain >> 14U, 0xffff);
    // 255 parts are 256 of 256.
    const std::uint64_t parts = ~place[3] & 0xffU;
    drive.amplitude = static_cast<std::uint16_t>(amplitude * (parts + (parts >> 7U)) >> 8U);
    if (foci.size() > 1) drive.phase = sum.angle;
    return drive;
}

}  // namespace

GeometryWords pack_geometry(Vec3 position, double offset_turns, double weight) {
    if (!std::isfinite(offset_turns))
        throw bad_input("focus engine", fmt::format("an offset of {} turns; expected a finite number", offset_turns));
    if (!(weight >= 0.0 && weight <= 1.0))
        throw bad_input("focus engine", fmt::format("a weight of {}; expected 0 to 1", weight));
    const double offset = std::round((offset_turns - std::floor(offset_turns)) * 256.0);
    const double lacks = std::round((1.0 - weight) * 255.0);
    return {low_half(units("an element", 'x', position.x, 16)), low_half(units("an element", 'y', position.y, 16)),
            low_half(units("an element", 'z', position.z, 16)),
            low_half(static_cast<std::int32_t>(256.0 * offset + lacks))};
}

bool weighs(std::span<const GeometryWords> geometry) {
    return std::ranges::any_of(geometry, [](const GeometryWords& words) { return (words[3] & 0xffU) != 0; });
}

FocusWords pack_focus(const Focus& focus) {
    if (!(focus.amplitude >= 0.0 && focus.amplitude <= 1.0))
        throw bad_input("focus engine", fmt::format("a focus of amplitude {}; expected 0 to 1", focus.amplitude));
    const std::int32_t x = units("a focus", 'x', focus.position.x, 18);
    const std::int32_t y = units("a focus", 'y', focus.position.y, 18);
    const std::int32_t z = units("a focus", 'z', focus.position.z, 18);
    const auto amplitude = static_cast<std::int32_t>(std::lround(focus.amplitude * 255.0));
    const auto high = [](std::int32_t value) { return value >> 16 & 3; };
    return {low_half(x), low_half(y), low_half(z), low_half(amplitude << 8 | high(z) << 4 | high(y) << 2 | high(x))};
}

Focus unpack_focus(const FocusWords& words) {
    const auto metres = [&](std::size_t axis) {
        return signed_18(words[axis], static_cast<std::uint32_t>(words[3] >> (2 * axis) & 3)) * focus_unit_m;
    };
    return {{metres(0), metres(1), metres(2)}, (words[3] >> 8) / 255.0};
}

std::vector<std::complex<double>> summed_drives(const Array& array, std::span<const Focus> foci) {
    const double k = turn / array.wavelength_m();
    std::vector<std::complex<double>> sums(array.elements.size());
    for (std::size_t m = 0; m < sums.size(); ++m) {
        const Element& element = array.elements[m];
        for (const Focus& focus : foci)
            sums[m] += std::polar(focus.amplitude, k * distance(element, focus.position) - std::arg(element.response));
    }
    return sums;
}

std::uint32_t wave_number_word(double wavelength_m) {
    const double word = std::round(focus_unit_m / wavelength_m * 0x1p27);
    if (!(word >= 1.0 && word < 0x1p18))
        throw bad_input("focus engine",
                        fmt::format("a wavelength of {} mm; expected more than 4 mm, and less than 1 km",
                                    wavelength_m / millimetre));
    return static_cast<std::uint32_t>(word);
}

std::uint16_t gain_word(double full) {
    // What the engine finds as the length of one focus of amplitude 1: CORDIC lengthens it by the product of
    // √(1 + 2^(−2·step)) over the steps.
    double length = 255.0 * 0x1p17 / 0x1p6 / 0x1p5;
    for (int step = 0; step < cordic_steps; ++step) length *= std::sqrt(1.0 + std::ldexp(1.0, -2 * step));
    if (!(full >= 0.61 && full <= static_cast<double>(most_record_foci)))
        throw bad_input("focus engine", fmt::format("full amplitude for sums of length {}; expected 0.61 to {}", full,
                                                    most_record_foci));
    return static_cast<std::uint16_t>(std::ceil(65535.0 * 0x1p14 / (length * full)));
}

FocusEngine focus_engine(const Array& array, double full) {
    FocusEngine engine{{}, wave_number_word(array.wavelength_m()), gain_word(full)};
    engine.geometry.reserve(array.elements.size());
    for (const Element& element : array.elements)
        engine.geometry.push_back(pack_geometry(element.position, std::arg(element.response) / turn,
                                                std::min(1.0, std::abs(element.aligning()))));
    return engine;
}

std::vector<ChannelDrive> engine_drives(const FocusEngine& engine, std::span<const FocusWords> foci, bool whole) {
    if (engine.geometry.empty())
        throw bad_input("focus engine", "it has no channels; give it the geometry of at least one");
    if (foci.empty() || foci.size() > most_record_foci)
        throw bad_input("focus engine",
                        fmt::format("{} foci in a record; expected 1 to {}", foci.size(), most_record_foci));
    if (engine.wave_number >= 1U << 18U)
        throw bad_input("focus engine",
                        fmt::format("a wave number of {}; it has 18 bits, so at most 262143", engine.wave_number));
    for (std::size_t i = 0; i < foci.size(); ++i)
        if ((foci[i][3] & 0xc0U) != 0)
            throw bad_input(
                "focus engine",
                fmt::format("focus {}: the last word is {:#06x}; expected 0 in bits 7 and 6", i + 1, foci[i][3]));
    std::vector<ChannelDrive> drives = engine_outputs(engine.geometry, engine.wave_number, engine.gain, foci, whole);
    for (ChannelDrive& drive : drives)
        if (drive.amplitude == 0) drive.phase = 0;
    return drives;
}

std::vector<ChannelDrive> engine_outputs(std::span<const GeometryWords> geometry, std::uint32_t wave_number,
                                         std::uint16_t gain, std::span<const FocusWords> foci, bool whole) {
    std::vector<ChannelDrive> drives;
    drives.reserve(geometry.size());
    for (const GeometryWords& place : geometry) drives.push_back(drive_of(place, foci, wave_number, gain, whole));
    return drives;
}

}  // namespace haptogram
