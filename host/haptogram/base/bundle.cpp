// SPDX-License-Identifier: Apache-2.0
#include "haptogram/base/bundle.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "haptogram/base/error.hpp"

namespace haptogram {

bool is_bundle(const std::filesystem::path& path) { return path.extension() == ".haptogram"; }

std::filesystem::path named_in(const std::filesystem::path& folder, const std::filesystem::path& name) {
    const bool outside = name.is_absolute() || std::ranges::find(name, "..") != name.end();
    if (outside && std::ranges::any_of(folder, is_bundle))
        throw bad_input(folder.string(), fmt::format("a bundle names its own files alone, and this one names '{}'; put "
                                                     "that file into it",
                                                     name.string()));
    return folder / name;
}

}  // namespace haptogram
