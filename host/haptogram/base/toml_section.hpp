// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"

/// What the readers of array and transducer files share.
namespace haptogram::section {

inline std::string place(const std::string& file, const toml::node& node) {
    return fmt::format("{}:{}", file, node.source().begin.line);
}

/// The value as the file has it.
inline std::string found(const toml::node& node) {
    std::ostringstream text;
    node.visit([&text](const auto& value) { text << value; });
    return text.str();
}

/// @throws Error{bad_input} naming the line
inline toml::table parse(const std::filesystem::path& path) {
    const std::string text = read_file(path);
    try {
        return toml::parse(text);
    } catch (const toml::parse_error& error) {
        throw bad_input(fmt::format("{}:{}", path.string(), error.source().begin.line),
                        fmt::format("not valid TOML: {}", error.description()));
    }
}

/// One table of the file: typed, range-checked, and it knows which keys nobody asked for.
class Section {
public:
    /// A table named `name`, which may be missing.
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

    [[nodiscard]] const toml::node* find(std::string_view key) const {
        return table_ == nullptr ? nullptr : table_->get(key);
    }

    /// The key's line, for messages.
    [[nodiscard]] std::string at(std::string_view key) const {
        const toml::node* node = find(key);
        return node == nullptr ? file_ : place(file_, *node);
    }

    [[nodiscard]] std::optional<double> number(std::string_view key, double low, double high) const {
        const toml::node* node = find(key);
        if (node == nullptr) return {};
        const std::optional<double> value = node->value<double>();
        if (!value || !std::isfinite(*value) || *value < low || *value > high)
            throw bad_input(place(file_, *node), fmt::format("{}{} must be a number from {} to {}, found {}", prefix_,
                                                             key, low, high, found(*node)));
        return value;
    }

    [[nodiscard]] std::optional<std::uint32_t> whole(std::string_view key, std::uint32_t low,
                                                     std::uint32_t high) const {
        const toml::node* node = find(key);
        if (node == nullptr) return {};
        const auto value = node->as_integer() == nullptr ? std::optional<std::int64_t>{} : node->value<std::int64_t>();
        if (!value || *value < low || *value > high)
            throw bad_input(place(file_, *node), fmt::format("{}{} must be a whole number from {} to {}, found {}",
                                                             prefix_, key, low, high, found(*node)));
        return static_cast<std::uint32_t>(*value);
    }

    [[nodiscard]] std::optional<std::string> text(std::string_view key) const {
        const toml::node* node = find(key);
        if (node == nullptr) return {};
        auto value = node->value<std::string>();
        if (!value)
            throw bad_input(place(file_, *node),
                            fmt::format("{}{} must be a text in quotes, found {}", prefix_, key, found(*node)));
        return value;
    }

    void only(std::initializer_list<std::string_view> keys) const {
        if (table_ == nullptr) return;
        for (const auto& [key, node] : *table_)
            if (std::find(keys.begin(), keys.end(), key.str()) == keys.end())
                throw bad_input(place(file_, node), fmt::format("unknown key {}{}; known are {}", prefix_, key.str(),
                                                                fmt::join(keys, ", ")));
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
