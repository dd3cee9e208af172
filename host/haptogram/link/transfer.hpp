// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>

#include "haptogram/base/progress.hpp"
#include "haptogram/image/image.hpp"
#include "haptogram/link/client.hpp"

namespace haptogram::link {

/// What an upload found and did, in frames: a record each, and the sequence in pieces as long.
struct Uploaded {
    std::size_t pieces = 0;   ///< that the image has
    std::size_t written = 0;  ///< that the board did not hold already
};

/// @throws Error{bad_input} saying why the image does not fit the board
void require_fits(const Image& image, const Identity& board, const std::string& where);

/// Brings an image into a board's memories. Asks for the digest of each piece first and writes only those that differ,
/// so that an upload which was cut off goes on where it was; then asks again. The caller has checked that the image
/// fits.
/// @throws Error{device} when the board's digests are still others after writing
Uploaded upload(Client& client, const Image& image, const Progress& progress = {});

/// Reads an image's places back, byte by byte. @return empty when they hold it, else the first difference in words
std::string compare(Client& client, const Image& image, const Progress& progress = {});

/// The image that a board's memories hold: its sequence, and as many records as that plays or as are asked for, if
/// more.
/// @param where  names the board in messages
/// @throws Error{device} when there is no sequence, Error{bad_input} when a record is none
Image download(Client& client, const Identity& board, std::uint32_t records, const std::string& where,
               const Progress& progress = {});

}  // namespace haptogram::link
