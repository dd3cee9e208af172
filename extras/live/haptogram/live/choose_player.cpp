// SPDX-License-Identifier: Apache-2.0
#include "haptogram/live/choose_player.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "haptogram/base/error.hpp"
#include "haptogram/format/image.hpp"
#include "haptogram/format/interface.hpp"
#include "haptogram/live/ring_player.hpp"

namespace haptogram::live {
namespace {

constexpr double record_frame_bytes = 16.0;  // beside a record: command, address, CRC and framing
constexpr std::size_t fewest_steps = 6;      // that still draw something
constexpr std::size_t most_steps = 60;
constexpr std::size_t others_in_fifo = 8;  // beside a turn
constexpr std::size_t banks = 3;
constexpr double record_share = 0.8;        // may go into records
constexpr double usual_interval_s = 20e-3;  // between two paths: fewer steps that come faster do not feel better
constexpr double slack = 1.02;              // of what a line is measured to do
constexpr double longest_interval_s = 0.1;  // that still follows a hand

bool computes_foci(const std::vector<DevicePart>& parts) {
    return std::ranges::all_of(parts, [](const DevicePart& part) {
        const link::Identity& board = part.device.identity();
        return interface::has(board.features, interface::Feature::live_foci) && board.channels == part.elements;
    });
}

/// Boards with a role play nothing else.
void require_common_period(const Timer& timer, const link::Identity& board) {
    constexpr std::uint32_t common_hz = 40'000;
    const std::uint32_t wanted = board.clock_hz / common_hz, made = timer.prescaler * timer.cycle_ticks;
    if (made != wanted)
        throw bad_input("rig", fmt::format("its carrier period is {} clocks, but boards in step play only records of "
                                           "{}, which is a period of {} Hz; take arrays with that carrier",
                                           made, wanted, common_hz));
}

ChosenPlayer with_foci(link::Commands& device, link::Clock& clock, const Array& array, const PlayerOptions& options,
                       const Line& line) {
    auto player =
        std::make_unique<FocusPlayer>(device, clock, array, options.pace, line, options.watchdog_ms, options.parts);
    const FocusPace pace = player->pace();
    std::string about = fmt::format("the board computes foci: {} at a time, new ones every {:.2f} ms", pace.foci,
                                    1e3 * pace.periods * player->timer().period_s());
    if (pace.foci < options.pace.foci) about += fmt::format("; up to {} play in turn", options.pace.foci);
    const double wanted_s = options.pace.periods / array.carrier_hz;
    const double parts = std::ceil(static_cast<double>(options.pace.foci) / static_cast<double>(pace.foci));
    const double takes_s = parts * pace.periods * player->timer().period_s();
    std::string shortfall;
    if (takes_s > slack * wanted_s)
        shortfall = fmt::format(
            "the line cannot keep up: each place of {} is renewed every {:.2f} ms where {:.2f} ms are "
            "wanted, so paths have fewer places; take a faster line, at least {:.0f} baud",
            options.pace.foci, 1e3 * takes_s, 1e3 * wanted_s, 10.0 * line.bytes_s * takes_s / wanted_s);
    return {std::move(player), std::move(about), 0.0, std::move(shortfall)};
}

ChosenPlayer with_records(link::Commands& device, link::Clock& clock, const Array& array, const PlayerOptions& options,
                          const Line& line) {
    const link::Identity& board = device.identity();
    if (options.slow)
        throw Error(ErrorCode::device, "board",
                    "it plays records, too few for a pass of this algorithm, which takes seconds; take a board that "
                    "computes foci, or another algorithm");
    // Each board has a line of its own.
    std::uint32_t most_channels = 0;
    for (const DevicePart& part : options.parts)
        most_channels = std::max(most_channels, part.device.identity().channels);
    const double record_s =
        (2.0 * static_cast<double>(record_words(most_channels)) + record_frame_bytes) / line.bytes_s;
    std::size_t steps = options.steps;
    if (steps == 0) {
        const double interval_s = std::max(1.0 / options.rate_hz, usual_interval_s);
        const std::size_t room =
            std::min<std::size_t>({board.records / banks, board.live_depth - others_in_fifo, most_steps});
        steps = std::clamp<std::size_t>(static_cast<std::size_t>(record_share * interval_s / record_s), fewest_steps,
                                        std::max(room, fewest_steps));
    }
    const double path_s = static_cast<double>(steps) * record_s;
    if (path_s > longest_interval_s)
        throw Error(ErrorCode::device, "board",
                    fmt::format("the {} records of a path take {:.0f} ms on this line, which is too slow to follow a "
                                "hand; take a board that computes foci, or a line of at least {:.0f} baud",
                                steps, 1e3 * path_s, 10.0 * line.bytes_s * path_s / longest_interval_s));
    std::string shortfall;
    if (path_s * options.rate_hz > slack)
        shortfall = fmt::format(
            "the line cannot keep up with {:.0f} frames a second, and the rest are skipped; take a "
            "board that computes foci, or at least {:.0f} baud",
            options.rate_hz, 10.0 * line.bytes_s * path_s * options.rate_hz);
    return {
        std::make_unique<RingPlayer>(device, clock, array, steps, options.method, options.watchdog_ms, options.parts),
        fmt::format("the board plays records: {} a path, which take {:.1f} ms on the line, so it follows {:.0f} "
                    "frames a second",
                    steps, 1e3 * path_s, std::min(options.rate_hz, 1.0 / path_s)),
        path_s, std::move(shortfall)};
}

}  // namespace

ChosenPlayer choose_player(link::Commands& device, link::Clock& clock, const Array& array,
                           const PlayerOptions& options) {
    PlayerOptions all = options;
    if (all.parts.empty()) all.parts = one_part(device, array);
    const Line line = measured_line(device, clock);
    ChosenPlayer chosen = computes_foci(all.parts) ? with_foci(device, clock, array, all, line)
                                                   : with_records(device, clock, array, all, line);
    if (all.parts.size() > 1) require_common_period(chosen.player->timer(), device.identity());
    return chosen;
}

}  // namespace haptogram::live
