// SPDX-License-Identifier: Apache-2.0
// Findings: for each rule a project that breaks it and one that does not; and a remedy does what it says.
#include <algorithm>
#include <catch2/catch.hpp>
#include <random>

#include "../refusal.hpp"
#include "haptogram/verbs/document.hpp"
#include "haptogram/verbs/report_page.hpp"

using namespace haptogram;
using nlohmann::ordered_json;

namespace {

ordered_json with(ordered_json changes) {
    ordered_json document{{"format", "haptogram-project-1"}};
    document.update(changes);
    return document;
}

struct Looked {
    Project project;
    Compiled compiled;
    ImageAnalysis analysis;
    std::vector<Finding> findings;

    [[nodiscard]] const Finding* find(const std::string& kind) const {
        const auto found =
            std::find_if(findings.begin(), findings.end(), [&](const Finding& each) { return each.kind == kind; });
        return found == findings.end() ? nullptr : &*found;
    }
};

Looked look(const ordered_json& document) {
    Looked looked;
    looked.project = project_from_toml(toml_of(document), "test");
    looked.compiled = compile(looked.project);
    looked.analysis = analyze(timeline_of(looked.compiled.bundle));
    looked.findings = findings_of(looked.project, looked.compiled, looked.analysis);
    return looked;
}

const ordered_json point{{"kind", "point"}};
const ordered_json circle{{"kind", "circle"}};
ordered_json shapes(const ordered_json& shape) { return ordered_json::array({shape}); }

/// A document after a remedy, as a page applies it: of a table, the keys that change.
ordered_json mended(ordered_json document, const Remedy& remedy) {
    document.merge_patch(remedy.changes);
    return document;
}

}  // namespace

TEST_CASE("findings: dwells that are too short, and remedies that make them long enough") {
    std::mt19937 random(Catch::rngSeed());
    for (int i = 0; i < 6; ++i) {
        const auto points = std::uniform_int_distribution(40, 160)(random);
        const double rate_hz = std::uniform_int_distribution(300, 1000)(random) / 1.0;
        const double capped = std::min(rate_hz, 40e3 / points / 1.5);
        const ordered_json document = with({{"points", points}, {"rate_hz", capped}, {"shape", shapes(circle)}});
        INFO(document.dump());
        const Looked looked = look(document);
        const Finding* const finding = looked.find("short-dwell");
        REQUIRE(finding != nullptr);
        CHECK(finding->message == short_dwell_warning(looked.compiled));
        CHECK_FALSE(finding->records.empty());
        CHECK_FALSE(finding->remedies.empty());
        for (const Remedy& remedy : finding->remedies) {
            INFO(remedy.label);
            CHECK(look(mended(document, remedy)).find("short-dwell") == nullptr);
        }
    }
    CHECK(look(with({{"points", 8}, {"rate_hz", 10}, {"shape", shapes(circle)}})).find("short-dwell") == nullptr);
}

TEST_CASE("findings: no remedy takes more points than a shape has that moves") {
    // The second key frame cuts a dwell short, which neither fewer points nor fewer passes change.
    const ordered_json frames = {{{"time_s", 0}}, {{"time_s", 0.0501}, {"move_mm", {5, 0, 0}}}, {{"time_s", 1.5}}};
    const Looked looked =
        look(with({{"points", 20}, {"rate_hz", 10}, {"keyframe", frames}, {"shape", shapes(circle)}}));
    const Finding* const finding = looked.find("short-dwell");
    REQUIRE(finding != nullptr);
    CHECK(finding->remedies.empty());
}

TEST_CASE("findings: a steady point, and none that moves or changes") {
    const ordered_json document = with({{"shape", shapes(point)}});
    const Looked looked = look(document);
    const Finding* const finding = looked.find("steady");
    REQUIRE(finding != nullptr);
    REQUIRE(finding->remedies.size() == 1);
    CHECK(look(mended(document, finding->remedies[0])).find("steady") == nullptr);
    CHECK(look(with({{"points", 8}, {"shape", shapes(circle)}})).find("steady") == nullptr);
}

TEST_CASE("findings: points out of reach are left out, and said") {
    const ordered_json wide = {{"kind", "line"}, {"length_mm", 800}};
    const Looked looked = look(with({{"points", 40}, {"clip", true}, {"shape", shapes(wide)}}));
    REQUIRE(looked.find("out-of-reach") != nullptr);
    CHECK(looked.findings.front().kind == "out-of-reach");
    CHECK_SAID(looked.find("out-of-reach")->message);
    CHECK(look(with({{"points", 8}, {"clip", true}, {"shape", shapes(circle)}})).find("out-of-reach") == nullptr);
}

