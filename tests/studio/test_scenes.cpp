// SPDX-License-Identifier: Apache-2.0
// Documents, files and scenes: the same bytes as without the studio, and no other files of this machine.
#include <array>
#include <catch2/catch.hpp>
#include <complex>
#include <future>
#include <thread>

#include "../refusal.hpp"
#include "../test_data.hpp"
#include "assets.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/process.hpp"
#include "haptogram/hand/project.hpp"
#include "haptogram/shape/place.hpp"
#include "haptogram/verbs/document.hpp"
#include "live.hpp"
#include "pins.hpp"
#include "scenes.hpp"
#include "worker.hpp"

using namespace haptogram;
using namespace haptogram::studio;
using Catch::Contains;
using nlohmann::ordered_json;

namespace {

const std::string data = test_data();
const std::string circle =
    "format = \"haptogram-project-1\"\npoints = 8\nrate_hz = 500\n\n[[shape]]\nkind = \"circle\"\n";

ordered_json with_file(const std::string& name) {
    return {{"format", "haptogram-project-1"},
            {"points", 20},
            {"place", {{"size_mm", 40}, {"center_mm", {0, 0, 130}}}},
            {"shape", {{{"file", name}}}}};
}

}  // namespace

TEST_CASE("studio scenes: a document makes the image that its project file makes") {
    Scenes scenes;
    const auto scene = scenes.compile(document_of(circle, "circle")).scene;
    const Compiled direct = compile(project_from_toml(circle, "circle"));
    CHECK(scene->compiled.bundle.hex == direct.bundle.hex);
    CHECK(to_text(scene->compiled.bundle.manifest) == to_text(direct.bundle.manifest));
    const Compiled again = compile(project_from_toml(scene->project, "taken away"));
    CHECK(again.bundle.hex == direct.bundle.hex);
    CHECK(to_text(again.bundle.manifest) == to_text(direct.bundle.manifest));
    CHECK(to_json(*scene)["foci"].size() == 8);
    CHECK(scenes.find(scene->name) == scene);
    CHECK(scenes.compile(document_of(circle, "circle")).scene == scene);
}

TEST_CASE("studio scenes: a dropped file makes the image that the file makes") {
    const std::filesystem::path file = std::filesystem::path(data) / "shapes/trimesh_binary.stl";
    REQUIRE(std::filesystem::exists(file));
    Scenes scenes;
    scenes.add_file("trimesh_binary.stl", read_file(file));
    const auto scene = scenes.compile(with_file("trimesh_binary.stl")).scene;
    TemporaryFolder folder;
    std::filesystem::copy(file, folder.path() / "trimesh_binary.stl");
    write_file(folder.path() / "project.toml", scene->project);
    const Compiled direct = compile(load_project(folder.path() / "project.toml"));
    CHECK(scene->compiled.bundle.hex == direct.bundle.hex);
    CHECK(to_text(scene->compiled.bundle.manifest) == to_text(direct.bundle.manifest));
}

