// SPDX-License-Identifier: Apache-2.0
// What --version says: the release, the commit of the sources, and what this build has.
#include <fmt/format.h>

#include "command.hpp"
#include "commit.hpp"
#include "haptogram/format/bundle.hpp"

namespace haptogram::cli {

std::string about_this_build() {
    return fmt::format("haptogram {}\ncommit: {}\nbuilt with: {}", version(), commit, HAPTOGRAM_BUILT_WITH);
}

}  // namespace haptogram::cli
