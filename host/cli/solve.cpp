// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/solve.hpp"

#include <fmt/format.h>

#include <memory>

#include "command.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/verbs/compile.hpp"
#include "haptogram/verbs/level.hpp"
#include "haptogram/verbs/rig.hpp"
#include "progress_line.hpp"
#include "source_options.hpp"

namespace haptogram::cli {
namespace {

struct SolveCommand {
    Source source;  ///< or a file of foci
    std::vector<std::string> focus;
    std::optional<std::string> rig, quantise;
    std::string solver = name_of(Method::gauss_newton);
    std::string level = "reachable";
    bool amplitudes = false, follow = false, json = false;
    std::optional<unsigned> rounds;
    std::optional<double> rate_hz;
    std::string output;
};

SolveOptions options_of(const SolveCommand& command) {
    return {method_of(command.solver), command.amplitudes,
            command.level == "pressure" ? Level::pressure : Level::reachable, command.rounds};
}

/// What is to be solved, and for what.
struct Asked {
    std::vector<std::vector<Focus>> sets;
    Array array;
    Core core;
    std::string rig;
};

Asked asked_of(const SolveCommand& command) {
    const std::string& file = command.source.file;
    if (command.focus.empty() == file.empty())
        throw bad_argument("source",
                           "expected a file of foci or of what plays them, or --focus; see haptogram solve "
                           "--help");
    if (!file.empty() && file != "-" && is_source_file(file)) {
        if (command.output.ends_with(".hex") && is_rig_file(file))
            throw bad_argument("output",
                               "images of a rig are made for its boards: give the foci, and the rig with --rig");
        if (command.rig) throw bad_argument("rig", fmt::format("{} has an array of its own", file));
        Source source = command.source;
        source.makers = path_makers();
        Timeline timeline = open_timeline(source);
        Asked asked{{}, std::move(timeline.manifest.array), std::move(timeline.manifest.core), {}};
        for (RecordMeaning& record : timeline.manifest.records) asked.sets.push_back(std::move(record.foci));
        return asked;
    }
    Project project;
    project.array = command.source.array;
    project.board = command.source.board;
    ProjectInstrument instrument = command.rig ? instrument_of_rig(*command.rig) : instrument_of(project);
    Asked asked{{}, std::move(instrument.array), std::move(instrument.core), command.rig.value_or("")};
    if (!file.empty()) {
        asked.sets = foci_from_text(read_file(file), file);
    } else {
        asked.sets.emplace_back();
        for (const std::string& text : command.focus) asked.sets.back().push_back(parse_focus_mm("focus", text));
    }
    return asked;
}

void print(const Solved& solved) {
    for (std::size_t i = 0; i < solved.steps.size(); ++i) {
        const SolvedStep& step = solved.steps[i];
        fmt::print("{}set {}, {} foci by {}\n  focus        x        y        z mm  amplitude  exact Pa  in ticks Pa\n",
                   i == 0 ? "" : "\n", i + 1, step.foci.size(), name_of(solved.options.method));
        for (std::size_t k = 0; k < step.foci.size(); ++k) {
            const auto& [p, amplitude] = step.foci[k];
            fmt::print("  {:5} {:8.2f} {:8.2f} {:8.2f} {:13.3f} {:9.1f} {:12.1f}\n", k + 1, p.x / millimetre,
                       p.y / millimetre, p.z / millimetre, amplitude, step.exact.pressure_pa[k],
                       step.quantised.pressure_pa[k]);
        }
        for (const auto& [name, q] : {std::pair("exact", &step.exact), std::pair("in ticks", &step.quantised)}) {
            fmt::print("  {:9} spread (CV) {:.5f}, least over mean {:.4f}, efficiency {:.4f}\n", name, q->spread,
                       q->least_over_mean, q->efficiency);
            if (q->null_share)
                fmt::print("  {:9} foci of amplitude 0 held down to {:.5f} of what the array can make there\n", "",
                           *q->null_share);
        }
    }
    fmt::print("{}\n", level_text(solved.array.transducer));
}

int solve(const SolveCommand& command) {
    if (!command.output.empty()) check_solved_path(command.output);
    if (command.output == "-" && command.json)
        throw bad_argument("json", "the drives would go to standard output, too; give --output a file");
    std::vector<NamedPath> outputs = {{"--output", command.output}};
    if (command.output.ends_with(".hex"))
        outputs.push_back({"--output", manifest_path(command.output), command.output});
    if (!command.output.empty()) require_distinct(files_of(command.source), outputs);
    if (command.rate_hz && !command.output.ends_with(".hex"))
        throw bad_argument("rate", "is of an image; let --output name one, .hex");
    if (command.rounds && command.solver == "superposition")
        throw bad_argument("rounds", "superposition has none; choose another --solver");
    const Asked asked = asked_of(command);
    ProgressLine progress("solve");
    Solved solved = solve_steps(asked.sets, asked.array, asked.core, options_of(command), command.follow,
                                progress.callback(), command.quantise.value_or(""));
    solved.rig = asked.rig;
    if (!command.output.empty()) write_solved(command.output, solved, command.rate_hz.value_or(10.0));
    if (command.output == "-") return 0;
    if (command.json)
        fmt::print("{}", to_json_text(solved));
    else
        print(solved);
    return 0;
}

}  // namespace

void add_solve(CLI::App& app, Action& action) {
    auto options = std::make_shared<SolveCommand>();
    CLI::App* sub = app.add_subcommand(
        "solve", "Find drives for several foci at the same time, and say how even and strong the foci are");
    auto* foci = sub->add_option(
        "source", options->source.file,
        "File of foci: a line x,y,z or x,y,z,amplitude each (mm, 0 to 1; 0 holds the pressure down there); "
        "an empty line begins the next set. - is standard input. Or the foci of each record of an image, a rig's "
        "manifest, or what is compiled first: a project, a path, a shape");
    sub->add_option("--focus", options->focus, "A focus x,y,z or x,y,z,amplitude instead; again for each")
        ->excludes(foci);
    auto* array = sub->add_option("--array", options->source.array,
                                  "Array file or shipped array; by default the board's, or tile-10x10");
    auto* board = sub->add_option("--board", options->source.board,
                                  "Board file, shipped board or configuration, whose ticks are used");
    sub->add_option("--rig", options->rig,
                    "Rig file or shipped rig instead: several arrays in their places, each with its board's ticks")
        ->excludes(array)
        ->excludes(board);
    std::vector<std::string> names;
    std::string about;
    for (const MethodName& one : method_names) {
        names.emplace_back(one.name);
        about += fmt::format("{}{} ({})", about.empty() ? "" : ", ", one.name, one.about);
    }
    sub->add_option("--solver", options->solver, about)->check(CLI::IsMember(names))->capture_default_str();
    sub->add_flag("--amplitudes", options->amplitudes,
                  "Drives may differ in amplitude; a record keeps only their phases");
    sub->add_option("--level", options->level,
                    "An amplitude of 1 is: reachable, the most that the array can make at that place; or pressure, the "
                    "same pressure at all places")
        ->check(CLI::IsMember({"reachable", "pressure"}))
        ->capture_default_str();
    sub->add_option("--rounds", options->rounds,
                    "Rounds of an iterating solver; by default 10 of gauss-newton, 100 of others")
        ->check(whole(0, 1'000'000));
    sub->add_flag("--follow", options->follow,
                  "Begin each set with the drives of the one before; the first takes the rounds of the default");
    add_quantise(*sub, options->quantise);
    sub->add_flag("--json", options->json, "Everything as JSON on standard output");
    sub->add_option("-o,--output", options->output,
                    "A .csv file of drives, a .json file of everything, a .png picture, or an image (.hex) with its "
                    "manifest, of a rig "
                    "the images of its boards; - is CSV on standard output");
    sub->add_option("--rate", options->rate_hz, "Passes over all sets a second that an image plays, Hz (default: 10)")
        ->check(positive());
    sub->callback([options, &action] { action = [options] { return solve(*options); }; });
}

}  // namespace haptogram::cli
