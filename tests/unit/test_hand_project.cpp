// SPDX-License-Identifier: Apache-2.0
// Projects whose subject is a hand: their files, their images, and a frame for a view.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "../refusal.hpp"
#include "../test_data.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/hand/project.hpp"
#include "haptogram/hand/recording.hpp"
#include "haptogram/shape/path_file.hpp"
#include "haptogram/verbs/document.hpp"

using namespace haptogram;

namespace {

const std::string head = "format = \"haptogram-project-1\"\n";

Project read(const std::string& text) { return project_from_toml(head + text, "test"); }

Project sliding(std::size_t frame, const std::string& object = "sphere", const std::string& algorithm = "A") {
    Project project;
    project.makers = path_makers();
    HandSource& hand = project.hand.emplace();
    hand.recording = "synthetic:slide";
    hand.object.name = object;
    hand.algorithm = algorithm;
    hand.frame = frame;
    project.points = 60;
    return project;
}

}  // namespace

TEST_CASE("hand project: whatever is set survives the way to a file and back, and to JSON and back") {
    CAPTURE(Catch::rngSeed());
    std::mt19937_64 random(Catch::rngSeed());
    const auto one_in_two = [&] { return random() % 2 == 0; };
    const auto number = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
    for (int round = 0; round < 50; ++round) {
        Project project = sliding(1 + random() % 500);
        HandSource& hand = *project.hand;
        if (one_in_two()) {
            hand.recording = "a \"hand\" ä \\ ' .pose";
            hand.model = one_in_two() ? "bones.json" : "";
            hand.rate_hz = number(1.0, 500.0);
        }
        if (one_in_two()) {
            hand.object.name = "cone";
            if (one_in_two()) hand.object.height_m = number(1e-3, 1.0);
        } else {
            hand.object.name = "mesh $(x).stl";
            hand.object.unit = one_in_two() ? "mm" : "cm";
        }
        if (one_in_two()) hand.object.size_m = number(1e-3, 1.0);
        hand.object.centre = {number(-1.0, 1.0), number(-1.0, 1.0), number(-1.0, 1.0)};
        hand.object.angles_deg = {number(-180.0, 180.0), 0.0, number(-180.0, 180.0)};
        hand.algorithm = std::string(1, static_cast<char>('A' + random() % 12));
        if (one_in_two()) project.pace = one_in_two() ? Pace{number(0.1, 20.0), {}} : Pace{{}, number(0.1, 200.0)};
        project.points = 1 + random() % 1000;
        project.seed = random() % 100;
        const std::string text = to_toml(project);
        INFO(text);
        const Project again = project_from_toml(text, "again");
        CHECK(to_toml(again) == text);
        CHECK(distance(again.hand->object.centre, hand.object.centre) < 1e-15);  // some numbers have no text in mm
        REQUIRE(again.hand->object.size_m.has_value() == hand.object.size_m.has_value());
        REQUIRE(again.hand->object.height_m.has_value() == hand.object.height_m.has_value());
        CHECK(std::abs(again.hand->object.size_m.value_or(0.0) - hand.object.size_m.value_or(0.0)) < 1e-15);
        CHECK(std::abs(again.hand->object.height_m.value_or(0.0) - hand.object.height_m.value_or(0.0)) < 1e-15);
        CHECK(again.hand->object.unit == hand.object.unit);
        CHECK(again.hand->recording == hand.recording);
        CHECK(again.hand->frame == hand.frame);
        CHECK(to_toml(project_from_toml(toml_of(document_of(text, "json")), "json")) == text);
    }
}

TEST_CASE("hand project: bad ones are refused by the key") {
    const char* const wrong[] = {
        "[hand]\nobject = \"cube\"\n",
        "[hand]\nrecording = 5\n",
        "[hand]\nrecording = \"synthetic:press\"\nframes = 3\n",
        "[hand]\nrecording = \"synthetic:press\"\nframe = 0\n",
        "[hand]\nrecording = \"synthetic:press\"\nalgorithm = \"M\"\n",
        "[hand]\nrecording = \"synthetic:press\"\nunit = \"furlong\"\n",
        "[hand]\nrecording = \"synthetic:press\"\nsize_mm = -1\n",
        "points = 9\n[hand]\nrecording = \"synthetic:press\"\n",
        "rate_hz = 9\n[hand]\nrecording = \"synthetic:press\"\n",
        "path = \"p.json\"\n[hand]\nrecording = \"synthetic:press\"\n",
        "[hand]\nrecording = \"synthetic:press\"\n[[shape]]\nkind = \"circle\"\n",
        "hand = 3\n",
    };
    for (const char* text : wrong) {
        INFO(text);
        CHECK_REFUSED(read(text));
    }
    CHECK_REFUSED(render_options(read("[[shape]]\nkind = \"circle\"\n")));
}

TEST_CASE("hand project: the image is that of the path that is rendered, for every algorithm") {
    const char letter = GENERATE(range('A', static_cast<char>('L' + 1)));
    CAPTURE(letter);
    Project project = sliding(60, "cube", std::string(1, letter));
    project.hand->object.size_m = 80e-3;
    project.hand->object.angles_deg = {0.0, 0.0, 30.0};
    const ProjectInstrument instrument = instrument_of(project);
    const Rendered rendered = render(project, instrument);
    const Path path = path_from_json(to_json_text(rendered.path, rendered.carrier_hz), "path", rendered.carrier_hz);
    const auto image_of = [](auto make) -> std::string {
        try {
            return make().bundle.hex;
        } catch (const Error& error) {
            return error.message();  // of K, whose modulation needs more records than the board has
        }
    };
    CHECK(image_of([&] { return compile(project); }) ==
          image_of([&] { return compile(path, instrument.array, instrument.core); }));
    REQUIRE(rendered.touch);
    CHECK(rendered.touch->lines.size() == rendered.frames.front().lines);
}

