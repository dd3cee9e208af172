// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>

#include "command.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/boards/board.hpp"
#include "haptogram/image/manifest.hpp"
#include "haptogram/shape/import.hpp"
#include "haptogram/shape/place.hpp"
#include "haptogram/shape/primitives.hpp"
#include "haptogram/shape/sample.hpp"
#include "haptogram/shape/tour.hpp"
#include "haptogram/solve/focal_law.hpp"

namespace haptogram::cli {
namespace {

struct CompileOptions {
    std::vector<std::string> inputs;
    std::vector<std::string> shapes;
    PrimitiveSpec primitive;  ///< but for its kind: the measures of every --shape, in mm
    std::optional<std::string> board;
    std::optional<std::string> array;
    std::string unit = "mm";
    std::size_t points = 200;
    std::uint64_t seed = 1;
    double rate_hz = 10.0;
    std::uint16_t loops = 0;
    std::vector<double> center_mm;
    std::vector<double> rotate_deg;
    double size_mm = 0.0;
    double scale = 1.0;
    bool clip = false;
    std::string output = "image.hex";
    std::string manifest;
    std::string readmemh;
    bool json = false;
};

struct Numbers {
    std::size_t duplicates = 0, clipped = 0;
    double tour_before_m = 0.0, tour_after_m = 0.0;
};

double metres_per_unit(const std::string& unit) { return unit == "m" ? 1.0 : unit == "cm" ? 0.01 : millimetre; }

Vec3 vector_mm(const std::vector<double>& v) { return from_mm(v[0], v[1], v[2]); }

Shape gather(const CompileOptions& options, std::string& hashed) {
    Shape shape;
    const auto add = [&shape](Shape part) {
        std::move(part.pieces.begin(), part.pieces.end(), std::back_inserter(shape.pieces));
    };
    for (const std::string& input : options.inputs) {
        std::string hash;
        add(load_shape(input, metres_per_unit(options.unit), &hash));
        hashed += hash;
    }
    for (const std::string& kind : options.shapes) {
        PrimitiveSpec spec = options.primitive;
        spec.kind = kind;
        for (std::optional<double>* length : {&spec.diameter, &spec.length, &spec.height})
            if (*length) **length *= millimetre;
        add(make_primitive(spec));
    }
    if (shape.pieces.empty())
        throw Error(ErrorCode::bad_argument, "compile",
                    fmt::format("nothing to compile: give a file, or --shape with one of {}",
                                fmt::join(primitive_kinds(), ", ")));
    return shape;
}

Placement placement(const CompileOptions& options) {
    Placement result;
    result.scale = options.scale;
    if (options.size_mm > 0.0) result.size_m = options.size_mm * millimetre;
    if (!options.rotate_deg.empty()) std::copy_n(options.rotate_deg.begin(), 3, result.rotate_deg.begin());
    if (!options.center_mm.empty())
        result.center = vector_mm(options.center_mm);
    else if (options.inputs.empty())
        result.center = from_mm(0.0, 0.0, 130.0);  // where the paper shows its shapes to people
    return result;
}

/// Leaves out what cannot be reached, or refuses the whole shape and says which points.
void require_reachable(std::vector<Vec3>& points, const Array& array, bool clip, Numbers& numbers) {
    constexpr std::size_t most_listed = 10;
    std::string listed;
    std::size_t count = 0;
    std::vector<Vec3> reachable;
    for (const Vec3& p : points) {
        const std::string reason = array.unreachable(p);
        if (reason.empty()) {
            reachable.push_back(p);
            continue;
        }
        if (++count <= most_listed)
            listed += fmt::format("\n  ({:.2f}, {:.2f}, {:.2f}) mm: {}", p.x / millimetre, p.y / millimetre,
                                  p.z / millimetre, reason);
    }
    if (count == 0) return;
    if (count > most_listed) listed += fmt::format("\n  and {} more", count - most_listed);
    if (!clip)
        throw bad_input(array.file, fmt::format("{} of {} points are out of reach:{}\nmove or scale the shape "
                                                "(--center, --size), or leave them out with --clip",
                                                count, points.size(), listed));
    if (reachable.empty())
        throw bad_input(array.file,
                        fmt::format("--clip leaves no point: all {} are out of reach:{}", points.size(), listed));
    numbers.clipped = count;
    points = std::move(reachable);
}

/// Carrier cycles for each point, as even as whole numbers allow, so that a pass takes one period of the rate.
std::vector<std::uint32_t> dwells(const Timer& timer, double rate_hz, std::size_t count) {
    const double total = timer.carrier_hz() / rate_hz;
    const double each = total / static_cast<double>(count);
    if (each < 1.0)
        throw bad_input(
            "--rate",
            fmt::format(
                "{} points at {} Hz leave {:.2f} carrier cycles a point, and a focus lasts at least one; "
                "at most {:.4g} Hz can be reached with these points{}",
                count, rate_hz, each, timer.carrier_hz() / static_cast<double>(count),
                total >= 1.0 ? fmt::format(", or {} points at this rate", static_cast<std::size_t>(total)) : ""));
    if (each > 65535.0)
        throw bad_input("--rate",
                        fmt::format("{} points at {} Hz leave {:.4g} carrier cycles a point, and a sequence entry "
                                    "holds 65535; at least {:.4g} Hz",
                                    count, rate_hz, each, timer.carrier_hz() / static_cast<double>(count) / 65535.0));
    std::vector<std::uint32_t> result;
    std::uint64_t given = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const auto until = static_cast<std::uint64_t>(std::llround(each * static_cast<double>(i + 1)));
        result.push_back(static_cast<std::uint32_t>(until - given));
        given = until;
    }
    return result;
}

Image make_image(const Manifest& manifest, std::uint16_t loops) {
    const Array& array = manifest.array;
    Image image;
    image.channels = array.board.channels;
    image.clock_hz = static_cast<std::uint32_t>(array.board.clock_hz);
    image.timing_bits = array.board.timing_bits;
    image.pulse_bits = array.board.pulse_bits;
    image.loops = loops;
    const std::size_t elements = array.elements.size();
    const std::vector<std::uint16_t> ticks = focal_law(array, manifest.timer, manifest.foci);
    for (std::size_t i = 0; i < manifest.foci.size(); ++i) {
        Record record{manifest.timer.cycle_ticks,
                      manifest.timer.prescaler,
                      static_cast<std::uint8_t>(manifest.timer.pulse_ticks),
                      {}};
        record.timings.assign(ticks.begin() + static_cast<std::ptrdiff_t>(i * elements),
                              ticks.begin() + static_cast<std::ptrdiff_t>((i + 1) * elements));
        record.timings.resize(image.channels, interface::silent_timing);
        image.records.push_back(std::move(record));
        image.sequence.push_back(
            {static_cast<std::uint16_t>(i + 1), static_cast<std::uint16_t>(manifest.dwell_cycles[i])});
    }
    return image;
}

/// The least time that any point is shown.
double shortest_dwell_s(const Manifest& m) {
    return *std::min_element(m.dwell_cycles.begin(), m.dwell_cycles.end()) * m.timer.period_s();
}

void print_report(const Manifest& m, const Numbers& numbers, std::size_t hex_bytes, const CompileOptions& options) {
    const Formation& f = m.formation;
    fmt::print("array             {}, {} elements on {} channels\n", m.array.name, m.array.elements.size(),
               m.array.board.channels);
    fmt::print("points            {}", m.foci.size());
    if (numbers.clipped > 0) fmt::print(", {} out of reach left out", numbers.clipped);
    if (numbers.duplicates > 0) fmt::print(", {} duplicates left out", numbers.duplicates);
    fmt::print("\ntour              {:.1f} mm, {:.1f} mm as given\n", numbers.tour_after_m / millimetre,
               numbers.tour_before_m / millimetre);
    fmt::print(
        "timer             prescaler {}, {} ticks of {:.0f} ns a cycle, pulse {} ticks ({:.1f} %), carrier {:.1f} Hz\n",
        m.timer.prescaler, m.timer.cycle_ticks, m.timer.tick_s() * 1e9, m.timer.pulse_ticks, 100.0 * m.timer.duty(),
        m.timer.carrier_hz());
    fmt::print("rendering rate    {:.4g} Hz, {:.1f} µs a point\n", m.rate_hz, shortest_dwell_s(m) * 1e6);
    fmt::print("flight spread ΔT  {:.1f} µs, β = {} periods\n", f.flight_spread_s * 1e6, f.periods);
    fmt::print("focus forms in    T_f = {:.1f} µs, {:.1f} µs with the transducers' ring-up\n", f.formation_s * 1e6,
               f.with_ring_up_s() * 1e6);
    fmt::print("full pressure for at most {} points at this rate, {} with ring-up\n",
               most_points(m.rate_hz, f.formation_s), most_points(m.rate_hz, f.with_ring_up_s()));
    fmt::print("image             {} ({} bytes), manifest {}\n", options.output, hex_bytes, options.manifest);
}

nlohmann::ordered_json report_json(const Manifest& m, const Numbers& numbers, std::size_t hex_bytes,
                                   const CompileOptions& options) {
    return {{"array", m.array.name},
            {"points", m.foci.size()},
            {"clipped", numbers.clipped},
            {"duplicates", numbers.duplicates},
            {"tour_mm", numbers.tour_after_m / millimetre},
            {"tour_as_given_mm", numbers.tour_before_m / millimetre},
            {"prescaler", m.timer.prescaler},
            {"cycle_ticks", m.timer.cycle_ticks},
            {"pulse_ticks", m.timer.pulse_ticks},
            {"carrier_hz", m.timer.carrier_hz()},
            {"rate_hz", m.rate_hz},
            {"shortest_dwell_s", shortest_dwell_s(m)},
            {"flight_spread_s", m.formation.flight_spread_s},
            {"beta_periods", m.formation.periods},
            {"formation_s", m.formation.formation_s},
            {"formation_with_ring_up_s", m.formation.with_ring_up_s()},
            {"most_points", most_points(m.rate_hz, m.formation.formation_s)},
            {"most_points_with_ring_up", most_points(m.rate_hz, m.formation.with_ring_up_s())},
            {"image", options.output},
            {"image_bytes", hex_bytes},
            {"manifest", options.manifest}};
}

void warn_short_dwell(const Manifest& m) {
    const double dwell = shortest_dwell_s(m);
    if (dwell >= m.formation.with_ring_up_s()) return;
    const bool geometry = dwell < m.formation.formation_s;
    complain(fmt::format(
        "warning: a point lasts {:.1f} µs, shorter than the {:.1f} µs {}; it will not reach its full pressure",
        dwell * 1e6, (geometry ? m.formation.formation_s : m.formation.with_ring_up_s()) * 1e6,
        geometry ? "in which all waves arrive at a focus" : "that the transducers' ring-up takes as well"));
}

void check_options(CompileOptions& options) {
    const PrimitiveSpec& measures = options.primitive;
    if (options.shapes.empty() &&
        (measures.diameter || measures.length || measures.height || measures.sides || measures.turns))
        throw Error(ErrorCode::bad_argument, "--diameter, --length, --height, --sides, --turns",
                    "measure a built-in shape, and there is none; add --shape, or scale files with --size");
    if (options.output.empty()) throw Error(ErrorCode::bad_argument, "--output", "the name is empty; name the image");
    if (options.manifest.empty()) {
        if (options.output == "-")
            throw Error(ErrorCode::bad_argument, "-o -",
                        "needs --manifest FILE: an image is of little use without its manifest");
        options.manifest = manifest_path(options.output);
    }
    std::vector<NamedPath> inputs;
    for (const std::string& input : options.inputs) inputs.push_back({"an input", input});
    if (options.array && options.array->ends_with(".toml")) inputs.push_back({"--array", *options.array});
    if (options.board && options.board->ends_with(".toml")) inputs.push_back({"--board", *options.board});
    std::vector<NamedPath> outputs = {{"--output", options.output}, {"--manifest", options.manifest}};
    if (!options.readmemh.empty()) {
        outputs.push_back({"--readmemh", options.readmemh + ".primary.mem"});
        outputs.push_back({"--readmemh", options.readmemh + ".sequence.mem"});
    }
    require_distinct(inputs, outputs);
}

std::string everything_that_shapes_the_image(const CompileOptions& o, const Manifest& m) {
    const PrimitiveSpec& p = o.primitive;
    return fmt::format("{} {} {} {} {} {} {} {} {} {} {} {} {} {} {} {} {} ", version(), fmt::join(o.shapes, ","),
                       p.diameter.value_or(0.0), p.length.value_or(0.0), p.height.value_or(0.0), p.sides.value_or(0),
                       p.turns.value_or(0.0), o.unit, o.points, o.seed, o.rate_hz, o.loops, fmt::join(o.center_mm, ","),
                       fmt::join(o.rotate_deg, ","), o.size_mm, o.scale, o.clip) +
           to_json(Manifest{.array = m.array,
                            .timer = m.timer,
                            .foci = {},
                            .dwell_cycles = {},
                            .formation = {},
                            .input_sha256 = {},
                            .image_sha256 = {}})
               .dump();
}

/// The array, on the board that --board names or on the one that its own file describes.
Array chosen_array(const CompileOptions& options) {
    if (!options.board) return find_array(options.array.value_or("tile-10x10"));
    const Board board = load_board(*options.board);
    return find_array(options.array.value_or(board.array), board.spec());
}

int compile(CompileOptions options) {
    check_options(options);
    Manifest manifest;
    manifest.array = chosen_array(options);
    manifest.timer = choose_timer(manifest.array);
    std::string hashed = everything_that_shapes_the_image(options, manifest);
    const Shape shape = place(gather(options, hashed), placement(options));
    Sampled sampled = sample(shape, options.points, options.seed);
    std::vector<Vec3> points = std::move(sampled.points);
    Numbers numbers;
    numbers.duplicates = sampled.duplicates_removed;
    require_reachable(points, manifest.array, options.clip, numbers);
    const BoardSpec& board = manifest.array.board;
    const std::size_t most = std::min(board.records, board.sequence_depth - 1);
    if (points.size() > most)
        throw bad_input(board.name, fmt::format("{} points, but the board holds {} ({} records, {} sequence entries); "
                                                "take fewer (--points {}) or another board (--board, --array)",
                                                points.size(), most, board.records, board.sequence_depth - 1, most));

    const std::vector<std::size_t> order = closed_tour(points);
    std::vector<std::size_t> as_given(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) as_given[i] = i;
    numbers.tour_before_m = tour_length(points, as_given);
    numbers.tour_after_m = tour_length(points, order);
    for (const std::size_t i : order) manifest.foci.push_back(points[i]);

    manifest.dwell_cycles = dwells(manifest.timer, options.rate_hz, points.size());
    std::uint64_t cycles = 0;
    for (const std::uint32_t dwell : manifest.dwell_cycles) cycles += dwell;
    manifest.rate_hz = manifest.timer.carrier_hz() / static_cast<double>(cycles);
    manifest.formation = slowest_formation(manifest.array, manifest.foci);
    manifest.input_sha256 = sha256(hashed);

    const Image image = make_image(manifest, options.loops);
    const std::string hex = to_intel_hex(image);
    manifest.image_sha256 = sha256(hex);
    std::vector<std::pair<std::filesystem::path, std::string>> files = {
        {options.output, hex}, {options.manifest, to_json(manifest).dump(1) + "\n"}};
    if (!options.readmemh.empty()) {
        files.emplace_back(options.readmemh + ".primary.mem", primary_readmemh(image));
        files.emplace_back(options.readmemh + ".sequence.mem", sequence_readmemh(image));
    }
    write_files(files);
    const bool stdout_taken = options.output == "-" || options.manifest == "-";
    if (options.json && !stdout_taken)
        fmt::print("{}\n", report_json(manifest, numbers, hex.size(), options).dump(1));
    else if (!stdout_taken)
        print_report(manifest, numbers, hex.size(), options);
    warn_short_dwell(manifest);
    return 0;
}

}  // namespace

