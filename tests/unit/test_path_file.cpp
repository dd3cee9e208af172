// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include "../refusal.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/shape/adaptics.hpp"
#include "haptogram/shape/adaptics_frames.hpp"
#include "haptogram/shape/path_file.hpp"
#include "haptogram/verbs/compile.hpp"
#include "haptogram/verbs/document.hpp"

using namespace haptogram;

namespace {

constexpr double carrier_hz = 40e3;

/// A pattern file: a brush of one kind, from one place to another in 20 ms, and a pause there for 10 ms.
std::string pattern(const std::string& brush, const std::string& transform = "0", const std::string& more = "") {
    const auto number = [](const std::string& value) { return "{\"type\": \"f64\", \"value\": " + value + "}"; };
    const auto frame = [&](int time, const std::string& coords, const std::string& intensity, const std::string& type) {
        std::string text = "{\"type\": \"" + type + "\", \"time\": " + std::to_string(time) +
                           ", \"brush\": {\"brush\": " + brush +
                           ", \"transition\": {\"name\": \"linear\", \"params\": {}}}, \"intensity\": {\"intensity\": "
                           "{\"name\": \"constant\", \"params\": {\"value\": " +
                           number(intensity) +
                           "}}, \"transition\": {\"name\": \"linear\", \"params\": {}}}, \"cjumps\": [" + more + "]";
        if (!coords.empty())
            text +=
                ", \"coords\": {\"coords\": " + coords + ", \"transition\": {\"name\": \"linear\", \"params\": {}}}";
        return text + "}";
    };
    return "{\"$DATA_FORMAT\": \"MidAirHapticsAnimationFileFormat\", \"$REVISION\": \"0.1.0-alpha.2\", \"name\": \"x\","
           "\"keyframes\": [" +
           frame(0, R"({"x": -10, "y": 0, "z": 0})", "1", "standard") + "," +
           frame(20, R"({"x": 10, "y": 0, "z": 0})", "0.5", "standard") + "," + frame(30, "", "0.5", "pause") +
           ", {\"type\": \"stop\", \"time\": 30}], \"pattern_transform\": {\"geometric_transforms\": {\"translate\": "
           "{\"x\": " +
           number("0") + ", \"y\": " + number("0") + ", \"z\": " + number("150") +
           "}, \"rotation\": " + number(transform) + ", \"scale\": {\"x\": " + number("1") + ", \"y\": " + number("1") +
           ", \"z\": " + number("1") + "}}, \"intensity_factor\": " + number("1") +
           ", \"playback_speed\": " + number("1") +
           "}, \"user_parameter_definitions\": {\"depth\": {\"default\": 5, \"min\": 0, \"max\": 2, \"step\": 1}}}";
}

const std::string still =
    R"({"name": "circle", "params": {"radius": {"type": "f64", "value": 0}, "am_freq": {"type": "f64", "value": 0}}})";
const std::string ring =
    R"({"name": "circle", "params": {"radius": {"type": "f64", "value": 8}, "am_freq": {"type": "f64", "value": 0}}})";
const std::string line =
    R"({"name": "line", "params": {"length": {"type": "f64", "value": 6}, "thickness": {"type": "f64", "value": 1}, "rotation": {"type": "f64", "value": 90}, "am_freq": {"type": "f64", "value": 50}}})";

}  // namespace

