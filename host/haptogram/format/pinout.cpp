// SPDX-License-Identifier: Apache-2.0
#include "haptogram/format/pinout.hpp"

#include <fmt/core.h>

#include "haptogram/base/error.hpp"

namespace haptogram {

Pinout pinout(const std::string& board, const std::string& array) {
    Pinout found{load_board(board), {}, {}};
    found.array = find_array(array.empty() ? found.board.array : array);
    const std::vector<Element>& elements = found.array.elements;
    const std::uint32_t channels = found.board.parameters.channels;
    if (elements.size() != channels)
        throw bad_input(found.array.file,
                        fmt::format("{} elements but the board has {} channels ({}); name an array of as many elements",
                                    elements.size(), channels, found.board.name),
                        {"array"});
    for (std::uint32_t k = 0; k < channels; ++k) {
        PinoutRow row{found.board.outputs[k], k, {}, {}, elements[k].position};
        if (found.array.columns > 0) {
            row.row = k / found.array.columns;
            row.column = k % found.array.columns;
        }
        found.rows.push_back(std::move(row));
    }
    return found;
}

}  // namespace haptogram
