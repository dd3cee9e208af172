// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>

#include "bench.hpp"
#include "haptogram/live/loop.hpp"
#include "haptogram/model/array.hpp"
#include "haptogram/sense/depth_renderer.hpp"
#include "haptogram/solve/drives.hpp"

using namespace haptogram;

namespace {

constexpr double pi = std::numbers::pi;

/// Two upright fingers of 8 mm whose tips press on a fixed cube from above.
std::vector<RoundedBody> two_fingers(double time_s) {
    const double depth = 4e-3 * (0.5 - 0.5 * std::cos(2.0 * pi * time_s)) + 2e-3;
    std::vector<RoundedBody> fingers;
    for (const double x : {-15e-3, 15e-3})
        fingers.push_back({{x, 0, 0.2 + 8e-3 - depth + 25e-3}, {0, 0, 25e-3}, {}, 8e-3});
    return fingers;
}

live::LoopOptions on_a_cube() {
    live::LoopOptions options;
    options.scene.size_m = 60e-3;
    options.scene.pose.origin = {0, 0, 0.17};
    options.scene.mass_kg = 0.0;
    return options;
}

std::vector<DepthCamera> four_cameras() { return cameras_around({0, 0, 0.21}, 0.3, 4); }

/// Changes what a source gives.
class Changed final : public DepthSource {
public:
    using Change = std::function<bool(DepthShot&)>;  ///< false: the shot is lost
    Changed(DepthSource& source, Change change) : source_(source), change_(std::move(change)) {}
    [[nodiscard]] const std::vector<DepthCamera>& cameras() const override { return source_.cameras(); }
    [[nodiscard]] std::optional<DepthShot> next() override {
        for (;;) {
            auto shot = source_.next();
            if (!shot || change_(*shot)) return shot;
        }
    }

private:
    DepthSource& source_;
    Change change_;
};

}  // namespace

TEST_CASE("live: two fingers at 30 Hz through the board, from depth to pulses") {
    LiveBench bench("tile-100");
    const Array array = find_array("tile-10x10");
    live::Loop loop(bench.client, bench.clock, array, on_a_cube());
    SyntheticDepth source(four_cameras(), two_fingers, 30.0, 1.0, {});
    std::size_t pairs = 0;
    const live::LoopReport report = loop.run(source, [&](const live::ShotReport& shot, const DepthShot&) {
        if (shot.foci == 2) ++pairs;
        return true;
    });
    CHECK(report.shots == 30);
    CHECK(pairs >= 28);
    CHECK(report.missed == 0);
    CHECK(report.underruns == 0);
    CHECK(report.fades == 0);
    CHECK(report.rings.size() >= 28);
    const live::Latency latency = live::latency_of(report.rings, bench.starts);
    CHECK(latency.rings == report.rings.size());
    INFO("latency " << 1e3 * latency.least_s << " " << 1e3 * latency.median_s << " " << 1e3 * latency.most_s);
    CHECK(latency.least_s > 0.02);  // ten records of 208 bytes take 22 ms at 1 Mbaud
    CHECK(latency.most_s < 0.05);
    for (const live::SentRing& ring : report.rings) CHECK(ring.pushed_s - ring.shot_s < 1.0 / 30.0);
    // The pins agree with what was expected of the FIFO.
    std::size_t next = 0;
    for (const live::SentRing& ring : report.rings) {
        while (next < bench.starts.size() &&
               (bench.starts[next].first < ring.pushed_s || bench.starts[next].second != ring.first_index))
            ++next;
        REQUIRE(next < bench.starts.size());
        CHECK(std::abs(bench.starts[next].first - ring.expected_s) < 2.5e-3);
    }
    CHECK_FALSE(bench.board.any_pin());
}