TEST_CASE("hand project: a view has the path's foci, lines where the voices go, and a skin around them") {
    CAPTURE(Catch::rngSeed());
    std::mt19937_64 random(Catch::rngSeed());
    const Project project = sliding(1 + random() % 300, random() % 2 == 0 ? "sphere" : "cylinder");
    CAPTURE(*project.hand->frame, project.hand->object.name);
    const ProjectInstrument instrument = instrument_of(project);
    const HandView view = hand_view(project, instrument);
    const Rendered rendered = render(project, instrument);
    REQUIRE(view.report);
    CHECK(view.frames == 300);
    CHECK(view.frame == *project.hand->frame);
    CHECK(view.time_s == Approx(0.01 * static_cast<double>(view.frame - 1)));
    CHECK(view.end_s == Approx(2.99));
    CHECK_FALSE(view.nothing);
    CHECK(view.pass_s == Approx(1.0 / view.report->draw_hz).margin(1e-4));
    std::vector<Vec3> foci;
    for (const PathStep& step : rendered.path.steps)
        for (const Focus& focus : step.foci) foci.push_back(focus.position);
    CHECK(view.foci == foci);
    // All that is drawn is as long as the report says, and the weak part of it is its share.
    const auto length = [](const auto& segments) {
        double sum = 0.0;
        for (const auto& [from, to] : segments) sum += distance(from, to);
        return sum;
    };
    const double strong = length(view.strong), weak = length(view.weak);
    CHECK(strong + weak == Approx(view.report->length_m).epsilon(1e-6));
    CHECK(weak / (strong + weak) == Approx(view.report->weak).margin(1e-6));
    // The drawn skin is coarser than the one that is rendered on, but no line is far from it.
    for (const Vec3& focus : foci) {
        double nearest = INFINITY;
        for (const auto& triangle : view.skin)
            for (const Vec3& corner : triangle) nearest = std::min(nearest, distance(corner, focus));
        CHECK(nearest < 4e-3);
    }
}

TEST_CASE("hand project: a frame without lines says why, and one that is not there is refused") {
    Project project = sliding(10, "sphere", "B");
    const ProjectInstrument instrument = instrument_of(project);
    const HandView nothing = hand_view(project, instrument);
    REQUIRE(nothing.nothing);
    CHECK_SAID(nothing.nothing->message());
    CHECK(nothing.foci.empty());
    CHECK_FALSE(nothing.skin.empty());
    project.hand->object.centre.z = 0.5;
    CHECK_SAID(hand_view(project, instrument).nothing->message());
    project.hand->frame = 301;
    CHECK_REFUSED(hand_view(project, instrument));
    project.hand->frame.reset();
    CHECK_REFUSED(hand_view(project, instrument));
    auto empty = std::make_shared<HandRecording>();
    empty->frames.resize(1);
    project.hand->frame = 1;
    project.hand->hands = empty;
    CHECK_SAID(hand_view(project, instrument).nothing->message());
    project.points = 0;  // settings that make no sense in any frame are no property of this one
    project.hand->hands.reset();
    CHECK_REFUSED(hand_view(project, instrument));
}

TEST_CASE("hand project: the drawn surface of every built-in object lies on it, and looks outwards") {
    for (const std::string_view kind : object_kinds()) {
        ObjectSource source;
        source.name = kind;
        source.angles_deg = {15.0, -40.0, 70.0};
        CAPTURE(source.name);
        const TouchObject object = open_object(source);
        const Mesh mesh = surface_of(source);
        REQUIRE(mesh.triangles.size() > 1000);
        double farthest = 0.0;
        for (const Vec3& vertex : mesh.vertices) farthest = std::max(farthest, std::abs(object.solid.distance(vertex)));
        CHECK(farthest < 2.5e-3);  // a cell is 2 to 4 mm
        const auto& [a, b, c] = mesh.triangles.front();
        const Vec3 middle = (1.0 / 3.0) * (mesh.vertices[a] + mesh.vertices[b] + mesh.vertices[c]);
        const Vec3 normal = cross(mesh.vertices[b] - mesh.vertices[a], mesh.vertices[c] - mesh.vertices[a]);
        CHECK(object.solid.distance(middle + (1e-3 / norm(normal)) * normal) > 0.0);
    }
}

TEST_CASE("hand project: files come from the reader that is given, and are known by name") {
    Project project = sliding(1);
    CHECK(files_of(*project.hand).empty());
    project.hand->recording = "hand.pose";
    project.hand->object.name = "box.stl";
    CHECK(files_of(*project.hand) == std::vector<std::string>{"hand.pose", "model_hand.json", "box.stl"});
    project.hand->model = "bones.json";
    CHECK(files_of(*project.hand)[1] == "bones.json");
    std::vector<std::string> asked;
    const FileReader reader = [&](const std::filesystem::path& file) -> std::string {
        asked.push_back(file.string());
        throw bad_input(file.string(), "is not here");
    };
    CHECK_REFUSED(open_hand(project, reader));
    CHECK(asked.size() == 1);
    const std::string box = test_data() + "/shapes/trimesh_binary.stl";
    ObjectSource named, given;
    named.name = box;
    given.name = "box.stl";
    const auto content = [&](const std::filesystem::path&) { return read_file(box); };
    CHECK(surface_of(given, content).vertices == surface_of(named).vertices);
}
