// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>

#include "../refusal.hpp"
#include "../soak.hpp"
#include "../virtual_clock.hpp"
#include "../virtual_line.hpp"
#include "bench.hpp"
#include "haptogram/array/array.hpp"
#include "haptogram/hand/recording.hpp"
#include "haptogram/live/depth.hpp"
#include "haptogram/live/loop.hpp"
#include "haptogram/live/pipeline.hpp"
#include "haptogram/solve/drives.hpp"

using namespace haptogram;
using namespace std::chrono_literals;

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

DepthOptions on_a_cube() {
    DepthOptions options;
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
    [[nodiscard]] double rate_hz() const override { return source_.rate_hz(); }
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

/// A camera: its shots come by the board's clock, so long after they were taken, and it has a clock of its own.
class Camera final : public DepthSource {
public:
    using Delay = std::function<double(std::uint64_t number)>;
    Camera(DepthSource& source, link::Clock& clock, double clock_rate, Delay delay)
        : source_(source), clock_(clock), clock_rate_(clock_rate), delay_(std::move(delay)) {}
    [[nodiscard]] const std::vector<DepthCamera>& cameras() const override { return source_.cameras(); }
    [[nodiscard]] double rate_hz() const override { return source_.rate_hz(); }
    [[nodiscard]] bool live() const override { return true; }
    [[nodiscard]] bool ready() override {
        if (!coming_ && !ended_) {
            coming_ = source_.next();
            ended_ = !coming_;
        }
        if (ended_) return true;
        const double taken_s = coming_->time_s;
        if (!begin_s_) begin_s_ = clock_.now_s() - taken_s;
        return clock_.now_s() >= *begin_s_ + taken_s + delay_(coming_->number);
    }
    [[nodiscard]] std::optional<DepthShot> next() override {
        while (!ready()) clock_.rest(1ms);
        auto shot = std::exchange(coming_, std::nullopt);
        if (shot) shot->time_s = 1000.0 + shot->time_s * clock_rate_;
        return shot;
    }

private:
    DepthSource& source_;
    link::Clock& clock_;
    double clock_rate_;
    Delay delay_;
    std::optional<DepthShot> coming_;
    std::optional<double> begin_s_;
    bool ended_ = false;
};

}  // namespace

TEST_CASE("live: a session of which less than a quarter was played is a failure") {
    live::LoopReport report;
    CHECK_NOTHROW(live::require_played(report));  // nothing was felt
    report.shots = 24;
    report.with_rings = report.given = 24;
    CHECK_THROWS_AS(live::require_played(report), Error);
    report.rings.resize(5);
    CHECK_THROWS_AS(live::require_played(report), Error);
    report.skipped = 4;  // the line was busy: these were not due
    CHECK_NOTHROW(live::require_played(report));
    report.skipped = 0;
    report.rings.resize(6);
    CHECK_NOTHROW(live::require_played(report));
    CHECK(live::overtaken_in_words(report).empty());
    // A busy machine: the feeler made three hundred, and of those that were sent all began.
    report.with_rings = 300;
    CHECK_NOTHROW(live::require_played(report));
    CHECK_SAID(live::overtaken_in_words(report));
    report.skipped = 276;  // for which the line had no time, as was said
    CHECK(live::overtaken_in_words(report).empty());
    report.unsent = 13;
    CHECK_THROWS_AS(live::require_played(report), Error);
}