TEST_CASE("studio scenes: what is refused has ways out, and each of them works") {
    const ordered_json circle_40{{"kind", "circle"}, {"diameter_mm", 40}};
    const auto with = [&](ordered_json more) {
        ordered_json document{{"format", "haptogram-project-1"}, {"shape", {circle_40}}};
        document.update(more);
        return document;
    };
    const ordered_json moves = {{{"time_s", 0}}, {{"time_s", 1}, {"move_mm", {20, 0, 0}}}};
    const std::vector<std::pair<std::string, ordered_json>> refused = {
        {"more records than a board has", with({{"am", "sine:50"}, {"rate_hz", 2}})},
        {"more steps than a board plays", with({{"keyframe", moves}})},
        {"more points than a board has records", with({{"points", 5000}})},
        {"less than a period a point", with({{"rate_hz", 2000}})},
        {"drawn too often", with({{"frequency_hz", 2000}})},
        {"drawn too fast", with({{"speed_m_s", 500}})},
        {"longer than an entry holds", with({{"points", 2}, {"rate_hz", 0.001}})},
        {"out of reach", with({{"place", {{"center_mm", {0, 0, -20}}}}})},
        {"partly out of reach", with({{"shape", {{{"kind", "line"}, {"length_mm", 900}}}}})}};
    Scenes scenes;
    for (const auto& [why, document] : refused) {
        INFO(why << ": " << document.dump());
        CHECK_THROWS_AS(scenes.compile(document), Error);
        const std::vector<Remedy> ways = scenes.ways_out(document);
        CHECK_FALSE(ways.empty());
        for (const Remedy& way : ways) {
            INFO(to_json(way).dump());
            ordered_json mended = document;
            mended.merge_patch(way.changes);
            CHECK_NOTHROW(scenes.compile(mended));
        }
    }
    // The smallest change stands first, and one point is no shape.
    const auto first = [&](ordered_json more) { return scenes.ways_out(with(std::move(more))).at(0).label; };
    const ordered_json circle_20{{"kind", "circle"}, {"diameter_mm", 20}};
    const ordered_json moving{{"shape", {circle_20}}, {"speed_m_s", 7}, {"points", 20}, {"keyframe", moves}};
    CHECK_THAT(first(moving), Catch::Matchers::StartsWith("Draw it at "));
    CHECK_THAT(first({{"shape", {circle_20}}, {"speed_m_s", 7}, {"points", 30}, {"am", "square:200"}}),
               Catch::Matchers::StartsWith("Draw it at "));
    for (const ordered_json& document : {with({{"am", "sine:50"}, {"rate_hz", 2}}), with({{"points", 5000}})})
        for (const Remedy& way : scenes.ways_out(document)) {
            INFO(way.label);
            CHECK(way.changes.value("points", 200) >= 5);
            CHECK_FALSE(way.changes.contains("place"));
        }
    // What cannot be read, or names a file that is not there, is not mended by other numbers.
    CHECK(scenes.ways_out(with({{"points", "many"}})).empty());
    CHECK(scenes.ways_out(with_file("none.stl")).empty());
}

TEST_CASE("studio scenes: the object is the one that was sampled, new and known") {
    Scenes scenes;
    const std::string name = "trimesh_binary.stl";
    scenes.add_file(name, read_file(std::filesystem::path(data) / "shapes" / name));
    Project project = project_from_toml(toml_of(with_file(name)), "test");
    project.folder = std::filesystem::path(data) / "shapes";
    const Shape expected = shape_of(project);
    for (int i = 0; i < 2; ++i) {  // the second time the scene is known
        const Shape shape = scenes.compile(with_file(name)).shape;
        REQUIRE(shape.pieces.size() == 1);
        CHECK(std::get<Mesh>(shape.pieces[0]).vertices == std::get<Mesh>(expected.pieces[0]).vertices);
        CHECK(std::get<Mesh>(shape.pieces[0]).triangles == std::get<Mesh>(expected.pieces[0]).triangles);
    }
}

TEST_CASE("studio scenes: objects have places of their own, and the whole has one, too") {
    Scenes scenes;
    ordered_json document{{"format", "haptogram-project-1"},
                          {"points", 40},
                          {"shape",
                           {{{"kind", "circle"}, {"diameter_mm", 20}, {"center_mm", {-30, 0, 120}}},
                            {{"kind", "circle"}, {"size_mm", 10}, {"center_mm", {30, 5, 150}}}}}};
    const auto extent = [&] { return bounding_box(scenes.compile(document).shape); };
    CHECK(extent().low.x == Approx(-0.04));
    CHECK(extent().low.z == Approx(0.12));  // built-in shapes that have centres stay where they are
    CHECK(extent().high.x == Approx(0.035));
    CHECK(extent().high.z == Approx(0.15));
    document["place"] = {{"center_mm", {0, 0, 140}}};
    CHECK(extent().center().z == Approx(0.14));
    CHECK(extent().extent().x == Approx(0.075));
}

TEST_CASE("studio scenes: a hand is what its project file makes, and is opened once") {
    const ordered_json document{{"format", "haptogram-project-1"},
                                {"points", 30},
                                {"hand", {{"recording", "synthetic:press"}, {"object", "cone"}, {"frame", 20}}}};
    Scenes scenes;
    const HandScene first = scenes.hand(document), again = scenes.hand(document);
    CHECK(first.object == again.object);
    CHECK(first.project.hand->hands == again.project.hand->hands);
    CHECK(first.object->surface.triangles.size() > 1000);
    const auto scene = scenes.compile(document).scene;
    for (const std::string& text : {toml_of(document), scene->project}) {
        Project direct = project_from_toml(text, "direct");
        direct.makers = path_makers();
        CHECK(scene->compiled.bundle.hex == compile(direct).bundle.hex);
    }
    CHECK(to_json(*scene)["foci"].size() == 30);
    ordered_json other = document;
    other["hand"]["size_mm"] = 50;
    CHECK(scenes.hand(other).object->name != first.object->name);
    CHECK_REFUSED(scenes.hand(document_of(circle, "circle")));
}

