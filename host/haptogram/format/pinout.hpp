// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "haptogram/format/board.hpp"

namespace haptogram {

/// Which pin of a board drives which element of an array.
struct PinoutRow {
    Board::Output output;
    std::uint32_t channel = 0;
    std::optional<std::uint32_t> row, column;  ///< of the element, in an array that is a grid
    Vec3 position;                             ///< of the element, metres
};

struct Pinout {
    Board board;
    Array array;
    std::vector<PinoutRow> rows;  ///< one an element
};

/// @param array  name or file; empty for the one that the board's file names
/// @throws Error{bad_input} unless the array has as many elements as the board has channels: otherwise a cable that is
/// made by this table would not fit
[[nodiscard]] Pinout pinout(const std::string& board, const std::string& array = {});

}  // namespace haptogram
