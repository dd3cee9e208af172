// SPDX-License-Identifier: Apache-2.0
// Triggers of a project: what its file says, which entries of the sequence they start, and which lines fire them.
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "../refusal.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/link/play.hpp"
#include "haptogram/verbs/compile.hpp"
#include "haptogram/verbs/project.hpp"
#include "haptogram/verbs/trigger_reader.hpp"
#include "haptogram/verbs/trigger_table.hpp"

using namespace haptogram;

namespace {

const std::string all = R"([[trigger]]
on = "key:a"
[[trigger]]
on = "line:go on"
from_s = 0.25
to_s = 0.5
loops = 0
[[trigger]]
on = "region"
center_mm = [10, 0, 150]
size_mm = 60
loops = 3
[[trigger]]
on = "pin"
)";

std::string project_with(const std::string& triggers) {
    return "format = \"haptogram-project-1\"\n[[shape]]\nkind = \"circle\"\n" + triggers;
}

std::string scene(double x, double y, double z) {
    return R"({"scene": 2, "hands": [{"palm_mm": [0, 0, 400], "fingers_mm": [[], [[300, 0, 0], [)" + std::to_string(x) +
           ", " + std::to_string(y) + ", " + std::to_string(z) + "]]]}]}";
}

}  // namespace

TEST_CASE("triggers: a project's file says them, and is written as it was read") {
    const Project project = project_from_toml(project_with(all), "project");
    const std::vector<Trigger>& found = project.triggers;
    REQUIRE(found.size() == 4);
    CHECK(found[0] == Trigger{.on = Trigger::On::key, .word = "a"});
    CHECK(found[1] == Trigger{.on = Trigger::On::line, .word = "go on", .from_s = 0.25, .to_s = 0.5, .loops = 0});
    CHECK(found[2].on == Trigger::On::region);
    CHECK(found[2].centre.x == Approx(0.010));
    CHECK(found[2].diameter_m == Approx(0.060));
    CHECK(found[3].on == Trigger::On::pin);
    CHECK(project_from_toml(to_toml(project), "again").triggers == found);
}

TEST_CASE("triggers: what makes no sense is refused by its line") {
    const auto refused = [](const std::string& table) {
        return heard::refusal_of(
            [&] { static_cast<void>(project_from_toml(project_with("[[trigger]]\n" + table), "project")); });
    };
    CHECK_REFUSAL(refused("from_s = 1\n"));
    CHECK_REFUSAL(refused("on = \"key:ab\"\n"));
    CHECK_REFUSAL(refused("on = \"key:{\"\n"));
    CHECK_REFUSAL(refused("on = \"line: go\"\n"));
    CHECK_REFUSAL(refused("on = \"region\"\nsize_mm = 3\n"));
    CHECK_REFUSAL(refused("on = \"pin\"\nsize_mm = 3\ncenter_mm = [0, 0, 1]\n"));
    CHECK_REFUSAL(refused("on = \"pin\"\nfrom_s = 1\nto_s = 1\n"));
    CHECK_REFUSAL(refused("on = \"pin\"\nloops = 70000\n"));
    CHECK_REFUSAL(refused("on = \"pin\"\n[[trigger]]\non = \"pin\"\n"));
    CHECK_REFUSAL(refused("on = \"key:a\"\n[[trigger]]\non = \"line:a\"\n"));
    CHECK_REFUSAL(refused("on = \"pin\"\nwhen = 1\n"));
}

TEST_CASE("triggers: each plays the entries that begin in its time") {
    const std::vector<SequenceEntry> sequence{
        {1, 10}, {2, 20}, {0, 30}, {3, 40}};  // begin at 0, 10, 30, 60, end at 100
    const auto part = [&](double from, std::optional<double> to, std::uint16_t loops = 1) {
        Trigger one;
        one.from_s = from / 1000;
        if (to) one.to_s = *to / 1000;
        one.loops = loops;
        return parts_of(std::vector{one}, sequence, 1000.0).at(0);
    };
    CHECK(part(0, {}) == TriggeredPart{1, 4, 1, true});
    CHECK(part(10, 30) == TriggeredPart{2, 1, 1, true});
    CHECK(part(0, 31, 0) == TriggeredPart{1, 3, 0, true});
    CHECK(part(11, 100) == TriggeredPart{3, 2, 1, true});
    CHECK_REFUSED(part(61, {}));
    CHECK_REFUSED(part(100, {}));
    CHECK_REFUSED(part(0, 102));
}

TEST_CASE("triggers: a part that the sequence does not have, and a board without the pin, are refused") {
    link::Identity identity;
    const std::vector<TriggeredPart> key{{2, 3, 1, false}}, pin{{1, 1, 1, true}};
    CHECK_NOTHROW(link::require_parts(key, 4, identity));
    CHECK_REFUSED(link::require_parts(key, 3, identity));
    CHECK_REFUSED(link::require_parts(pin, 4, identity));
    identity.features = 1U << static_cast<unsigned>(interface::Feature::trigger);
    CHECK_NOTHROW(link::require_parts(pin, 4, identity));
    const std::vector<TriggeredPart> two{pin[0], pin[0]};
    CHECK_REFUSED(link::require_parts(two, 4, identity));
    Project project = project_from_toml(project_with("[[trigger]]\non = \"pin\"\n"), "project");
    project.points = 8;
    CHECK_REFUSED(compile(project));
    project.board = "ulx3s-85f";
    CHECK(compile(project).parts == std::vector<TriggeredPart>{{1, 8, 1, true}});
}

TEST_CASE("triggers: words fire keys and lines, hands that come into a region fire it once, and all else is told") {
    const std::vector<Trigger> triggers = triggers_from_toml(all, "project");
    TriggerLines lines(triggers);
    using Numbers = std::vector<std::size_t>;
    CHECK(lines.fired("a", "in:1") == Numbers{0});
    CHECK(lines.fired("go on", "in:2") == Numbers{1});
    CHECK(lines.fired(scene(300, 0, 0), "in").empty());
    CHECK(lines.fired(scene(10, 29, 150), "in") == Numbers{2});
    CHECK(lines.fired(scene(10, 0, 150), "in").empty());
    CHECK(lines.fired(scene(10, 31, 150), "in").empty());
    CHECK(lines.fired(scene(10, 0, 179), "in") == Numbers{2});
    CHECK(lines.fired(R"({"scene": 1, "hands": []})", "in").empty());
    CHECK(lines.fired(scene(10, 0, 150), "in") == Numbers{2});
    CHECK_REFUSED(lines.fired("b", "in:7"));
    CHECK_REFUSED(lines.fired("{", "in:8"));
    CHECK_REFUSED(lines.fired(R"({"scene": 3, "hands": []})", "in:9"));
}
