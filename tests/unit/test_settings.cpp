// SPDX-License-Identifier: Apache-2.0
// The one table of a project's settings: its rows hold in files, and the published schema says what it says.
#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

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
    SettingValue operator()(const Form&) const { return std::string("back:0.25"); }  // of the one there is
    SettingValue operator()(Choices names) const {
        for (const std::string_view name : names)
            if (!standard || *standard != SettingValue(std::string(name))) return std::string(name);
        return {};
    }
    SettingValue operator()(OwnTable) const { return {}; }
};

/// Shapes that are drawn, or a path: each setting has an effect on one of them.
Project a_project(std::string_view key) {
    Project project;
    if (key == "path") return project;
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
    nlohmann::json operator()(OwnTable) const { return {}; }
};

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

TEST_CASE("settings: the schema of projects has each row as the table has it", "[settings]") {
    const nlohmann::json properties =
        nlohmann::json::parse(read_file(std::filesystem::path(test_data()) / "../../docs/schemas/project.schema.json"))
            .at("properties");
    for (const Setting& one : project_settings()) {
        if (one.key.empty()) continue;
        CAPTURE(one.key);
        REQUIRE(properties.contains(one.key));
        if (one.get == nullptr) continue;
        nlohmann::json row = std::visit(SchemaOf{}, one.kind);
        row["description"] = std::string(one.help) + ".";
        if (const auto standard = default_of(one)) std::visit([&](const auto& v) { row["default"] = v; }, *standard);
        CHECK(properties[std::string(one.key)] == row);
    }
}
