// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <numeric>
#include <random>

#include "../refusal.hpp"
#include "haptogram/acoustics/drive.hpp"
#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/solve/drives.hpp"
#include "haptogram/solve/focal_law.hpp"
#include "haptogram/verbs/compile.hpp"
#include "haptogram/verbs/focus_check.hpp"
#include "haptogram/verbs/measure.hpp"
#include "haptogram/verbs/timeline.hpp"

using namespace haptogram;

namespace {

struct Setting {
    Array array = find_array("tile-10x10");
    Core core = find_configuration("tile-100");
    Timer timer = choose_timer(array, core);
};

}  // namespace

TEST_CASE("drives: one focus by superposition is the focal law, tick for tick but at rounding edges", "[path]") {
    const Setting s;
    std::mt19937_64 g(Catch::rngSeed());
    std::uniform_real_distribution<double> lateral(-0.05, 0.05), height(0.06, 0.25);
    std::size_t different = 0;
    for (int i = 0; i < 200; ++i) {
        const Focus focus{{lateral(g), lateral(g), height(g)}};
        const Record record = quantise(superposed_drives(s.array, {&focus, 1}), s.timer, 100);
        const auto ticks = focal_law(s.array, s.timer, {&focus.position, 1});
        for (std::size_t m = 0; m < ticks.size(); ++m) {
            if (record.timings[m] == ticks[m]) continue;
            ++different;
            const auto apart =
                static_cast<unsigned>(record.timings[m] - ticks[m] + s.timer.cycle_ticks) % s.timer.cycle_ticks;
            REQUIRE((apart == 1 || apart == s.timer.cycle_ticks - 1));
        }
    }
    REQUIRE(different < 100);  // of 20,000
}

TEST_CASE("drives: two foci are both there, each with about its share", "[path]") {
    const Setting s;
    const std::vector<Focus> foci = {{from_mm(-30, 0, 120), 1.0}, {from_mm(30, 10, 120), 1.0}};
    const auto drives = superposed_drives(s.array, foci);
    double strongest = 0.0;
    for (const auto& drive : drives) strongest = std::max(strongest, std::abs(drive));
    REQUIRE(strongest == Approx(1.0));
    const auto one = std::abs(pressure(s.array, drives, foci[0].position));
    const auto other = std::abs(pressure(s.array, drives, foci[1].position));
    const auto between = std::abs(pressure(s.array, drives, from_mm(0, 5, 120)));
    REQUIRE(one == Approx(other).epsilon(0.2));
    REQUIRE(between < 0.5 * one);
}

TEST_CASE("drives: a pulse's length gives the wanted amplitude of the carrier", "[path]") {
    const Setting s;
    REQUIRE(pulse_ticks(s.timer, 1.0) == s.timer.pulse_ticks);
    REQUIRE(pulse_ticks(s.timer, 0.0) == 0);
    for (const double wanted : {0.1, 0.25, 0.5, 0.9}) {
        const std::uint32_t ticks = pulse_ticks(s.timer, wanted);
        const DrivePulse pulse{0.0, ticks * s.timer.tick_s()};
        const double made = std::abs(carrier_component({&pulse, 1}, s.timer.carrier_hz(), s.timer.period_s()));
        REQUIRE(made == Approx(wanted).margin(std::numbers::pi / s.timer.cycle_ticks));
    }
}