TEST_CASE("path file: what is written is read back, bit by bit", "[path_file]") {
    std::mt19937_64 random(Catch::rngSeed());
    std::uniform_real_distribution<double> place(-0.1, 0.1), part(0.0, 1.0);
    Path path;
    for (std::uint32_t i = 0; i < 200; ++i) {
        PathStep& step = path.steps.emplace_back();
        step.periods = 1 + i * i;
        for (std::uint32_t k = 0; k < i % 4; ++k)
            step.foci.push_back({{place(random), place(random), 0.15 + place(random)}, part(random)});
    }
    path.modulation = {{0.0, 1.0, part(random), part(random)}, 7};
    const Path back = path_from_json(to_json_text(path, carrier_hz), "p.json", carrier_hz);
    REQUIRE(back.steps.size() == path.steps.size());
    REQUIRE(back.modulation == path.modulation);
    for (std::size_t i = 0; i < path.steps.size(); ++i) {
        REQUIRE(back.steps[i].periods == path.steps[i].periods);
        REQUIRE(back.steps[i].foci.size() == path.steps[i].foci.size());
        for (std::size_t k = 0; k < path.steps[i].foci.size(); ++k) {
            const Focus a = path.steps[i].foci[k], b = back.steps[i].foci[k];
            REQUIRE(a.amplitude == b.amplitude);
            REQUIRE(distance(a.position, b.position) < 1e-16);
        }
    }
    // A second time there is nothing left to round.
    REQUIRE(to_json_text(back, carrier_hz) == to_json_text(path, carrier_hz));
}

TEST_CASE("path file: rows of a CSV are foci that last until the next row", "[path_file]") {
    const Path path = path_from_csv(
        "# a "
        "comment\nTime_ms,x_mm,y_mm,z_mm,intensity\n5,0,0,130,1\n5.1,10,0,130,0.5\n5.16,0,0,130,0\n6.16,1,2,130,1\n",
        "p.csv", carrier_hz);
    // 4, 2.4, 40 and 40 periods.
    const Path expected{
        {{{{from_mm(0, 0, 130)}}, 4}, {{{from_mm(10, 0, 130), 0.5}}, 2}, {{}, 40}, {{{from_mm(1, 2, 130)}}, 40}}, {}};
    REQUIRE(path == expected);
    const Path seconds = path_from_csv("z_mm;x_mm;y_mm;time_s\n130;1;2;0\n130;3;4;0.001\n", "p.csv", carrier_hz);
    REQUIRE(seconds == Path{{{{{from_mm(1, 2, 130)}}, 40}, {{{from_mm(3, 4, 130)}}, 40}}, {}});
}

TEST_CASE("path file: a CSV's column of marks is that of the steps, also of silence", "[path_file]") {
    const Path path = path_from_csv(
        "time_ms,x_mm,y_mm,z_mm,mark,intensity\n0,0,0,130,0,1\n1,0,0,130,1,0\n2,0,0,130,1,1\n", "p.csv", carrier_hz);
    const Path expected{{{{{from_mm(0, 0, 130)}}, 40}, {{}, 40, true}, {{{from_mm(0, 0, 130)}}, 40, true}}, {}};
    REQUIRE(path == expected);
}

TEST_CASE("path file: a CSV's times are kept on average, whatever the carrier period", "[path_file]") {
    std::string text = "time_ms,x_mm,y_mm,z_mm\n";
    for (int i = 0; i < 100; ++i) text += std::to_string(i * 0.1111) + ",0," + std::to_string(i % 2) + ",130\n";
    const Path path = path_from_csv(text, "p.csv", carrier_hz);
    REQUIRE(static_cast<double>(path.periods()) == Approx(100 * 0.1111e-3 * carrier_hz).margin(0.6));
    for (const PathStep& step : path.steps) REQUIRE((step.periods == 4 || step.periods == 5));
}