TEST_CASE("studio scenes: recordings and meshes of a hand are files that were sent, by any name, and no others") {
    const std::string mesh = "trimesh_binary.stl";
    const auto document = [](const std::string& recording, const std::string& object) {
        return ordered_json{{"format", "haptogram-project-1"},
                            {"hand", {{"recording", recording}, {"object", object}, {"frame", 1}}}};
    };
    Scenes scenes;
    for (const char* name : {"/etc/passwd.json", "../secret.lz", "a.pose", "synthetic", ""})
        CHECK_REFUSED(scenes.hand(document(name, "cube")));
    for (const char* name : {"/etc/passwd.stl", "trimesh_binary.stl"})
        CHECK_REFUSED(scenes.hand(document("synthetic:press", name)));
    CHECK_REFUSED(scenes.hand(document("synthetic:press", "torus")));
    scenes.add_file("torn.lz", "N4Ig");
    CHECK_REFUSED(scenes.hand(document("torn.lz", "cube")));
    scenes.add_file("hand.json", "{\"frames\": []}");
    CHECK_REFUSED(scenes.hand(document("hand.json", "cube")));
    scenes.add_file(
        "hand.json",
        R"({"frames": [{"timestamp": 1, "pointables": [], "hands": [{"id": 7, "type": "right", "palmPosition": [0, 200, 0], "palmNormal": [0, -1, 0], "direction": [0, 0, -1], "palmVelocity": [0, 0, 0]}]}]})");
    scenes.add_file(mesh, read_file(std::filesystem::path(data) / "shapes" / mesh));
    const HandScene scene = scenes.hand(document("hand.json", mesh));
    CHECK(scene.project.hand->hands->frames.size() == 1);
    CHECK(scene.object->surface.triangles.size() > 0);
    CHECK_REFUSED(scenes.add_file("hand.png", "x"));
}

TEST_CASE("studio scenes: what plays when, and the drives of each record") {
    Scenes scenes;
    const auto scene = scenes.compile(document_of(circle, "circle")).scene;
    const ordered_json json = to_json(*scene);
    REQUIRE(json["tour"].size() == 8);
    double until = 0.0;
    for (const ordered_json& entry : json["tour"]) {
        CHECK(entry["from_s"].get<double>() == Approx(until));
        until += entry["dwell_s"].get<double>();
    }
    CHECK(until == Approx(json["pass_s"].get<double>()));
    CHECK(until == Approx(1.0 / 500));
    // Delays of the waves' ways: all are in phase at the focus, so phase plus k times the way is the same for all.
    const Manifest& manifest = scene->compiled.bundle.manifest;
    for (std::uint32_t record = 1; record <= 8; ++record) {
        const ordered_json drives = drives_json(*scene, record);
        REQUIRE(drives["phases_deg"].size() == 100);
        const Vec3 focus = manifest.records[record - 1].foci[0].position;
        std::complex<double> sum = 0.0;
        for (std::size_t i = 0; i < 100; ++i) {
            CHECK(drives["amplitudes"][i].get<double>() == Approx(1.0).margin(0.01));
            const double way = distance(manifest.array.elements[i], focus) / manifest.array.wavelength_m();
            sum += std::polar(1.0, 2.0 * 3.141592653589793 * (drives["phases_deg"][i].get<double>() / 360.0 - way));
        }
        CHECK(std::abs(sum) > 99.0);
    }
    CHECK_REFUSED(drives_json(*scene, 0));
    CHECK_REFUSED(drives_json(*scene, 9));
}