void add_compile(CLI::App& app, Action& action) {
    auto options = std::make_shared<CompileOptions>();
    CLI::App* sub =
        app.add_subcommand("compile", "Turn shapes into an Intel HEX image of focal timings, and its manifest");
    sub->add_option("inputs", options->inputs, "PLY, OBJ, STL, XYZ or CSV files; several become one shape");
    sub->add_option("--shape", options->shapes,
                    fmt::format("Built-in shape, may be repeated: {}", fmt::join(primitive_kinds(), ", ")));
    sub->add_option("--diameter", options->primitive.diameter, "Of a built-in round shape, mm")->check(positive());
    sub->add_option("--length", options->primitive.length,
                    "Of a built-in line or plus, or the edge of a built-in straight-edged shape, mm")
        ->check(positive());
    sub->add_option("--height", options->primitive.height, "Of a built-in cone, cylinder or helix, mm")
        ->check(positive());
    sub->add_option("--sides", options->primitive.sides, "Of a built-in polygon")->check(whole(3, 1000));
    sub->add_option("--turns", options->primitive.turns, "Of a built-in helix")->check(positive());
    sub->add_option("--board", options->board,
                    "Board file (TOML) or shipped board, see haptogram board list (default: the array file's [board])");
    sub->add_option("--array", options->array,
                    "Array file (TOML) or shipped array: tile-10x10, tile-7x8, hoshi-18x18 (default: the board's, or "
                    "tile-10x10)");
    sub->add_option("--unit", options->unit, "Unit of the coordinates in the files")
        ->check(CLI::IsMember({"mm", "cm", "m"}))
        ->capture_default_str();
    sub->add_option("--points", options->points, "Focal points to take from a surface, a curve or a larger cloud")
        ->check(whole(1, 65535))
        ->capture_default_str();
    sub->add_option("--seed", options->seed, "Of the sampling")
        ->check(whole(0, std::numeric_limits<std::uint64_t>::max()))
        ->capture_default_str();
    sub->add_option("--rate", options->rate_hz, "Passes over the shape a second, Hz")
        ->check(positive())
        ->capture_default_str();
    sub->add_option("--loops", options->loops, "Passes when the image is played by itself; 0 is for ever")
        ->check(whole(0, 65535))
        ->capture_default_str();
    sub->add_option("--center", options->center_mm,
                    "Move the bounding box's centre to x,y,z mm (built-in shapes: 0,0,130)")
        ->delimiter(',')
        ->expected(3);
    sub->add_option("--size", options->size_mm, "Scale so that the largest extent is this many mm")->check(positive());
    sub->add_option("--rotate", options->rotate_deg, "Turn about the centre, degrees about x, then y, then z")
        ->delimiter(',')
        ->expected(3);
    sub->add_option("--scale", options->scale, "Multiply every coordinate")->check(positive())->capture_default_str();
    sub->add_flag("--clip", options->clip, "Leave out points that the array cannot reach");
    sub->add_option("-o,--output", options->output, "Image; - is standard output")->capture_default_str();
    sub->add_option("--manifest", options->manifest, "Manifest (default: the image's name with .json)");
    sub->add_option("--readmemh", options->readmemh,
                    "Also write PREFIX.primary.mem and PREFIX.sequence.mem for $readmemh");
    sub->add_flag("--json", options->json, "Report as JSON");
    sub->callback([options, &action] { action = [options] { return compile(*options); }; });
}

}  // namespace haptogram::cli
