// SPDX-License-Identifier: Apache-2.0
// Shapes that move from key frame to key frame: where each focus is, when, and how strong; and the project file's table
// of them.
#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>

#include "../refusal.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/shape/key_frames.hpp"
#include "haptogram/verbs/compile.hpp"
#include "haptogram/verbs/document.hpp"
#include "haptogram/verbs/project.hpp"

using namespace haptogram;

namespace {

constexpr double carrier_hz = 40'000.0;
constexpr std::size_t many = 100'000;
const Vec3 centre{0.0, 0.0, 0.13};

/// Two points, 10 mm at either side of the centre, each for 5 ms.
Path pass() {
    Path path;
    for (const double x : {-0.01, 0.01}) path.steps.push_back({{{centre + Vec3{x, 0.0, 0.0}, 1.0}}, 200});
    return path;
}

double from_centre_mm(const PathStep& step) { return 1e3 * distance(step.foci.at(0).position, centre); }

}  // namespace

TEST_CASE("key frames: passes follow each other until the last key frame, and nothing moves without a reason") {
    const Path path = moved_by({{.time_s = 0.0}, {.time_s = 0.1}}, pass(), centre, carrier_hz, many);
    REQUIRE(path.periods() == 4000);
    REQUIRE(path.steps.size() == 20);
    for (std::size_t i = 0; i < path.steps.size(); ++i) REQUIRE(path.steps[i] == pass().steps[i % 2]);
    // The last pass is cut where the path ends.
    const Path cut = moved_by({{.time_s = 0.0}, {.time_s = 0.0125}}, pass(), centre, carrier_hz, many);
    REQUIRE(cut.periods() == 500);
    REQUIRE(cut.steps.back().periods == 100);
}

TEST_CASE("key frames: movement, size, turn and strength go evenly, slowly at the ends, or in a step") {
    const Ease ease = GENERATE(Ease::linear, Ease::smooth, Ease::step);
    const std::vector<KeyFrame> frames = {
        {.time_s = 0.0, .ease = ease},
        {.time_s = 0.2, .move = {0.0, 0.02, 0.01}, .turn_deg = {0.0, 0.0, 90.0}, .scale = 3.0, .amplitude = 0.5}};
    const Path path = moved_by(frames, pass(), centre, carrier_hz, many);
    REQUIRE(path.steps.size() == 40);
    std::uint64_t before = 0;
    for (std::size_t i = 0; i < path.steps.size(); ++i) {
        const double part = (static_cast<double>(before) + 100.0) / 8000.0;
        // Of the smooth way: the sum over its speed, which is a parabola 6 u (1 − u).
        double eased = ease == Ease::linear ? part : 0.0;
        if (ease == Ease::smooth)
            for (int k = 0; k < 10'000; ++k) {
                const double u = part * (k + 0.5) / 10'000;
                eased += 6.0 * u * (1.0 - u) * part / 10'000;
            }
        const double angle = eased * std::numbers::pi / 2.0;
        const double reach = (i % 2 == 0 ? -0.01 : 0.01) * (1.0 + 2.0 * eased);
        const Vec3 expected =
            centre + Vec3{reach * std::cos(angle), reach * std::sin(angle) + 0.02 * eased, 0.01 * eased};
        const Focus& focus = path.steps[i].foci.at(0);
        REQUIRE(distance(focus.position, expected) < 1e-8);
        REQUIRE(std::abs(focus.amplitude - (1.0 - 0.5 * eased)) < 1e-7);
        before += path.steps[i].periods;
    }
}

