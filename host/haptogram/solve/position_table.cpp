// SPDX-License-Identifier: Apache-2.0
#include "haptogram/solve/position_table.hpp"

#include <fmt/core.h>

#include <complex>

#include "haptogram/base/error.hpp"
#include "haptogram/solve/drives.hpp"

namespace haptogram {

PositionTable position_table(const Array& array, std::span<const Vec3> positions, const Segments& segments) {
    PositionTable table{{positions.begin(), positions.end()}, array.elements.size(), {}};
    table.pulses.reserve(positions.size() * table.channels);
    for (std::size_t i = 0; i < positions.size(); ++i) {
        if (const std::string why = array.unreachable(positions[i]); !why.empty())
            throw bad_input(fmt::format("position {}", i + 1), why);
        const Focus focus{positions[i]};
        for (const std::complex<double>& drive : superposed_drives(array, {&focus, 1}))
            table.pulses.push_back(segment_pulse(drive, segments));
    }
    return table;
}

std::vector<std::vector<std::size_t>> square_units(const Array& array, std::size_t edge) {
    const std::size_t columns = array.columns;
    const std::size_t rows = columns == 0 ? 0 : array.elements.size() / columns;
    if (rows == 0 || edge == 0 || rows % edge != 0 || columns % edge != 0)
        throw bad_input(array.name, fmt::format("a grid of {} × {} elements; units of {} × {} need a grid whose rows "
                                                "and columns are multiples of it",
                                                rows, columns, edge, edge));
    std::vector<std::vector<std::size_t>> units(rows / edge * (columns / edge));
    for (std::size_t row = 0; row < rows; ++row)
        for (std::size_t column = 0; column < columns; ++column)
            units[row / edge * (columns / edge) + column / edge].push_back(row * columns + column);
    return units;
}

std::vector<std::uint8_t> packed(const PositionTable& table, std::span<const std::size_t> unit,
                                 const Segments& segments) {
    constexpr unsigned phase_bits = 4, amplitude_bits = 3;
    if (segments.count != 1U << phase_bits)
        throw bad_argument("segments", fmt::format("a grid of {} segments; the table's entries are of {}",
                                                   segments.count, 1U << phase_bits));
    std::vector<std::uint8_t> bytes((table.positions.size() * unit.size() * (phase_bits + amplitude_bits) + 7) / 8);
    std::size_t next = 0;
    const auto put = [&](std::uint32_t value, unsigned bits) {
        for (unsigned bit = bits; bit-- > 0; ++next)
            if ((value >> bit & 1U) != 0) bytes[next / 8] |= static_cast<std::uint8_t>(0x80U >> next % 8);
    };
    for (std::size_t position = 0; position < table.positions.size(); ++position)
        for (const std::size_t channel : unit) {
            const SegmentPulse& pulse = table.at(position, channel);
            if (pulse.length == 0)
                throw bad_argument("table", fmt::format("channel {} is silent at position {}; an entry of three bits "
                                                        "has no silence",
                                                        channel, position + 1));
            put(pulse.start, phase_bits);
            put(pulse.length - 1, amplitude_bits);
        }
    return bytes;
}

}  // namespace haptogram
