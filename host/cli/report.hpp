// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

namespace haptogram::cli {

/// Prints values: as JSON, or as a sentence, or without one as a line "name  value" for each of them.
void tell(const nlohmann::ordered_json& report, bool as_json, const std::string& sentence = {});

/// What a command with more to say tells at its end, written once: as lines for a person, or as one JSON object.
class Report {
public:
    Report() = default;
    /// Begins with numbers that a library gathered; their lines follow by tell().
    explicit Report(nlohmann::ordered_json numbers) : json_(std::move(numbers)) {}

    /// @param line  for a person, without its newline; empty for what only programs want
    Report& add(const std::string& key, nlohmann::ordered_json value, std::string line = {}) {
        json_[key] = std::move(value);
        return tell(std::move(line));
    }
    /// A line that programs need not see, as its numbers have keys of their own.
    Report& tell(std::string line) {
        if (!line.empty()) lines_.push_back(std::move(line));
        return *this;
    }

    /// On standard output.
    void print(bool as_json) const;
    [[nodiscard]] const nlohmann::ordered_json& json() const { return json_; }

private:
    nlohmann::ordered_json json_ = nlohmann::ordered_json::object();
    std::vector<std::string> lines_;
};

}  // namespace haptogram::cli
