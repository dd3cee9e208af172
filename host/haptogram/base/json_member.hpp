// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <fmt/format.h>

#include <algorithm>
#include <initializer_list>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "haptogram/base/depth.hpp"
#include "haptogram/base/error.hpp"

/// What the readers of JSON files share. Not installed: no public header includes it.
namespace haptogram {

/// @throws Error{bad_input} naming the byte at which the text stops being JSON, or a number that no double can hold
[[nodiscard]] inline nlohmann::ordered_json parse_json(std::string_view text, const std::string& file) {
    require_shallow(text, file);
    try {
        return nlohmann::ordered_json::parse(text);
    } catch (const nlohmann::json::parse_error& error) {
        throw bad_input(file, fmt::format("not valid JSON at byte {}; write the file again", error.byte));
    } catch (const nlohmann::json::out_of_range& error) {
        const std::string_view said = error.what();  // ends with the number between quotation marks
        const std::size_t quote = std::min(said.find('\''), said.size());
        throw bad_input(file, fmt::format("a number is too large: {}; the largest that can be held is {:.2g}",
                                          said.substr(quote, 60), std::numeric_limits<double>::max()));
    }
}

/// A value of a JSON document and its place, such as "steps[3].foci". Its functions check types and ranges; every
/// error names the file and the place.
class JsonMember {
public:
    using Json = nlohmann::ordered_json;

    JsonMember(const Json& value, std::string file, std::string place = {})
        : value_(&value), file_(std::move(file)), place_(std::move(place)) {}

    [[nodiscard]] Error wrong(std::string_view expected) const {
        std::string found =
            value_->is_structured() ? value_->type_name() : value_->dump(-1, ' ', true, Json::error_handler_t::replace);
        if (found.size() > 40) found = found.substr(0, 40) + "…";
        return bad_input(file_,
                         fmt::format("{} must be {}, found {}", place_.empty() ? "it" : place_, expected, found));
    }

    [[nodiscard]] std::optional<JsonMember> find(const std::string& key) const {
        const auto found = object().find(key);
        if (found == value_->end()) return {};
        return JsonMember(*found, file_, place_.empty() ? key : place_ + "." + key);
    }

    [[nodiscard]] JsonMember at(const std::string& key) const {
        if (auto found = find(key)) return *std::move(found);
        throw bad_input(file_, fmt::format("{} has no {}", place_.empty() ? "it" : place_, key));
    }

    [[nodiscard]] std::vector<JsonMember> list() const {
        if (!value_->is_array()) throw wrong("a list");
        std::vector<JsonMember> members;
        for (std::size_t i = 0; i < value_->size(); ++i)
            members.emplace_back((*value_)[i], file_, fmt::format("{}[{}]", place_, i));
        return members;
    }

    [[nodiscard]] double number(double low, double high) const {
        const double value = value_->is_number() ? value_->get<double>() : std::nan("");
        if (!(value >= low && value <= high)) throw wrong(fmt::format("a number from {} to {}", low, high));
        return value;
    }

    [[nodiscard]] std::string text() const {
        if (!value_->is_string()) throw wrong("a text");
        return value_->get<std::string>();
    }

    [[nodiscard]] const Json& object() const {
        if (!value_->is_object()) throw wrong("an object");
        return *value_;
    }

    /// Refuses unknown members.
    void only(std::initializer_list<std::string_view> keys) const {
        for (const auto& [key, member] : object().items()) {
            if (std::find(keys.begin(), keys.end(), key) != keys.end()) continue;
            const std::string shown = Json(key.substr(0, 40)).dump(-1, ' ', true, Json::error_handler_t::replace);
            throw bad_input(file_, fmt::format("{}unknown member {}; known are {}", place_.empty() ? "" : place_ + ": ",
                                               shown, fmt::join(keys, ", ")));
        }
    }

    [[nodiscard]] const Json& value() const { return *value_; }

private:
    const Json* value_;
    std::string file_, place_;
};

}  // namespace haptogram