TEST_CASE("key frames: a step is cut where a key frame falls into it, which is where a mark is told") {
    const std::vector<KeyFrame> frames = {{.time_s = 0.0, .ease = Ease::step},
                                          {.time_s = 0.0075, .scale = 2.0, .ease = Ease::step, .mark = true},
                                          {.time_s = 0.02}};
    const Path path = moved_by(frames, pass(), centre, carrier_hz, many);
    REQUIRE(path.periods() == 800);
    REQUIRE(path.steps.size() == 5);
    for (std::size_t i = 0; i < 5; ++i) {
        INFO(i);
        REQUIRE(path.steps[i].periods == (i == 1 || i == 2 ? 100 : 200));
        REQUIRE(path.steps[i].mark == (i == 2));
        REQUIRE(std::abs(from_centre_mm(path.steps[i]) - (i < 2 ? 10.0 : 20.0)) < 1e-9);
    }
}

TEST_CASE("key frames: an amplitude beats as often as its frequency says, which may change, and silence has no foci") {
    Path one;
    one.steps.push_back({{{centre, 1.0}}, 10});  // 0.25 ms
    const auto beats = [](const Path& path) {
        int count = 0;
        for (std::size_t i = 1; i + 1 < path.steps.size(); ++i) {
            const auto at = [&](std::size_t k) { return path.steps[k].foci.at(0).amplitude; };
            if (at(i) < at(i - 1) && at(i) <= at(i + 1)) ++count;
        }
        return count;
    };
    REQUIRE(beats(moved_by({{.time_s = 0.0, .am_hz = 100.0}, {.time_s = 1.0, .am_hz = 100.0}}, one, centre, carrier_hz,
                           many)) == 100);
    // From 50 to 150 Hz: as many as at their mean.
    REQUIRE(beats(moved_by({{.time_s = 0.0, .am_hz = 50.0}, {.time_s = 1.0, .am_hz = 150.0}}, one, centre, carrier_hz,
                           many)) == 100);
    const Path silent = moved_by(
        {{.time_s = 0.0, .amplitude = 0.0, .ease = Ease::step}, {.time_s = 0.01, .amplitude = 1.0}, {.time_s = 0.02}},
        pass(), centre, carrier_hz, many);
    REQUIRE(silent.steps[0].foci.empty());
    REQUIRE(silent.steps[1].foci.empty());
    REQUIRE(silent.steps[2].foci.size() == 1);
}

TEST_CASE("key frames: a form's points are matched by the turn and the sense of least squares") {
    // All ways to lay one tour on the other, one by one, from the tour turned by hand.
    std::mt19937 random(7);
    std::uniform_real_distribution<double> anywhere(-0.05, 0.05);
    for (const std::size_t size : {1U, 2U, 7U, 12U}) {
        std::vector<Vec3> pass(12), tour(size);
        for (Vec3& point : pass) point = {anywhere(random), anywhere(random), anywhere(random)};
        for (Vec3& point : tour) point = {anywhere(random), anywhere(random), anywhere(random)};
        const auto way = [&](const std::vector<Vec3>& becomes) {
            double sum = 0.0;
            for (std::size_t i = 0; i < pass.size(); ++i) sum += std::pow(distance(pass[i], becomes[i]), 2);
            return sum;
        };
        double least = 1e9;
        for (int sense = 0; sense < 2; ++sense) {
            for (std::size_t k = 0; k < size; ++k) {
                std::vector<Vec3> becomes;
                for (std::size_t i = 0; i < pass.size(); ++i) becomes.push_back(tour[i * size / pass.size()]);
                least = std::min(least, way(becomes));
                std::ranges::rotate(tour, tour.begin() + 1);
            }
            std::ranges::reverse(tour);
        }
        const std::vector<Vec3> found = matched(pass, tour);
        REQUIRE(std::abs(way(found) - least) < 1e-12);
        for (const Vec3& point : tour) REQUIRE(std::ranges::find(found, point) != found.end());
    }
}