TEST_CASE(
    "live: lost shots, late shots, cameras without a picture, and nothing at all are counted, and the next shot "
    "works") {
    LiveBench bench("tile-100");
    const Array array = find_array("tile-10x10");
    live::Loop loop(bench.client, bench.clock, array, on_a_cube());
    SyntheticDepth simulated(
        four_cameras(), [](double) { return two_fingers(0.5); }, 30.0, 1.0, no_depth_noise);
    Changed source(simulated, [](DepthShot& shot) {
        if (shot.number == 5) return false;                       // one lost
        if (shot.number >= 8 && shot.number <= 11) return false;  // four lost: the outputs fade
        if (shot.number == 15) shot.pictures[2].reset();          // a camera that gave nothing
        if (shot.number == 18)
            for (auto& p : shot.pictures) p.reset();  // none gave anything
        if (shot.number == 22) shot.number = 3;       // out of order
        return true;
    });
    std::map<std::uint64_t, live::ShotReport> shots;
    const live::LoopReport report = loop.run(source, [&](const live::ShotReport& shot, const DepthShot&) {
        shots[shot.number] = shot;
        return true;
    });
    CHECK(report.lost == 6);  // that which came out of order is lost, too
    CHECK(report.out_of_order == 1);
    CHECK(report.without_camera == 2);
    CHECK(report.empty == 1);
    CHECK(report.shots == 24);
    CHECK(report.fades >= 1);
    CHECK(report.missed >= 4);
    CHECK(report.underruns == 0);
    for (const std::uint64_t good : {6U, 12U, 15U, 19U, 23U}) {
        INFO(good);
        CHECK(shots.at(good).foci == 2);
    }
    CHECK(shots.at(6).troubles.size() == 1);
    CHECK(shots.at(15).troubles.at(0) == "camera 3 gave no picture");
    // Between the second miss after shot 7 and shot 12 the pins fall silent within 100 ms.
    const double faded = 7.0 / 30.0 + 2.5 / 30.0 + 0.1, next = 12.0 / 30.0;
    const double begin = report.rings.front().shot_s - static_cast<double>(report.rings.front().shot) / 30.0;
    bool silent = false;
    for (const auto& [time, index] : bench.starts)
        if (time - begin > 7.0 / 30.0 + 2.0 / 30.0 && time - begin < std::max(faded, next) && index == 0) silent = true;
    CHECK(silent);
}

TEST_CASE("live: a finger that goes through the object gets no ring, and has one again when it is back") {
    LiveBench bench("tile-100");
    live::LoopOptions options = on_a_cube();
    live::Loop loop(bench.client, bench.clock, find_array("tile-10x10"), options);
    const auto scene = [](double time_s) {
        const double depth = time_s > 0.25 && time_s < 0.5 ? 40e-3 : 4e-3;
        return std::vector<RoundedBody>{{{0, 0, 0.2 + 8e-3 - depth + 25e-3}, {0, 0, 25e-3}, {}, 8e-3}};
    };
    SyntheticDepth source(four_cameras(), scene, 30.0, 0.8, no_depth_noise);
    std::size_t last_foci = 0;
    const live::LoopReport report = loop.run(source, [&](const live::ShotReport& shot, const DepthShot&) {
        last_foci = shot.foci;
        return true;
    });
    CHECK(report.through >= 5);
    CHECK(report.fades == 1);
    CHECK(last_foci == 1);
}

TEST_CASE("live: a hand at 200 mm/s with 50 ms of latency has its ring under the finger when it is predicted") {
    for (const auto kind : {live::Prediction::none, live::Prediction::velocity, live::Prediction::kalman}) {
        LiveBench bench("tile-100");
        live::LoopOptions options = on_a_cube();
        options.scene.size_m = 120e-3;
        options.scene.pose.origin = {0, 0, 0.14};
        options.predict.kind = kind;
        options.predict.ahead_s = 0.05;
        live::Loop loop(bench.client, bench.clock, find_array("tile-10x10"), options);
        const auto x_at = [](double time_s) { return -45e-3 + 0.2 * time_s; };
        const auto scene = [&](double time_s) {
            return std::vector<RoundedBody>{{{x_at(time_s), 0, 0.2 + 4e-3 + 25e-3}, {0, 0, 25e-3}, {}, 8e-3}};
        };
        SyntheticDepth source(four_cameras(), scene, 30.0, 0.45, {});
        double worst = 0.0, mean = 0.0;
        std::size_t count = 0;
        (void)loop.run(source, [&](const live::ShotReport& shot, const DepthShot&) {
            if (shot.number < 4 || shot.centres.empty()) return true;
            const double off = std::abs(shot.centres[0].x - x_at(shot.time_s + 0.05));
            worst = std::max(worst, off);
            mean += off;
            ++count;
            return true;
        });
        INFO(static_cast<int>(kind) << ": worst " << 1e3 * worst << " mm");
        REQUIRE(count >= 8);
        if (kind == live::Prediction::none)
            CHECK(mean / static_cast<double>(count) == Approx(10e-3).margin(0.5e-3));
        else
            CHECK(worst < 1.5e-3);
    }
}

