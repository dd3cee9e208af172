// SPDX-License-Identifier: Apache-2.0
// A tracker's hands to pulses: algorithms A to L, on boards of foci and of records.
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <random>

#include "../refusal.hpp"
#include "../virtual_clock.hpp"
#include "bench.hpp"
#include "haptogram/format/focus_engine.hpp"
#include "haptogram/hand/recording.hpp"
#include "haptogram/live/hand_feeler.hpp"
#include "haptogram/live/hand_source.hpp"
#include "haptogram/live/pipeline.hpp"
#include "haptogram/live/players.hpp"

using namespace haptogram;

namespace {

constexpr double pi = std::numbers::pi;

std::shared_ptr<const live::ObjectsNow> sphere(Vec3 centre = {0, 40e-3, 0.16}) {
    const TouchObject object = built_in_object("sphere", {80e-3, 80e-3, centre, {}});
    return std::make_shared<const live::ObjectsNow>(
        live::ObjectsNow{object, {object}, {{"object", "sphere", 80e-3, {}, {.origin = centre}}}});
}

/// An open hand that presses on the sphere, as a tracker of 110 Hz sees it.
HandRecording pressing(double seconds, double rate_hz = 110.0) {
    HandRecording hands;
    for (int i = 0; i < seconds * rate_hz; ++i) {
        const double time_s = i / rate_hz;
        hands.frames.push_back({time_s, {synthetic_hand(HandScript::press, 0.5 + time_s, 0.2)}});
    }
    return hands;
}

live::HandOptions with(Algorithm algorithm) {
    live::HandOptions options;
    options.algorithm = algorithm;
    options.predict = {live::Prediction::velocity, 20e-3};
    return options;
}

struct Run {
    live::LoopReport report;
    live::Latency latency;
    std::string about;
};

Run played(LiveBench& bench, HandRecording hands, const live::HandOptions& options, const live::Loop::Told& told = {}) {
    const Array array = find_array("tile-10x10");
    live::RecordedHands source(std::move(hands), "hands");
    live::HandFeeler feeler(
        array, array.carrier_hz, [object = sphere()](double) { return object; }, options);
    const live::ChosenPlayer chosen = live::choose_player(
        bench.client, bench.clock, array, {.pace = {.foci = live::most_foci(options)}, .rate_hz = source.rate_hz()});
    Run run;
    run.about = chosen.about;
    run.report = live::Loop(bench.client, bench.clock, *chosen.player, {.interval_s = chosen.interval_s})
                     .run(source, feeler, told);
    run.latency = live::latency_of(run.report.rings, bench.starts);
    return run;
}

interface::CoreConfiguration tile(bool foci, std::uint32_t baud) {
    interface::CoreConfiguration board = *interface::find_configuration(foci ? "tile-100-wide" : "tile-100");
    board.parameters.baud = baud;
    return board;
}

}  // namespace

TEST_CASE("live hands: frames at 110 Hz become pulses within 12 ms, and none is lost") {
    const auto worst =
        GENERATE(table<std::uint32_t, double, double>({{3000000, 12e-3, 20e-3}, {1000000, 14e-3, 25e-3}}));
    const auto& [baud, median_s, most_s] = worst;
    for (const Algorithm algorithm : {Algorithm::intersection, Algorithm::features_intersection}) {
        LiveBench bench(tile(true, baud));
        const Run run = played(bench, pressing(1.0), with(algorithm));
        INFO(run.about);
        CHECK(run.report.shots == 110);
        CHECK(run.report.lost == 0);
        CHECK(run.report.missed == 0);
        CHECK(run.report.fades == 0);
        CHECK(run.report.underruns == 0);
        CHECK(run.report.with_rings == 110);
        CHECK(run.latency.rings >= 105);
        // The board's time stands still while the processor works, which is told beside.
        std::vector<double> compute = run.report.compute_s;
        std::sort(compute.begin(), compute.end());
        WARN("skeleton frame to first pulse, tile-100-wide at "
             << baud << " baud, algorithm " << name_of(algorithm).letter << ": " << 1e3 * run.latency.median_s
             << " ms median, " << 1e3 * run.latency.most_s << " most, and " << 1e3 * compute[compute.size() / 2]
             << " ms of processor, " << 1e3 * compute.back() << " most; " << run.report.lost << " of "
             << run.report.shots << " frames lost");
        CHECK(run.latency.median_s + compute[compute.size() / 2] <= median_s);
        CHECK(run.latency.most_s <= most_s);
        CHECK_FALSE(bench.board.any_pin());
    }
}

