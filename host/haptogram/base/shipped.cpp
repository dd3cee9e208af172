// SPDX-License-Identifier: Apache-2.0
#include "haptogram/base/shipped.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "haptogram/base/error.hpp"

namespace haptogram {

std::optional<std::string_view> shipped_file(std::string_view name) {
    if (!name.starts_with(shipped_prefix)) return {};
    name.remove_prefix(shipped_prefix.size());
    for (const ShippedFile& file : shipped_table())
        if (file.name == name) return file.content;
    return {};
}

std::vector<std::string> shipped_names(std::string_view folder, std::string_view ending) {
    std::vector<std::string> names;
    for (const ShippedFile& file : shipped_table()) {
        const std::size_t slash = file.name.rfind('/');
        if (file.name.substr(0, slash) != folder || !file.name.ends_with(ending)) continue;
        const std::string_view name = file.name.substr(slash + 1);
        names.emplace_back(name.substr(0, name.size() - ending.size()));
    }
    std::sort(names.begin(), names.end());
    return names;
}

void require_no_part(const std::string& name, std::string_view folder, std::string_view ending, std::string_view kind) {
    std::vector<std::string> names = shipped_names(folder, ending);
    std::erase_if(names, [&](const std::string& each) { return each.find(name) == std::string::npos; });
    if (!name.empty() && !names.empty())
        throw bad_input(name,
                        fmt::format("no shipped {} has this name; did you mean {}?", kind, fmt::join(names, ", ")));
}

std::string path_or_shipped(const std::string& name, std::string_view folder, std::string_view ending,
                            std::string_view kind) {
    if (name.find('/') != std::string::npos || name.ends_with(ending)) return name;
    const std::string shipped = fmt::format("{}{}/{}{}", shipped_prefix, folder, name, ending);
    if (shipped_file(shipped)) return shipped;
    require_no_part(name, folder, ending, kind);
    throw bad_input(name, fmt::format("no shipped {} has this name (shipped are {}); give the path of a {} file", kind,
                                      fmt::join(shipped_names(folder, ending), ", "), ending));
}

}  // namespace haptogram