TEST_CASE("path file: mistakes are named with their place", "[path_file]") {
    const auto refuses = [](const std::string& text) {
        CAPTURE(text);
        REQUIRE_REFUSED(path_from_json(text, "p.json", carrier_hz));
    };
    const auto steps = [](const std::string& list) {
        return R"({"format": "haptogram-path-1", "carrier_hz": 40000, "steps": [)" + list + "]}";
    };
    refuses("{");
    refuses(R"({"carrier_hz": 1e999})");
    refuses("[]");
    refuses("{}");
    refuses(R"({"format": "haptogram-path-2"})");
    refuses(R"({"format": "haptogram-path-1", "carrier_hz": 41000, "steps": []})");
    refuses(steps(""));
    refuses(steps(R"({"periods": 0, "foci": []})"));
    refuses(steps(R"({"periods": 1.5, "foci": []})"));
    refuses(steps(R"({"periods": 1, "foci": [{"position_mm": [1, 2]}]})"));
    refuses(steps(R"({"periods": 1, "foci": [{"position_mm": [1, 2, "a"]}]})"));
    refuses(steps(R"({"periods": 1, "foci": [{"position_mm": [1, 2, 3], "amplitude": 1.1}]})"));
    refuses(steps(R"({"periods": 1, "foci": [], "focus": 1})"));
    const auto refuses_csv = [](const std::string& text) {
        CAPTURE(text);
        REQUIRE_REFUSED(path_from_csv(text, "p.csv", carrier_hz));
    };
    const std::string head = "time_s,x_mm,y_mm,z_mm,intensity\n";
    refuses_csv("0,1,2,3,4\n");
    refuses_csv("time_s,x_mm,y_mm\n");
    refuses_csv("time_s,x_mm,y_mm,z_mm,speed\n");
    refuses_csv("time_s,time_ms,x_mm,y_mm,z_mm\n");
    refuses_csv(head);
    refuses_csv(head + "0,0,0,130,1\n");
    refuses_csv(head + "0,0,0,130,1\n0.00001,0,0,130,1\n");
    refuses_csv(head + "0,0,0,130,1\n0.1,0,0,130,2\n");
    refuses_csv("time_s,x_mm,y_mm,z_mm,mark\n0,0,0,130,2\n");
    refuses_csv("time_s,x_mm,y_mm,z_mm,mark,mark\n");
    refuses_csv(head + "0,0,0,130\n");
    refuses_csv(head + "0,0,0,x,1\n");
    REQUIRE_REFUSED(path_of_file("", "p.txt", carrier_hz));
}

TEST_CASE("path file: an AdapTics pattern goes from place to place and holds", "[path_file]") {
    const Path path = path_from_adaptics(pattern(still), "p.adaptics", carrier_hz, 60);
    // Every half millisecond: 40 samples on the way, then a pause, which is one step.
    REQUIRE(path.periods() == 1200);
    REQUIRE(path.steps.size() == 41);
    for (std::size_t i = 0; i < 40; ++i) {
        const double part = (static_cast<double>(i) + 0.5) / 40.0;
        REQUIRE(path.steps[i].periods == 20);
        REQUIRE(distance(path.steps[i].foci[0].position, from_mm(-10 + 20 * part, 0, 150)) < 1e-12);
        REQUIRE(path.steps[i].foci[0].amplitude == Approx(1.0 - 0.5 * part));
    }
    REQUIRE(path.steps[40].periods == 400);
    REQUIRE(path.steps[40].foci[0].amplitude == Approx(0.5));
}

TEST_CASE("path file: brushes of an AdapTics pattern turn and pulsate around the place", "[path_file]") {
    const Path circle = path_from_adaptics(pattern(ring, "90"), "p.adaptics", carrier_hz, 600);
    const Path stroke = path_from_adaptics(pattern(line), "p.adaptics", carrier_hz, 600);
    for (std::size_t i = 0; i < 600; ++i) {
        const double ms = (static_cast<double>(i) + 0.5) * 0.05;
        const double along = -10.0 + 20.0 * std::min(1.0, ms / 20.0);
        const double turns = 2.0 * std::numbers::pi * 0.1 * ms;
        // The way is turned to +y by the pattern; the brush is not.
        const Vec3 on_circle = from_mm(8.0 * std::cos(turns), along + 8.0 * std::sin(turns), 150.0);
        REQUIRE(distance(circle.steps.at(i).foci.at(0).position, on_circle) < 1e-12);
        const Focus on_line = stroke.steps.at(i).foci.at(0);
        REQUIRE(distance(on_line.position, from_mm(along, 6.0 * std::cos(turns), 150.0)) < 1e-12);
        const double level =
            (1.0 - 0.5 * std::min(1.0, ms / 20.0)) * (0.5 + 0.5 * std::cos(2.0 * std::numbers::pi * 0.05 * ms));
        REQUIRE(on_line.amplitude == Approx(level).margin(1e-12));
    }
}

