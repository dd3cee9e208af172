// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string_view>
#include <utility>
#include <vector>

#include "haptogram/link/client.hpp"
#include "haptogram/link/clock.hpp"
#include "haptogram/link/focus_ring.hpp"
#include "haptogram/live/depth_source.hpp"
#include "haptogram/live/loop.hpp"
#include "haptogram/live/players.hpp"
#include "haptogram/live/shot_rings.hpp"
#include "reference_board.hpp"
#include "simulated_transport.hpp"

/// A reference board on its simulated line, whose clock is the loop's, and what its pins begin to play.
struct LiveBench {
    explicit LiveBench(const haptogram::interface::CoreConfiguration& configuration)
        : board(configuration), line(board), client(line) {
        board.on_cycle_start([this](const haptogram::sim::CycleStart& c) {
            if (c.enabled && (starts.empty() || starts.back().second != c.index))
                starts.emplace_back(seconds(c.clock), c.index);
        });
        client.identify();
    }
    explicit LiveBench(std::string_view configuration)
        : LiveBench(*haptogram::interface::find_configuration(configuration)) {}
    /// Where the board keeps the foci that are pushed to it.
    [[nodiscard]] haptogram::link::FocusRing ring() { return haptogram::link::make_ring(client); }
    [[nodiscard]] double seconds(std::uint64_t clocks) const {
        return static_cast<double>(clocks) / board.parameters().clock_hz;
    }

    haptogram::sim::ReferenceBoard board;
    haptogram::sim::SimulatedTransport line;
    haptogram::link::Client client;
    haptogram::link::Clock& clock = line.clock();
    std::vector<std::pair<double, std::uint16_t>> starts;  ///< changes of the record: when, and its index
};

/// What a loop of depth is made of.
struct DepthOptions : haptogram::live::FingerOptions, haptogram::live::LoopOptions {
    haptogram::Method method = haptogram::Method::distance_weighted;
};

/// Depth to rings of records on a board.
class DepthLoop {
public:
    using Told = std::function<bool(const haptogram::live::ShotReport&, const haptogram::DepthShot&)>;

    DepthLoop(haptogram::link::Commands& device, haptogram::link::Clock& clock, const haptogram::Array& array,
              const DepthOptions& options)
        : device_(device),
          clock_(clock),
          array_(array),
          options_(options),
          player_(device, clock, array, options.ring.points, options.method, options.watchdog_ms) {}

    haptogram::live::LoopReport run(haptogram::DepthSource& source, const Told& told = {},
                                    const std::function<bool()>& waits = {}) {
        using namespace haptogram::live;
        DepthFrames frames(source);
        ShotRings rings(array_, player_.timer().carrier_hz(), options_, source.cameras());
        return Loop(device_, clock_, player_, options_)
            .run(
                frames, rings,
                [&](const ShotReport& shot, const Frame& frame, const std::optional<haptogram::Path>&) {
                    return !told || told(shot, std::get<haptogram::DepthShot>(frame.seen));
                },
                waits);
    }

private:
    haptogram::link::Commands& device_;
    haptogram::link::Clock& clock_;
    haptogram::Array array_;
    DepthOptions options_;
    haptogram::live::RingPlayer player_;
};
