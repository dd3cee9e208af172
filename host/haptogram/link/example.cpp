// SPDX-License-Identifier: Apache-2.0
// A whole program on link::Device: brings an image into a board and plays it once.
// Usage: haptogram_example PORT IMAGE.hex
#include <chrono>
#include <cstdio>

#include "haptogram/base/file.hpp"
#include "haptogram/link/device.hpp"
#include "haptogram/link/outputs.hpp"
#include "haptogram/link/transfer.hpp"

int main(int argc, char** argv) try {
    using namespace haptogram;
    if (argc != 3) throw Error(ErrorCode::bad_argument, "haptogram_example", "expected a port and an image");
    link::Device board({.port = argv[1]});
    const Image image = from_intel_hex(read_file(argv[2]), argv[2]);
    link::require_fits(image, board.identity(), argv[2]);
    link::upload(board, image);
    // The board's watchdog turns the outputs off 500 ms after the last request, should this program die meanwhile.
    link::while_on(board, 500, [&] {
        board.start(1, static_cast<std::uint16_t>(image.sequence.size()), 1);
        while (!link::is_over(link::sure_status(board))) board.clock().rest(std::chrono::milliseconds(50));
    });
    return 0;
} catch (const haptogram::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return error.code() == haptogram::ErrorCode::device ? 4 : 1;  // 4: as the program haptogram says of a board
}
