// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>

#include "../refusal.hpp"
#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/format/intel_hex.hpp"
#include "haptogram/link/transfer.hpp"
#include "haptogram/verbs/compile.hpp"
#include "haptogram/verbs/focus_check.hpp"
#include "haptogram/verbs/focus_image.hpp"
#include "haptogram/verbs/inspect.hpp"
#include "haptogram/verbs/measure.hpp"

using namespace haptogram;

namespace {

const Array& tile() {
    static const Array array = find_array("tile-10x10");
    return array;
}

const Core& wide() {
    static const Core core = find_configuration("tile-100-wide");
    return core;
}

Path two_steps() {
    return {{{{{from_mm(3, -4, 120), 1.0}}, 20},
             {{{from_mm(-20, 0, 130), 1.0}, {from_mm(22, 5, 140), 0.5}}, 70'000},
             {{}, 5},
             {{{from_mm(3, -4, 120), 1.0}}, 2}},
            {}};
}

}  // namespace

TEST_CASE("focus image: equal foci share a record, and long steps are several entries", "[foci]") {
    const FocusImage made = focus_image_of(two_steps(), tile(), wide(), 3);
    const FocusRecords& foci = made.image.foci.value();
    REQUIRE(made.image.records.empty());
    REQUIRE(foci.count() == 2);
    REQUIRE(foci.each == 2);
    REQUIRE(foci.board_records == 400);
    REQUIRE(made.image.sequence == std::vector<SequenceEntry>{{401, 20}, {402, 65535}, {402, 4465}, {0, 5}, {401, 2}});
    REQUIRE(made.records[0].dwell_cycles == 22);
    REQUIRE(made.records[1].dwell_cycles == 70'000);
    REQUIRE(unpack_focus(foci.record(0)[0]) == Focus{from_mm(3, -4, 120), 1.0});
    REQUIRE(unpack_focus(foci.record(0)[1]).amplitude == 0.0);  // fills the record up
    REQUIRE(made.timer.prescaler == 1);
    REQUIRE(made.timer.cycle_ticks == 1250);
    REQUIRE(place_of(made.image, 401) == 0);
    REQUIRE(place_of(made.image, 402) == 1);
    for (const std::uint32_t none : {0U, 1U, 400U, 403U, 65535U}) REQUIRE_FALSE(place_of(made.image, none));
    REQUIRE(index_of(made.image, 1) == 402);
    // 8 bytes a focus, from address 0 on.
    REQUIRE(primary_words(made.image).size() == 4 * 4);
}

TEST_CASE("focus image: what the board computes is a focus where it was asked, with the asked amplitude", "[foci]") {
    const Compiled compiled = compile(two_steps(), tile(), wide());
    const Bundle& bundle = compiled.bundle;
    const Array& array = bundle.manifest.array;
    for (std::size_t i = 0; i < 2; ++i) {
        const auto drives = drives_of(bundle.manifest, bundle.image, i);
        const RecordMeaning& meaning = bundle.manifest.records[i];
        REQUIRE(check_record(bundle.manifest, meaning, drives).pressure_kept >= 0.999);
        REQUIRE(check_record(bundle.manifest, meaning, drives).peak_offset_m < 0.1e-3);
        // Beside the libraries' formulas: each element's phase is that of its distance, up to one of all.
        if (meaning.foci.size() > 1) continue;
        const Vec3 focus = meaning.foci.front().position;
        const double k = 2 * std::numbers::pi / array.wavelength_m();
        double worst = 0.0;
        for (std::size_t m = 0; m < drives.size(); ++m) {
            const double asked =
                k * (distance(array.elements[m].position, focus) - distance(array.elements[0].position, focus));
            const double made = std::arg(drives[m]) - std::arg(drives[0]);
            worst = std::max(worst, std::abs(std::remainder(made - asked, 2 * std::numbers::pi)));
            REQUIRE(std::abs(drives[m]) ==
                    Approx(array.transducer.source_pa_m / bundle.manifest.foci.value().full).epsilon(0.003));
        }
        // Both are rounded to half a tick, and a place to half of 1/128 mm.
        REQUIRE(worst < 2 * std::numbers::pi * 1.3 / 1250);
    }
    // The weaker focus keeps its ratio to the stronger one, against exact sums.
    const auto& two = bundle.manifest.records[1];
    const auto exact = summed_drives(array, two.foci);
    const auto made = drives_of(bundle.manifest, bundle.image, 1);
    for (const Focus& focus : two.foci) {
        const double ratio = std::abs(pressure(array, made, focus.position)) / array.transducer.source_pa_m *
                             bundle.manifest.foci.value().full / std::abs(pressure(array, exact, focus.position));
        REQUIRE(ratio == Approx(1.0).margin(0.002));
    }
}

TEST_CASE("focus image: what the board rounds stays within the limits of its check", "[foci]") {
    CAPTURE(Catch::rngSeed());
    std::mt19937_64 g(Catch::rngSeed());
    std::uniform_real_distribution<double> lateral(-0.04, 0.04), height(0.08, 0.18), weak(0.05, 1.0);
    Path path;
    for (int i = 0; i < 64; ++i) {
        std::vector<Focus> foci;
        while (foci.size() < 2 + static_cast<std::size_t>(i) % 7) {
            const Vec3 at{lateral(g), lateral(g), height(g)};
            if (std::none_of(foci.begin(), foci.end(), [&](const Focus& f) { return distance(f.position, at) < 0.02; }))
                foci.push_back({at, foci.empty() ? 1.0 : weak(g)});
        }
        path.steps.push_back({foci, 20});
    }
    const Bundle bundle = compile(path, tile(), wide()).bundle;
    double least = 1.0;
    int told = 0;
    for (std::size_t i = 0; i < bundle.manifest.records.size(); ++i) {
        const RecordMeaning& record = bundle.manifest.records[i];
        auto drives = drives_of(bundle.manifest, bundle.image, i);
        const FocusCheck check = check_record(bundle.manifest, record, drives);
        const FocusLimits limits = limits_of(bundle.manifest, record);
        CAPTURE(i, record.foci.size(), check.pressure_kept, limits.least_kept, check.peak_offset_m,
                limits.most_offset_m);
        CHECK(check.pressure_kept >= limits.least_kept);
        CHECK(check.peak_offset_m <= limits.most_offset_m);
        least = std::min(least, check.pressure_kept);
        // A tenth of the elements silent is no rounding, where rounding leaves most of each focus.
        if (limits.least_kept < 0.95) continue;
        ++told;
        for (std::size_t m = 0; m < drives.size(); m += 10) drives[m] = 0.0;
        const FocusCheck broken = check_record(bundle.manifest, record, drives);
        CHECK((broken.pressure_kept < limits.least_kept || broken.peak_offset_m > limits.most_offset_m));
    }
    CHECK(told > 32);
    CHECK(least < 0.999);  // which is what a fixed limit would be
}

TEST_CASE("focus image: what is written is read back, with its manifest", "[foci]") {
    Path path = two_steps();
    path.modulation = {{0.0, 0.25, 1.0}, 7};
    const Compiled compiled = compile(path, tile(), wide(), 2, "foci.hex");
    const Image& image = compiled.bundle.image;
    REQUIRE(from_intel_hex(to_intel_hex(image), "f") == image);
    REQUIRE(image.modulation == SampledModulation{7, {0, 64, 255}});
    const std::string text = to_text(compiled.bundle.manifest);
    const Manifest back = manifest_from_json(text, "m");
    REQUIRE(to_text(back) == text);
    REQUIRE(back.index_of(1) == 402);
    REQUIRE(back.place_of(402) == 1);
    REQUIRE_FALSE(back.place_of(400));
    const Bundle bundle = bundle_of(compiled.bundle.hex, back, "i", "m");
    REQUIRE(path_of(bundle).modulation.periods_a_sample == 7);
    REQUIRE(path_of(bundle).steps.size() == 4);
    REQUIRE(record_clocks(image) == std::vector<std::uint64_t>{22 * 1250, 70'000 * 1250ULL});
    const Inspection inspection = inspect(compiled.bundle.hex, "i");
    REQUIRE(inspection.problems.empty());
    REQUIRE(inspection.ranges[0].firing == 100);
    // An image without foci or modulation is what it was: a description of eight words.
    const Compiled plain =
        compile(two_steps(), tile(), wide(), 2, "plain.hex", Method::gauss_newton, {}, ImageKind::records);
    REQUIRE(intel_hex::read(plain.bundle.hex, "f").back().bytes.size() == 16);
    REQUIRE_FALSE(plain.bundle.image.foci);
}

TEST_CASE("focus image: boards of protocol 2.4 add a channel's phase, and know no weights", "[foci]") {
    Image image = compile(two_steps(), tile(), wide(), 1, "foci.hex").bundle.image;
    link::Identity board;
    board.version_major = 2;
    board.version_minor = 4;
    image.foci->engine.geometry[7][3] = 0x4000;
    CHECK_NOTHROW(link::UploadSteps(image, board));
    image.foci->engine.geometry[7][3] = 0x4001;
    CHECK_REFUSED(link::UploadSteps(image, board));
    board.version_minor = 5;
    CHECK_NOTHROW(link::UploadSteps(image, board));
}

TEST_CASE("focus image: a manifest of other foci, of another geometry or modulation is refused", "[foci]") {
    const Compiled compiled = compile(two_steps(), tile(), wide(), 1, "foci.hex");
    const auto refused = [&](auto change) {
        Manifest manifest = compiled.bundle.manifest;
        change(manifest);
        REQUIRE_REFUSED(bundle_of(compiled.bundle.hex, manifest, "i", "m"));
    };
    refused([](Manifest& m) { m.records[0].foci[0].position.x += 1e-4; });
    refused([](Manifest& m) { m.records[1].amplitude = 0.9; });
    refused([](Manifest& m) { m.array.elements[7].position.y += 1e-4; });
    refused([](Manifest& m) { m.foci.reset(); });
    refused([](Manifest& m) { m.modulation = SampledModulation{1, {3}}; });
    refused([](Manifest& m) { m.core.parameters.records = 399; });
    refused([](Manifest& m) { m.records[1].foci.pop_back(); });
}

TEST_CASE("focus image: what does not fit a board is named", "[foci]") {
    const Path path = two_steps();
    const auto throws = [&](const Path& asked, const Array& array, const Core& core) {
        REQUIRE_REFUSED(focus_image_of(asked, array, core, 0));
    };
    throws(path, tile(), find_configuration("tile-100"));
    throws(path, find_array("tile-7x8"), wide());
    throws({{{std::vector<Focus>(9, {from_mm(0, 0, 100)}), 1}}, {}}, tile(), wide());
    throws({{{{{from_mm(0, 0, 1024)}}, 1}}, {}}, tile(), wide());
    throws({{{{{from_mm(-1000, 0, 100)}}, 1}}, {}}, tile(), wide());
    throws({{{{{from_mm(0, 0, 100), 0.001}}, 1}}, {}}, tile(), wide());
    Path modulated = path;
    modulated.modulation.samples.assign(4097, 1.0);
    throws(modulated, tile(), wide());
    Path many;
    for (int i = 0; i < 1024; ++i) many.steps.push_back({{{from_mm(0.01 * i, 0, 100)}}, 1});
    throws(many, tile(), wide());

    const Image image = focus_image_of(path, tile(), wide(), 0).image;
    REQUIRE_NOTHROW(require_fits(image, wide().parameters, "i"));
    const auto unfit = [&](auto change) {
        interface::CoreParameters core = wide().parameters;
        change(core);
        REQUIRE_REFUSED(require_fits(image, core, "i"));
    };
    unfit([](auto& p) { p.foci = 0; });
    unfit([](auto& p) { p.records = 401; });
    unfit([](auto& p) { p.width_bits = 9; });
    unfit([](auto& p) { p.channels = 99; });
    Image with_samples = image;
    with_samples.modulation = SampledModulation{1, std::vector<std::uint8_t>(4097)};
    REQUIRE_REFUSED(require_fits(with_samples, wide().parameters, "i"));

    Image timed;
    timed.channels = wide().parameters.channels;
    timed.clock_hz = wide().parameters.clock_hz;
    timed.timing_bits = wide().parameters.timing_bits;
    for (const std::uint32_t cycle : {2048U, 2049U, 3071U, 3072U}) {  // 2^11 + 1 to 2^11 + 2^10 − 1 play silence
        timed.records.assign(
            1, Record{cycle, 1, 100, std::vector<std::uint16_t>(timed.channels), interface::Kind::timings});
        INFO(cycle << " ticks");
        if (cycle == 2048U || cycle == 3072U)
            CHECK_NOTHROW(require_fits(timed, wide().parameters, "i"));
        else
            CHECK_REFUSED(require_fits(timed, wide().parameters, "i"));
    }
}

TEST_CASE("focus image: many foci at a time take more than a period to compute, which is a warning", "[foci]") {
    Core slow = wide();
    slow.parameters.channels = 256;
    Array array = tile();
    while (array.elements.size() < 256) array.elements.push_back(array.elements[array.elements.size() - 100]);
    const std::vector<Focus> eight(8, {from_mm(0, 0, 150), 0.5});
    const FocusImage made = focus_image_of({{{eight, 4}}, {}}, array, slow, 0);
    REQUIRE(made.warnings.size() == 1);
    REQUIRE_SAID(made.warnings[0]);
    REQUIRE(focus_image_of({{{{eight[0]}, 4}}, {}}, array, slow, 0).warnings.empty());
}

TEST_CASE("focus image: a record of amplitudes is read, inspected and bounded", "[foci]") {
    Image image;
    image.channels = 2;
    image.clock_hz = 50'000'000;
    image.timing_bits = 11;
    image.records = {{1250, 1, 0, {0xff40, 0x0080}, interface::Kind::amplitudes}};
    image.sequence = {{1, 5}};
    const std::string hex = to_intel_hex(image);
    REQUIRE(from_intel_hex(hex, "f") == image);
    const Inspection inspection = inspect(hex, "f");
    REQUIRE(inspection.problems.empty());
    // The middle of the only pulse is at a quarter of the cycle, and it is half a cycle long.
    REQUIRE(inspection.ranges[0].firing == 1);
    REQUIRE(inspection.ranges[0].longest == 625);
    REQUIRE(inspection.ranges[0].lowest <= 1);
    image.records[0].prescaler = 2;
    REQUIRE_SAID(problems(image).at(0));
    image.records[0].prescaler = 1;
    image.records[0].cycle_length = 4096;
    REQUIRE_SAID(problems(image).at(0));
}

TEST_CASE("focus image: the host's kind follows the board, unless it is asked for", "[foci]") {
    Project project;
    project.shapes.push_back({});
    project.shapes.back().primitive.kind = "point";
    project.array = "tile-10x10";
    project.board = "tile-100-wide";
    REQUIRE(compile(project).bundle.image.foci);
    project.image = ImageKind::records;
    REQUIRE_FALSE(compile(project).bundle.image.foci);
    REQUIRE(project_from_toml(to_toml(project), "p").image == ImageKind::records);
    project.image.reset();
    project.quantise = "hoshi";
    REQUIRE_FALSE(compile(project).bundle.image.foci);
    project.image = ImageKind::foci;
    REQUIRE_REFUSED(compile(project));
    project.quantise.clear();
    project.board = "tile-100";
    REQUIRE_REFUSED(compile(project));
}
