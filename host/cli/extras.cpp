// SPDX-License-Identifier: Apache-2.0
#include "extras.hpp"

#include "haptogram/verbs/pattern.hpp"

namespace haptogram::cli {

const Extras& extras() {
    static const Extras registered = [] {
        Extras made;
        made.makers.of_pattern = path_of_pattern;
        register_extras(made);
        return made;
    }();
    return registered;
}

void add_below(const std::string& name, CLI::App& command, Action& action) {
    if (const auto found = extras().below.find(name); found != extras().below.end())
        for (const AddCommand add : found->second) add(command, action);
}

const PathMakers& path_makers() { return extras().makers; }

}  // namespace haptogram::cli
