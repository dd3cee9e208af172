// SPDX-License-Identifier: Apache-2.0
// Images of a rig: what each tile gets, what they are together, and their files.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <map>
#include <random>

#include "../refusal.hpp"
#include "../test_data.hpp"
#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/process.hpp"
#include "haptogram/format/rig_bundle.hpp"
#include "haptogram/solve/focal_law.hpp"
#include "haptogram/verbs/rig.hpp"
#include "haptogram/verbs/source.hpp"

using namespace haptogram;

namespace {

/// A grid of elements 10 mm apart, with all else as an array has it.
Array grid_like(Array array, std::uint32_t edge) {
    array.elements.clear();
    for (std::uint32_t row = 0; row < edge; ++row)
        for (std::uint32_t column = 0; column < edge; ++column)
            array.elements.push_back(
                {from_mm(10.0 * (column - (edge - 1) / 2.0), 10.0 * (row - (edge - 1) / 2.0), 0.0)});
    array.columns = edge;
    array.faces.clear();
    return array;
}

std::pair<long, long> key_of(Vec3 p) { return {std::lround(p.x * 1e6), std::lround(p.y * 1e6)}; }

/// Where each element of one array stands among those of another with the same places.
std::vector<std::size_t> places_in(const Array& array, const Array& other) {
    std::map<std::pair<long, long>, std::size_t> places;
    for (std::size_t i = 0; i < other.elements.size(); ++i) places[key_of(other.elements[i].position)] = i;
    REQUIRE(places.size() == other.elements.size());
    std::vector<std::size_t> found;
    for (const Element& element : array.elements) {
        const auto place = places.find(key_of(element.position));
        REQUIRE(place != places.end());
        REQUIRE(distance(element.position, other.elements[place->second].position) < 1e-12);
        REQUIRE(distance(element.normal, other.elements[place->second].normal) < 1e-12);
        found.push_back(place->second);
    }
    return found;
}

/// A few points somewhere above a wall.
Project some_points(std::mt19937_64& random, ImageKind kind) {
    Project project;
    project.shapes.push_back({});
    project.shapes.back().primitive.kind = "circle";
    project.placement.center = from_mm(std::uniform_real_distribution<double>(-20, 20)(random),
                                       std::uniform_real_distribution<double>(-20, 20)(random),
                                       std::uniform_real_distribution<double>(150, 220)(random));
    project.points = std::uniform_int_distribution<std::size_t>(3, 12)(random);
    project.rate_hz = 100.0;
    project.seed = random();
    project.image = kind;
    return project;
}

}  // namespace

TEST_CASE("rig: the shipped rigs of tiles are the larger arrays of the same places", "[rig]") {
    std::mt19937_64 random(Catch::rngSeed());
    const auto [name, edge] = GENERATE(std::pair<const char*, std::uint32_t>{"2x2", 20},
                                       std::pair<const char*, std::uint32_t>{"hoshi-9x36", 18});
    const Array rig = joined(find_rig(name));
    const Array single = grid_like(rig, edge);
    REQUIRE(rig.elements.size() == single.elements.size());
    const std::vector<std::size_t> places = places_in(rig, single);
    if (edge == 18) {  // as the shipped array of Hoshi's device has them
        const Array hoshi = find_array("hoshi");
        REQUIRE(places_in(rig, hoshi) == places);
        REQUIRE(hoshi.transducer == rig.transducer);
        REQUIRE(hoshi.medium == rig.medium);
    }
    std::uniform_real_distribution<double> side(-0.04, 0.04), up(0.12, 0.25);
    for (int i = 0; i < 5; ++i) {
        const Vec3 focus{side(random), side(random), up(random)};
        const Vec3 at = focus + Vec3{side(random), side(random), side(random)} * 0.3;
        const auto together = pressure(rig, ideal_drives(rig, focus), at);
        const auto alone = pressure(single, ideal_drives(single, focus), at);
        CHECK(std::abs(together - alone) < 1e-9 * std::abs(alone));
        const Timer timer{50e6, 1, 1250, 250};
        const std::vector<Vec3> foci = {focus};
        const std::vector<std::uint16_t> ticks = focal_law(rig, timer, foci), same = focal_law(single, timer, foci);
        for (std::size_t e = 0; e < ticks.size(); ++e) REQUIRE(ticks[e] == same[places[e]]);
    }
}

