// SPDX-License-Identifier: Apache-2.0
// The one table of a project's settings: its rows hold in files, and the published schema says what it says.
#include <fmt/format.h>

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <tuple>
#include <type_traits>
#include <vector>

#include "../refusal.hpp"
#include "../test_data.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/verbs/settings.hpp"

using namespace haptogram;

namespace {

/// A value that is not the default.
struct AnotherValue {
    std::optional<SettingValue> standard;
    SettingValue operator()(Flag) const { return true; }
    SettingValue operator()(File) const { return std::string("drawn.json"); }
    SettingValue operator()(FileOrName) const { return std::string("some.toml"); }
    SettingValue operator()(const Numbers& n) const { return n.least * 3.0; }
    SettingValue operator()(const WholeNumbers& n) const { return n.most - 1; }
    SettingValue operator()(const Form& form) const {
        return std::string(form.fits("back:0.25") ? "back:0.25" : "push=0.25,how deep=-2");
    }
    SettingValue operator()(Choices names) const {
        for (const std::string_view name : names)
            if (!standard || *standard != SettingValue(std::string(name))) return std::string(name);
        return {};
    }
    SettingValue operator()(Length) const { return 3.0; }
    SettingValue operator()(Place) const { return std::array{3.0, -4.0, 5.5}; }
    SettingValue operator()(Turn) const { return std::array{3.0, -4.0, 5.5}; }
    SettingValue operator()(Table) const { return {}; }
};

/// Shapes that are drawn, or a path: each setting has an effect on one of them.
Project a_project(std::string_view key) {
    Project project;
    if (key == "path") return project;
    if (key == "set") {
        project.path = "a.adaptics";
        return project;
    }
    project.shapes.emplace_back().primitive.kind = "circle";
    if (key == "jump") project.pace.speed_m_s = 5.0;
    return project;
}

struct SchemaOf {
    nlohmann::json operator()(Flag) const { return {{"type", "boolean"}}; }
    nlohmann::json operator()(File) const { return {{"type", "string"}, {"minLength", 1}}; }
    nlohmann::json operator()(FileOrName) const { return {{"type", "string"}}; }
    nlohmann::json operator()(const Numbers& n) const {
        return {{"type", "number"}, {"minimum", n.least}, {"maximum", n.most}};
    }
    nlohmann::json operator()(const WholeNumbers& n) const {
        return {{"type", "integer"}, {"minimum", n.least}, {"maximum", n.most}};
    }
    nlohmann::json operator()(const Form& form) const { return {{"type", "string"}, {"pattern", form.pattern}}; }
    nlohmann::json operator()(Choices names) const {
        return {{"enum", std::vector<std::string>(names.begin(), names.end())}};
    }
    nlohmann::json operator()(Length) const { return (*this)(Numbers{Length::least_mm, Length::most_mm}); }
    nlohmann::json operator()(Place) const { return three(Place::most_mm); }
    nlohmann::json operator()(Turn) const { return three(Turn::most_deg); }
    static nlohmann::json three(double most) {
        return {{"type", "array"},
                {"minItems", 3},
                {"maxItems", 3},
                {"items", {{"type", "number"}, {"minimum", -most}, {"maximum", most}}}};
    }
    nlohmann::json operator()(Table) const { return {}; }
};

/// Checks that a part of the schema has each row of a table, and no others.
template <class... Owners>
void check_schema(const nlohmann::json& properties, Settings<Owners>... tables) {
    std::size_t rows = 0;
    const auto check = [&](const auto& table) {
        for (const auto& one : table) {
            CAPTURE(one.key);
            ++rows;
            REQUIRE(properties.contains(one.key));
            if (one.get == nullptr) continue;
            nlohmann::json row = std::visit(SchemaOf{}, one.kind);
            row["description"] = std::string(one.help) + ".";
            if (const auto standard = default_of(one); standard && one.needed.empty())
                std::visit([&](const auto& v) { row["default"] = v; }, *standard);
            CHECK(properties[std::string(one.key)] == row);
        }
    };
    (check(tables), ...);
    CHECK(rows == properties.size());
}

/// Checks that each row of a part's table comes back, one at a time.
/// @param part  of a project
template <class Owner, class Part>
void check_part(const Project& project, Settings<Owner> table, Part part) {
    for (const SettingOf<Owner>& one : table) {
        CAPTURE(one.key);
        Project changed = project;
        if constexpr (std::is_same_v<Owner, HandSource>)
            if (one.subject == "a .pose file") changed.hand->recording = "a.pose";
        if (one.subject == "shape files" || one.key == "file") {
            changed.shapes.front().file = "a.ply";
            changed.shapes.front().primitive = {};
        } else if (one.key == "kind") {
            continue;  // a measure comes with a kind that has it
        } else if (one.subject == "built-in shapes") {
            PrimitiveSpec& shape = changed.shapes.front().primitive;
            shape.kind = one.key == "length_mm" ? "line" : one.key == "sides" ? "polygon" : "helix";
        }
        const SettingValue value =
            one.key == "shape" ? SettingValue(std::uint64_t{1}) : std::visit(AnotherValue{default_of(one)}, one.kind);
        one.put(part(changed), one, value);
        const std::string text = to_toml(changed);
        INFO(text);
        Project read = project_from_toml(text, "p.toml");
        CHECK(one.get(part(read), one) == value);
        CHECK(to_toml(read) == text);
    }
}

}  // namespace