TEST_CASE("live: two fingers at 30 Hz through the board, from depth to pulses") {
    LiveBench bench("tile-100");
    const Array array = find_array("tile-10x10");
    DepthLoop loop(bench.client, bench.clock, array, on_a_cube());
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
    DepthLoop loop(bench.client, bench.clock, array, on_a_cube());
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
    CHECK(report.without_picture == std::vector<std::uint64_t>{1, 1, 2, 1});
    CHECK(report.blind == 1);
    CHECK(report.empty == 0);
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

TEST_CASE("live: when all cameras vanish what plays goes on for a shot, then fades, and the next picture has a ring") {
    for (const std::size_t count : {1U, 4U}) {
        LiveBench bench("tile-100");
        DepthLoop loop(bench.client, bench.clock, find_array("tile-10x10"), on_a_cube());
        std::vector<DepthCamera> cameras = four_cameras();
        cameras.resize(count);
        SyntheticDepth simulated(
            cameras, [](double) { return two_fingers(0.5); }, 30.0, 0.8, no_depth_noise);
        Changed source(simulated, [](DepthShot& shot) {
            if (shot.number == 4 || (shot.number >= 8 && shot.number < 14))
                for (auto& picture : shot.pictures) picture.reset();
            return true;
        });
        std::map<std::uint64_t, live::ShotReport> shots;
        const live::LoopReport report = loop.run(source, [&](const live::ShotReport& shot, const DepthShot&) {
            shots[shot.number] = shot;
            return true;
        });
        INFO(count << " cameras");
        CHECK(report.blind == 7);
        CHECK(report.without_picture == std::vector<std::uint64_t>(count, 7));
        CHECK(report.missed == 7);
        CHECK(report.fades == 1);  // not for the single one
        CHECK(shots.at(4).troubles.size() == count);
        CHECK(shots.at(10).troubles.front() == "camera 1 gave no picture");
        CHECK(shots.at(5).foci == shots.at(3).foci);
        CHECK(shots.at(14).foci == shots.at(3).foci);
        CHECK(shots.at(3).foci >= 1);
        const double begin = report.rings.front().shot_s - static_cast<double>(report.rings.front().shot) / 30.0;
        std::uint16_t playing = 0;
        bool silent_early = false, silent_late = false, sounds_again = false;
        for (const auto& [time, index] : bench.starts) {
            const double shot = (time - begin) * 30.0;
            if (shot > 3.0 && shot < 8.0 && index == 0) silent_early = true;
            if (shot < 13.0) playing = index;
            if (shot > 14.0 && index != 0) sounds_again = true;
        }
        silent_late = playing == 0;
        CHECK_FALSE(silent_early);
        CHECK(silent_late);
        CHECK(sounds_again);
    }
}

TEST_CASE("live: a finger out of the array's reach is named and gets no ring, the other one keeps its own") {
    LiveBench bench("tile-100");
    DepthOptions options = on_a_cube();
    Array array = find_array("tile-10x10");
    array.reach_angle_rad = std::atan(30e-3 / 0.2);  // x = 30 mm at this height
    // One finger walks out of the reach and back, the other one leaves for a while.
    const auto scene = [](double time_s) {
        const double x = 15e-3 + 20e-3 * std::max(0.0, std::sin(2.0 * pi * time_s));
        std::vector<RoundedBody> fingers{{{x, 0, 0.2 + 4e-3 + 25e-3}, {0, 0, 25e-3}, {}, 8e-3}};
        if (time_s < 0.2 || time_s > 0.35)
            fingers.push_back({{-18e-3, 0, 0.2 + 4e-3 + 25e-3}, {0, 0, 25e-3}, {}, 8e-3});
        return fingers;
    };
    options.scene.size_m = 90e-3;
    options.scene.pose.origin = {0, 0, 0.155};
    DepthLoop loop(bench.client, bench.clock, array, options);
    SyntheticDepth source(four_cameras(), scene, 30.0, 1.0, no_depth_noise);
    std::uint64_t named = 0, alone = 0, last = 0;
    const live::LoopReport report = loop.run(source, [&](const live::ShotReport& shot, const DepthShot&) {
        bool out = false;
        for (const std::string& trouble : shot.troubles)
            if (trouble.find("is out of the array's reach") != std::string::npos) {
                ++named;
                out = true;
                CHECK(trouble.find("off the axis") != std::string::npos);
            }
        if (out && shot.foci == 1) ++alone;
        for (const Vec3 centre : shot.centres) CHECK(std::abs(centre.x) < 30e-3);
        last = shot.foci;
        return true;
    });
    CHECK(named >= 4);
    CHECK(report.out_of_reach == named);
    CHECK(alone >= 1);
    CHECK(report.fades >= 1);  // when nobody else was there
    CHECK(last == 2);
    CHECK(report.underruns == 0);
}

TEST_CASE("live: a whole hand that goes through the object gets no ring, and has one again when it is back") {
    LiveBench bench("tile-100");
    DepthOptions options = on_a_cube();
    options.scene.size_m = 40e-3;
    options.scene.pose.origin = {0, 0, 0.2};
    DepthLoop loop(bench.client, bench.clock, find_array("tile-10x10"), options);
    const auto scene = [](double time_s) -> std::vector<RoundedBody> {
        if (time_s > 0.25 && time_s < 0.5) return bodies_of(synthetic_hand(HandScript::press, 0.0, 0.2));
        return {{{0, 0, 0.22 + 4e-3 + 25e-3}, {0, 0, 25e-3}, {}, 8e-3}};
    };
    DepthCamera below = wide_depth_camera();
    below.pose = looking_at({0, 0, -0.1}, {0, 0, 0.2});
    SyntheticDepth source({below}, scene, 30.0, 0.8, no_depth_noise);
    std::size_t last_foci = 0, in_hand = 0;
    const live::LoopReport report = loop.run(source, [&](const live::ShotReport& shot, const DepthShot&) {
        last_foci = shot.foci;
        if (shot.time_s > 0.25 && shot.time_s < 0.5) in_hand += shot.foci;
        return true;
    });
    CHECK(report.through + report.no_section >= 5);
    CHECK(in_hand == 0);
    CHECK(report.fades >= 1);
    CHECK(last_foci == 1);
    CHECK(report.underruns == 0);
}

TEST_CASE("live: a board that counts carrier periods tells when rings began, as the pins do") {
    Array array = find_array("tile-10x10");
    array.elements.resize(16);
    array.name = "sixteen";
    for (const auto motion : {FocusMotion::revolving, FocusMotion::still}) {
        LiveBench bench("small-16");
        DepthOptions options = on_a_cube();
        options.ring.motion = motion;
        options.ring.points = 8;
        DepthLoop loop(bench.client, bench.clock, array, options);
        SyntheticDepth simulated(four_cameras(), two_fingers, 30.0, 0.8, {});
        Changed source(simulated, [](DepthShot& shot) { return shot.number < 10 || shot.number > 15; });
        const live::LoopReport report = loop.run(source);
        const live::Latency pins = live::latency_of(report.rings, bench.starts);
        const live::Latency told = live::latency_of(report.rings);
        CHECK(report.underruns == 0);
        CHECK(report.fades == 1);
        REQUIRE(pins.rings > 12);
        CHECK(told.rings + 3 >= pins.rings);  // those that were silenced at once may not be told
        CHECK(told.uncertain_s < 1.5e-3);
        CHECK(told.median_s == Approx(pins.median_s).margin(told.uncertain_s + 1e-4));
        std::size_t next = 0, compared = 0;
        for (const live::SentRing& ring : report.rings) {
            while (next < bench.starts.size() &&
                   (bench.starts[next].first < ring.pushed_s || bench.starts[next].second != ring.first_index))
                ++next;
            if (next == bench.starts.size() || !ring.began_s) continue;
            ++compared;
            CHECK(ring.began_s->least <= bench.starts[next].first + 25e-6);
            CHECK(ring.began_s->most >= bench.starts[next].first - 25e-6);
        }
        CHECK(compared == told.rings);
    }
    LiveBench other("tile-100");
    DepthLoop loop(other.client, other.clock, find_array("tile-10x10"), on_a_cube());
    SyntheticDepth source(four_cameras(), two_fingers, 30.0, 0.2, {});
    CHECK(live::latency_of(loop.run(source).rings).rings == 0);
}

TEST_CASE("live: pressing foci and a focus of a magnitude play, and what has no magnitude is named") {
    const auto run = [](DepthOptions options, std::size_t fingers) {
        LiveBench bench("tile-100");
        DepthLoop loop(bench.client, bench.clock, find_array("tile-10x10"), options);
        SyntheticDepth source(
            four_cameras(),
            [fingers](double) {
                std::vector<RoundedBody> bodies = two_fingers(0.5);
                bodies.resize(fingers);
                return bodies;
            },
            30.0, 0.4, no_depth_noise);
        std::string troubles;
        const live::LoopReport report = loop.run(source, [&](const live::ShotReport& shot, const DepthShot&) {
            for (const std::string& trouble : shot.troubles) troubles += trouble + "\n";
            return true;
        });
        CHECK(report.underruns == 0);
        return std::pair(report, troubles);
    };
    DepthOptions options = on_a_cube();
    options.ring.motion = FocusMotion::pressing;
    const auto [pressed, nothing] = run(options, 2);
    CHECK(pressed.with_rings >= 11);
    CHECK(pressed.rings.size() >= 4);  // one is 50 ms long
    CHECK(pressed.fades == 0);
    CHECK(nothing.empty());

    options = on_a_cube();
    options.magnitude = 1.5;
    CHECK_REFUSED(run(options, 1));
    options.ring.motion = FocusMotion::still;
    const auto [felt, quiet] = run(options, 1);
    CHECK(felt.with_rings >= 11);
    CHECK(quiet.empty());
    const auto [shared, named] = run(options, 2);
    CHECK(shared.with_rings == 0);
    CHECK(shared.without_magnitude >= 11);
    CHECK(named.find("share the array's pressure") != std::string::npos);
    options.magnitude = 1000.0;
    CHECK_REFUSED(run(options, 1));
}

TEST_CASE("live: a finger that goes through the object gets no ring, and has one again when it is back") {
    LiveBench bench("tile-100");
    DepthOptions options = on_a_cube();
    DepthLoop loop(bench.client, bench.clock, find_array("tile-10x10"), options);
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
        DepthOptions options = on_a_cube();
        options.scene.size_m = 120e-3;
        options.scene.pose.origin = {0, 0, 0.14};
        options.predict.kind = kind;
        options.predict.ahead_s = 0.05;
        DepthLoop loop(bench.client, bench.clock, find_array("tile-10x10"), options);
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

TEST_CASE("live: weights that records cannot have are refused before anything plays") {
    LiveBench bench("small-16");
    Array array = find_array("tile-10x10");
    array.elements.resize(16);
    array.elements[3].weight = 0.5;
    CHECK_REFUSED(live::RingPlayer(bench.client, bench.clock, array, 8, Method::distance_weighted));
}

TEST_CASE("live: rings by the thousand are replaced, and no turn at the pins has steps of two") {
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
    bench.client.set_watchdog(500);
    bench.client.enable();
    const std::uint64_t rings = test::soaked(10'000, 1'500);
    while (made < rings) {
        if (!player.sending() && player.sent().size() == made) {
            const Path ring = ring_of(++made);
            const std::vector<double> full(steps, 1.0);
            auto& ticks_of = expected[made];
            for (const Record& record : records_of(array, player.timer(), 16, ring.steps, full))
                ticks_of.push_back(record.timings);
            player.replace(ring, made, bench.clock.now_s());
        }
        if (!player.service()) bench.clock.rest(20us);
    }
    INFO(turns << " turns, " << replaced << " rings at the pins, " << player.sent().size() << " sent");
    CHECK(mixed == 0);
    CHECK(replaced > rings * 9 / 10);
    CHECK(turns >= replaced);
    CHECK(bench.client.status().underruns == 0);
}

TEST_CASE("live: shots of a camera are due as they come, whatever its clock says") {
    // A clock that is 2 % fast would be three quarters of a period off after these shots, and late shots would add up.
    const double fast = GENERATE(0.98, 1.0, 1.02);
    LiveBench bench("tile-100");
    SyntheticDepth simulated(four_cameras(), two_fingers, 30.0, 1.3, {});
    Camera camera(simulated, bench.clock, fast, [](std::uint64_t number) { return number % 3 == 1 ? 8e-3 : 0.0; });
    DepthLoop loop(bench.client, bench.clock, find_array("tile-10x10"), on_a_cube());
    std::vector<double> taken;
    const live::LoopReport done = loop.run(camera, [&](const live::ShotReport&, const DepthShot&) {
        taken.push_back(bench.clock.now_s());
        return true;
    });
    CHECK(done.shots == 39);
    CHECK(done.missed == 0);
    CHECK(done.fades == 0);
    CHECK(done.out_of_order == 0);
    CHECK(done.underruns == 0);
    for (std::size_t i = 3; i < taken.size(); ++i)
        CHECK(taken[i] - taken[0] < static_cast<double>(i) / 30.0 + (i % 3 == 1 ? 8e-3 : 0.0) + 6e-3);
}

TEST_CASE("live: a camera that falls silent fades, and its next shot is felt again") {
    LiveBench bench("tile-100");
    SyntheticDepth simulated(four_cameras(), two_fingers, 30.0, 1.0, {});
    // From the tenth shot on all come 0.3 s later.
    Camera camera(simulated, bench.clock, 1.0, [](std::uint64_t number) { return number < 10 ? 0.0 : 0.3; });
    DepthLoop loop(bench.client, bench.clock, find_array("tile-10x10"), on_a_cube());
    const live::LoopReport done = loop.run(camera);
    CHECK(done.shots == 30);
    CHECK(done.missed >= 8);
    CHECK(done.missed <= 9);
    CHECK(done.fades == 1);
    CHECK(done.with_rings == 30);
    CHECK(done.underruns == 0);
}

TEST_CASE("live: a wall in the picture keeps neither the line nor the watchdog waiting") {
    constexpr std::size_t wall_points = 65'025;
    constexpr std::uint16_t watchdog_ms = 50;
    test::VirtualClock clock;
    sim::ReferenceBoard board("tile-100");
    test::VirtualLine line(board, clock);
    link::Client client(line);
    client.identify();
    /// Takes six times the watchdog's time for each wall.
    struct Slow final : live::Feeler {
        live::ShotRings rings;
        link::Clock& clock;
        std::size_t walls = 0;
        Slow(const Array& array, link::Clock& time, const std::vector<DepthCamera>& cameras)
            : rings(array, array.carrier_hz, on_a_cube(), cameras), clock(time) {}
        std::optional<Path> feel(const live::Frame& frame, live::ShotReport& report) override {
            std::optional<Path> path = rings.feel(frame, report);
            if (report.points < wall_points) return path;
            ++walls;
            clock.rest(300ms);
            return path;
        }
        live::ShotCounts counts() const override { return rings.counts(); }
    };
    std::vector<DepthCamera> cameras = four_cameras();
    cameras.resize(1);
    SyntheticDepth simulated(
        cameras,
        [](double time_s) {
            if (time_s < 0.4 || time_s > 0.55) return two_fingers(0.5);
            return std::vector<RoundedBody>{{{0, 0, 0.21}, {0.1, 0, 0}, {0, 0, 0.1}, 1e-3}};
        },
        30.0, 1.5, no_depth_noise);
    live::DepthFrames source(simulated);
    const Array array = find_array("tile-10x10");
    Slow feeler(array, clock, cameras);
    live::RingPlayer player(client, clock, array, on_a_cube().ring.points, Method::distance_weighted, watchdog_ms);
    std::size_t felt_before = 0, felt_after = 0;
    live::LoopReport report;
    {
        live::Pipeline pipeline(source, feeler, clock);
        report = live::Loop(client, clock, player, {.watchdog_ms = watchdog_ms})
                     .run(pipeline, pipeline,
                          [&](const live::ShotReport& shot, const live::Frame&, const std::optional<Path>& path) {
                              (shot.time_s < 0.4 ? felt_before : felt_after) += path && shot.points < wall_points;
                              return true;
                          });
    }
    CHECK(feeler.walls >= 1);
    CHECK(client.status().watchdog_trips == 0);
    CHECK(felt_before > 0);
    CHECK(felt_after > 0);
    CHECK(report.underruns == 0);
    CHECK(report.fades >= 1);  // what played does not stay while nothing is known
}

TEST_CASE("live: while a camera is silent its user may end") {
    LiveBench bench("tile-100");
    SyntheticDepth simulated(four_cameras(), two_fingers, 30.0, 1.0, {});
    Camera camera(simulated, bench.clock, 1.0, [](std::uint64_t number) { return number < 5 ? 0.0 : 1e6; });
    DepthLoop loop(bench.client, bench.clock, find_array("tile-10x10"), on_a_cube());
    const live::LoopReport done = loop.run(camera, {}, [&] { return bench.clock.now_s() < 2.0; });
    CHECK(done.shots == 5);
    CHECK(done.fades == 1);
    CHECK_FALSE(bench.client.status().enabled);
    // The watchdog was kept quiet while nothing played.
    CHECK(bench.clock.now_s() >= 2.0);
}
