// SPDX-License-Identifier: Apache-2.0
#include "refusal.hpp"

#define CATCH_CONFIG_EXTERNAL_INTERFACES  // for a listener
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <regex>
#include <sstream>
#include <utility>
#include <vector>

namespace fs = std::filesystem;

namespace {

/// What was said under one identity, one after the other.
struct Entry {
    std::string identity;
    std::vector<std::string> texts;
};
using Entries = std::vector<Entry>;

/// The identities of tests/messages.txt by case; tests/messages.py says how that is written.
const std::map<std::string, std::vector<std::string>>& recorded() {
    static const auto all = [] {
        std::map<std::string, std::vector<std::string>> read;
        std::ifstream file(HAPTOGRAM_TEST_FOLDER "/messages.txt");
        std::vector<std::string>* list = nullptr;
        for (std::string line; std::getline(file, line);) {
            if (line.starts_with("    ") || line.starts_with('#') || line.empty()) continue;
            if (line.starts_with("  ")) {
                if (list != nullptr) list->push_back(line.substr(2));
            } else {
                list = &read[line];
            }
        }
        return read;
    }();
    return all;
}

std::string environment(const char* name, const char* otherwise) {
    const char* value = std::getenv(name);
    return value == nullptr ? otherwise : value;
}

bool recording() { return !environment("HAPTOGRAM_RECORD_MESSAGES", "").empty(); }

/// The case that runs; only one thread of a test asserts.
struct Running {
    std::string name;                     ///< FILE: CASE
    std::vector<std::string> sections;    ///< those that are entered, without the case itself
    std::map<std::string, Entries> said;  ///< by the name of case and sections
    bool loose = false;

    std::string where() const {
        std::string all = name;
        for (const std::string& section : sections) all += " / " + section;
        return all;
    }
} running;

void replace(std::string& text, const std::string& from, const std::string& to) {
    for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
        text.replace(at, from.size(), to);
}

/// Without what is different in another checkout, another folder, another process.
std::string without_chance(std::string text) {
    static const std::string root = fs::path(HAPTOGRAM_TEST_FOLDER).parent_path().string();
    static const std::string temporary = fs::temp_directory_path().lexically_normal().string();
    static const std::regex folder("TMP/[^/:;,'\"\\s)]+"), number("(/dev/pts/|127\\.0\\.0\\.1:)[0-9]+");
    static const std::regex digits("[0-9]+(\\.[0-9]+)?(e[-+]?[0-9]+)?");
    replace(text, root, "ROOT");
    replace(text, temporary, "TMP");
    text = std::regex_replace(text, folder, "TMP/#");
    text = std::regex_replace(text, number, "$1#");
    return running.loose ? std::regex_replace(text, digits, "#") : text;
}

void write_file(const fs::path& folder) {
    std::ostringstream text;
    text << "# " << running.name << '\n';
    for (const auto& [name, entries] : running.said) {
        text << name << '\n';
        for (const Entry& entry : entries) {
            text << "  " << entry.identity << '\n';
            for (std::string words : entry.texts) {
                replace(words, "\n", "\n    | ");
                text << "    " << words << '\n';
            }
        }
    }
    fs::create_directories(folder);
    std::ostringstream name;
    name << std::hex << std::hash<std::string>()(running.name) << ".txt";
    std::ofstream(folder / name.str()) << text.str();
}

struct Listener : Catch::TestEventListenerBase {
    using TestEventListenerBase::TestEventListenerBase;
    void testCaseStarting(const Catch::TestCaseInfo& info) override {
        running = {fs::path(info.lineInfo.file).filename().string() + ": " + info.name, {}, {}, false};
        depth = 0;
    }
    void sectionStarting(const Catch::SectionInfo& info) override {
        if (depth++ > 0) running.sections.push_back(info.name);  // the first is the case itself
    }
    void sectionEnded(const Catch::SectionStats&) override {
        if (--depth > 0) running.sections.pop_back();
    }
    void testCaseEnded(const Catch::TestCaseStats& stats) override {
        const std::string folder = environment("HAPTOGRAM_MESSAGES", HAPTOGRAM_TEST_MESSAGES);
        if (stats.totals.assertions.failed == 0 && !folder.empty()) write_file(folder);
        running = {};
    }
    int depth = 0;
};
CATCH_REGISTER_LISTENER(Listener)

std::string name_of(haptogram::ErrorCode code) {
    switch (code) {
        case haptogram::ErrorCode::failed: return "failed";
        case haptogram::ErrorCode::bad_argument: return "bad_argument";
        case haptogram::ErrorCode::bad_input: return "bad_input";
        case haptogram::ErrorCode::device: return "device";
        case haptogram::ErrorCode::cancelled: return "cancelled";
    }
    return "a code without a name";
}

}  // namespace

namespace heard {

Refusal::Refusal(const haptogram::Error& error) : identity(name_of(error.code())), words(error.message()) {
    if (!error.where().empty()) identity += " at " + error.where();
    for (std::size_t i = 0; i < error.remedies().size(); ++i)
        identity += (i == 0 ? "; mend " : ", ") + error.remedies()[i];
}

Refusal Refusal::notice(const std::string& words) {
    Refusal notice;
    notice.identity = words.empty() ? "nothing" : "notice";
    notice.words = words;
    return notice;
}

Refusal Refusal::caught() {
    try {
        throw;
    } catch (const haptogram::Error& error) {
        return Refusal(error);
    } catch (const std::exception& error) {
        Refusal other;
        other.identity = "another exception";
        other.words = error.what();
        return other;
    }  // all else is Catch's own
}

std::string wrong_with(const Refusal& refusal) {
    std::string identity = without_chance(refusal.identity), words = without_chance(refusal.words);
    replace(identity, "\n", " ");
    if (refusal.identity == "no error") return "no error was thrown";
    if (refusal.identity == "nothing") return "nothing was said";
    const std::string where = running.where();
    Entries& said = running.said[where];
    if (said.empty() || said.back().identity != identity) {
        said.push_back({identity, {words}});
    } else {
        auto& texts = said.back().texts;
        if (std::find(texts.begin(), texts.end(), words) == texts.end()) texts.push_back(words);
        return "";
    }
    const auto found = recorded().find(where);
    if (recording() || found == recorded().end() || found->second.size() < said.size()) return "";
    const std::string& expected = found->second[said.size() - 1];
    return expected == identity ? ""
                                : "found '" + identity + "', tests/messages.txt has '" + expected +
                                      "' for this message. If that was meant, run make messages. The text: " + words;
}

void loose_numbers() { running.loose = true; }

}  // namespace heard
