// SPDX-License-Identifier: Apache-2.0
#include "haptogram/format/method.hpp"

#include <fmt/format.h>

#include <vector>

#include "haptogram/base/error.hpp"

namespace haptogram {

const char* name_of(Method method) {
    for (const MethodName& one : method_names)
        if (one.method == method) return one.name;
    return "";
}

Method method_of(const std::string& name, const std::string& setting) {
    std::vector<std::string> names;
    for (const MethodName& one : method_names) {
        if (name == one.name) return one.method;
        names.emplace_back(one.name);
    }
    throw bad_argument(setting, fmt::format("'{}' is no solver; expected {}", name, fmt::join(names, ", ")));
}

}  // namespace haptogram
