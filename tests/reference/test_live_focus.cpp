// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "haptogram/link/client.hpp"
#include "haptogram/link/live_focus.hpp"
#include "haptogram/link/transfer.hpp"
#include "haptogram/verbs/compile.hpp"
#include "reference_board.hpp"
#include "simulated_transport.hpp"

using namespace haptogram;

namespace {

/// For each of many calls of put(), at uneven times: how long until the first pulse of the focus, in the board's time.
std::vector<double> times_to_pulse_s(const std::string& configuration, std::uint32_t baud) {
    interface::CoreConfiguration wanted = *interface::find_configuration(configuration);
    wanted.parameters.baud = baud;
    sim::ReferenceBoard board(wanted);
    sim::SimulatedTransport line(board);
    link::Client client(line);
    client.identify();
    const Vec3 place{0.01, 0.0, 0.15};
    Path still;
    still.steps = {{.foci = {{place, 1.0}}, .periods = 1}};
    upload(client, compile(still, find_array("tile-10x10"), {configuration, wanted.parameters}, 0, "image",
                           Method::gauss_newton, {}, ImageKind::foci)
                       .bundle.image);

    std::uint64_t asked = 0, last = 0;
    std::vector<double> found;
    const double clock_hz = wanted.parameters.clock_hz;
    board.on_edge([&](const sim::Edge& edge) {
        last = edge.clock;
        if (edge.rises && asked != 0) found.push_back(static_cast<double>(edge.clock - asked) / clock_hz), asked = 0;
    });
    link::FocusMailbox mailbox(client.clock());
    unsigned random = 1;
    play_live_focus(client, {}, mailbox, [&](const link::LiveFocusPlaying&) {
        board.run(static_cast<std::uint64_t>(20e-6 * clock_hz));  // the host's own work between two frames
        random = random * 1664525 + 1013904223;
        const double silent_s = static_cast<double>(board.now() - last) / clock_hz;
        const double waits_s = 4e-3 + 1e-3 * (random >> 16) / 65536.0;
        if (asked == 0 && silent_s > waits_s) {
            asked = board.now();
            mailbox.put({place, 1.0});
        } else if (asked == 0 && silent_s < 1e-4) {
            mailbox.put({place, 0.0});
        }
        return found.size() < 400;
    });
    std::ranges::sort(found);
    return found;
}

}  // namespace

TEST_CASE("a live focus is felt soon after it was asked for", "[reference]") {
    const auto [configuration, baud, line, median_s] = GENERATE(table<std::string, std::uint32_t, std::string, double>(
        {{"tile-100-wide", 3'000'000, "a serial line of 3 Mbaud", 3e-3},
         {"colorlight-5a-75e-v7.1-net", 1'000'000, "a network port", 1e-3}}));
    const std::vector<double> found = times_to_pulse_s(configuration, baud);
    const std::string told = fmt::format("{}: median {:.2f} ms, longest {:.2f} ms of {}\n", line,
                                         1e3 * found[found.size() / 2], 1e3 * found.back(), found.size());
    fmt::print("{}", told);
    CHECK(found[found.size() / 2] <= median_s);
    CHECK(found.front() > 0.0);
}