TEST_CASE("path file: key frames of an AdapTics pattern play what the pattern is as a path", "[path_file]") {
    const std::string beats =
        R"({"name": "circle", "params": {"radius": {"type": "f64", "value": 8}, "am_freq": {"type": "f64", "value": 50}}})";
    const std::string& brush = GENERATE_REF(still, ring, beats);
    const std::string text = pattern(brush, "90");
    const AdapticsFrames found = frames_from_adaptics(text, "p.adaptics");
    REQUIRE(found.frames.size() == 3);
    REQUIRE(found.diameter_m.has_value() == (&brush != &still));
    // 16 places of the circle, each for 25 periods: a hundred circles a second.
    Path pass;
    for (int i = 0; i < 16; ++i) {
        const double turns = 2.0 * std::numbers::pi * (i + 0.5) / 16.0, radius = 0.5 * found.diameter_m.value_or(0.0);
        pass.steps.push_back({{{found.centre + radius * Vec3{std::cos(turns), std::sin(turns), 0.0}, 1.0}}, 25});
    }
    const Path moved = moved_by(found.frames, pass, found.centre, carrier_hz, 1000);
    REQUIRE(moved.periods() == 1200);
    const Path path = path_from_adaptics(text, "p.adaptics", carrier_hz, 48);
    std::uint64_t now = 0;
    std::size_t at = 0;
    for (const PathStep& step : path.steps)
        for (const std::uint64_t end = now + step.periods; now < end; now += moved.steps.at(at++).periods) {
            REQUIRE(moved.steps.at(at).foci.size() == step.foci.size());
            if (step.foci.empty()) continue;
            REQUIRE(distance(moved.steps.at(at).foci[0].position, step.foci[0].position) < 1e-12);
            REQUIRE(moved.steps.at(at).foci[0].amplitude == Approx(step.foci[0].amplitude).margin(1e-12));
        }
    REQUIRE(at == 48);
}

TEST_CASE("path file: an AdapTics pattern as a project, or why its key frames are none of a shape", "[path_file]") {
    const Project project = project_from_adaptics(pattern(ring, "90"), "p");
    CHECK(project.shapes.at(0).primitive.kind == "circle");
    CHECK(project.pace.frequency_hz == 100.0);
    CHECK(project.key_frames.at(1).amplitude == 0.5);
    CHECK(distance(project.key_frames.at(2).move, from_mm(0, 20, 0)) < 1e-12);
    CHECK(project_from_toml(to_toml(project), "again").key_frames == project.key_frames);
    const Compiled compiled = compile(project, "p");
    CHECK(static_cast<double>(compiled.path.periods()) == 1200.0);
    CHECK(compile(project_from_adaptics(pattern(still), "p"), "p").path.steps.size() == 30);
    const auto refuses = [](std::string text, const std::string& from, const std::string& to,
                            const std::string& words) {
        CAPTURE(words);
        for (std::size_t at = text.find(from); !from.empty() && at != std::string::npos;
             at = text.find(from, at + to.size()))
            text.replace(at, from.size(), to);
        REQUIRE_REFUSED(project_from_adaptics(text, "p.adaptics"));
    };
    refuses(pattern(line), "", "", "its brush is a line");
    refuses(pattern(ring), "\"time\": 30", "\"time\": 3000", "6 points each are more than the 400 steps");
    // The strength falls evenly while the place waits for its step.
    const std::string coords = R"("coords": {"x": -10, "y": 0, "z": 0}, "transition": {"name": "linear")";
    refuses(pattern(still), coords, R"("coords": {"x": -10, "y": 0, "z": 0}, "transition": {"name": "step")",
            "from 0 ms on one thing changes evenly and another in a step");
    refuses("{\"$DATA_FORMAT\": 1}", "", "", "$DATA_FORMAT");
}