TEST_CASE("rig: tiles' images are the parts of the image of one large array", "[rig]") {
    std::mt19937_64 random(Catch::rngSeed());
    const ImageKind kind = GENERATE(ImageKind::records, ImageKind::foci);
    const Project project = some_points(random, kind);
    const CompiledRig compiled = compile_rig(project, "2x2", "wall.json");
    REQUIRE(compiled.bundle.tiles.size() == 4);
    const Array wall = grid_like(joined(find_rig("2x2")), 20);
    const std::vector<std::size_t> places = places_in(joined(find_rig("2x2")), wall);
    Core core = find_core("tile-100-wide");
    core.parameters.channels = 400;
    const Compiled single = compile({wall, core}, project, "single.hex");
    for (std::size_t t = 0; t < 4; ++t) {
        const Bundle& tile = compiled.bundle.tiles[t];
        CHECK(tile.name == "wall.tile-" + std::to_string(t + 1) + ".hex");
        CHECK(tile.image.channels == 100);
        CHECK(tile.image.sequence == single.bundle.image.sequence);
        REQUIRE(tile.image.records.size() == single.bundle.image.records.size());
        for (std::size_t r = 0; r < tile.image.records.size(); ++r)
            for (std::size_t c = 0; c < 100; ++c)
                REQUIRE(tile.image.records[r].timings[c] ==
                        single.bundle.image.records[r].timings[places[100 * t + c]]);
        REQUIRE(tile.image.foci.has_value() == (kind == ImageKind::foci));
        if (!tile.image.foci) continue;
        CHECK(tile.image.foci->foci == single.bundle.image.foci->foci);
        CHECK(tile.image.foci->engine.wave_number == single.bundle.image.foci->engine.wave_number);
        CHECK(tile.image.foci->engine.gain == single.bundle.image.foci->engine.gain);
        for (std::size_t c = 0; c < 100; ++c)
            REQUIRE(tile.image.foci->engine.geometry[c] ==
                    single.bundle.image.foci->engine.geometry[places[100 * t + c]]);
    }
    const Bundle together = joined(compiled.bundle.tiles, "wall.json");
    CHECK(together.image.records == compiled.whole.bundle.image.records);
    CHECK(together.image.sequence == compiled.whole.bundle.image.sequence);
    CHECK(together.image.foci == compiled.whole.bundle.image.foci);
}

TEST_CASE("rig: a rig's files are read back as they were, and a mix of files is refused", "[rig]") {
    std::mt19937_64 random(Catch::rngSeed());
    const TemporaryFolder folder;
    const ImageKind kind = GENERATE(ImageKind::records, ImageKind::foci);
    const auto at = [&](const char* name) { return (folder.path() / name).string(); };
    const CompiledRig compiled = compile_rig(some_points(random, kind), "2x2", at("wall.json"));
    write_files(files_of(compiled.bundle));
    const RigBundle read = load_rig_bundle(at("wall.json"));
    REQUIRE(read.rig == "2x2");
    REQUIRE(read.tiles.size() == 4);
    for (std::size_t t = 0; t < 4; ++t) {
        CHECK(read.tiles[t].hex == compiled.bundle.tiles[t].hex);
        CHECK(read.tiles[t].image == compiled.bundle.tiles[t].image);
        CHECK(read.parts[t].core.parameters.channels == 100);
    }
    CHECK(read.whole.image.records == compiled.whole.bundle.image.records);
    CHECK(to_text(read) == read_file(at("wall.json")));
    // Each tile's image is one that single-board tools read.
    CHECK(load_bundle(at("wall.tile-2.hex")).manifest.array.elements == read.tiles[1].manifest.array.elements);
    // And the rig's manifest stands for all of them.
    Source source;
    source.file = at("wall.json");
    CHECK(open_timeline(source).manifest.array.elements.size() == 400);

    CHECK_REFUSED(load_rig_bundle(at("wall.tile-1.json")));
    const std::string manifest = read_file(at("wall.json"));
    const auto with = [&](const std::string& from, const std::string& to) {
        std::string text = manifest;
        const std::size_t place = text.find(from);
        REQUIRE(place != std::string::npos);
        write_file(at("bad.json"), text.replace(place, from.size(), to));
        return heard::refusal_of([&] { (void)load_rig_bundle(at("bad.json")); });
    };
    CHECK_REFUSAL(with("wall.tile-1.hex", "wall.tile-2.hex"));
    CHECK_REFUSAL(with("wall.tile-3.hex", "none.hex"));
    CHECK_REFUSAL(with("\"image\"", "\"picture\""));
    CHECK_REFUSAL(with("\"tiles\"", "\"boards\""));
    CHECK_REFUSAL(with("\"elements_sha256\": \"", "\"elements_sha256\": \"0"));
    // A tile of another compilation in the place of this one.
    Project other = some_points(random, kind);
    other.points += 1;
    const CompiledRig second = compile_rig(other, "2x2", at("second.json"));
    write_file(at("wall.tile-4.hex"), second.bundle.tiles[3].hex);
    write_file(at("wall.tile-4.json"), to_text(second.bundle.tiles[3].manifest));
    CHECK_REFUSED(load_rig_bundle(at("wall.json")));
    CHECK_REFUSAL(heard::refusal_of([&] {
        std::vector<Bundle> mixed = compiled.bundle.tiles;
        mixed[3] = second.bundle.tiles[3];
        (void)joined(mixed, "mixed");
    }));
}