TEST_CASE("live hands: every algorithm plays, where the array can, on foci and on records") {
    for (const AlgorithmName& one : algorithm_names()) {
        for (const bool foci : {true, false}) {
            if (!foci && one.letter == 'K') continue;  // a pass takes seconds, which no ring of records holds
            LiveBench bench(tile(foci, 3000000));
            const Array array = find_array("tile-10x10");
            std::size_t checked = 0, beyond = 0;
            const Run run = played(bench, pressing(0.4), with(algorithm_of(std::string(1, one.letter))),
                                   [&](const live::ShotReport&, const live::Frame&, const std::optional<Path>& path) {
                                       if (!path) return true;
                                       for (const PathStep& step : path->steps)
                                           for (const Focus& focus : step.foci) {
                                               beyond += array.unreachable(focus.position).empty() ? 0 : 1;
                                               ++checked;
                                           }
                                       return true;
                                   });
            INFO("algorithm " << one.letter << ", " << run.about);
            if (one.letter == 'B') continue;  // a sphere has no edges
            CHECK(run.report.with_rings > 0);
            CHECK(run.report.missed == 0);
            CHECK(run.report.underruns == 0);
            CHECK(run.latency.rings > 0);
            CHECK(checked > 0);
            CHECK(beyond == 0);
        }
    }
}

TEST_CASE("live hands: the board's foci are those of the path, by their own words") {
    LiveBench bench(tile(true, 3000000));
    const Array array = find_array("tile-10x10");
    HandRecording still;
    for (int i = 0; i < 20; ++i) still.frames.push_back({i / 110.0, {synthetic_hand(HandScript::press, 1.0, 0.2)}});
    std::optional<Path> last;
    (void)played(bench, still, with(Algorithm::intersection),
                 [&](const live::ShotReport&, const live::Frame&, const std::optional<Path>& path) {
                     last = path;
                     return true;
                 });
    REQUIRE(last);
    // What stands in the board's memory, unpacked: each focus lies on the path.
    const auto memory = bench.board.primary_memory();
    const link::FocusRing ring = bench.ring();
    std::size_t loud = 0;
    for (std::size_t n = 0; n < ring.count; ++n) {
        FocusWords words;
        for (std::size_t k = 0; k < 4; ++k) words[k] = memory[4 * (ring.base + n * ring.each) + k];
        const Focus focus = unpack_focus(words);
        if (focus.amplitude == 0.0) continue;
        double nearest = 1.0;
        for (const PathStep& step : last->steps)
            for (const Focus& wanted : step.foci)
                nearest = std::min(nearest, distance(wanted.position, focus.position));
        CHECK(nearest < 0.1e-3);
        ++loud;
    }
    CHECK(loud > 100);
}

TEST_CASE("live hands: a tracker that falls silent fades after two frames, and plays again when it is back") {
    LiveBench bench(tile(true, 3000000));
    HandRecording hands = pressing(0.6);
    std::erase_if(hands.frames, [](const HandFrame& frame) { return frame.time_s > 0.2 && frame.time_s < 0.4; });
    const Run run = played(bench, hands, with(Algorithm::intersection));
    CHECK(run.report.fades == 1);
    const double begin_s = run.report.rings.front().shot_s;
    double silent_s = 0.0, since_s = -1.0;
    bool again = false;
    for (const auto& [time_s, index] : bench.starts) {
        const double at_s = time_s - begin_s;
        if (index == 0 && at_s > 0.2 && at_s < 0.4 && since_s < 0.0) since_s = at_s;
        if (index != 0 && since_s >= 0.0 && !again) {
            silent_s = at_s - since_s;
            again = true;
        }
    }
    CHECK(since_s > 0.2);
    CHECK(since_s < 0.28);
    CHECK(again);
    CHECK(silent_s > 0.1);
}

TEST_CASE("live hands: what neither the line nor the board can carry is said before anything plays") {
    const Array array = find_array("tile-10x10");
    LiveBench records(tile(false, 115200));
    CHECK_REFUSED(live::choose_player(records.client, records.clock, array, {.steps = 10}));
    LiveBench foci(tile(true, 115200));
    const Run run = played(foci, pressing(0.5, 30.0), with(Algorithm::intersection));
    INFO(run.about);
    CHECK(run.report.missed == 0);
    CHECK(run.report.underruns == 0);
    CHECK(run.latency.rings == run.report.rings.size());
    WARN("skeleton frame to first pulse at 115,200 baud, algorithm A: " << 1e3 * run.latency.median_s << " ms median; "
                                                                        << run.about);
}