TEST_CASE("path file: the same path by hand in two formats gives the same pulses", "[path_file]") {
    const Array array = find_array("tile-10x10");
    const Core core = find_configuration("tile-100");
    const Path from_pattern = path_from_adaptics(pattern(still), "p.adaptics", carrier_hz, 60);
    std::string rows = "time_ms,x_mm,y_mm,z_mm,intensity\n";
    for (int i = 0; i < 40; ++i) {
        const double part = (i + 0.5) / 40.0;
        rows += std::to_string(0.5 * i) + "," + std::to_string(-10 + 20 * part) + ",0,150," +
                std::to_string(1 - 0.5 * part) + "\n";
    }
    rows += "20,10,0,150,0.5\n30,10,0,150,0\n31,10,0,150,0\n";
    Path from_rows = path_from_csv(rows, "p.csv", carrier_hz);
    from_rows.steps.resize(41);  // the last two rows only say how long the pause is
    const Compiled one = compile(from_pattern, array, core), other = compile(from_rows, array, core);
    REQUIRE(one.bundle.hex == other.bundle.hex);
    const Path from_json = path_from_json(to_json_text(from_pattern, carrier_hz), "p.json", carrier_hz);
    REQUIRE(compile(from_json, array, core).bundle.hex == one.bundle.hex);
}

namespace {

std::string with_radius(const std::string& type, const std::string& value) {
    return R"({"name": "circle", "params": {"radius": {"type": ")" + type + R"(", "value": )" + value +
           R"(}, "am_freq": {"type": "f64", "value": 0}}})";
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
    REQUIRE(text.find(from) != std::string::npos);
    return text.replace(text.find(from), from.size(), to);
}

}  // namespace

TEST_CASE("path file: AdapTics parameters and formulas have their defaults, or what is set", "[path_file][adaptics]") {
    const auto radius = [](const std::string& type, const std::string& value, const Parameters& given = {}) {
        const Path path = path_from_adaptics(pattern(with_radius(type, value)), "p.adaptics", carrier_hz, 300, given);
        return distance(path.steps[0].foci[0].position, from_mm(-10 + 0.05, 0, 150)) / millimetre;
    };
    for (const char* const type : {"param", "dynamic"}) {
        CHECK(radius(type, "\"depth\"") == Approx(2.0));  // 5 is more than the most, 2
        CHECK(radius(type, "\"depth\"", {{"depth", 0.5}}) == Approx(0.5));
    }
    CHECK(radius("param", "\"nowhere\"") == Approx(0.0).margin(1e-9));
    CHECK(radius("param", "\"nowhere\"", {{"nowhere", 3.0}}) == Approx(3.0));
    const std::string depth = R"({"type": "parameter", "value": "depth"})";
    const auto of = [&depth](const std::string& name, const std::string& right) {
        return R"({"type": ")" + name + R"(", "value": [)" + depth + "," + right + "]}";
    };
    const std::string three = R"({"type": "constant", "value": 3})";
    CHECK(radius("formula", of("add", three)) == Approx(5.0));
    CHECK(radius("formula", of("Multiply", of("subtract", R"({"type": "constant", "value": 0.5})"))) == Approx(3.0));
    CHECK(radius("formula", of("divide", three), {{"depth", 1.5}}) == Approx(0.5));
    CHECK(radius("formula", depth) == Approx(2.0));
    REQUIRE_REFUSED(radius("formula", of("divide", of("subtract", depth))));
    REQUIRE_REFUSED(radius("formula", of("power", three)));
    REQUIRE_REFUSED(radius("formula", R"({"type": "add", "value": [1]})"));
    REQUIRE_REFUSED(radius("formula", "\"depth + 1\""));
    REQUIRE_REFUSED(radius("random", "1"));
    REQUIRE_REFUSED(radius("f64", "1", {{"deep", 1.0}}));
    REQUIRE_REFUSED(radius("param", "\"depth\"", {{"depth", 3.0}}));
    CHECK(parameters_of("push=0.5, how deep=-2e1") == Parameters{{"push", 0.5}, {"how deep", -20.0}});
    for (const char* const wrong : {"", "push", "push=", "=1", "push=a", "push=1,push=2", "push=1,", "push=inf"})
        CHECK_FALSE(parameters_of(wrong));
}