TEST_CASE("studio scenes: a tour on a board that computes foci") {
    Scenes scenes;
    ordered_json document = document_of(circle, "circle");
    document["board"] = "colorlight-5a-75e-v7.1-wide";
    const auto scene = scenes.compile(document).scene;
    const Manifest& manifest = scene->compiled.bundle.manifest;
    REQUIRE(manifest.foci);
    const ordered_json tour = to_json(*scene)["tour"];
    REQUIRE(tour.size() == 8);
    // Indices of focus records begin behind those of the board's other records.
    CHECK(tour[0]["index"] == manifest.core.parameters.records + 1);
    CHECK(tour[0]["record"] == 1);
    CHECK(drives_json(*scene, 1)["index"] == tour[0]["index"]);
}

TEST_CASE("studio scenes: the analysis tells of every focus, and of findings") {
    Scenes scenes;
    const auto scene = scenes.compile(document_of(circle, "circle")).scene;
    const ordered_json json = analysis_json(*scene, analyze(timeline_of(scene->compiled.bundle)));
    REQUIRE(json["foci"].size() == 8);
    for (std::size_t i = 0; i < 8; ++i) {
        CHECK(json["foci"][i]["record"] == i + 1);
        CHECK(json["foci"][i]["radiation_pa"].get<double>() > 0.0);
    }
    CHECK(std::any_of(json["findings"].begin(), json["findings"].end(),
                      [](const ordered_json& each) { return each["kind"] == "short-dwell"; }));
}

TEST_CASE("studio pins: pulses from a record's first one on") {
    Pins pins;
    pins.clock_hz = 50'000'000;
    pins.carrier_hz = 40e3;  // 1250 clocks
    for (std::uint32_t i = 0; i < 8; ++i)
        pins.pulses.push_back({1000 + 625 * i, 1100 + 625 * i, i % 3, static_cast<std::uint16_t>(i < 3 ? 1 : 2)});
    const ordered_json found = pulses_json(pins, 2, 1);
    CHECK(found["from_clk"] == 1000 + 3 * 625);
    CHECK(found["to_clk"] == 1000 + 3 * 625 + 1250);
    REQUIRE(found["pulses"].size() == 2);
    CHECK(found["pulses"][1] == ordered_json({1, 3500, 3600, 2}));
    CHECK_REFUSED(pulses_json(pins, 7, 1));
    CHECK_REFUSED(pulses_json(pins, 1, 0));
    CHECK_REFUSED(pulses_json(pins, 1, most_pulse_periods + 1));
}

TEST_CASE("studio scenes: a new file of an old name is another scene") {
    Scenes scenes;
    scenes.add_file("a.xyz", "0 0 0\n10 0 0\n");
    const auto first = scenes.compile(with_file("a.xyz")).scene;
    scenes.add_file("a.xyz", "0 0 0\n10 0 0\n0 10 0\n");
    const auto second = scenes.compile(with_file("a.xyz")).scene;
    CHECK(first->name != second->name);
    CHECK(second->compiled.path.steps.size() == 3);
}

TEST_CASE("studio scenes: a document names no other files of this machine") {
    Scenes scenes;
    CHECK_REFUSED(scenes.compile(with_file("/etc/passwd.csv")));
    CHECK_REFUSED(scenes.compile(with_file(data + "/shapes/trimesh_binary.stl")));
    ordered_json document = document_of(circle, "circle");
    document["array"] = "/tmp/array.toml";
    CHECK_REFUSED(scenes.compile(document));
    document = document_of(circle, "circle");
    document["board"] = "board.toml";
    CHECK_REFUSED(scenes.compile(document));
    CHECK_REFUSED(scenes.compile({{"format", "haptogram-project-1"}, {"path", "/tmp/path.json"}}));
    document = document_of(circle, "circle");
    for (const char* am : {"csv:/tmp/wave.csv", "csv:wave.csv"}) {
        document["am"] = am;
        CHECK_REFUSED(scenes.compile(document));
    }
    document["am"] = "sine:200+wav:/etc/hostname";
    CHECK_REFUSED(scenes.compile(document));
}

