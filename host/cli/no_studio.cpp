// SPDX-License-Identifier: Apache-2.0
// In place of studio.cpp in a build without the studio (HAPTOGRAM_STUDIO=OFF).
#include "command.hpp"
#include "haptogram/base/error.hpp"

namespace haptogram::cli {

void add_studio(CLI::App& app, Action& action) {
    CLI::App* sub = app.add_subcommand("studio", "Not in this build, which has no studio");
    sub->allow_extras();
    sub->callback([&action] {
        action = []() -> int {
            throw bad_argument("studio", "this build has no studio; build with HAPTOGRAM_STUDIO=ON");
        };
    });
}

}  // namespace haptogram::cli