TEST_CASE("findings: an object smaller than a focus, and its size afterwards") {
    const ordered_json document =
        with({{"points", 8}, {"rate_hz", 20}, {"shape", shapes({{"kind", "circle"}, {"diameter_mm", 8}})}});
    const Looked looked = look(document);
    const Finding* const finding = looked.find("small");
    REQUIRE(finding != nullptr);
    REQUIRE(finding->remedies.size() == 1);
    CHECK(look(mended(document, finding->remedies[0])).find("small") == nullptr);
    CHECK(look(with({{"points", 8}, {"rate_hz", 20}, {"shape", shapes(circle)}})).find("small") == nullptr);
}

TEST_CASE("findings: none of an object that is as it should be") {
    const Looked good = look(with({{"points", 8}, {"rate_hz", 20}, {"shape", shapes(circle)}}));
    for (const char* const kind : {"weak", "uneven", "side-lobe", "bandwidth", "duplicates", "warning"}) {
        INFO(kind);
        CHECK(good.find(kind) == nullptr);
    }
}

TEST_CASE("findings: what only the numbers of an analysis say") {
    Looked looked = look(with({{"points", 4}, {"rate_hz", 20}, {"shape", shapes(circle)}}));
    ImageAnalysis analysis = looked.analysis;
    CHECK(looked.find("weak") == nullptr);
    double strongest = 0.0;
    for (const PointAnalysis& each : analysis.points) strongest = std::max(strongest, each.focus.radiation_pa);
    analysis.points[0].focus.radiation_pa = 0.99 * least_even_share * strongest;
    analysis.points[1].too_weak = analysis.points[3].too_weak = true;
    analysis.points[3].focus.force_n = 0.25e-3;
    analysis.points[2].focus.side_lobe = 1.01 * most_side_lobe;
    analysis.loudness.at_300_mm_db = recommended_for_ears_db + 1.0;
    analysis.loudness.intensity_w_m2 = safe_in_tissue_w_m2 + 1.0;
    looked.findings = findings_of(looked.project, looked.compiled, analysis);
    REQUIRE(looked.find("weak") != nullptr);
    CHECK(looked.find("weak")->records == std::vector<std::size_t>{1, 3});
    CHECK_SAID(looked.find("weak")->message);
    REQUIRE(looked.find("uneven") != nullptr);
    CHECK(looked.find("uneven")->records == std::vector<std::size_t>{0});
    CHECK(looked.find("uneven")->remedies[0].changes["even"] == true);
    REQUIRE(looked.find("side-lobe") != nullptr);
    CHECK(looked.find("side-lobe")->records == std::vector<std::size_t>{2});
    CHECK(looked.find("loud") != nullptr);
    CHECK(looked.find("intense") != nullptr);
    analysis.points[2].focus.side_lobe = 0.99 * most_side_lobe;
    analysis.loudness.at_300_mm_db = recommended_for_ears_db - 1.0;
    analysis.loudness.intensity_w_m2 = safe_in_tissue_w_m2 - 1.0;
    looked.findings = findings_of(looked.project, looked.compiled, analysis);
    for (const char* const kind : {"side-lobe", "loud", "intense"}) CHECK(looked.find(kind) == nullptr);
}

TEST_CASE("findings: bandwidth, duplicates and other warnings") {
    // Two places far apart, a few periods each: the transducers do not follow.
    const Looked fast = look(with({{"points", 2}, {"rate_hz", 10000}, {"shape", shapes({{"kind", "line"}})}}));
    const Finding* const finding = fast.find("bandwidth");
    REQUIRE(finding != nullptr);
    CHECK_FALSE(finding->records.empty());
    ShapeSource twice;
    twice.file = "twice.xyz";
    twice.content = "0 0 130\n10 0 130\n0 0 130\n";
    Project project;
    project.shapes = {twice};
    const Compiled compiled = compile(project);
    const std::vector<Finding> found = findings_of(project, compiled);
    const auto is = [](const std::string& kind) { return [kind](const Finding& each) { return each.kind == kind; }; };
    REQUIRE(std::any_of(found.begin(), found.end(), is("duplicates")));
    Compiled warned = compiled;
    warned.warnings.push_back("something else");
    CHECK_FALSE(std::any_of(found.begin(), found.end(), is("warning")));
    const std::vector<Finding> more = findings_of(project, warned);
    CHECK(std::count_if(more.begin(), more.end(), is("warning")) == 1);
}

TEST_CASE("findings: a modulation's weak records are meant to be weak") {
    const Looked looked = look(with({{"am", "sine:200"}, {"shape", shapes(point)}}));
    REQUIRE(looked.compiled.bundle.manifest.records.size() > 3);
    CHECK(looked.find("weak") == nullptr);
    CHECK(looked.find("uneven") == nullptr);
}

TEST_CASE("findings: as JSON, records are counted from 1") {
    const Finding finding{"kind", "words", {0, 4}, {{"Do it", {{"points", 3}}}}};
    CHECK(to_json(finding).dump() ==
          R"({"kind":"kind","message":"words","records":[1,5],"remedies":[{"label":"Do it","changes":{"points":3}}]})");
}