TEST_CASE("path file: AdapTics jumps to the beginning are loops, and templates play", "[path_file][adaptics]") {
    const auto jump = [](const std::string& name, const std::string& to = "0") {
        return R"({"condition": {"parameter": "depth", "value": 1, "operator": {"name": ")" + name +
               R"(", "params": {}}}, "jump_to": )" + to + "}";
    };
    const auto path_of_jump = [&](const std::string& name, const std::string& to = "0", const Parameters& given = {}) {
        return path_from_adaptics(pattern(still, "0", jump(name, to)), "p", carrier_hz, 40, given);
    };
    CHECK(path_of_jump("lt").periods() == 1200);
    CHECK(path_of_jump("gt").periods() == 800);  // before the pause
    CHECK(path_of_jump("gt_eq").periods() == 800);
    CHECK(path_of_jump("gt", "5", {{"depth", 0.0}}).periods() == 1200);
    REQUIRE_REFUSED(path_of_jump("gt", "5"));
    REQUIRE_REFUSED(path_of_jump("eq"));
    const auto template_of = [](const std::string& brush) {
        std::string text = pattern(brush);
        const std::size_t second = text.find(R"(,{"type": "standard", "time": 20)"),
                          end = text.find("], \"pattern_transform");
        return text.erase(second, end - second);
    };
    const Path circle = path_from_adaptics(template_of(ring), "p", carrier_hz, 40);
    CHECK(circle.periods() == 400);
    CHECK(distance(circle.steps.at(10).foci.at(0).position, from_mm(-10 + 8 * std::cos(1.05 * std::numbers::pi / 2),
                                                                    8 * std::sin(1.05 * std::numbers::pi / 2), 150)) <
          1e-12);
    const std::string beating =
        replaced(ring, R"("am_freq": {"type": "f64", "value": 0)", R"("am_freq": {"type": "f64", "value": 125)");
    CHECK(path_from_adaptics(template_of(beating), "p", carrier_hz, 40).periods() == 1600);
    REQUIRE_REFUSED(path_from_adaptics(replaced(template_of(ring), R"("type": "standard")", R"("type": "pause")"), "p",
                                       carrier_hz, 40));
}

TEST_CASE("path file: what is no AdapTics pattern is refused", "[path_file][adaptics]") {
    REQUIRE_REFUSED(path_from_adaptics(replaced(pattern(still), "0.1.0", "0.0.3"), "p.adaptics", carrier_hz, 300));
    REQUIRE_REFUSED(path_from_adaptics("{}", "p.adaptics", carrier_hz, 300));
    REQUIRE_REFUSED(path_from_adaptics(pattern(still), "p", carrier_hz, 1201));
}

TEST_CASE("path file: times since 1970 in milliseconds are not taken for seconds", "[path_file]") {
    REQUIRE_REFUSED(
        path_from_csv("time_s,x_mm,y_mm,z_mm\n1700000000000,0,0,130\n1700000000010,1,0,130\n", "p.csv", carrier_hz));
    CHECK(path_from_csv("time_ms,x_mm,y_mm,z_mm\n1700000000000,0,0,130\n1700000000010,1,0,130\n", "p.csv", carrier_hz)
              .periods() == 800);
    CHECK(is_path_csv("t,x,y,z\n0,1,2,3\n"));
    REQUIRE_REFUSED(path_from_csv("t,x,y,z\n0,1,2,3\n1,1,2,3\n", "p.csv", carrier_hz));
}
