// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/self_test.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/link/device.hpp"
#include "interrupt.hpp"
#include "port.hpp"
#include "progress_line.hpp"
#include "report.hpp"

namespace haptogram::cli {
namespace {

struct SelfTestOptions {
    link::PortSettings port;
    std::string array = "tile-10x10";
    std::vector<std::string> checks;
    std::vector<std::uint32_t> channels;
    double channel_s = 0.3, height_mm = 150.0, point_s = 5.0;
    bool no_questions = false, json = false;
};

std::vector<std::string> names() {
    std::vector<std::string> found;
    for (const link::Check check : link::all_checks) found.emplace_back(to_string(check));
    return found;
}

/// Questions go to standard error, where progress is, because the report may go to a file.
std::string ask(const std::string& question) {
    fmt::print(stderr, "{}", question);
    std::string answer;
    if (!std::getline(std::cin, answer)) throw Error(ErrorCode::cancelled, "self-test", "there was no answer");
    return answer;
}

int self_test(const SelfTestOptions& options) {
    catch_interrupts();
    link::SelfTestSettings settings;
    settings.array = find_array(options.array);
    if (!options.checks.empty()) {
        settings.checks.clear();
        for (const std::string& name : options.checks) settings.checks.push_back(*link::check_named(name));
    }
    if (!options.channels.empty()) {
        settings.first_channel = options.channels.front();
        settings.last_channel = options.channels.back();
    }
    settings.channel_s = options.channel_s;
    settings.point.z = 1e-3 * options.height_mm;
    settings.point_s = options.point_s;
    settings.warn = complain;
    if (!options.no_questions && ::isatty(STDIN_FILENO) != 0) settings.ask = ask;
    link::PortSettings port = options.port;
    port.interrupt = interrupts;
    link::Device device(port);
    auto progress = std::make_unique<ProgressLine>("self-test");
    settings.progress = [&](double fraction, std::string_view stage) {
        progress->update(fraction, std::string(stage));
        return !interrupted();
    };
    settings.tell = [&](const link::Finding& finding) {
        progress = std::make_unique<ProgressLine>("self-test");  // ends the line of the one before
        if (options.json) return;
        fmt::print("{:<12} {:<9} {}\n", to_string(finding.check), to_string(finding.outcome), finding.found);
        if (!finding.advice.empty()) fmt::print("{:<22} {}\n", "", finding.advice);
        std::fflush(stdout);
    };
    const std::vector<link::Finding> findings = link::self_test(device, settings);
    if (options.json) tell(link::to_json(findings), true);
    const auto failed = std::ranges::count(findings, link::Outcome::failed, &link::Finding::outcome);
    if (failed != 0)
        throw Error(ErrorCode::failed, "self-test", fmt::format("{} of {} checks failed", failed, findings.size()));
    return 0;
}

}  // namespace

void add_self_test(CLI::App& device, Action& action) {
    auto options = std::make_shared<SelfTestOptions>();
    CLI::App* sub = device.add_subcommand(
        "self-test",
        "Test everything from this host to the hand: link, memories, clock, outputs, watchdog, stop switch, each "
        "channel, and a point that should be felt. Ends what plays; restores the memories");
    add_port_options(*sub, options->port);
    sub->add_option("--array", options->array, "The array that the board drives: a file, or the name of a shipped one")
        ->capture_default_str();
    sub->add_option("--check", options->checks, "Only these checks")->check(CLI::IsMember(names()))->delimiter(',');
    sub->add_option("--channels", options->channels, "The first and the last channel that play (default: all)")
        ->expected(2);
    sub->add_option("--channel-seconds", options->channel_s, "For how long each channel plays")
        ->check(positive())
        ->capture_default_str();
    sub->add_option("--height", options->height_mm, "Height of the point above the array's centre, mm")
        ->check(positive())
        ->capture_default_str();
    sub->add_option("--point-seconds", options->point_s, "For how long the point plays")
        ->check(positive())
        ->capture_default_str();
    sub->add_flag("--no-questions", options->no_questions,
                  "Ask no questions; what only a person can judge is left open");
    sub->add_flag("--json", options->json, "The findings as JSON");
    sub->callback([options, &action] { action = [options] { return self_test(*options); }; });
}

}  // namespace haptogram::cli
