// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "haptogram/array/array.hpp"
#include "haptogram/format/bundle.hpp"
#include "haptogram/format/core.hpp"
#include "haptogram/format/image.hpp"
#include "haptogram/format/path.hpp"

namespace haptogram {

/// An image of focus records, and what they mean.
struct FocusImage {
    Image image;
    Timer timer;
    std::vector<RecordMeaning> records;  ///< in the order of the image's places
    FocusMeaning meaning;
    std::vector<std::string> warnings;  ///< whole sentences
};

/// Whether focus records are in a board's memory, which limits their number, or come over the line as they are due.
enum class FociFrom { memory, line };

/// A path as focus records, for a board that computes phases and amplitudes by itself (rtl/amplitudes/focus_engine.v).
/// Steps with the same foci, rounded as the board has them, share a record. All records have as many foci as the
/// largest step; weaker steps are filled up with foci of amplitude 0. A channel's amplitude is the length of its sum of
/// foci over the longest sum of the path, or over 1 where no sum is longer, so that a lone focus of amplitude 1 has the
/// array's full duty and several keep their ratio. The path's modulation becomes samples of the board's own, which runs
/// beside the sequence.
/// @param loops   passes of the sequence; 0 is for ever
/// @param boards  that share the array's elements, each with as many as `core` has channels; the image is of all of
/// them
/// @throws Error{bad_input} naming the step, for a focus that the board cannot hold or that is too far from an element,
/// for more foci at a time than the board takes, and when the records, the sequence or the samples do not fit the
/// board; and when the array has not one element for each channel, because the board computes all of them
[[nodiscard]] FocusImage focus_image_of(const Path& path, const Array& array, const Core& core, std::uint16_t loops,
                                        std::size_t boards = 1, FociFrom from = FociFrom::memory);

}  // namespace haptogram