TEST_CASE("live hands: rings go around the fingers, and a tracker's ring is as large as the finger") {
    LiveBench bench(tile(true, 1000000));
    const Array array = find_array("tile-10x10");
    // A hand whose middle finger points down into a cube's top by 15 mm: its section is a circle of the tip's radius.
    HandRecording hands;
    for (int i = 0; i < 30; ++i) {
        Hand hand;
        hand.palm = {0, 0, 0.32};
        hand.normal = {0, -1, 0};
        hand.direction = {0, 0, -1};
        hand.fingers[2] = Finger{{Vec3{0, 0, 0.27}, {0, 0, 0.24}, {0, 0, 0.21}, {0, 0, 0.1925}}, {}};
        hands.frames.push_back({i / 110.0, {hand}});
    }
    live::RecordedHands source(hands, "hands");
    live::FingerOptions options;
    options.scene.size_m = 60e-3;
    options.scene.pose.origin = {0, 0, 0.17};
    options.scene.mass_kg = 0.0;
    options.rate_hz = 110.0;
    live::ShotRings feeler(array, array.carrier_hz, options);
    const live::ChosenPlayer chosen =
        live::choose_player(bench.client, bench.clock, array, {.pace = {2, 40}, .rate_hz = 110.0});
    std::size_t seen = 0;
    const live::LoopReport report =
        live::Loop(bench.client, bench.clock, *chosen.player, {})
            .run(source, feeler, [&](const live::ShotReport& shot, const live::Frame&, const std::optional<Path>&) {
                for (const Ellipse& section : shot.sections) {
                    CHECK(section.half_major == Approx(7.5e-3).epsilon(0.05));
                    CHECK(section.half_minor == Approx(7.5e-3).epsilon(0.05));
                    ++seen;
                }
                return true;
            });
    CHECK(seen >= 28);
    CHECK(report.missed == 0);
}

TEST_CASE("live hands: two threads and the loop lose no frame, and the newest wins where the feeler is slow") {
    struct Slow final : live::Feeler {
        link::Clock& clock;
        double seconds;
        Slow(link::Clock& c, double s) : clock(c), seconds(s) {}
        std::optional<Path> feel(const live::Frame&, live::ShotReport&) override {
            clock.rest(link::Clock::time(seconds));
            return Path{{{{{{0, 0, 0.2}, 1.0}}, 10}}, {}};
        }
        live::ShotCounts counts() const override { return {}; }
    };
    /// Numbers of the frames that were felt.
    const auto felt = [](live::FrameSource& source, double slow_s) {
        test::VirtualClock clock;
        Slow feeler(clock, slow_s);
        live::Pipeline pipeline(source, feeler, clock);
        std::vector<std::uint64_t> numbers;
        while (const auto frame = pipeline.next()) {
            live::ShotReport report;
            CHECK(pipeline.feel(*frame, report));
            numbers.push_back(frame->number);
        }
        CHECK(std::is_sorted(numbers.begin(), numbers.end()));
        return numbers;
    };
    constexpr std::uint64_t all = 55;  // at 110 Hz, in half a second
    live::RecordedHands recorded(pressing(0.5), "hands");
    const std::vector<std::uint64_t> quick = felt(recorded, 0.0);
    CHECK(quick.size() == all);
    // 9.1 ms apart, each felt for 30 ms: after one of them the newest is the third or fourth behind it.
    live::RecordedHands again(pressing(0.5), "hands");
    const std::vector<std::uint64_t> slow = felt(again, 0.03);
    CHECK(slow.size() == 18);
    CHECK(slow.back() == all - 1);
    /// Loses one frame, which must be noticed.
    struct Losing final : live::FrameSource {
        live::RecordedHands of{pressing(0.5), "hands"};
        [[nodiscard]] double rate_hz() const override { return of.rate_hz(); }
        [[nodiscard]] bool live() const override { return false; }
        [[nodiscard]] bool ready() override { return true; }
        [[nodiscard]] std::optional<live::Frame> next() override {
            auto frame = of.next();
            return frame && frame->number == 20 ? of.next() : frame;
        }
    } losing;
    CHECK(felt(losing, 0.0).size() == all - 1);
}