TEST_CASE("path: steps, silence, amplitudes and repeats become records and a sequence", "[path]") {
    const Setting s;
    const Focus a{from_mm(0, 0, 120)}, b{from_mm(20, 0, 120), 0.5};
    const Path path{{{{a}, 10}, {{}, 3}, {{b}, 70'000}, {{a}, 5}}, {}};
    const Compiled compiled = compile(path, s.array, s.core, 7, "p.hex");
    const Image& image = compiled.bundle.image;
    REQUIRE(image.records.size() == 2);  // the second visit of a is the same record
    REQUIRE(image.records[0].pulse_length == s.timer.pulse_ticks);
    REQUIRE(image.records[1].pulse_length == pulse_ticks(s.timer, 0.5));
    REQUIRE(image.sequence == std::vector<SequenceEntry>{{1, 10}, {0, 3}, {2, 65'535}, {2, 4'465}, {1, 5}});
    REQUIRE(image.loops == 7);
    REQUIRE(compiled.shortest_dwell_s() ==
            Approx(5 * s.timer.period_s()));  // neither the silence nor a split dwell's rest
    const Path split{{{{a}, 70'000}, {{}, 3}}, {}};
    REQUIRE(compile(split, s.array, s.core).shortest_dwell_s() == Approx(70'000 * s.timer.period_s()));
    REQUIRE(compiled.bundle.manifest.records[0].dwell_cycles == 15);
    REQUIRE(compiled.bundle.manifest.records[1].amplitude == 0.5);
    REQUIRE(compiled.bundle.manifest.records[1].foci == std::vector<Focus>{{b.position, 1.0}});
    // What was made is what is read back, and it keeps its foci.
    const Bundle bundle =
        bundle_of(compiled.bundle.hex, manifest_from_json(to_text(compiled.bundle.manifest), "m"), "p.hex", "m");
    for (std::size_t i = 0; i < 2; ++i) {
        const FocusCheck check =
            check_record(bundle.manifest, bundle.manifest.records[i], drives_of(bundle.manifest, image.records[i]));
        REQUIRE(check.pressure_kept > 0.999);
        REQUIRE(check.peak_offset_m < 0.2e-3);
    }
}

TEST_CASE("path: a record of several foci says so in the manifest and is checked at each of them", "[path]") {
    const Setting s;
    const Path path{{{{{from_mm(-25, 0, 120)}, {from_mm(25, 0, 120), 0.8}}, 20}}, {}};
    const Compiled compiled = compile(path, s.array, s.core);
    const Manifest back = manifest_from_json(to_text(compiled.bundle.manifest), "m");
    REQUIRE(back.records.size() == 1);
    REQUIRE(back.records[0].foci == path.steps[0].foci);
    const FocusCheck check = check_record(back, back.records[0], drives_of(back, compiled.bundle.image.records[0]));
    REQUIRE(check.pressure_kept > 0.995);
    REQUIRE(excitation_of(timeline_of(compiled.bundle)).foci.size() == 2);
}

TEST_CASE("path: a modulation is played for exactly its periods, over as many passes as it takes", "[path]") {
    const Setting s;
    const Focus a{from_mm(0, 0, 120)}, b{from_mm(10, 0, 120)};
    const Path path{{{{a}, 4}, {{b}, 2}}, {{1.0, 0.5, 0.0}, 3}};  // 6 periods of path, 9 of modulation: 18 together
    const Compiled compiled = compile(path, s.array, s.core);
    const Image& image = compiled.bundle.image;
    std::vector<unsigned> pulses;  // one a period
    for (const SequenceEntry& entry : image.sequence)
        pulses.insert(pulses.end(), entry.dwell, entry.index == 0 ? 0U : image.records[entry.index - 1U].pulse_length);
    REQUIRE(pulses.size() == 18);
    for (std::size_t period = 0; period < pulses.size(); ++period)
        REQUIRE(pulses[period] == pulse_ticks(s.timer, path.modulation.samples[period / 3 % 3]));
}

TEST_CASE("path: what makes no sense, or does not fit, is named", "[path]") {
    const Setting s;
    const Focus a{from_mm(0, 0, 120)};
    const auto refuses = [&](const Path& path, const std::string& word) {
        CAPTURE(word);
        REQUIRE_REFUSED(compile(path, s.array, s.core));
    };
    refuses({{}, {}}, "no steps");
    refuses({{{{a}, 0}}, {}}, "step 1");
    refuses({{{{}, 5}}, {}}, "silent");
    refuses({{{{{a.position, 1.5}}, 5}}, {}}, "amplitude of 1.5");
    refuses({{{{{{NAN, 0, 0.1}}}, 5}}, {}}, "not finite");
    refuses({{{{a}, 5}}, {{0.5, 2.0}, 1}}, "modulation sample of 2");
    Path many;
    for (int i = 0; i < 401; ++i) many.steps.push_back({{{from_mm(0.01 * i, 0, 120)}}, 1});
    refuses(many, "400");
    Path busy;
    for (int i = 0; i < 1024; ++i) busy.steps.push_back({{{from_mm(i % 2, 0, 120)}}, 1});
    refuses(busy, "1023");
    Array large = s.array;
    large.elements.push_back({from_mm(60, 0, 0)});
    REQUIRE_REFUSED(compile(Path{{{{a}, 5}}, {}}, large, s.core));
}

TEST_CASE("project: what is written is read back, and the same settings give the same bytes", "[project]") {
    Project project;
    ShapeSource shape;
    shape.primitive.kind = "circle";
    shape.primitive.diameter = 0.0421;
    project.shapes = {shape};
    project.points = 30;
    project.rate_hz = 12.5;
    project.loops = 3;
    project.seed = 9;
    project.placement.center = from_mm(1.1, -2.3, 123.4);
    project.placement.rotate_deg = {10, 0, 33.3};
    project.array = "tile-7x8";
    const std::string text = to_toml(project);
    const Project back = project_from_toml(text, "p.toml");
    REQUIRE(to_toml(back) == text);
    const Compiled first = compile(project), second = compile(back);
    REQUIRE(first.bundle.hex == second.bundle.hex);
    REQUIRE(to_text(first.bundle.manifest) == to_text(second.bundle.manifest));
    REQUIRE(first.bundle.manifest.core.name == "generic-56");
}

TEST_CASE("project: a shape in memory is compiled like its file, and mistakes are named with their line", "[project]") {
    Project project;
    ShapeSource shape;
    shape.file = "dropped.xyz";
    shape.content = "0 0 130\n10 0 130\n0 10 130\n";
    project.shapes = {shape};
    const Compiled compiled = compile(project);
    REQUIRE(compiled.bundle.image.records.size() == 3);
    REQUIRE_REFUSED(to_toml(project));
    const std::string text =
        GENERATE(as<std::string>{}, "", "format = \"haptogram-project-9\"\n", "format = \"haptogram-project-1\"\n",
                 "format = \"haptogram-project-1\"\nshape = 3\n", "format = \"haptogram-project-1\"\n[[shape]]\n",
                 "format = \"haptogram-project-1\"\n[[shape]]\nkind = \"cube\"\nfile = \"x.ply\"\n",
                 "format = \"haptogram-project-1\"\nrate = 3\n[[shape]]\nkind = \"cube\"\n",
                 "format = \"haptogram-project-1\"\nrate_hz = -3\n[[shape]]\nkind = \"cube\"\n",
                 "format = \"haptogram-project-1\"\n[place]\ncenter_mm = [1, 2]\n[[shape]]\nkind = \"cube\"\n",
                 "format = \"haptogram-project-1\"\n[[shape]]\nfile = \"a.ply\"\nsides = 3\n");
    CAPTURE(text);
    REQUIRE_REFUSED(project_from_toml(text, "p.toml"));
}

TEST_CASE("compile: progress is told, and false ends it", "[project]") {
    Project project;
    project.shapes.resize(1);
    project.shapes[0].primitive.kind = "sphere";
    project.points = 20;
    double last = 0.0;
    static_cast<void>(compile(project, "p", [&](double fraction, std::string_view) {
        REQUIRE(fraction >= last);
        last = fraction;
        return true;
    }));
    REQUIRE(last == 1.0);
    try {
        static_cast<void>(compile(project, "p", [](double, std::string_view) { return false; }));
        FAIL("it went on");
    } catch (const Error& error) {
        REQUIRE(error.code() == ErrorCode::cancelled);
    }
}
