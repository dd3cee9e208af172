// SPDX-License-Identifier: Apache-2.0
#include "live.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <thread>
#include <vector>

#include "haptogram/base/error.hpp"
#include "haptogram/link/live_feed.hpp"
#include "interrupt.hpp"
#include "outputs.hpp"
#include "progress_line.hpp"

namespace haptogram::cli {

Fed feed(Device& device, std::uint16_t watchdog_ms, const std::function<std::optional<SequenceEntry>(int)>& next,
         const std::function<bool()>& ended) {
    link::Client& client = device.client();
    client.set_watchdog(watchdog_ms);
    const std::chrono::milliseconds pause = keep_alive_pause(watchdog_ms);
    const link::BoardStatus before = client.status();
    link::BoardStatus now = before;
    Fed fed;
    {
        const Outputs on(client);
        ProgressLine progress("stream");
        link::LiveFeed fifo(client, device.identity());
        std::optional<SequenceEntry> entry;
        auto asked = std::chrono::steady_clock::now();
        while (!interrupted()) {
            if (std::chrono::steady_clock::now() - asked > pause) {
                require_on(client.status());
                asked = std::chrono::steady_clock::now();
            }
            if (!entry) entry = next(static_cast<int>(pause.count()));
            if (!entry && ended()) break;
            if (!entry || fifo.room() < fifo.frame()) {  // which also says that this host is alive
                if (entry && client.unanswered() == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
                fifo.refresh();
                continue;
            }
            std::vector<std::uint16_t> indices;
            const std::uint16_t dwell = entry->dwell;
            while (entry && entry->dwell == dwell && indices.size() < fifo.room()) {
                indices.push_back(entry->index);
                entry = next(0);
            }
            fifo.push(indices, dwell);
            fed.sent += indices.size();
            progress.note(fmt::format("{} indices", fed.sent));
        }
        // Silence for good follows at once: running out of indices would be an underrun.
        while (!interrupted() && fifo.room() == 0) fifo.refresh();
        if (!interrupted()) fifo.push({0}, 0);
        for (now = client.status(); !interrupted() && (now.live_level > 0 || now.present_index != 0);
             now = client.status()) {
            require_on(now);
            std::this_thread::sleep_for(pause);
        }
    }
    fed.underruns = static_cast<std::uint16_t>(now.underruns - before.underruns);
    fed.interrupted = interrupted();
    return fed;
}

void tell(const Fed& fed, bool json) {
    if (json)
        fmt::print(
            "{}\n",
            nlohmann::ordered_json{{"sent", fed.sent}, {"underruns", fed.underruns}, {"interrupted", fed.interrupted}}
                .dump(1));
    else
        fmt::print("{} indices, {} underruns\n", fed.sent, fed.underruns);
}

double record_carrier_hz(Device& device, std::uint16_t index) {
    const link::Identity& board = device.identity();
    const std::uint32_t place = 2 * record_words(board.channels) * (index - 1U);
    const link::Bytes b = device.client().read(interface::primary_base + place, 2 * interface::record_header_words);
    const double cycle = b.at(0) | b.at(1) << 8 | b.at(2) << 16;
    const double prescaler = b.at(4) | b.at(5) << 8 | b.at(6) << 16;
    if (cycle == 0.0 || prescaler == 0.0)
        throw Error(ErrorCode::device, "board",
                    fmt::format("record {} in its memory has no carrier; upload an image first", index));
    return board.clock_hz / (cycle * prescaler);
}

std::uint16_t dwell_of(double rate_hz, double carrier_hz) {
    constexpr double most = 65535.0;
    constexpr double tolerance = 0.05;
    const double cycles = std::clamp(std::round(carrier_hz / rate_hz), 1.0, most);
    const double made = carrier_hz / cycles;
    if (std::abs(made - rate_hz) > tolerance * rate_hz)
        throw Error(ErrorCode::bad_argument, "--rate",
                    fmt::format("{} a second cannot be made of whole cycles at {:.0f} Hz; the nearest is {:.6g}",
                                rate_hz, carrier_hz, made));
    return static_cast<std::uint16_t>(cycles);
}

}  // namespace haptogram::cli