TEST_CASE("live hands: prediction by velocity leads a hand to within 2 mm, and a filter does not overshoot") {
    // A hand that goes to and fro by 40 mm, once a second, at 110 Hz, with a latency of 20 ms.
    const auto place = [](double time_s) { return Vec3{40e-3 * std::sin(2.0 * pi * time_s), 0, 0.2}; };
    constexpr double ahead_s = 20e-3, moving_s = 0.5;
    for (const auto& [kind, most_m] : {std::pair(live::Prediction::none, 6e-3),
                                       {live::Prediction::velocity, 1.2e-3},
                                       {live::Prediction::kalman, 3e-3}}) {
        live::Predictor predictor({kind, ahead_s});
        double worst = 0.0, beyond = 0.0;
        for (int i = 0; i < 220; ++i) {
            const double time_s = i / 110.0;
            const Vec3 made = predictor.ahead(1, place(time_s), time_s, time_s);
            if (time_s < moving_s) continue;
            worst = std::max(worst, distance(made, place(time_s + ahead_s)));
            beyond = std::max(beyond, std::abs(made.x) - 40e-3);
        }
        INFO("prediction " << static_cast<int>(kind) << ": " << 1e3 * worst << " mm off, " << 1e3 * beyond
                           << " mm beyond");
        CHECK(worst < most_m);
        CHECK(beyond < 1e-3);
        if (kind == live::Prediction::none) CHECK(worst > 4e-3);
    }
}

TEST_CASE("live hands: a place that is told again is no new one, whatever lies between") {
    // A hand at 200 mm/s, seen every 10 ms, and told again 1 µs and 4 ms later with what another tracker saw.
    const auto place = [](double time_s) { return Vec3{0.2 * time_s, 0, 0.2}; };
    constexpr double ahead_s = 20e-3;
    for (const live::Prediction kind : {live::Prediction::velocity, live::Prediction::kalman}) {
        live::Predictor predictor({kind, ahead_s});
        double worst = 0.0;
        for (int i = 0; i < 100; ++i)
            for (const double later_s : {0.0, 1e-6, 4e-3}) {
                const double seen_s = i / 100.0;
                const Vec3 made = predictor.ahead(1, place(seen_s), seen_s, seen_s + later_s);
                if (i > 10) worst = std::max(worst, distance(made, place(seen_s + later_s + ahead_s)));
            }
        CHECK(worst < 0.2e-3);
    }
}

TEST_CASE("live hands: paths of which few begin are a session that failed") {
    live::LoopReport report;
    report.shots = report.with_rings = report.given = 100;
    report.rings.resize(2);
    CHECK_REFUSED(live::require_played(report));
    report.given = 5;  // the others were overtaken
    CHECK_NOTHROW(live::require_played(report));
}

TEST_CASE("live hands: a filter's error is bounded where a hand turns back, and with noise") {
    // To and fro by 40 mm at 200 mm/s with sharp turns, 1 mm of noise on each place.
    constexpr double rate_hz = 110.0, ahead_s = 20e-3, speed_m_s = 0.2, half_m = 40e-3, noise_m = 1e-3;
    const auto place = [](double time_s) {
        const double way = std::fmod(speed_m_s * time_s, 4.0 * half_m);
        return Vec3{way < 2.0 * half_m ? way - half_m : 3.0 * half_m - way, 0, 0.2};
    };
    std::map<live::Prediction, std::pair<double, double>> found;  // beyond the turn at most, and error in the mean, m
    for (const auto kind : {live::Prediction::none, live::Prediction::velocity, live::Prediction::kalman}) {
        std::mt19937 random(7);
        std::normal_distribution<double> noise(0.0, noise_m);
        live::Predictor predictor({kind, ahead_s});
        double beyond_m = 0.0, squares = 0.0;
        constexpr int frames = 3000, first = 60;
        for (int i = 0; i < frames; ++i) {
            const double time_s = i / rate_hz;
            const Vec3 seen = place(time_s) + Vec3{noise(random), noise(random), noise(random)};
            const Vec3 made = predictor.ahead(1, seen, time_s, time_s);
            if (i < first) continue;
            beyond_m = std::max(beyond_m, std::abs(made.x) - half_m);
            squares += std::pow(made.x - place(time_s + ahead_s).x, 2) / (frames - first);
        }
        found[kind] = {beyond_m, std::sqrt(squares)};
        WARN("prediction " << static_cast<int>(kind) << ", 1 mm of noise, sharp turns: " << 1e3 * beyond_m
                           << " mm beyond at most, " << 1e3 * found[kind].second << " mm off in the mean");
    }
    const auto [beyond_m, off_m] = found[live::Prediction::kalman];
    // Nobody can know of a turn before it: what the hand went on in the time ahead, and five times the noise.
    CHECK(beyond_m < ahead_s * speed_m_s + 5.0 * noise_m);
    CHECK(beyond_m < 0.7 * found[live::Prediction::velocity].first);
    CHECK(off_m < found[live::Prediction::velocity].second);
    CHECK(off_m < found[live::Prediction::none].second);
}
