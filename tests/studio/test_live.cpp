// SPDX-License-Identifier: Apache-2.0
// What a live session of the page is started with.
#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>

#include "../refusal.hpp"
#include "haptogram/base/file.hpp"
#include "live.hpp"
#include "scenes.hpp"

using namespace haptogram;

namespace {

studio::LiveStart started(const nlohmann::ordered_json& table) {
    studio::Scenes scenes;
    nlohmann::ordered_json document{{"format", "haptogram-project-1"}, {"hand", {{"recording", "synthetic:press"}}}};
    if (!table.is_null()) document["live"] = table;
    return studio::prepare_live(scenes, {.n = 1, .document = document, .from = ""});
}

bool has(const studio::LiveStart& start, const std::string& word) {
    return std::ranges::find(start.words, word) != start.words.end();
}

}  // namespace

TEST_CASE("live: the project's table is handed on, but for what page, board and design decide, which is said") {
    const studio::LiveStart start = started({{"predict", "none"}, {"workspace_low", {-50, -50, 80}}});
    REQUIRE(has(start, "--settings=live-settings.toml"));
    CHECK(read_file(start.folder->path() / "live-settings.toml") ==
          "\n[live]\npredict = \"none\"\nworkspace_low = [-50, -50, 80]\n");
    CHECK(start.left_out.empty());
    const studio::LiveStart less = started({{"port", "/dev/ttyUSB9"}, {"seconds", 2.5}, {"record", "/etc/kept"}});
    CHECK(read_file(less.folder->path() / "live-settings.toml") == "\n[live]\nseconds = 2.5\n");
    CHECK_SAID(less.left_out);
    const studio::LiveStart none = started(nlohmann::ordered_json::object({{"watchdog", 0}}));
    CHECK_FALSE(has(none, "--settings=live-settings.toml"));
    CHECK_SAID(none.left_out);
    CHECK(started({}).left_out.empty());
    CHECK(has(started({}), "--from=synthetic:press"));
}

TEST_CASE("live: the array is named by its file, and what the session cannot do is said") {
    CHECK(has(started({}), "--array=shipped:arrays/tile-10x10.toml"));
    studio::Scenes scenes;
    nlohmann::ordered_json document{{"format", "haptogram-project-1"},
                                    {"hand", {{"recording", "synthetic:press"}, {"frame", 5}}}};
    CHECK_SAID(studio::prepare_live(scenes, {.n = 1, .document = document, .from = ""}).left_out);
    document["hand"] = {{"recording", "synthetic:press"}, {"frames_hz", 30}};
    CHECK_REFUSED(studio::prepare_live(scenes, {.n = 1, .document = document, .from = ""}));
}

TEST_CASE("live: how a design draws is handed on, and what a session cannot play is refused") {
    const auto of = [](const nlohmann::ordered_json& settings, const nlohmann::ordered_json& table = {}) {
        studio::Scenes scenes;
        nlohmann::ordered_json document{{"format", "haptogram-project-1"},
                                        {"hand", {{"recording", "synthetic:press"}, {"algorithm", "E"}}}};
        if (!settings.is_null()) document.update(settings);
        if (!table.is_null()) document["live"] = table;
        return studio::prepare_live(scenes, {.n = 1, .document = document, .from = ""});
    };
    const studio::LiveStart start = of({{"speed_m_s", 2.5}, {"jump", "blank"}, {"seed", 7}});
    CHECK(has(start, "--speed=2.5"));
    CHECK(has(start, "--jump=blank"));
    CHECK(has(start, "--seed=7"));
    CHECK(has(of({{"frequency_hz", 30}}), "--frequency=30"));
    const auto options = [](const studio::LiveStart& one, const std::string& option) {
        return std::ranges::count_if(one.words, [&](const std::string& word) { return word.starts_with(option); });
    };
    CHECK(options(of({}), "--speed") + options(of({}), "--jump") + options(of({}), "--seed") == 0);
    CHECK(options(of({{"speed_m_s", 2.5}}, {{"frequency", 20}}), "--speed") == 0);
    CHECK(options(of({{"speed_m_s", 2.5}}, {{"speed", 3}}), "--speed") == 0);
    CHECK(options(of({{"jump", "blank"}}, {{"speed", 3}}), "--jump") == 1);
    CHECK(start.left_out.empty());
    for (const nlohmann::ordered_json& settings :
         {nlohmann::ordered_json{{"amplitude", 0.5}}, {{"am", "sine:200"}}, {{"quantise", "hoshi"}}}) {
        INFO(settings.dump());
        CHECK_REFUSED(of(settings));
    }
}
