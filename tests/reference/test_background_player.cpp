// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>
#include <chrono>
#include <functional>
#include <memory>

#include "../virtual_clock.hpp"
#include "../virtual_line.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/link/background_player.hpp"
#include "haptogram/verbs/compile.hpp"
#include "reference_board.hpp"

using namespace haptogram;
using namespace std::chrono_literals;

namespace {

constexpr auto configuration = "tile-100-wide";

}  // namespace

TEST_CASE("what plays in the background falls silent when it must", "[reference]") {
    test::VirtualClock clock;
    sim::ReferenceBoard board(configuration);
    std::uint64_t pulses = 0;
    board.on_edge([&pulses](const sim::Edge& edge) { pulses += edge.rises ? 1 : 0; });
    test::VirtualLine line(board, clock);  // whose time goes on while others have theirs open
    link::BackgroundPlayer player([&] { return std::make_unique<test::VirtualLine>(board, clock, 0s); }, 20s, clock);
    const auto soon = [&](const std::function<bool()>& condition) {
        for (const auto end = clock.now() + 60s; clock.now() < end; clock.rest(1ms))
            if (condition()) return true;
        return false;
    };
    const Focus focus{{0.01, 0.0, 0.15}, 1.0};
    Path still;
    still.steps = {{.foci = {focus}, .periods = 1}};
    player.upload(compile(still, find_array("tile-10x10"),
                          {configuration, interface::find_configuration(configuration)->parameters}, 0, "image",
                          Method::gauss_newton, {}, ImageKind::foci)
                      .bundle);
    const auto heard_within = [&](std::chrono::milliseconds time) {
        line.catch_up();
        const std::uint64_t before = pulses;
        clock.rest(time);
        line.catch_up();
        return pulses != before;
    };
    const auto falls_silent = [&] { return soon([&] { return !heard_within(200ms); }) && player.work().busy; };
    const auto is_heard = [&] { return soon([&] { return heard_within(20ms); }); };
    const auto begin = [&](const link::BackgroundPlay& how) {
        player.play_live(how);
        const bool begun = soon([&] { return player.work().sent > 100; });
        INFO("busy " << player.work().busy << ", sent " << player.work().sent << ", " << player.work().trouble);
        REQUIRE(begun);
    };

    SECTION("nobody moves the focus any more") {
        begin({.stale_ms = 300});
        CHECK(soon([&] {
            player.set_focus(focus);
            return heard_within(20ms);
        }));
        CHECK(falls_silent());
        player.set_focus(focus);
        CHECK(is_heard());
    }
    SECTION("a focus is refused") {
        begin({.stale_ms = 0});
        player.set_focus(focus);
        CHECK(is_heard());
        clock.rest(1s);
        CHECK(is_heard());  // without a limit it stays
        CHECK_THROWS_AS(player.set_focus({{5.0, 0.0, 0.15}, 1.0}), Error);
        CHECK(falls_silent());
    }
    SECTION("the next to play has put nothing yet") {
        begin({.stale_ms = 0});
        player.set_focus(focus);
        CHECK(is_heard());
        player.stop();
        begin({.stale_ms = 0});
        CHECK(falls_silent());
        CHECK(player.work().sent > 100);
        player.set_focus(focus);
        CHECK(is_heard());
    }
    SECTION("the factor is 0, under a waveform") {
        const bool live = GENERATE(true, false);
        const auto again = [&] {
            if (!live) return player.play({.loops = 0, .am = "sine:200"});
            player.set_focus(focus);
            begin({.am = "sine:200", .stale_ms = 0});
        };
        again();
        CHECK(is_heard());
        player.set_intensity(0.0);
        CHECK(falls_silent());
        player.set_intensity(1.0);
        CHECK(is_heard());
        player.set_intensity(0.0);
        player.stop();
        again();  // an earlier factor is this one's, too
        REQUIRE(soon([&] { return player.state().status.enabled; }));
        CHECK(!heard_within(300ms));
        player.shut_off();  // which leaves the waveform in the board
        player.set_intensity(1.0);
        again();
        CHECK(is_heard());
    }
}
