// SPDX-License-Identifier: Apache-2.0
#include "study.hpp"

#include <fmt/format.h>

#include <csignal>
#include <cstdlib>

#include "haptogram/base/error.hpp"
#include "haptogram/base/process.hpp"

namespace haptogram::studio {
namespace {

using nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

constexpr std::size_t longest_line = 1'000'000;  ///< bytes; a protocol's texts are shorter

/// `python3 -m haptogram.study` with these arguments.
Child::Command runner(std::vector<std::string> arguments, const std::filesystem::path& folder) {
    // -P: a folder of protocols is none of programs; a file json.py in it would be taken for Python's own.
    Child::Command command{{python_program(), "-P", "-m", "haptogram.study"}, folder, {"PYTHONDONTWRITEBYTECODE=1"}};
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

Study::Study(Child::Command command, Settings settings)
    : settings_(std::move(settings)), thread_([this, command = std::move(command)] { run(command); }) {}

Study::~Study() {
    end();
    thread_.join();
}

void Study::answer(std::uint32_t number, const std::string& text) {
    say({{"do", "answer"}, {"number", number}, {"text", text}});
}

void Study::leave() { say({{"do", "stop"}}); }

void Study::end() {
    const std::lock_guard lock(mutex_);
    if (ending_) return;
    ending_ = Clock::now();
    if (child_ != nullptr) child_->signal(SIGTERM);
}

void Study::say(const ordered_json& line) {
    const std::lock_guard lock(mutex_);
    if (child_ != nullptr) (void)child_->say(line.dump() + "\n");  // one that takes nothing has ended, and will say so
}

void Study::show(std::string_view line) const {
    ordered_json shown = ordered_json::parse(line, nullptr, false);
    if (shown.is_object() && shown.contains("show")) return settings_.shown(std::move(shown));
    // What the runner says on standard error, as in a terminal.
    if (constexpr std::string_view prefix = "haptogram-study: "; line.starts_with(prefix))
        line.remove_prefix(prefix.size());
    settings_.shown({{"show", "note"}, {"text", line}});
}

bool Study::hear(Child& child, std::string& text) {
    const Child::Heard heard = child.hear(text, std::chrono::milliseconds(100));
    for (std::size_t end; (end = text.find('\n')) != std::string::npos; text.erase(0, end + 1))
        show(std::string_view(text).substr(0, end));
    const std::lock_guard lock(mutex_);
    if (text.size() > longest_line || (ending_ && Clock::now() - *ending_ > most_ending)) child.signal(SIGKILL);
    return heard != Child::Heard::end;
}

void Study::run(const Child::Command& command) {
    std::optional<int> code;
    try {
        Child child("study", command);
        {
            const std::lock_guard lock(mutex_);
            child_ = &child;
            if (ending_) child.signal(SIGTERM);
        }
        std::string text;
        while (hear(child, text)) {
        }
        if (!text.empty()) show(text);
        {
            const std::lock_guard lock(mutex_);
            child_ = nullptr;
        }
        code = child.wait(most_ending);
    } catch (const std::exception& error) {
        settings_.shown({{"show", "note"}, {"text", error.what()}});
    }
    settings_.ended(code);
}

}  // namespace haptogram::studio
