// SPDX-License-Identifier: Apache-2.0
#include "haptogram/shape/parameters.hpp"

#include <algorithm>
#include <cmath>

#include "haptogram/base/text.hpp"

namespace haptogram {

std::optional<Parameters> parameters_of(std::string_view text) {
    Parameters parameters;
    Fields fields;
    split_at(',', text, fields);
    for (const std::string_view field : fields) {
        const std::size_t equals = std::min(field.find('='), field.size());
        const auto value = parse_number(field.substr(std::min(equals + 1, field.size())));
        if (equals == 0 || !value || !std::isfinite(*value)) return {};
        if (!parameters.emplace(field.substr(0, equals), *value).second) return {};
    }
    return parameters;
}

}  // namespace haptogram