TEST_CASE(
    "key frames: a circle grows into another one, and becomes a square whose points are those of the square alone") {
    const std::string head = "format = \"haptogram-project-1\"\npoints = 24\nrate_hz = 20\n";
    const std::string circle = "[[shape]]\nkind = \"circle\"\ndiameter_mm = 40\n";
    const std::string larger = "[[shape]]\nkind = \"circle\"\ndiameter_mm = 60\n";
    const std::string square = "[[shape]]\nkind = \"square\"\nlength_mm = 50\n";
    const std::string frames =
        "[[keyframe]]\ntime_s = 0\n[[keyframe]]\ntime_s = 0.5\nshape = 2\n[[keyframe]]\ntime_s = 0.55\nshape = 2\n";
    const auto path_of_text = [](const std::string& text) {
        return compile(project_from_toml(text, "forms.toml"), "forms").path;
    };
    // Evenly spread points of two circles lie on the same rays, so the radius tells how far it is.
    const Path grows = path_of_text(head + circle + larger + frames);
    REQUIRE(grows.periods() == 22'000);
    std::uint64_t now = 0;
    for (const PathStep& step : grows.steps) {
        const double part = std::min(1.0, (static_cast<double>(now) + 0.5 * step.periods) / 20'000.0);
        REQUIRE(std::abs(distance(step.foci.at(0).position, from_mm(0, 0, 130)) - 1e-3 * (20.0 + 10.0 * part)) < 1e-9);
        now += step.periods;
    }
    // The last pass is of the square alone, point by point, from wherever; no pass on the way is longer than its two
    // ends.
    const Path becomes = path_of_text(head + circle + square + frames);
    const Path alone = path_of_text(head + square), first = path_of_text(head + circle);
    const auto pass_at = [](const Path& path, std::size_t from) {
        std::vector<Vec3> points;
        for (std::size_t i = from; i < from + 24; ++i) points.push_back(path.steps.at(i).foci.at(0).position);
        return points;
    };
    const auto length = [](const std::vector<Vec3>& points) {
        double sum = 0.0;
        for (std::size_t i = 0; i < points.size(); ++i) sum += distance(points[i], points[(i + 1) % points.size()]);
        return sum;
    };
    const std::vector<Vec3> last = pass_at(becomes, becomes.steps.size() - 24);
    for (const Vec3& point : pass_at(alone, 0))
        REQUIRE(std::ranges::any_of(last, [&](const Vec3& each) { return distance(each, point) < 1e-12; }));
    const double longest = std::max(length(pass_at(first, 0)), length(last));
    for (std::size_t i = 0; i + 24 <= becomes.steps.size(); i += 24)
        REQUIRE(length(pass_at(becomes, i)) < 1.02 * longest);
}

TEST_CASE("key frames: which shape a frame has is said, and what cannot be is named") {
    const std::string text =
        "format = \"haptogram-project-1\"\npoints = 10\nrate_hz = 20\n[[shape]]\nkind = \"circle\"\n[[shape]]\nkind = "
        "\"square\"\n[[keyframe]]\ntime_s = 0\nshape = {}\n[[keyframe]]\ntime_s = 1\nshape = {}\n";
    const auto with = [&](int first, int second) {
        return project_from_toml(fmt::format(fmt::runtime(text), first, second), "forms.toml");
    };
    REQUIRE(with(1, 2).key_frames[1].shape == 2);
    REQUIRE(project_from_toml(to_toml(with(2, 1)), "again").key_frames == with(2, 1).key_frames);
    REQUIRE_REFUSED(with(1, 3));
    // The first frame's is gone through when all are named.
    Project circle = with(1, 2);
    circle.shapes.pop_back();
    circle.key_frames.clear();
    const Path alone = compile(circle, "circle").path, both = compile(with(1, 2), "forms").path;
    for (std::size_t i = 0; i < 10; ++i)
        REQUIRE(distance(both.steps[i].foci[0].position, alone.steps[i].foci[0].position) < 2e-3);
    Project half = with(1, 2);
    half.key_frames.push_back({.time_s = 2.0});
    REQUIRE_REFUSED(compile(half, "forms"));
    REQUIRE_REFUSED(moved_by({{.time_s = 0.0}, {.time_s = 1.0, .shape = 2}}, pass(), centre, carrier_hz, many));
}

TEST_CASE("key frames: what makes no sense is named") {
    const auto message = [](const std::vector<KeyFrame>& frames, std::size_t most = many) {
        return heard::refusal_of([&] { (void)moved_by(frames, pass(), centre, carrier_hz, most); });
    };
    const KeyFrame first{}, last{.time_s = 1.0};
    REQUIRE_REFUSAL(message({first}));
    REQUIRE_REFUSAL(message({{.time_s = 0.5}, last}));
    REQUIRE_REFUSAL(message({first, last, {.time_s = 1.00001}}));
    REQUIRE_REFUSAL(message({first, {.time_s = 1.0, .amplitude = 1.5}}));
    REQUIRE_REFUSAL(message({first, {.time_s = 1.0, .scale = 0.0}}));
    REQUIRE_REFUSAL(message({first, {.time_s = 1.0, .am_hz = 3e4}}));
    REQUIRE_REFUSAL(message({first, {.time_s = 1.0, .move = {0.0, NAN, 0.0}}}));
    REQUIRE_REFUSAL(message({first, last}, 199));
    REQUIRE(message({first, last}, 200).identity == "no error");
}

TEST_CASE("key frames: a project has them, as a file and as a page's document, and its image plays them") {
    const std::string text =
        "format = \"haptogram-project-1\"\npoints = 10\nrate_hz = 20\n\n[[shape]]\nkind = \"circle\"\ndiameter_mm = "
        "30\n"
        "\n[[keyframe]]\ntime_s = 0\nease = \"smooth\"\nmark = true\n"
        "\n[[keyframe]]\ntime_s = 1\nmove_mm = [20, 0, 10]\nrotate_deg = [0, 30, 0]\nscale = 1.5\namplitude = "
        "0.5\nam_hz = 80\nease = \"step\"\n"
        "\n[[keyframe]]\ntime_s = 1.5\n";
    const Project project = project_from_toml(text, "moves.toml");
    REQUIRE(project.key_frames.size() == 3);
    REQUIRE(project.key_frames[0] == KeyFrame{.ease = Ease::smooth, .mark = true});
    REQUIRE(project.key_frames[1] == KeyFrame{.time_s = 1.0,
                                              .move = from_mm(20, 0, 10),
                                              .turn_deg = {0.0, 30.0, 0.0},
                                              .scale = 1.5,
                                              .amplitude = 0.5,
                                              .am_hz = 80.0,
                                              .ease = Ease::step});
    REQUIRE(project_from_toml(to_toml(project), "again").key_frames == project.key_frames);
    REQUIRE(project_from_toml(toml_of(document_of(text, "moves.toml")), "again").key_frames == project.key_frames);
    const Compiled compiled = compile(project, "moves");
    REQUIRE(compiled.path.periods() == 60'000);
    REQUIRE(compiled.path.steps.size() == 300);
    REQUIRE(compiled.path.steps.front().mark);
    // Where the shape was placed, and from there on.
    const auto middle = [&](std::size_t from) {
        Vec3 sum;
        for (std::size_t i = from; i < from + 10; ++i) sum = sum + 0.1 * compiled.path.steps[i].foci.at(0).position;
        return sum;
    };
    REQUIRE(distance(middle(0), from_mm(0, 0, 130)) < 1e-3);
    REQUIRE(distance(middle(200), from_mm(20, 0, 140)) < 1e-9);
    REQUIRE_REFUSED(project_from_toml(text + "path = \"a.json\"\n", "moves.toml"));
    const std::string hand =
        "format = \"haptogram-project-1\"\n[hand]\nrecording = \"synthetic:press\"\n[[keyframe]]\ntime_s = 0\n";
    REQUIRE_REFUSED(project_from_toml(hand, "hand.toml"));
    REQUIRE_REFUSED(project_from_toml(text + "speed = 1\n", "moves.toml"));
}
