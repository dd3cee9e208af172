// SPDX-License-Identifier: Apache-2.0
// A whole program on link::Client: brings an image into a board and plays it once. Usage: haptogram_example PORT
// IMAGE.hex
#include <chrono>
#include <cstdio>
#include <thread>

#include "haptogram/base/file.hpp"
#include "haptogram/link/port.hpp"
#include "haptogram/link/transfer.hpp"

int main(int argc, char** argv) try {
    using namespace haptogram;
    if (argc != 3) throw Error(ErrorCode::bad_argument, "haptogram_example", "expected a port and an image");
    const auto port = link::open_port(argv[1], 1'000'000);
    link::Client board(*port);
    const link::Identity identity = board.identify();
    const Image image = from_intel_hex(read_file(argv[2]), argv[2]);
    link::require_fits(image, identity, argv[2]);
    link::upload(board, image);
    board.enable();  // from here on the watchdog turns them off 500 ms after the last request, whatever ends this
                     // program
    board.start(1, static_cast<std::uint16_t>(image.sequence.size()), 1);
    while (board.status().mode != 0) std::this_thread::sleep_for(std::chrono::milliseconds(50));
    board.disable();
    return 0;
} catch (const haptogram::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return static_cast<int>(error.code());
}
