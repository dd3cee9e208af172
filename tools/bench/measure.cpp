// SPDX-License-Identifier: Apache-2.0
// Measurements for tools/bench.py that need the libraries themselves; prints one JSON object.
#include <fmt/core.h>

#include <nlohmann/json.hpp>
#include <stdexcept>

#include "haptogram/link/client.hpp"
#include "haptogram/link/transfer.hpp"
#include "simulated_board.hpp"
#include "simulated_transport.hpp"

namespace {

using namespace haptogram;

/// Whether all records of 100 channels with pulses of the shortest length are in time when two of them alternate every
/// `cycle_clocks`.
bool in_time(std::uint32_t cycle_clocks) {
    sim::SimulatedBoard board("tile-100");
    sim::SimulatedTransport line(board);
    link::Client client(line);
    const auto pulse = static_cast<std::uint8_t>(client.identify().min_pulse_clocks);
    Image image;
    image.channels = board.parameters().channels;
    for (std::uint16_t i = 0; i < 2; ++i) {
        image.records.push_back({cycle_clocks, 1, pulse, std::vector<std::uint16_t>(image.channels, i)});
        image.sequence.push_back({static_cast<std::uint16_t>(i + 1), 1});
    }
    link::upload(client, image);
    client.enable();
    client.start(1, 2, 100);
    board.run(300ULL * 2 * cycle_clocks);
    const link::Status status = client.status();
    if (status.refused_records != 0 || !status.enabled) throw std::runtime_error("the board did not play the records");
    return status.underruns == 0;
}

/// The shortest cycle in which a new record can be loaded while the last one plays, less the pulse's clocks but the
/// first: in these a record waits for the end of the pulse.
std::uint32_t load_clocks() {
    std::uint32_t cycle = 150;
    while (in_time(cycle - 1)) --cycle;
    sim::SimulatedBoard board("tile-100");
    return cycle - (board.parameters().min_pulse_clocks - 1);
}

}  // namespace

int main() try {
    const nlohmann::ordered_json json = {{"load_clocks", load_clocks()}};
    fmt::print("{}\n", json.dump());
    return 0;
} catch (const std::exception& error) {
    fmt::print(stderr, "measure: {}\n", error.what());
    return 1;
}
