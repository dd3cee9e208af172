// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "haptogram/base/depth.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"

/// For the writers of TOML files. Not installed: no public header includes it.
namespace haptogram::section {

/// The shortest digits that read back as the same number, with a decimal point so that TOML takes it for a
/// floating-point number: as a whole number, -0 would lose its sign.
inline std::string number_text(double value) {
    std::string text = fmt::format("{}", value);
    if (text.find_first_of(".en") == std::string::npos) text += ".0";
    return text;
}

/// A text between quotation marks, on one line, that reads back as the same text. toml++'s own writer is not used:
/// it writes a text with line breaks on several lines, and leaves backslashes and tabs there as they are.
/// @throws Error{bad_input} for a text that is not UTF-8, which no TOML file can hold
inline std::string quoted_text(const std::string& text) {
    std::string quoted;
    try {
        quoted = nlohmann::json(text).dump();
    } catch (const nlohmann::json::type_error&) {
        const std::string shown = nlohmann::json(text).dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
        throw bad_input(shown, "it is not UTF-8, which a TOML file has to be; give the file another name");
    }
    // All that JSON may hold as it is, TOML may, too, except for DEL.
    for (std::size_t at = 0; (at = quoted.find('\x7f', at)) != std::string::npos;) quoted.replace(at, 1, "\\u007F");
    return quoted;
}

}  // namespace haptogram::section

/// What the readers of TOML files share. Not installed: no public header includes it.
namespace haptogram::section {

inline std::string place(const std::string& file, const toml::node& node) {
    return fmt::format("{}:{}", file, node.source().begin.line);
}

/// The value as the file has it. Of a table or a list, which could fill a page, only that it is one.
inline std::string found(const toml::node& node) {
    if (node.is_table()) return "a table";
    if (const toml::array* list = node.as_array(); list != nullptr) return fmt::format("a list of {}", list->size());
    std::ostringstream text;
    node.visit([&text](const auto& value) { text << value; });
    return text.str();
}

/// @param file  names the text in messages
/// @throws Error{bad_input} naming the line
inline toml::table parse_text(std::string_view text, const std::string& file) {
    require_shallow(text, file);
    try {
        return toml::parse(text);
    } catch (const toml::parse_error& error) {
        throw bad_input(fmt::format("{}:{}", file, error.source().begin.line),
                        fmt::format("not valid TOML: {}", error.description()));
    }
}

inline toml::table parse(const std::filesystem::path& path) { return parse_text(read_file(path), path.string()); }

/// One table of a file. Its functions check types and ranges, and only() refuses unknown keys. A value may be missing;
/// required() is for those that must be there.
class Section {
public:
    /// The table named `name`, which may be missing.
    Section(std::string file, const toml::table& root, const std::string& name)
        : file_(std::move(file)), prefix_(name + ".") {
        const toml::node* node = root.get(name);
        if (node == nullptr) return;
        table_ = node->as_table();
        if (table_ == nullptr)
            throw bad_input(place(file_, *node), fmt::format("'{}' must be a table, [{}]", name, name));
    }

    /// The file's own keys.
    Section(std::string file, const toml::table& root) : file_(std::move(file)), table_(&root) {}

    [[nodiscard]] const std::string& file() const { return file_; }
    [[nodiscard]] bool exists() const { return table_ != nullptr; }
    [[nodiscard]] std::string full(std::string_view key) const { return prefix_ + std::string(key); }

    [[nodiscard]] const toml::node* find(std::string_view key) const {
        return table_ == nullptr ? nullptr : table_->get(key);
    }

    /// The key's line, for messages; the section's when the key is missing.
    [[nodiscard]] std::string at(std::string_view key) const {
        const toml::node* node = find(key);
        if (node == nullptr) node = prefix_.empty() ? nullptr : table_;
        return node == nullptr ? file_ : place(file_, *node);
    }

    [[nodiscard]] Error missing(std::string_view key, std::string_view expected) const {
        return bad_input(at(key), fmt::format("{} is missing; it must be {}", full(key), expected));
    }

    [[nodiscard]] Error wrong(const toml::node& node, std::string_view key, std::string_view expected) const {
        return bad_input(place(file_, node), fmt::format("{} must be {}, found {}", full(key), expected, found(node)));
    }

