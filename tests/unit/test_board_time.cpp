// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <vector>

#include "haptogram/live/player.hpp"

using namespace haptogram;

namespace {

constexpr double period_s = 25e-6;

/// A device that plays entries without a gap from a period on, and whose clock runs off from the host's.
struct Device {
    double zero_s, drift;
    std::uint64_t first_period;
    std::uint64_t dwell;
    std::vector<std::uint16_t> entries;  // their indices
    [[nodiscard]] double host_s(double period) const { return zero_s + period * period_s * (1.0 + drift); }
    [[nodiscard]] std::uint64_t begins(std::size_t entry) const { return first_period + entry * dwell; }
    /// What it says at a period when `pushed` entries were pushed.
    [[nodiscard]] link::Status at(std::uint64_t period, std::size_t pushed) const {
        const std::size_t playing = (period - first_period) / dwell;
        link::Status status;
        status.present_index = entries[playing];
        status.live_level = static_cast<std::uint16_t>(pushed - playing - 1);
        status.period = period;
        return status;
    }
};

}  // namespace

TEST_CASE("board time: entries began where statuses say, and never outside of what is told") {
    std::mt19937_64 random(Catch::rngSeed());
    const auto between = [&](double low, double high) {
        return std::uniform_real_distribution<double>(low, high)(random);
    };
    for (int round = 0; round < 20; ++round) {
        const auto dwell = static_cast<std::uint16_t>(6 + random() % 60);
        Device device{between(-100, 100), between(-5e-5, 5e-5), 1000 + random() % 100000, dwell, {}};
        live::BoardTime time(period_s);
        std::vector<std::size_t> starts;  // of rings
        std::size_t rings = 0;
        double narrowest = 1.0;
        const auto push = [&](std::uint16_t bank) {
            std::vector<std::uint16_t> turn;
            for (std::uint16_t j = 0; j < 10; ++j) {
                turn.push_back(static_cast<std::uint16_t>(bank * 10 + j + 1));
                device.entries.push_back(turn.back());
            }
            time.pushed(turn, dwell);
        };
        for (int turn = 0; turn < 60; ++turn) {
            if (turn % 3 == 0) starts.push_back(device.entries.size());
            push(static_cast<std::uint16_t>(turn / 3 % 4));
            const std::size_t pushed = device.entries.size();
            // Asked while the last entries but a few are left, answered up to a millisecond later.
            const std::uint64_t period = device.begins(pushed - 1 - (2 + random() % 6)) + random() % dwell;
            const double told_s = device.host_s(static_cast<double>(period) + between(0.0, 1.0));
            time.heard(device.at(period, pushed), pushed, told_s - between(0.0, 1e-3), told_s + between(0.0, 1e-3));
            if (turn < 5) continue;
            for (; rings < starts.size() && starts[rings] + 10 < pushed; ++rings) {
                const auto began = time.began(starts[rings]);
                REQUIRE(began);
                const double truth = device.host_s(static_cast<double>(device.begins(starts[rings])));
                CHECK(began->least <= truth + 1e-9);
                CHECK(began->most >= truth - 1e-9);
                narrowest = std::min(narrowest, began->half());
            }
        }
        CHECK(rings >= 18);
        CHECK(narrowest < 0.6e-3);
        CHECK_FALSE(time.began(device.entries.size() - 1));  // no status has shown it yet
        CHECK_FALSE(time.began(device.entries.size()));
    }
}

TEST_CASE("board time: after the FIFO has run empty, or silence, earlier statuses say nothing of later entries") {
    live::BoardTime time(period_s);
    const std::vector<std::uint16_t> turn{1, 2, 3};
    link::Status status;
    time.pushed(turn, 40);
    status.present_index = 2;
    status.live_level = 1;
    status.period = 1050;  // entry 1 began within 1010…1050, so entry 0 within 970…1010
    time.heard(status, 3, 0.0265, 0.0270);
    REQUIRE(time.began(0));
    CHECK(time.began(0)->least < 1010 * period_s + 1e-3);
    time.pushed(std::vector<std::uint16_t>{0}, 0);
    time.pushed(turn, 40);
    CHECK_FALSE(time.began(4));
    status.present_index = 1;
    status.live_level = 2;
    status.period = 9000;
    time.heard(status, 7, 0.2252, 0.2257);
    REQUIRE(time.began(4));
    CHECK(time.began(4)->least > 0.22);
    CHECK(time.began(4)->most < 0.23);
    // An underrun: what follows begins anew, and what lies between is not known.
    time.pushed(turn, 40);
    status.present_index = 3;
    status.live_level = 0;
    status.period = 20000;
    status.underruns = 1;
    time.heard(status, 10, 0.5002, 0.5007);
    CHECK_FALSE(time.began(7));
    REQUIRE(time.began(9));
    CHECK(time.began(9)->most > 0.49);
    // A device that counts no periods tells nothing.
    live::BoardTime other(period_s);
    other.pushed(turn, 40);
    status.period.reset();
    other.heard(status, 3, 0.0, 0.1);
    CHECK_FALSE(other.began(2));
}
