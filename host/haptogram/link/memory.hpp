// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "haptogram/base/progress.hpp"
#include "haptogram/link/commands.hpp"

namespace haptogram::link {

/// The part of a device's memory, as it is or as it shall be, that one frame carries.
struct Piece {
    std::uint32_t address = 0;
    Bytes bytes;
};

/// Cuts words into pieces of at most this many bytes, little-endian, and appends them.
/// @param base  the address of the first word
template <class Word>
void cut(std::vector<Piece>& pieces, std::uint32_t base, const std::vector<Word>& words, std::size_t bytes) {
    const std::size_t most = bytes / sizeof(Word);
    for (std::size_t at = 0; at < words.size(); at += most) {
        Piece& piece = pieces.emplace_back(Piece{base + static_cast<std::uint32_t>(sizeof(Word) * at), {}});
        for (std::size_t i = at; i < std::min(at + most, words.size()); ++i)
            for (std::size_t byte = 0; byte < sizeof(Word); ++byte)
                piece.bytes.push_back(static_cast<std::uint8_t>(words[i] >> (8 * byte)));
    }
}

/// The words that little-endian bytes make.
template <class Word>
[[nodiscard]] std::vector<Word> words_of(const Bytes& bytes) {
    std::vector<Word> words(bytes.size() / sizeof(Word));
    for (std::size_t i = 0; i < words.size() * sizeof(Word); ++i)
        words[i / sizeof(Word)] =
            static_cast<Word>(words[i / sizeof(Word)] | Word{bytes[i]} << (8U * (i % sizeof(Word))));
    return words;
}

/// A READ or DIGEST of a piece, with the piece's length.
[[nodiscard]] Request asking(interface::Command command, const Piece& piece);
[[nodiscard]] std::vector<Request> asking(interface::Command command, const std::vector<Piece>& pieces);
/// The WRITE of a piece.
[[nodiscard]] Request writing(const Piece& piece);
[[nodiscard]] std::vector<Request> writing(const std::vector<Piece>& pieces);

/// The pieces that a device does not hold, told by its replies to a DIGEST of each.
[[nodiscard]] std::vector<Piece> differing(const std::vector<Piece>& pieces, const std::vector<Reply>& digests);
/// The same; it asks for them.
[[nodiscard]] std::vector<Piece> differing(Commands& device, const std::vector<Piece>& pieces,
                                           const Progress& progress = {});

/// What a device holds from an address on, read in frames of at most a record.
[[nodiscard]] Bytes contents(Commands& device, std::uint32_t address, std::size_t bytes, const Progress& progress = {});

}  // namespace haptogram::link
