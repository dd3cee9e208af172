// SPDX-License-Identifier: Apache-2.0
// Marks of entries from a path file to a board's memory.
#include <catch2/catch.hpp>
#include <vector>

#include "../refusal.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/format/image.hpp"
#include "haptogram/shape/path_file.hpp"

using namespace haptogram;

namespace {

Image marked_image() {
    Image image;
    image.channels = 16;
    image.clock_hz = 50'000'000;
    image.timing_bits = 12;
    image.records = {Record{250, 5, 100, std::vector<std::uint16_t>(16, 7)}};
    image.sequence = {{1, 3}, {0, 2, true}, {1, 9, true}};
    return image;
}

}  // namespace

TEST_CASE("marks: an image keeps them in the uppermost bit of an entry's index, and reads them back") {
    const Image image = marked_image();
    REQUIRE(sequence_words(image) == std::vector<std::uint32_t>{3, 0x0003'0001, 0x0002'8000, 0x0009'8001});
    REQUIRE(from_intel_hex(to_intel_hex(image), "image").sequence == image.sequence);
}

TEST_CASE("marks: a board without a trigger output refuses them, by name") {
    interface::CoreParameters core = interface::find_configuration("small-16")->parameters;
    REQUIRE_NOTHROW(require_fits(marked_image(), core, "image"));
    core.trigger = 0;
    REQUIRE_REFUSED(require_fits(marked_image(), core, "image"));
}

TEST_CASE("marks: a path file says them by step, and anything but true and false is an error") {
    const std::string text =
        R"({"format": "haptogram-path-1", "carrier_hz": 40000, "steps": [{"periods": 4, "foci": []},
            {"periods": 5, "mark": true, "foci": []}, {"periods": 5, "mark": false, "foci": []}]})";
    const Path path = path_from_json(text, "path.json", 40'000.0);
    REQUIRE((!path.steps[0].mark && path.steps[1].mark && !path.steps[2].mark));
    REQUIRE(path_from_json(to_json_text(path, 40'000.0), "again", 40'000.0) == path);
    std::string wrong = text;
    wrong.replace(wrong.find("true"), 4, "1");
    REQUIRE_REFUSED(path_from_json(wrong, "path.json", 40'000.0));
}
