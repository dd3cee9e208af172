// SPDX-License-Identifier: Apache-2.0
// Project files as JSON and back.
#include <catch2/catch.hpp>

#include "../refusal.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/verbs/document.hpp"
#include "haptogram/verbs/project.hpp"

using namespace haptogram;
using nlohmann::ordered_json;

namespace {

const std::string all_keys = R"(format = "haptogram-project-1"
array = "hoshi-18x18"
points = 40
seed = 7
clip = true
rate_hz = 12.5
even = true
loops = 3
am = "sine:200"
am_law = "radiation"
fade = "left:0.25"

[place]
scale = 2
size_mm = 61.25
rotate_deg = [1, -2.5, 1e-3]
center_mm = [0, 0.1, 150]

[[shape]]
file = "a \"quoted\" \\ file ä ●.ply"
unit = "cm"

[[shape]]
kind = "helix"
diameter_mm = 33.3
turns = 2.5
scale = 0.5
size_mm = 30.5
rotate_deg = [0, 90, 0.25]
center_mm = [10, -20, 140]

[live]
from = ["leap-pipe:-", "depth:\"a\" folder"]
center = [0, 40, 160.5]
mass = 1e2
json = true
)";

}  // namespace

TEST_CASE("document: every key of a project survives the way to JSON and back") {
    const ordered_json document = document_of(all_keys, "all");
    CHECK(document["place"]["center_mm"][2] == 150);
    CHECK(document["shape"][0]["file"] == "a \"quoted\" \\ file ä ●.ply");
    CHECK(document["clip"] == true);
    CHECK(project_from_toml(all_keys, "all").live.size() == 4);
    const std::string back = toml_of(document);
    CHECK(to_toml(project_from_toml(back, "back")) == to_toml(project_from_toml(all_keys, "all")));
    // Also through a program that writes whole numbers without a point, as JavaScript does.
    CHECK(document_of(toml_of(ordered_json::parse(document.dump())), "again") == document);
}

TEST_CASE("document: a text with any characters comes back as it was") {
    std::string every = "a file\r\n\t'\"\\\"\"\"\\n ä ●";
    for (char c = 1; c < ' '; ++c) every += c, every += 'b';
    every += "\x7f end \\";
    Project project;
    project.shapes.emplace_back().file = every;
    const Project again = project_from_toml(to_toml(project), "again");
    CHECK(again.shapes.at(0).file == every);
    const ordered_json document = document_of(to_toml(project), "document");
    CHECK(document["shape"][0]["file"] == every);
    CHECK(project_from_toml(toml_of(document), "page").shapes.at(0).file == every);
    project.shapes[0].file = "caf\xe9.ply";
    CHECK_REFUSED(to_toml(project));
}

TEST_CASE("document: the project's reader has the last word") {
    const auto read = [](const char* json) { return project_from_toml(toml_of(ordered_json::parse(json)), "page"); };
    CHECK_REFUSED(read(R"({"format": "haptogram-project-1", "pointz": 3})"));
    CHECK_REFUSED(read(R"({"format": "haptogram-project-1", "points": "3"})"));
    CHECK_REFUSED(read(R"({"points": 3})"));
    CHECK_THROWS_AS(document_of("points = ", "broken"), Error);
    CHECK_THROWS_AS(document_of("format = \"haptogram-project-1\"\npoints = 3\n", "nothing"), Error);
}

TEST_CASE("document: what no project file has is refused by its key") {
    for (const char* json : {R"({"a": null})", R"({"a": {"b": {}}})", R"({"a": [{"b": null}]})", R"({"a": [1, {}]})"}) {
        INFO(json);
        CHECK_REFUSED(toml_of(ordered_json::parse(json)));
    }
    CHECK_REFUSED(toml_of(ordered_json::parse("[]")));
}

TEST_CASE("document: keys and text cannot add lines of their own") {
    const ordered_json document = {{"a\nb = 1", "c\"\nd = 2\n[e]"}, {"", 1}};
    const std::string text = toml_of(document);
    CHECK(text == "\"a\\nb = 1\" = \"c\\\"\\nd = 2\\n[e]\"\n\"\" = 1\n");
}
