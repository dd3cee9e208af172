// SPDX-License-Identifier: Apache-2.0
#include "study.hpp"

#include <fmt/format.h>

#include "haptogram/base/error.hpp"
#include "haptogram/base/process.hpp"

namespace haptogram::studio {
namespace {

using nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

/// `python3 -m haptogram_study` with these arguments.
Child::Command runner(std::vector<std::string> arguments, const std::filesystem::path& folder) {
    // -P: a folder of protocols is none of programs; a file json.py in it would be taken for Python's own.
    Child::Command command{{python_program(), "-P", "-m", "haptogram_study"}, folder, {"PYTHONDONTWRITEBYTECODE=1"}};
    command.words.insert(command.words.end(), arguments.begin(), arguments.end());
    std::error_code ignored;
    if (const std::filesystem::path package = own_data("python"); std::filesystem::exists(package, ignored))
        command.environment.push_back("PYTHONPATH=" + package.string());
    return command;
}

}  // namespace

ordered_json study_protocols(const std::filesystem::path& folder) {
    Child child("study", runner({"list", "--json", "--folder", "."}, folder));
    std::string said;
    const auto until = Clock::now() + std::chrono::seconds(60);
    while (child.hear(said, std::chrono::milliseconds(100)) != Child::Heard::end && Clock::now() < until) {
    }
    const std::optional<int> code = child.wait(std::chrono::seconds(2));
    ordered_json found = ordered_json::parse(said, nullptr, false);
    if (code != 0 || !found.is_object())
        throw Error(ErrorCode::failed, "study",
                    fmt::format("the runner of studies did not start; it needs Python 3.11 or later and what "
                                "'pip install haptogram' brings. Python says: {}",
                                said.empty() ? "nothing" : said));
    return found;
}

Child::Command study_command(const StudyMessage& asked, const std::filesystem::path& folder,
                             const std::optional<BoardPort>& port) {
    std::vector<std::string> arguments = {"run",           asked.protocol,
                                          "--participant", std::to_string(asked.participant),
                                          "--seed",        std::to_string(asked.seed),
                                          "--output",      asked.results,
                                          "--observer",    "page"};
    if (port) arguments.insert(arguments.end(), {"--port=" + port->name, "--program", own_program().string()});
    if (port && port->baud) arguments.insert(arguments.end(), {"--baud", std::to_string(*port->baud)});
    return runner(std::move(arguments), folder);
}

}  // namespace haptogram::studio
