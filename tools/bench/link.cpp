// SPDX-License-Identifier: Apache-2.0
// The link's numbers, measured at the simulated board's line and pins, in its time: no clock of this machine is in
// them.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <random>
#include <vector>

#include "haptogram/link/client.hpp"
#include "haptogram/link/live_feed.hpp"
#include "haptogram/link/transfer.hpp"
#include "playback.hpp"
#include "simulated_board.hpp"
#include "simulated_transport.hpp"

namespace {

using namespace haptogram;
using Json = nlohmann::ordered_json;

constexpr std::string_view tile = "tile-100";

/// Focal points of one pulse a cycle at 40 kHz whose first element fires at tick 0, as the focal law makes them.
Image image_of(const interface::CoreParameters& p, std::uint16_t points) {
    std::mt19937 generator(3);
    Image image;
    image.channels = p.channels;
    image.clock_hz = p.clock_hz;
    for (std::uint16_t i = 1; i <= points; ++i) {
        Record record{250, 5, 125, std::vector<std::uint16_t>(p.channels)};
        for (auto& timing : record.timings) timing = static_cast<std::uint16_t>(generator() % 250);
        record.timings.front() = 0;
        image.records.push_back(std::move(record));
        image.sequence.push_back({i, 1});
    }
    return image;
}

/// Payload over what 8N1 allows: of the writing alone, with the window open, and of the whole upload with its digests.
Json upload_shares(std::string_view model) {
    sim::SimulatedBoard board(model);
    sim::SimulatedTransport line(board);
    link::Client client(line);
    client.identify();
    const interface::CoreParameters& p = board.parameters();
    const Image image = image_of(p, 200);
    const double bits = 10.0 * static_cast<double>(2 * primary_words(image).size() + 4 * sequence_words(image).size());
    const std::uint64_t begun = board.now();
    std::uint64_t writes = 0;
    std::uint64_t written = 0;
    link::upload(client, image, [&](double fraction, std::string_view) {
        if (fraction <= 0.05) writes = board.now();
        if (fraction <= 0.95) written = board.now();
        return true;
    });
    const auto share = [&](std::uint64_t clocks) { return bits * p.clock_hz / p.baud / static_cast<double>(clocks); };
    return {{"baud", p.baud},
            {"writing", share(written - writes)},
            {"with_digests", share(board.now() - begun)},
            {"retransmissions", client.retransmissions()}};
}

/// Indices at one carrier cycle each, through the live FIFO.
Json stream(std::string_view model, std::uint64_t count) {
    sim::SimulatedBoard board(model);
    const Image image = image_of(board.parameters(), 200);
    sim::load_directly(board, image);
    sim::PulseRecorder recorder(board);
    sim::SimulatedTransport line(board);
    link::Client client(line);
    const link::Identity identity = client.identify();
    client.enable();
    link::LiveFeed fifo(client, identity);
    for (std::uint64_t sent = 0; sent < count;) {
        if (fifo.room() < fifo.frame()) {
            fifo.refresh();
            continue;
        }
        std::vector<std::uint16_t> indices;
        for (; sent < count && indices.size() < fifo.frame(); ++sent)
            indices.push_back(static_cast<std::uint16_t>(1 + sent % 200));
        fifo.push(indices, 1);
    }
    client.wait();
    client.push({0}, 0);
    board.run_until([&] { return board.outputs().index == 0; }, 10'000'000);
    board.run(5000);
    std::uint64_t played = 0;
    std::uint64_t in_order = 0;
    std::uint64_t first = 0;
    std::uint64_t last = 0;
    for (const sim::CycleStart& cycle : recorder.cycles()) {
        if (cycle.index == 0) continue;
        if (played == 0) first = cycle.clock;
        in_order += cycle.index == 1 + played % 200 ? 1 : 0;
        ++played;
        last = cycle.clock;
    }
    const double seconds = static_cast<double>(last - first) / board.parameters().clock_hz;
    return {{"indices", count},
            {"cycles_in_order", in_order},
            {"cycles", played},
            {"per_second", static_cast<double>(played - 1) / seconds},
            {"underruns", client.status().underruns}};
}

/// Clocks from the end of a SELECT frame's last bit to the first rising edge of the new focus, over random phases.
Json select_latency(std::string_view model, std::size_t count) {
    sim::SimulatedBoard board(model);
    const interface::CoreParameters& p = board.parameters();
    sim::load_directly(board, image_of(p, 2));
    sim::SimulatedTransport line(board);
    link::Client client(line);
    client.identify();
    client.enable();
    client.select(1);
    std::uint64_t edge = 0;
    std::uint16_t wanted = 0;
    board.on_edge([&](const sim::Edge& e) {
        if (edge == 0 && e.rises && e.index == wanted) edge = e.clock;
    });
    std::mt19937 generator(11);
    std::vector<std::uint64_t> latencies;
    const auto stop_bit = static_cast<std::uint64_t>(static_cast<double>(p.clock_hz) / p.baud);
    for (std::size_t i = 0; i < count; ++i) {
        wanted = static_cast<std::uint16_t>(2 - i % 2);
        board.run(generator() % 1250);
        client.submit({interface::Command::select, {static_cast<std::uint8_t>(wanted), 0, 0, 0}});
        client.flush();
        edge = 0;
        while (!board.line_idle()) board.run(1);  // idle from the last stop bit's beginning on
        const std::uint64_t end = board.now() + stop_bit;
        if (!board.run_until([&] { return edge != 0; }, 100'000)) throw std::runtime_error("a SELECT was not played");
        latencies.push_back(edge - end);
        client.wait();
    }
    std::ranges::sort(latencies);
    Json percentiles;
    for (const unsigned percent : {0U, 10U, 25U, 50U, 75U, 90U, 99U, 100U})
        percentiles[std::to_string(percent)] = latencies[(latencies.size() - 1) * percent / 100];
    return {{"selects", count}, {"bound", 1250 + p.channels + 16}, {"percentiles", percentiles}};
}

}  // namespace

int main() try {
    fmt::print("{}\n", Json{{"upload", {upload_shares(tile), upload_shares("tile-100-3m")}},
                            {"stream", stream(tile, 20'000)},
                            {"select", select_latency(tile, 10'000)}}
                           .dump());
    return 0;
} catch (const std::exception& error) {
    fmt::print(stderr, "link: {}\n", error.what());
    return 1;
}
