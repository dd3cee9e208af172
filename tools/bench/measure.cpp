// SPDX-License-Identifier: Apache-2.0
// Measurements for tools/bench.py that need the libraries themselves; prints one JSON object.
#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <random>

#include "haptogram/link/client.hpp"
#include "haptogram/link/transfer.hpp"
#include "haptogram/solve/focal_law.hpp"
#include "simulated_transport.hpp"

namespace {

using namespace haptogram;

/// Median time of one call in milliseconds.
template <class Call>
double median_ms(int repeats, Call call) {
    std::vector<double> times;
    for (int i = 0; i < repeats; ++i) {
        const auto begun = std::chrono::steady_clock::now();
        call();
        times.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begun).count());
    }
    std::nth_element(times.begin(), times.begin() + repeats / 2, times.end());
    return times[static_cast<std::size_t>(repeats / 2)];
}

double focal_law_ms() {
    const Array array = find_array("tile-10x10");
    const Timer timer = choose_timer(array, core_of_array("tile-10x10"));
    std::mt19937 generator(1);
    std::uniform_real_distribution<double> lateral(-0.05, 0.05);
    std::vector<Vec3> foci(100'000);
    for (Vec3& f : foci) f = {lateral(generator), lateral(generator), 0.13 + lateral(generator)};
    std::size_t sink = 0;
    const double ms = median_ms(15, [&] { sink += focal_law(array, timer, foci).back(); });
    return sink == 0 ? 0.0 : ms;
}

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
    const nlohmann::ordered_json json = {{"focal_law_ms", focal_law_ms()},
                                         {"focal_law_target", focal_law_target()},
                                         {"shortest_cycle_clocks", shortest_cycle()}};
    fmt::print("{}\n", json.dump());
    return 0;
} catch (const std::exception& error) {
    fmt::print(stderr, "measure: {}\n", error.what());
    return 1;
}
