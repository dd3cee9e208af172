// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/hand_source.hpp"

#include <algorithm>
#include <array>

namespace haptogram {
namespace {

constexpr std::array<std::string_view, 6> kinds{"cube", "sphere", "cone", "pyramid", "cylinder", "half-space"};

}  // namespace

std::span<const std::string_view> object_kinds() { return kinds; }

bool has_height(std::string_view kind) { return kind == "cone" || kind == "pyramid" || kind == "cylinder"; }

bool is_built_in(const ObjectSource& source) { return std::ranges::find(kinds, source.name) != kinds.end(); }

bool names_mesh(const ObjectSource& source) { return source.name.find('.') != std::string::npos; }

std::pair<std::string, std::string> without_mounting(const std::string& name) {
    const std::size_t at = name.rfind('@');
    if (at == std::string::npos || !name.ends_with(".toml")) return {name, ""};
    return {name.substr(0, at), name.substr(at + 1)};
}

std::filesystem::path bones_file(const std::filesystem::path& file, const std::filesystem::path& model) {
    return model.empty() ? file.parent_path() / "model_hand.json" : model;
}

std::vector<std::string> files_of(const HandSource& hand) {
    std::vector<std::string> files;
    const auto [recording, mounting] = without_mounting(hand.recording);
    if (!recording.starts_with(synthetic_prefix)) files.push_back(recording);
    if (!mounting.empty()) files.push_back(mounting);
    if (recording.ends_with(".pose")) files.push_back(bones_file(recording, hand.model).string());
    if (names_mesh(hand.object)) files.push_back(hand.object.name);
    return files;
}

}  // namespace haptogram
