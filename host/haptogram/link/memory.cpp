// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/memory.hpp"

#include <zlib.h>

#include <utility>

#include "haptogram/format/image.hpp"

namespace haptogram::link {

using interface::Command;

Request asking(Command command, const Piece& piece) {
    return asking_request(command, piece.address, piece.bytes.size());
}

Request writing(const Piece& piece) { return write_request(piece.address, piece.bytes); }

std::vector<Request> writing(const std::vector<Piece>& pieces) {
    std::vector<Request> requests;
    requests.reserve(pieces.size());
    for (const Piece& piece : pieces) requests.push_back(writing(piece));
    return requests;
}

std::vector<Request> asking(Command command, const std::vector<Piece>& pieces) {
    std::vector<Request> requests;
    requests.reserve(pieces.size());
    for (const Piece& piece : pieces) requests.push_back(asking(command, piece));
    return requests;
}

std::vector<Piece> differing(Commands& device, const std::vector<Piece>& pieces, const Progress& progress) {
    return differing(pieces, device.pipeline(asking(Command::digest, pieces), progress));
}

std::vector<Piece> differing(const std::vector<Piece>& pieces, const std::vector<Reply>& digests) {
    std::vector<Piece> found;
    for (std::size_t i = 0; i < pieces.size(); ++i) {
        const auto digest = static_cast<std::uint32_t>(
            ::crc32(0, pieces[i].bytes.data(), static_cast<unsigned>(pieces[i].bytes.size())));
        const Bytes expected = {static_cast<std::uint8_t>(digest), static_cast<std::uint8_t>(digest >> 8),
                                static_cast<std::uint8_t>(digest >> 16), static_cast<std::uint8_t>(digest >> 24)};
        if (digests[i].data != expected) found.push_back(pieces[i]);
    }
    return found;
}

Bytes contents(Commands& device, std::uint32_t address, std::size_t bytes, const Progress& progress) {
    // Whole words of either memory.
    const std::size_t most = std::size_t{2} * record_words(device.identity().channels) / 4 * 4;
    std::vector<Request> requests;
    for (std::size_t at = 0; at < bytes; at += most)
        requests.push_back(
            asking_request(Command::read, address + static_cast<std::uint32_t>(at), std::min(most, bytes - at)));
    Bytes found;
    for (const Reply& reply : device.pipeline(std::move(requests), progress))
        found.insert(found.end(), reply.data.begin(), reply.data.end());
    return found;
}

}  // namespace haptogram::link
