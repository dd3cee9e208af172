// SPDX-License-Identifier: Apache-2.0
// Measurements for tools/bench.py that need the libraries themselves; prints one JSON object.
#include <fmt/core.h>

#include <nlohmann/json.hpp>

#include "haptogram/link/client.hpp"
#include "haptogram/link/transfer.hpp"
#include "simulated_board.hpp"
#include "simulated_transport.hpp"

namespace {

using namespace haptogram;

/// Underruns when two records of 100 channels with pulses of one tick alternate every `cycle_clocks`.
unsigned underruns(std::uint32_t cycle_clocks) {
    sim::SimulatedBoard board("tile-100");
    sim::SimulatedTransport line(board);
    link::Client client(line);
    client.identify();
    Image image;
    image.channels = board.parameters().channels;
    for (std::uint16_t i = 0; i < 2; ++i) {
        image.records.push_back({cycle_clocks, 1, 1, std::vector<std::uint16_t>(image.channels, i)});
        image.sequence.push_back({static_cast<std::uint16_t>(i + 1), 1});
    }
    link::upload(client, image);
    client.start(1, 2, 100);
    board.run(300ULL * 2 * cycle_clocks);
    return client.status().underruns;
}

/// The shortest cycle in which a new record can be loaded while the last one plays.
std::uint32_t shortest_cycle() {
    std::uint32_t cycle = 130;
    while (cycle > 20 && underruns(cycle - 1) == 0) --cycle;
    return cycle;
}

}  // namespace

int main() try {
    const nlohmann::ordered_json json = {{"shortest_cycle_clocks", shortest_cycle()}};
    fmt::print("{}\n", json.dump());
    return 0;
} catch (const std::exception& error) {
    fmt::print(stderr, "measure: {}\n", error.what());
    return 1;
}