TEST_CASE("live: ten thousand rings are replaced, and no turn at the pins has steps of two") {
    LiveBench bench("small-16");
    const Array array = [] {
        Array made = find_array("tile-10x10");
        made.elements.resize(16);
        made.name = "sixteen";
        return made;
    }();
    constexpr std::size_t steps = 8;
    live::RingPlayer player(bench.client, bench.clock, array, steps, Method::distance_weighted);
    // What each record makes: the tick at which the first channels rise, from the drives that its foci ask for.
    const auto ring_of = [](std::uint64_t k) {
        Path ring;
        for (std::size_t j = 0; j < steps; ++j) {
            const double turn = static_cast<double>(j) / steps, at = 0.37 * static_cast<double>(k);
            ring.steps.push_back({{{{20e-3 * std::cos(at) + 5e-3 * std::cos(2 * pi * turn),
                                     20e-3 * std::sin(at) + 5e-3 * std::sin(2 * pi * turn), 0.1},
                                    1.0}},
                                  6});
        }
        return ring;
    };
    std::vector<std::uint32_t> ticks(array.elements.size(), 0);  // since the cycle began, of each channel's last rise
    std::uint64_t cycle_clock = 0, turns = 0, mixed = 0, replaced = 0;
    std::uint16_t index = 0;
    std::uint64_t playing = 0;  // the ring whose turn plays
    std::size_t step = 0;
    std::map<std::uint64_t, std::vector<std::vector<std::uint16_t>>> expected;
    std::uint64_t made = 0;
    const std::uint32_t prescaler = player.timer().prescaler;
    std::uint32_t cycles_in = 0;
    std::vector<std::uint16_t> seen(array.elements.size());
    const auto judge = [&] {  // a cycle in the middle of a step has gone by
        for (std::size_t c = 0; c < seen.size(); ++c) seen[c] = static_cast<std::uint16_t>(ticks[c]);
        if (step == 0)
            for (std::uint64_t k = playing; k <= made; ++k)
                if (expected.contains(k) && expected[k][0] == seen) {
                    replaced += k != playing ? 1 : 0;
                    expected.erase(expected.begin(), expected.find(k));
                    playing = k;
                    break;
                }
        if (!expected.contains(playing) || expected[playing][step] != seen) ++mixed;
        if (step + 1 == steps) ++turns;
    };
    bench.board.on_edge([&](const sim::Edge& e) {
        if (e.rises && e.channel < ticks.size())
            ticks[e.channel] = static_cast<std::uint32_t>((e.clock - cycle_clock) / prescaler);
    });
    bench.board.on_cycle_start([&](const sim::CycleStart& c) {
        if (index != 0 && cycles_in == 5) judge();
        if (c.index != index) {
            index = c.index;
            cycles_in = 0;
            if (index != 0) step = (index - 1U) % steps;
        }
        ++cycles_in;
        cycle_clock = c.clock;
    });
    const link::Outputs on(bench.client, 500);
    constexpr std::uint64_t rings = 10'000;
    while (made < rings) {
        if (!player.sending() && player.sent().size() == made) {
            const Path ring = ring_of(++made);
            const std::vector<double> full(steps, 1.0);
            auto& ticks_of = expected[made];
            for (const Record& record : records_of(array, player.timer(), 16, ring.steps, full))
                ticks_of.push_back(record.timings);
            player.replace(ring, made, bench.clock.now_s());
        }
        if (!player.service()) bench.clock.wait_until(bench.clock.now_s() + 20e-6);
    }
    INFO(turns << " turns, " << replaced << " rings at the pins, " << player.sent().size() << " sent");
    CHECK(mixed == 0);
    CHECK(replaced > 9'000);
    CHECK(turns >= replaced);
    CHECK(bench.client.status().underruns == 0);
}