TEST_CASE("studio scenes: files of a design that a page sent are read from there") {
    const std::string array =
        "name = \"mine\"\n[transducer]\nfile = \"loud.toml\"\n[array]\ncolumns = 6\nrows = 6\npitch_mm = "
        "10.5\ncarrier_hz = 40000\nduty = 0.5\n";
    const std::string loud = "name = \"loud\"\nradius_mm = 4.5\nsource_pa_m = 0.9\n";
    const std::string wave = "time_ms,amplitude\n0,0\n5,1\n10,0\n";
    const std::string text =
        "format = \"haptogram-project-1\"\narray = \"my.toml\"\nam = \"csv:waves/wave.csv\"\n[[shape]]\nkind = "
        "\"point\"\n";
    Scenes scenes;
    scenes.add_file("my.toml", array);
    scenes.add_file("loud.toml", loud);
    scenes.add_file("waves/wave.csv", wave);
    const auto scene = scenes.compile(document_of(text, "sent")).scene;
    TemporaryFolder folder;
    std::filesystem::create_directories(folder.path() / "waves");
    for (const auto& [name, content] : {std::pair("my.toml", array), std::pair("loud.toml", loud),
                                        std::pair("waves/wave.csv", wave), std::pair("project.toml", scene->project)})
        write_file(folder.path() / name, content);
    CHECK(compile(load_project(folder.path() / "project.toml")).bundle.hex == scene->compiled.bundle.hex);
    CHECK(scenes.file("my.toml") == array);
    // Other contents are another scene, and what is sent leads to no other file of this machine.
    scenes.add_file("waves/wave.csv", "time_ms,amplitude\n0,1\n5,0\n10,1\n");
    CHECK(scenes.compile(document_of(text, "sent")).scene != scene);
    for (const std::string& outside : {data + "/shapes/loud.toml", std::string("../loud.toml")}) {
        std::string other = array;
        other.replace(other.find("loud.toml"), 9, outside);
        scenes.add_file("my.toml", other);
        CHECK_REFUSED(scenes.compile(document_of(text, "sent")));
    }
    for (const char* name : {"../my.toml", "/my.toml", "a/../my.toml", "a/.my.toml", "", "a/", "a.exe"})
        CHECK_THROWS_AS(scenes.add_file(name, "x"), Error);
}

TEST_CASE("studio scenes: names of files") {
    Scenes scenes;
    scenes.add_file("<img src=x onerror=alert(1)>.ply", "x");
    scenes.add_file("\xE2\x97\x8F two words.stl", "x");
    for (const std::string& wrong :
         {std::string(), std::string("../a.ply"), std::string("/a.ply"), std::string(".a.ply"), std::string("a\nb.ply"),
          std::string("a\0b.ply", 7), std::string(97, 'a').append(".ply")}) {
        INFO(wrong);
        CHECK_REFUSED(scenes.add_file(wrong, "x"));
    }
    CHECK_THROWS_AS(scenes.add_file("a.exe", "x"), Error);
}

TEST_CASE("studio scenes: a project that is opened brings its files, and what is wrong with it is said") {
    TemporaryFolder folder;
    write_file(folder.path() / "points.xyz", "0 0 130\n20 0 130\n");
    const std::string text = "format = \"haptogram-project-1\"\nrate_hz = 50\n\n[[shape]]\nfile = \"points.xyz\"\n";
    write_file(folder.path() / "project.toml", text);
    Scenes scenes;
    scenes.open(folder.path() / "project.toml");
    const ordered_json document = scenes.first_document();
    CHECK(document["rate_hz"] == 50);
    Project direct = load_project(folder.path() / "project.toml");
    CHECK(scenes.compile(document).scene->compiled.bundle.hex == compile(direct).bundle.hex);
    write_file(folder.path() / "bad.toml",
               "format = \"haptogram-project-1\"\nrate = 5\n\n[[shape]]\nkind = \"circle\"\n");
    CHECK_REFUSED(scenes.open(folder.path() / "bad.toml"));
}

TEST_CASE("studio scenes: only the last ones are kept") {
    Scenes scenes;
    ordered_json document = document_of(circle, "circle");
    const std::string first = scenes.compile(document).scene->name;
    for (std::size_t i = 0; i < Scenes::most_scenes; ++i) {
        document["points"] = 9 + i;
        (void)scenes.compile(document);
    }
    CHECK_REFUSED(scenes.find(first));
    CHECK_THROWS_AS(scenes.find(""), Error);
}