TEST_CASE("settings: each one comes back from a project file", "[settings]") {
    for (const Setting& one : project_settings()) {
        if (one.get == nullptr) continue;
        CAPTURE(one.key);
        Project project = a_project(one.key);
        const SettingValue value = std::visit(AnotherValue{default_of(one)}, one.kind);
        one.put(project, one, value);
        CHECK(one.get(project, one) == value);
        const Project read = project_from_toml(to_toml(project), "p.toml");
        CHECK(one.get(read, one) == value);
        for (const Setting& other : project_settings())
            if (other.get != nullptr && &other != &one) CHECK(other.get(read, other) == other.get(project, other));
    }
}

TEST_CASE("settings: those of the parts of a project come back from a file", "[settings]") {
    const Project shapes = a_project("shape");
    check_part(shapes, place_settings(), [](Project& p) -> Placement& { return p.placement; });
    check_part(shapes, place_settings(), [](Project& p) -> Placement& { return p.shapes.front().placement; });
    check_part(shapes, shape_settings(), [](Project& p) -> ShapeSource& { return p.shapes.front(); });
    Project moved = shapes;
    moved.key_frames.resize(2);
    check_part(moved, key_frame_settings(), [](Project& p) -> KeyFrame& { return p.key_frames.back(); });
    Project felt;
    felt.hand.emplace().recording = "synthetic:press";
    check_part(felt, hand_settings(), [](Project& p) -> HandSource& { return *p.hand; });
    check_part(felt, object_settings().first(2), [](Project& p) -> ObjectSource& { return p.hand->object; });
    for (const char* name : {"cone", "a.ply"}) {
        felt.hand->object.name = name;
        for (const SettingOf<ObjectSource>& one : object_settings().subspan(2))
            if (one.has_effect(felt.hand->object))
                check_part(felt, Settings<ObjectSource>(&one, 1),
                           [](Project& p) -> ObjectSource& { return p.hand->object; });
    }
}

TEST_CASE("settings: millimetres of a file are metres inside, and degrees stay", "[settings]") {
    const auto near = [](double found, double wanted) { return std::abs(found - wanted) < 1e-15; };
    const Project shapes = project_from_toml(
        "format = \"haptogram-project-1\"\n[place]\nsize_mm = 40\ncenter_mm = [1, -2, 130]\nrotate_deg = [10, 20, 30]\n"
        "[[shape]]\nkind = \"cone\"\ndiameter_mm = 30\nheight_mm = 50\nsize_mm = 60\ncenter_mm = [4, 5, 6]\n"
        "[[shape]]\nkind = \"line\"\nlength_mm = 70\n[[keyframe]]\ntime_s = 0\n"
        "[[keyframe]]\ntime_s = 1\nmove_mm = [7, 8, -9]\n",
        "p.toml");
    CHECK(near(shapes.placement.size_m.value(), 0.04));
    CHECK(distance(shapes.placement.center.value(), {0.001, -0.002, 0.13}) < 1e-15);
    CHECK(shapes.placement.rotate_deg == std::array{10.0, 20.0, 30.0});
    const ShapeSource& cone = shapes.shapes.front();
    CHECK(near(cone.primitive.diameter.value(), 0.03));
    CHECK(near(cone.primitive.height.value(), 0.05));
    CHECK(near(cone.placement.size_m.value(), 0.06));
    CHECK(distance(cone.placement.center.value(), {0.004, 0.005, 0.006}) < 1e-15);
    CHECK(near(shapes.shapes.back().primitive.length.value(), 0.07));
    CHECK(distance(shapes.key_frames.back().move, {0.007, 0.008, -0.009}) < 1e-15);
    const Project hand = project_from_toml(
        "format = \"haptogram-project-1\"\n[hand]\nrecording = \"synthetic:press\"\nobject = \"cone\"\nsize_mm = 80\n"
        "height_mm = 90\ncenter_mm = [1, 2, 200]\nrotate_deg = [0, 45, 0]\n",
        "p.toml");
    CHECK(near(hand.hand->object.size_m.value(), 0.08));
    CHECK(near(hand.hand->object.height_m.value(), 0.09));
    CHECK(distance(hand.hand->object.centre, {0.001, 0.002, 0.2}) < 1e-15);
    CHECK(distance(hand.hand->object.angles_deg, {0.0, 45.0, 0.0}) < 1e-15);
}

TEST_CASE("settings: what has no effect on a hand's object is refused by its line", "[settings]") {
    for (const auto& [object, line] : {std::pair("sphere", "height_mm = 5"), std::pair("sphere", "unit = \"m\""),
                                       std::pair("a.ply", "height_mm = 5"), std::pair("sphere", "frames_hz = 3"),
                                       std::pair("sphere", "center_mm = [0, 0, 2e6]")}) {
        const std::string text = fmt::format(
            "format = \"haptogram-project-1\"\n[hand]\nrecording = \"synthetic:press\"\nobject = \"{}\"\n{}\n", object,
            line);
        CHECK_REFUSED(project_from_toml(text, "p.toml"));
    }
}

TEST_CASE("settings: the schema of projects has each row as the tables have it", "[settings]") {
    const nlohmann::json schema =
        nlohmann::json::parse(read_file(std::filesystem::path(test_data()) / "../../docs/schemas/project.schema.json"));
    nlohmann::json whole = schema.at("properties");
    whole.erase("format");
    check_schema(whole, project_settings());
    check_schema(whole.at("place").at("properties"), place_settings());
    check_schema(whole.at("keyframe").at("items").at("properties"), key_frame_settings());
    check_schema(schema.at("$defs").at("shape").at("properties"), shape_settings(), place_settings());
    check_schema(schema.at("$defs").at("hand").at("properties"), hand_settings(), object_settings());
}
