// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/inspect.hpp"

#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "source_options.hpp"

namespace haptogram::cli {
namespace {

struct InspectOptions {
    Source source;
    bool json = false;
};

nlohmann::ordered_json to_json(const FocusRecords& foci) {
    nlohmann::ordered_json json = {{"first_index", foci.board_records + 1},  {"foci_a_record", foci.each},
                                   {"cycle_length", foci.cycle_ticks},       {"whole", foci.whole},
                                   {"wave_number", foci.engine.wave_number}, {"gain", foci.engine.gain}};
    for (const FocusWords& words : foci.foci) {
        const Focus focus = unpack_focus(words);
        json["foci"].push_back(
            {{"position_mm",
              {focus.position.x / millimetre, focus.position.y / millimetre, focus.position.z / millimetre}},
             {"amplitude_255", words[3] >> 8U}});
    }
    return json;
}

nlohmann::ordered_json to_json(const Inspection& inspection) {
    const Image& image = inspection.image;
    nlohmann::ordered_json json = {{"channels", image.channels},
                                   {"clock_hz", image.clock_hz},
                                   {"timing_bits", image.timing_bits},
                                   {"pulse_bits", image.pulse_bits},
                                   {"loops", image.loops}};
    json["records"] = nlohmann::ordered_json::array();
    for (std::size_t i = 0; i < image.records.size(); ++i) {
        const Record& r = image.records[i];
        json["records"].push_back({{"index", i + 1},
                                   {"cycle_length", r.cycle_length},
                                   {"prescaler", r.prescaler},
                                   {"pulse_length", r.pulse_length}});
        if (r.kind == interface::Kind::timings)
            json["records"].back()["timings"] = r.timings;
        else
            for (const std::uint16_t word : r.timings) {
                json["records"].back()["amplitudes_255"].push_back(word >> 8U);
                json["records"].back()["phases_256"].push_back(word & 0xffU);
            }
    }
    if (image.foci) json["focus_records"] = to_json(*image.foci);
    if (image.modulation)
        json["modulation"] = {{"periods_a_sample", image.modulation->divider}, {"samples", image.modulation->samples}};
    json["sequence"] = nlohmann::ordered_json::array();
    for (const SequenceEntry& entry : image.sequence)
        json["sequence"].push_back({{"index", entry.index}, {"dwell_cycles", entry.dwell}});
    json["problems"] = inspection.problems;
    return json;
}

std::string pulses(const TimingRange& range) {
    return range.shortest == range.longest ? fmt::to_string(range.longest)
                                           : fmt::format("{}…{}", range.shortest, range.longest);
}

void print_timings(const TimingRange& range) {
    if (range.firing > 0)
        fmt::print("{}…{}\n", range.lowest, range.highest);
    else
        fmt::print("silent\n");
}

void print(const Inspection& inspection) {
    const Image& image = inspection.image;
    const std::vector<std::string>& found = inspection.problems;
    fmt::print("{} channels, {} Hz clock, {} timing bits, {} pulse bits\n", image.channels, image.clock_hz,
               image.timing_bits, image.pulse_bits);
    if (!image.records.empty()) {
        fmt::print("\n{} records\n index  cycle  prescaler  pulse  channels firing  timings\n", image.records.size());
        for (std::size_t i = 0; i < image.records.size(); ++i) {
            const Record& r = image.records[i];
            const TimingRange& range = inspection.ranges[i];
            const std::string pulse =
                r.kind == interface::Kind::timings ? fmt::to_string(r.pulse_length) : pulses(range);
            fmt::print("{:6} {:6} {:10} {:>6} {:16}  ", i + 1, r.cycle_length, r.prescaler, pulse, range.firing);
            print_timings(range);
        }
    }
    if (image.foci) {
        const FocusRecords& foci = *image.foci;
        fmt::print(
            "\n{} focus records of {}, {} ticks a cycle, from index {} on\n index  pulses   channels firing  "
            "timings    foci (mm, amplitude)\n",
            foci.count(), foci.each, foci.cycle_ticks, foci.board_records + 1);
        for (std::size_t n = 0; n < foci.count(); ++n) {
            const TimingRange& range = inspection.ranges[image.records.size() + n];
            fmt::print("{:6} {:>7} {:17}  {:9}", foci.board_records + 1 + n, pulses(range), range.firing,
                       range.firing > 0 ? fmt::format("{}…{}", range.lowest, range.highest) : "silent");
            for (const FocusWords& words : foci.record(n)) {
                const Focus focus = unpack_focus(words);
                fmt::print("  ({:.2f}, {:.2f}, {:.2f}; {:.3f})", focus.position.x / millimetre,
                           focus.position.y / millimetre, focus.position.z / millimetre, focus.amplitude);
            }
            fmt::print("\n");
        }
    }
    if (image.modulation)
        fmt::print("\nmodulation: {} samples of {} carrier periods\n", image.modulation->samples.size(),
                   image.modulation->divider);
    fmt::print("\n{} sequence entries, {}\n entry  index  dwell\n", image.sequence.size(),
               image.loops == 0 ? std::string("repeated for ever") : fmt::format("played {} times", image.loops));
    for (std::size_t i = 0; i < image.sequence.size(); ++i)
        fmt::print("{:6} {:6} {:6}\n", i + 1, image.sequence[i].index, image.sequence[i].dwell);
    fmt::print("\nchecks: {}\n", found.empty()
                                     ? "checksums, regions, records and sequence are in order"
                                     : fmt::format("{} problem{}", found.size(), found.size() > 1 ? "s" : ""));
    for (const std::string& problem : found) fmt::print("  {}\n", problem);
}

int inspect(const InspectOptions& options) {
    const Inspection inspection = haptogram::inspect(open_hex(options.source.file, path_makers()), options.source.file);
    if (options.json)
        fmt::print("{}\n", to_json(inspection).dump(1));
    else
        print(inspection);
    return inspection.problems.empty() ? 0 : 1;
}

}  // namespace

void add_inspect(CLI::App& app, Action& action) {
    auto options = std::make_shared<InspectOptions>();
    CLI::App* sub = app.add_subcommand(
        "inspect", "Print an image's records, foci, sequence and checks; exit code 1 when something would not play");
    add_source_file(*sub, options->source)->required();
    sub->add_flag("--json", options->json, "As JSON, with every timing");
    sub->callback([options, &action] { action = [options] { return inspect(*options); }; });
}

}  // namespace haptogram::cli