TEST_CASE("studio worker: of an owner the newest work waits, and owners take turns") {
    Worker worker;
    std::mutex gate;
    std::vector<int> done;
    std::unique_lock closed(gate);
    std::promise<void> begun;
    worker.ask(1, [&] {
        begun.set_value();
        const std::lock_guard lock(gate);  // holds the thread
    });
    begun.get_future().wait();
    for (int i = 0; i < 10'000; ++i) worker.ask(1, [&done, i] { done.push_back(i); });
    worker.ask(2, [&done] { done.push_back(-2); });
    worker.ask(3, [&done] { done.push_back(-3); });
    worker.forget(3);
    std::promise<void> ended;
    worker.ask(4, [&ended] { ended.set_value(); });
    closed.unlock();
    REQUIRE(ended.get_future().wait_for(std::chrono::seconds(30)) == std::future_status::ready);
    CHECK(done == std::vector<int>{9'999, -2});
}

TEST_CASE("studio live: a session has the document's files in its folder, and no other of this machine") {
    const std::string stl = read_file(std::filesystem::path(data) / "shapes/trimesh_binary.stl");
    Scenes scenes;
    scenes.add_file("solid.stl", stl);
    const ordered_json hand = {
        {"recording", "synthetic:press"}, {"object", "solid.stl"}, {"size_mm", 60}, {"algorithm", "B"}, {"frame", 1},
        {"center_mm", {0, 5, 180}}};
    const ordered_json document = {{"format", "haptogram-project-1"}, {"points", 20}, {"hand", hand}};
    const LiveStart start = prepare_live(scenes, {1, document, ""});
    CHECK(read_file(start.folder->path() / "solid.stl") == stl);
    const Child::Command command = live_command(start, {"-port", 115200});
    CHECK(command.folder == start.folder->path());
    for (const std::string word : {"live", "--scene=-", "--port=-port", "--baud=115200", "--from=synthetic:press",
                                   "--object=solid.stl", "--size=60", "--center=0,5,180", "--rotate=0,0,0", "--unit=mm",
                                   "--algorithm=B", "--array=shipped:arrays/tile-10x10.toml"}) {
        INFO(word);
        CHECK(std::ranges::find(command.words, word) != command.words.end());
    }
    CHECK_REFUSED(prepare_live(scenes, {1, document, (start.folder->path() / "solid.stl").string()}));
    ordered_json other = document;
    other["hand"]["object"] = "/etc/other.stl";
    CHECK_REFUSED(prepare_live(scenes, {1, other, ""}));
}

TEST_CASE("studio assets: a page is read as its list says, and nothing else") {
    // What gzip makes of it.
    constexpr std::array<unsigned char, 31> packed = {31, 139, 8,   0,  0,   0,  0,   0,   2,  3,   179,
                                                      41, 176, 43,  72, 76,  79, 181, 209, 47, 176, 3,
                                                      0,  104, 197, 77, 251, 11, 0,   0,   0};
    const std::string plain = "<p>page</p>";
    TemporaryFolder folder;
    write_file(folder.path() / "index.html.gz", std::string(packed.begin(), packed.end()));
    const auto list = [&](const std::string& name, const std::string& hash, std::size_t bytes) {
        const ordered_json json = {
            {"files", {{{"name", name}, {"type", "text/html"}, {"sha256", hash}, {"bytes", bytes}}}}};
        write_file(folder.path() / "page.json", json.dump());
    };
    list("index.html", sha256(plain), plain.size());
    const Assets assets = load_assets(folder.path());
    CHECK(assets.at("/").plain == plain);
    CHECK(assets.at("/index.html").type == "text/html");
    CHECK(assets.size() == 2);
    list("index.html", sha256("another"), plain.size());
    CHECK_REFUSED(load_assets(folder.path()));
    for (const std::size_t bytes : {plain.size() - 1, plain.size() + 1}) {
        list("index.html", sha256(plain), bytes);
        CHECK_REFUSED(load_assets(folder.path()));
    }
    list("index.html", sha256(plain), plain.size());
    write_file(folder.path() / "index.html.gz", std::string(packed.begin(), packed.end() - 9));
    CHECK_REFUSED(load_assets(folder.path()));
    list("../index.html", sha256(plain), plain.size());
    CHECK_REFUSED(load_assets(folder.path()));
    write_file(folder.path() / "page.json", "{}");
    CHECK_REFUSED(load_assets(folder.path()));
    CHECK_SAID(assets_without_page("/nowhere").at("/").plain);
}
