// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/report_page.hpp"

#include <fmt/format.h>

#include <memory>
#include <string_view>

#include "command.hpp"
#include "extras.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "progress_line.hpp"
#include "source_options.hpp"

namespace haptogram::cli {
namespace {

struct ReportOptions {
    SourceOptions what;
    std::string output;
    bool methods = false, no_picture = false;
};

int make_report(const ReportOptions& options) {
    for (const std::string_view ending : {".pdf", ".svg", ".png"})
        if (options.output.ends_with(ending))
            throw bad_argument("output", fmt::format("'{}': the page is HTML; name it .html, and print it as {} from a "
                                                     "browser",
                                                     options.output, ending.substr(1)));
    const Source source = source_of(options.what, "report");
    if (!options.methods) require_distinct(files_of(source), {{"--output", options.output}});
    const Timeline timeline = open_timeline(source);
    const std::string methods = methods_text(timeline);  // which refuses what has no image, before all that takes long
    if (options.methods) {
        fmt::print("{}\n", methods);
        return 0;
    }
    std::string page;
    {
        ProgressLine progress("report");
        const Progress all = progress.callback();
        const ImageAnalysis analysis = analyze(timeline, least_felt_n, all.in_stage("analyze").between(0.0, 0.5));
        const std::string picture =
            options.no_picture ? "" : report_picture(timeline, 0, all.in_stage("field").between(0.5, 1.0));
        std::vector<std::string> findings = analysis.warnings;
        for (const Finding& finding : findings_of(analysis.loudness)) findings.push_back(finding.message);
        page = report_page(timeline, analysis, findings, picture,
                           extras().verdict ? extras().verdict(timeline, false) : "");
    }
    write_file(options.output, page);
    return 0;
}

}  // namespace

void add_report(CLI::App& app, Action& action) {
    auto options = std::make_shared<ReportOptions>();
    CLI::App* sub =
        app.add_subcommand("report", "Write a page about an input, or the paragraph for a paper's methods section");
    add_source(*sub, options->what);
    auto* output = sub->add_option("-o,--output", options->output, "The page, one HTML file; - is standard output")
                       ->default_val("report.html");
    auto* methods = sub->add_flag("--methods", options->methods, "Print only the paragraph")->excludes(output);
    sub->add_flag("--no-picture", options->no_picture,
                  "Leave out the picture of the field, which needs python3 with matplotlib")
        ->excludes(methods);
    sub->callback([options, &action] { action = [options] { return make_report(*options); }; });
}

}  // namespace haptogram::cli