    [[nodiscard]] std::optional<double> number(std::string_view key, double low, double high) const {
        const toml::node* node = find(key);
        if (node == nullptr) return {};
        const std::optional<double> value = node->value<double>();
        if (!value || !std::isfinite(*value) || *value < low || *value > high)
            throw wrong(*node, key, fmt::format("a number from {} to {}", low, high));
        return value;
    }

    [[nodiscard]] std::optional<std::uint64_t> whole64(std::string_view key, std::uint64_t low,
                                                       std::uint64_t high) const {
        const toml::node* node = find(key);
        if (node == nullptr) return {};
        const auto value = node->as_integer() == nullptr ? std::optional<std::int64_t>{} : node->value<std::int64_t>();
        if (!value || *value < 0 || static_cast<std::uint64_t>(*value) < low ||
            static_cast<std::uint64_t>(*value) > high)
            throw wrong(*node, key, fmt::format("a whole number from {} to {}", low, high));
        return static_cast<std::uint64_t>(*value);
    }

    [[nodiscard]] std::optional<std::uint32_t> whole(std::string_view key, std::uint32_t low,
                                                     std::uint32_t high) const {
        const auto value = whole64(key, low, high);
        return value ? std::optional(static_cast<std::uint32_t>(*value)) : std::nullopt;
    }

    [[nodiscard]] std::optional<bool> flag(std::string_view key) const {
        const toml::node* node = find(key);
        if (node == nullptr) return {};
        if (!node->is_boolean()) throw wrong(*node, key, "true or false");
        return node->value<bool>();
    }

    /// @param fits  tells whether a text is acceptable; `expected` says the same in words
    [[nodiscard]] std::optional<std::string> text(std::string_view key, std::string_view expected = "a text in quotes",
                                                  bool (*fits)(const std::string&) = nullptr) const {
        const toml::node* node = find(key);
        if (node == nullptr) return {};
        auto value = node->value<std::string>();
        if (!node->is_string() || !value || (fits != nullptr && !fits(*value))) throw wrong(*node, key, expected);
        return value;
    }

    [[nodiscard]] std::optional<std::vector<std::string>> texts(std::string_view key,
                                                                bool (*fits)(const std::string&) = nullptr) const {
        constexpr std::string_view expected = "a list of texts in quotes";
        const toml::node* node = find(key);
        if (node == nullptr) return {};
        if (!node->is_array()) throw wrong(*node, key, expected);
        std::vector<std::string> result;
        for (const toml::node& entry : *node->as_array()) {
            auto value = entry.value<std::string>();
            if (!entry.is_string() || !value || (fits != nullptr && !fits(*value))) throw wrong(entry, key, expected);
            result.push_back(*std::move(value));
        }
        return result;
    }

    /// A list of exactly `count` finite numbers.
    [[nodiscard]] std::optional<std::vector<double>> numbers(std::string_view key, std::size_t count) const {
        const std::string expected = fmt::format("a list of {} numbers", count);
        const toml::node* node = find(key);
        if (node == nullptr) return {};
        const toml::array* list = node->as_array();
        if (list == nullptr || list->size() != count) throw wrong(*node, key, expected);
        std::vector<double> result;
        for (const toml::node& entry : *list) {
            const auto value = entry.value<double>();
            if (!value || !std::isfinite(*value)) throw wrong(*node, key, expected);
            result.push_back(*value);
        }
        return result;
    }

    /// The value, or an error that says what must be there.
    template <class T>
    [[nodiscard]] T required(std::optional<T> value, std::string_view key, std::string_view expected) const {
        if (!value) throw missing(key, expected);
        return *std::move(value);
    }

    template <class Keys = std::initializer_list<std::string_view>>
    void only(const Keys& keys) const {
        if (table_ == nullptr) return;
        for (const auto& [key, node] : *table_)
            if (std::find(std::begin(keys), std::end(keys), key.str()) == std::end(keys))
                throw bad_input(place(file_, node),
                                fmt::format("unknown key {}; known are {}", full(key.str()), fmt::join(keys, ", ")));
    }

private:
    std::string file_;
    std::string prefix_;  ///< of the keys in messages, with its dot
    const toml::table* table_ = nullptr;
};

template <class T, class U>
void assign(T& target, const std::optional<U>& value, double factor = 1.0) {
    if (!value) return;
    if constexpr (std::is_same_v<T, double>)
        target = *value * factor;
    else
        target = *value;
}

}  // namespace haptogram::section