TEST_CASE("rig: tiles with channels to spare, a tilted tile, and ports", "[rig]") {
    std::mt19937_64 random(Catch::rngSeed());
    const TemporaryFolder folder;
    const auto rig = folder.path() / "pair.toml";
    write_file(rig,
               "format = \"haptogram-rig-1\"\n"
               "[[unit]]\narray = \"hoshi-6x6\"\norigin_mm = [-60, 0, 0]\nturn_deg = [0, 20, 0]\nport = \"/dev/a\"\n"
               "board = \"tile-100-wide\"\n"
               "[[unit]]\narray = \"hoshi-6x6\"\norigin_mm = [60, 0, 0]\nturn_deg = [0, -20, 0]\nport = \"/dev/b\"\n"
               "board = \"tile-100-wide\"\n");
    Project project = some_points(random, ImageKind::records);
    const CompiledRig compiled = compile_rig(project, rig.string(), "pair.json");
    CHECK(compiled.bundle.rig == "pair");
    CHECK(compiled.bundle.parts[1].port == "/dev/b");
    const Array whole = joined(find_rig(rig.string()));
    const Image& image = compiled.whole.bundle.image;
    CHECK(image.channels == 72);
    for (std::size_t t = 0; t < 2; ++t) {
        const Bundle& tile = compiled.bundle.tiles[t];
        CHECK(tile.image.channels == 100);
        for (std::size_t r = 0; r < image.records.size(); ++r)
            for (std::size_t c = 0; c < 100; ++c)
                REQUIRE(tile.image.records[r].timings[c] ==
                        (c < 36 ? image.records[r].timings[36 * t + c] : interface::silent_timing));
        for (std::size_t c = 0; c < 36; ++c)
            REQUIRE(distance(tile.manifest.array.elements[c].normal, whole.elements[36 * t + c].normal) < 1e-6);
    }
    project.image = ImageKind::foci;
    CHECK_REFUSED(compile_rig(project, rig.string(), "pair.json"));
}

TEST_CASE("rig: what cannot be compiled for a rig says why", "[rig]") {
    std::mt19937_64 random(Catch::rngSeed());
    const TemporaryFolder folder;
    Project project = some_points(random, ImageKind::records);
    const auto refused = [&](const std::string& rig) {
        return heard::refusal_of([&] { (void)compile_rig(project, rig, "x.json"); });
    };
    const auto rig = (folder.path() / "rig.toml").string();
    const auto two = [&](const std::string& first, const std::string& second) {
        write_file(rig, "format = \"haptogram-rig-1\"\n[[unit]]\narray = \"tile-10x10\"\norigin_mm = [-50, 0, 0]\n" +
                            first + "[[unit]]\narray = \"tile-10x10\"\norigin_mm = [50, 0, 0]\n" + second);
    };
    two("", "");
    CHECK_REFUSAL(refused(rig));
    const std::string wide = "board = \"tile-100-wide\"\n";
    two(wide, "board = \"tile-100\"\n");
    CHECK_REFUSAL(refused(rig));
    two(wide, "board = \"\"\n");
    CHECK_REFUSAL(refused(rig));
    two(wide + "port = \"a\"\n", wide + "port = \"a\"\n");
    CHECK_REFUSAL(refused(rig));
    const std::string small =
        fmt::format("array = \"{}/arrays/tile-4x4.toml\"\nboard = \"small-16-sync\"\n", test_data());
    write_file(rig, "format = \"haptogram-rig-1\"\n[[unit]]\norigin_mm = [-50, 0, 0]\n" + small +
                        "[[unit]]\norigin_mm = [50, 0, 0]\n" + small);
    CHECK_REFUSAL(refused(rig));
    project.array = "tile-10x10";
    CHECK_REFUSAL(refused("2x2"));
    project.array.reset();
    project.board = "tile-100";
    CHECK_REFUSAL(refused("2x2"));
}
