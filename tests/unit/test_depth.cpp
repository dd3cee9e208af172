// SPDX-License-Identifier: Apache-2.0
// Texts whose lists lie within each other by the thousand are refused before they are parsed.
#include <catch2/catch.hpp>
#include <string>

#include "../refusal.hpp"
#include "haptogram/base/depth.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/format/bundle.hpp"
#include "haptogram/format/rig_bundle.hpp"
#include "haptogram/shape/path_file.hpp"
#include "haptogram/verbs/project.hpp"

using namespace haptogram;

namespace {

std::string times(std::size_t count, const std::string& text) {
    std::string all;
    for (std::size_t i = 0; i < count; ++i) all += text;
    return all;
}

}  // namespace

TEST_CASE("depth: lists, objects and tables within each other are counted, and nothing else is", "[base]") {
    for (const std::string open : {"[", "{", "{\"a\":[", "[{"}) {
        const std::size_t fit = most_nested / static_cast<std::size_t>(std::ranges::count_if(
                                                  open, [](char c) { return c == '[' || c == '{'; }));
        CHECK(is_shallow(times(fit, open)));
        CHECK_FALSE(is_shallow(times(fit + 1, open)));
    }
    CHECK(is_shallow("a" + times(most_nested, ".a") + " = 1"));
    CHECK_FALSE(is_shallow("a" + times(most_nested + 1, ".a") + " = 1"));
    CHECK_FALSE(is_shallow("[a" + times(most_nested + 1, " . 'a'") + "]"));
    // Side by side, within a text, or in a comment they are not deep.
    CHECK(is_shallow(times(100'000, "[],")));
    CHECK(is_shallow("[" + times(100'000, "0.5, ") + "0.5]"));
    CHECK(is_shallow("{\"a\": \"\\\"" + times(1000, "[{") + "\"}"));
    CHECK(is_shallow("name = 'it" + times(1000, "[.") + "'\n# it's " + times(1000, "[.") + "\nb = 1"));
}

TEST_CASE("depth: every reader refuses what is too deep", "[base]") {
    const std::string deep = times(100'000, "["), keys = "a" + times(100'000, ".a") + " = 1\n";
    CHECK_REFUSED(manifest_from_json(deep, "m.json"));
    CHECK_REFUSED(project_from_toml(keys, "p.toml"));
    CHECK_REFUSED(project_from_toml("a = " + deep, "p.toml"));
    CHECK_FALSE(is_path_json(deep));
    CHECK_FALSE(is_rig_manifest(deep));
}
